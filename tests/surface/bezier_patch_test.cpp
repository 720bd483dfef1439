#include "gradus/surface/bezier_patch.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "support/jets.hpp"
#include "support/models.hpp"

using namespace gradus;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

BezierNet random_net(int m, int n, bool rational, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(-1, 1), weight(0.5, 2);
    BezierNet net{m, n, {}, {}};
    for (int k = 0; k < (m + 1) * (n + 1); ++k) {
        net.points.emplace_back(any(random), any(random), any(random));
        if (rational) net.weights.push_back(weight(random));
    }
    return net;
}

/// De Casteljau's algorithm in homogeneous coordinates.
Vector3d de_casteljau(const BezierNet& net, const Vector2d& uv) {
    const auto reduce = [](std::vector<Eigen::Vector4d> p, double t) {
        for (std::size_t left = p.size(); left > 1; --left)
            for (std::size_t i = 0; i + 1 < left; ++i) p[i] = (1 - t) * p[i] + t * p[i + 1];
        return p[0];
    };
    std::vector<Eigen::Vector4d> column;
    for (int j = 0; j <= net.degree_v; ++j) {
        std::vector<Eigen::Vector4d> row;
        for (int i = 0; i <= net.degree_u; ++i) {
            const int k = j * (net.degree_u + 1) + i;
            const double w = net.weights.empty() ? 1 : net.weights[k];
            row.emplace_back(w * net.points[k].x(), w * net.points[k].y(), w * net.points[k].z(), w);
        }
        column.push_back(reduce(row, uv.x()));
    }
    const Eigen::Vector4d p = reduce(column, uv.y());
    return p.head<3>() / p.w();
}

struct Degrees {
    int m, n;
};
const std::vector<Degrees> some_degrees{{1, 1}, {3, 3}, {2, 3}, {1, 4}, {5, 2}, {4, 4}, {11, 7}, {25, 25}};

}  // namespace

TEST_CASE("Bezier patches agree with de Casteljau's algorithm, a little outside the domain too",
          "[surface][property]") {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> in(-0.05, 1.05);
    for (const Degrees& d : some_degrees)
        for (const bool rational : {false, true}) {
            const BezierNet net = random_net(d.m, d.n, rational, 7);
            const models::Patch patch = make_bezier_patch(net);
            for (int k = 0; k < 20; ++k) {
                const Vector2d uv(in(random), in(random));
                CHECK((patch->position(uv) - de_casteljau(net, uv)).norm() <= 1e-12 * std::pow(1.2, d.m + d.n));
            }
        }
}

TEST_CASE("Derivatives of Bezier patches are those of their positions", "[surface][property]") {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> in(0, 1);
    for (const Degrees& d : some_degrees)
        for (const bool rational : {false, true}) {
            const models::Patch patch = make_bezier_patch(random_net(d.m, d.n, rational, 8));
            for (int k = 0; k < 10; ++k) check_jets(*patch, {in(random), in(random)}, 1e-4 / (d.m + d.n), 1e-5);
        }
}

TEST_CASE("A bicubic patch and its general form give the same jets", "[surface][property]") {
    const BezierNet net = random_net(3, 3, false, 9);
    BezierNet weighted = net;
    weighted.weights.assign(16, 1.0);
    const models::Patch fast = make_bezier_patch(net), general = make_bezier_patch(weighted);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> in(0, 1);
    for (int k = 0; k < 50; ++k) {
        const Vector2d uv(in(random), in(random));
        const Jet2 a = fast->jet2(uv), b = general->jet2(uv);
        CHECK((a.p - b.p).norm() < 1e-14);
        CHECK((a.du - b.du).norm() < 1e-13);
        CHECK((a.dv - b.dv).norm() < 1e-13);
        CHECK((a.duu - b.duu).norm() < 1e-12);
        CHECK((a.duv - b.duv).norm() < 1e-12);
        CHECK((a.dvv - b.dvv).norm() < 1e-12);
    }
}

TEST_CASE("Corners of a Bezier patch are its control points to the bit", "[surface][exact]") {
    for (const Degrees& d : some_degrees)
        for (const bool rational : {false, true}) {
            const BezierNet net = random_net(d.m, d.n, rational, 10);
            const models::Patch patch = make_bezier_patch(net);
            CHECK(patch->position({0, 0}) == net.points[0]);
            CHECK(patch->position({1, 0}) == net.points[d.m]);
            CHECK(patch->position({0, 1}) == net.points[d.n * (d.m + 1)]);
            CHECK(patch->jet1({1, 1}).p == net.points.back());
            CHECK(patch->jet2({1, 0}).p == net.points[d.m]);
        }
}

TEST_CASE("Sides with the same control points are the same to the bit, whichever way the patch is turned",
          "[surface][exact]") {
    std::mt19937 random(6);
    std::uniform_int_distribution<long long> in(0, 1LL << 53);
    for (const Degrees& d : some_degrees)
        for (const bool rational : {false, true}) {
            const BezierNet net = random_net(d.m, d.n, rational, 11);
            const models::Patch patch = make_bezier_patch(net);
            for (int variant = 1; variant < 8; ++variant) {
                const models::Patch other = make_bezier_patch(models::turned(net, variant));
                for (int k = 0; k < 20; ++k) {
                    const double s = std::ldexp(static_cast<double>(in(random)), -53);  // 1 - s is exact
                    for (const Vector2d& uv : {Vector2d(s, 0), Vector2d(s, 1), Vector2d(0, s), Vector2d(1, s)}) {
                        Vector2d turned = uv;
                        if (variant & 1) turned.x() = 1 - turned.x();
                        if (variant & 2) turned.y() = 1 - turned.y();
                        if (variant & 4) std::swap(turned.x(), turned.y());
                        CHECK(patch->position(uv) == other->position(turned));
                        CHECK(patch->jet1(uv).p == other->jet2(turned).p);
                    }
                }
            }
        }
}

TEST_CASE("Raising the degree leaves the surface alone", "[surface][property]") {
    const BezierNet net = random_net(3, 2, false, 12);
    const models::Patch low = make_bezier_patch(net), high = make_bezier_patch(models::raise_u(net));
    for (const double u : {0.0, 0.3, 0.9})
        for (const double v : {0.1, 0.5, 1.0}) {
            CHECK((low->jet2({u, v}).p - high->jet2({u, v}).p).norm() < 1e-14);
            CHECK((low->jet2({u, v}).duu - high->jet2({u, v}).duu).norm() < 1e-12);
        }
}

TEST_CASE("Rational patches are exactly round", "[surface][exact]") {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> in(0, 1);
    for (const models::Nets& nets : {models::sphere_octants(2), models::sphere_cube(2)})
        for (const BezierNet& net : nets)
            for (int k = 0; k < 10; ++k)
                CHECK(make_bezier_patch(net)->position({in(random), in(random)}).norm() == Approx(2).epsilon(1e-14));
    for (const BezierNet& net : models::torus(3, 1)) {
        const Vector3d p = make_bezier_patch(net)->position({in(random), in(random)});
        CHECK(std::hypot(p.head<2>().norm() - 3, p.z()) == Approx(1).epsilon(1e-14));
    }
}

TEST_CASE("Nets that make no patch are refused", "[surface]") {
    const BezierNet good = random_net(2, 2, true, 13);
    BezierNet net = good;
    net.points.pop_back();
    CHECK_THROWS_AS(make_bezier_patch(net), std::invalid_argument);
    net = good;
    net.points[4].y() = NAN;
    CHECK_THROWS_AS(make_bezier_patch(net), std::invalid_argument);
    net = good;
    net.weights[2] = 0;
    CHECK_THROWS_AS(make_bezier_patch(net), std::invalid_argument);
    net = good;
    net.weights.pop_back();
    CHECK_THROWS_AS(make_bezier_patch(net), std::invalid_argument);
    CHECK_THROWS_AS(make_bezier_patch({0, 2, {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {}}), std::invalid_argument);
    CHECK_THROWS_AS(make_bezier_patch(random_net(26, 1, false, 1)), std::invalid_argument);
}

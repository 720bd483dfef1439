// The energy that operations lower, against closed forms and finite differences.
#include "../../src/remesh/derivatives.hpp"
#include "remesh/simple_supports.hpp"

#include "gradus/surface/unit_normal.hpp"

#include <catch2/catch.hpp>

using namespace gradus;
using namespace gradus::testing;
using Eigen::Vector3d;

namespace {

// A star of triangles around its first vertex: its energy as that vertex moves, sizes and normals being what they are.
struct Star {
    Vertex centre;
    std::vector<Vertex> ring;

    double energy(const Vector3d& p, Aim aim) const {
        Vertex x = centre;
        x.p = p;
        double sum = 0;
        for (std::size_t i = 0; i < ring.size(); ++i)
            sum += weighted(triangle_energy(x, ring[i], ring[(i + 1) % ring.size()]), aim);
        return sum;
    }
    Derivatives derivatives(const Vector3d& u, const Vector3d& v, Aim aim) const {
        Derivatives sum;
        for (std::size_t i = 0; i < ring.size(); ++i)
            add_triangle(centre, ring[i], ring[(i + 1) % ring.size()], TangentAxes{u, v, u, v}, aim, sum);
        return sum;
    }
};

// Four to eight triangles around a vertex near the middle, none of them folded; lengths are about `radius`, sizes up to
// twice or half as much.
Star random_star(const SimpleSupport& support, const Vector3d& middle, double radius, std::mt19937& random) {
    std::uniform_real_distribution<double> uniform(0, 1);
    const Vector3d n = support.normal(middle), u = any_tangent(n), v = n.cross(u);
    const auto vertex = [&](double r, double angle) {
        Vertex x = vertex_at(support, middle + r * (std::cos(angle) * u + std::sin(angle) * v));
        x.h = radius * std::pow(2, 2 * uniform(random) - 1);
        x.g = std::cbrt(x.h * x.h);
        return x;
    };
    const int count = 4 + static_cast<int>(random() % 5);
    Star star;
    star.centre = vertex(0.3 * radius * uniform(random), 2 * std::numbers::pi * uniform(random));
    for (int i = 0; i < count; ++i)
        star.ring.push_back(
            vertex(radius * (0.7 + 0.6 * uniform(random)), 2 * std::numbers::pi * (i + 0.4 * uniform(random)) / count));
    return star;
}

// First and second derivatives of a function of two variables at 0, by central differences with Richardson's
// extrapolation: right to the fourth order of the step.
template <class F>
Derivatives differences(const F& f, double step) {
    const auto once = [&](double e) {
        Derivatives d;
        d.value = f(0, 0);
        d.gx = (f(e, 0) - f(-e, 0)) / (2 * e);
        d.gy = (f(0, e) - f(0, -e)) / (2 * e);
        d.hxx = (f(e, 0) - 2 * d.value + f(-e, 0)) / (e * e);
        d.hyy = (f(0, e) - 2 * d.value + f(0, -e)) / (e * e);
        d.hxy = (f(e, e) - f(e, -e) - f(-e, e) + f(-e, -e)) / (4 * e * e);
        return d;
    };
    const Derivatives coarse = once(step), fine = once(step / 2);
    const auto finer = [&](double Derivatives::*x) { return (4 * fine.*x - coarse.*x) / 3; };
    Derivatives d;
    d.value = fine.value;
    for (const auto x : {&Derivatives::gx, &Derivatives::gy, &Derivatives::hxx, &Derivatives::hxy, &Derivatives::hyy})
        d.*x = finer(x);
    return d;
}

// Largest difference of first and of second derivatives, each over what they are in all.
std::array<double, 2> difference(const Derivatives& a, const Derivatives& b) {
    const Eigen::Vector2d ga(a.gx, a.gy), gb(b.gx, b.gy);
    Eigen::Matrix2d ha, hb;
    ha << a.hxx, a.hxy, a.hxy, a.hyy;
    hb << b.hxx, b.hxy, b.hxy, b.hyy;
    return {(ga - gb).norm() / gb.norm(), (ha - hb).norm() / hb.norm()};
}

}  // namespace

TEST_CASE("The derivatives of the energy of a plane star are those of its differences", "[remesh][property]") {
    const SimpleSupport support = plane();
    std::mt19937 random(11);
    for (const Aim aim : {Aim::Mean, Aim::Worst})
        for (int i = 0; i < 200; ++i) {
            CAPTURE(static_cast<int>(aim), i);
            const Star star = random_star(support, {0, 0, 0}, 1, random);
            const Vector3d u = Vector3d(1, 2, 0).normalized(), v = Vector3d::UnitZ().cross(u);
            const Derivatives exact = star.derivatives(u, v, aim);
            REQUIRE_FALSE(exact.folded);
            const Derivatives near =
                differences([&](double x, double y) { return star.energy(star.centre.p + x * u + y * v, aim); }, 1e-3);
            CHECK(exact.value == Approx(star.energy(star.centre.p, aim)).epsilon(1e-12));
            const auto [first, second] = difference(exact, near);
            CHECK(first <= 1e-4);
            CHECK(second <= 1e-4);
            double worst = 0;
            for (std::size_t k = 0; k < star.ring.size(); ++k)
                worst =
                    std::max(worst, triangle_energy(star.centre, star.ring[k], star.ring[(k + 1) % star.ring.size()]));
            CHECK(exact.worst == Approx(worst).epsilon(1e-12));
        }
}

TEST_CASE("On a sphere the derivatives are those along it, to the second order of the edges", "[remesh][converges]") {
    // The same stars, smaller and smaller: what is neglected falls with the square.
    constexpr int kStars = 40, kSizes = 4;
    const SimpleSupport sphere = ball(1, 1);
    for (const Aim aim : {Aim::Mean, Aim::Worst}) {
        double first[kSizes] = {}, second[kSizes] = {};
        for (int size = 0; size < kSizes; ++size) {
            std::mt19937 random(12);
            const double radius = 0.2 / (1 << size);
            for (int i = 0; i < kStars; ++i) {
                const Star star = random_star(sphere, Vector3d(2, -1, 3).normalized(), radius, random);
                const Vector3d u = any_tangent(star.centre.n), v = star.centre.n.cross(u);
                const Derivatives near = differences(
                    [&](double x, double y) { return star.energy(sphere.project(star.centre.p + x * u + y * v), aim); },
                    1e-3 * radius);
                const auto [by_first, by_second] = difference(star.derivatives(u, v, aim), near);
                first[size] += by_first / kStars;
                second[size] += by_second / kStars;
            }
        }
        for (int size = 1; size < kSizes; ++size) {
            CAPTURE(static_cast<int>(aim), size, first[size], second[size]);
            CHECK(first[size - 1] / first[size] >= 3.5);
            CHECK(second[size - 1] / second[size] >= 3.5);
        }
        CHECK(first[0] <= 0.1);
        CHECK(second[0] <= 0.1);
    }
}

TEST_CASE("The derivatives of the energy of a curve's edges are those of its differences", "[remesh][property]") {
    std::mt19937 random(13);
    std::uniform_real_distribution<double> uniform(0, 1);
    const SimpleSupport support = plane();
    for (const Aim aim : {Aim::Mean, Aim::Worst})
        for (int i = 0; i < 200; ++i) {
            // The direction of the curve at x is not that of the edge; some edges are shorter than a quarter of the
            // size, where the term is linear.
            const Vector3d u = Vector3d(1, 2 * uniform(random) - 1, uniform(random)).normalized();
            Vertex x = vertex_at(support, {0, 0, 0}), a = vertex_at(support, {uniform(random) + 0.1, 0.2, 0});
            x.h = 0.1 + 3 * uniform(random);
            const auto energy = [&](double s, double) {
                Vertex moved = x;
                moved.p += s * u;
                return weighted(edge_energy(moved, a), aim);
            };
            Derivatives exact;
            add_edge(x, a, u, aim, exact);
            const Derivatives near = differences(energy, 1e-3);
            // Where the term passes to its tangent, the differences see both.
            const double m = (a.p - x.p).squaredNorm() / (a.h * x.h);
            if (std::abs(m - kTiny) < 0.01) continue;
            CAPTURE(static_cast<int>(aim), i, m);
            CHECK(exact.value == Approx(energy(0, 0)).epsilon(1e-12));
            CHECK(exact.gx == Approx(near.gx).epsilon(1e-4).margin(1e-7));
            CHECK(exact.hxx == Approx(near.hxx).epsilon(1e-4).margin(1e-5));
            CHECK(exact.gy == 0);
            CHECK(exact.hyy == 0);
        }
}

TEST_CASE("The terms of the energy are smooth, least where all is as asked, and 0 there", "[remesh][exact]") {
    CHECK(size_term(1).value == 0);
    CHECK(size_term(1).slope == 0);
    for (double m = 1e-3; m < 1e3; m *= 1.1) {
        CAPTURE(m);
        CHECK(size_term(m).value >= 0);
        const double e = 1e-4 * m;
        const SizeTerm below = size_term(m - e), above = size_term(m + e);
        CHECK(size_term(m).slope == Approx((above.value - below.value) / (2 * e)).epsilon(1e-3).margin(1e-6));
        if (std::abs(m - kTiny) > 2 * e)
            CHECK(size_term(m).curvature == Approx((above.slope - below.slope) / (2 * e)).epsilon(1e-3).margin(1e-6));
    }
    // Twice as large is as bad as half as large.
    CHECK(size_term(2).value == Approx(size_term(0.5).value));
    const double under = std::nextafter(kTiny, 0);
    CHECK(size_term(under).value == Approx(size_term(kTiny).value).epsilon(1e-12));
    CHECK(size_term(under).slope == Approx(size_term(kTiny).slope).epsilon(1e-12));

    CHECK(fold_penalty(1) == 0);
    CHECK(fold_penalty(kFoldCosine) == 0);
    CHECK(fold_penalty(kFoldCosine - 1e-6) <= 1e-10);
    CHECK(fold_penalty(-1) == Approx(kFoldWeight * (1 + kFoldCosine) * (1 + kFoldCosine)));
}

TEST_CASE("The energy of a triangle is 1 over its quality where its area is as asked, and grows from there",
          "[remesh][property]") {
    SimpleSupport support = plane();
    std::mt19937 random(14);
    std::uniform_real_distribution<double> uniform(0, 1);
    const Vertex a = vertex_at(support, {0, 0, 0}), b = vertex_at(support, {1, 0, 0});
    const Vertex c = vertex_at(support, {0.5, std::sqrt(0.75), 0});
    CHECK(triangle_energy(a, b, c) == Approx(1).epsilon(1e-12));
    for (int i = 0; i < 200; ++i) {
        Vertex d = vertex_at(support, {3 * uniform(random) - 1, 0.05 + 2 * uniform(random), 0});
        const double energy = triangle_energy(a, b, d), quality = triangle_quality(a.p, b.p, d.p);
        CHECK(energy >= 1 - 1e-12);
        CHECK(triangle_energy(a, b, d, 0) == Approx(1 / quality).epsilon(1e-12));
        CHECK(triangle_energy(b, d, a) == Approx(energy).epsilon(1e-12));
        // Sizes that ask for this area leave the shape alone.
        const double area = d.p.y() / 2, wanted = std::sqrt(area / (std::sqrt(3.0) / 4));
        const auto sized = [&](Vertex v) {
            v.h = wanted;
            v.g = std::cbrt(v.h * v.h);
            return v;
        };
        CHECK(triangle_energy(sized(a), sized(b), sized(d)) == Approx(1 / quality).epsilon(1e-12));
        // Turned over, the penalty is the largest there is.
        CHECK(triangle_energy(b, a, d) == Approx(energy + fold_penalty(-1)).epsilon(1e-12));
    }
    CHECK(triangle_energy(a, a, b) == 1e30);
}

TEST_CASE("A normal agrees with a vertex as with the nearest normal that the surface has there", "[remesh][exact]") {
    // Normals of a crease are within the lean of the one between; the nearest of a cone of them, by search.
    Vertex v;
    v.n = Vector3d(1, 2, 2) / 3;
    const Vector3d u = any_tangent(v.n), w = v.n.cross(u);
    for (const double lean_angle : {0.0, 0.1, 0.5, 1.0, 1.3})
        for (double angle = 0; angle < std::numbers::pi; angle += 0.05) {
            CAPTURE(lean_angle, angle);
            v.lean = static_cast<float>(std::cos(lean_angle));
            const Vector3d n = std::cos(angle) * v.n + std::sin(angle) * (std::cos(0.7) * u + std::sin(0.7) * w);
            double nearest = -1;
            constexpr int kRings = 400;
            for (int i = 0; i <= kRings; ++i) {
                const double tilt = lean_angle * i / kRings;
                const Vector3d side = std::cos(tilt) * v.n + std::sin(tilt) * (std::cos(0.7) * u + std::sin(0.7) * w);
                nearest = std::max(nearest, side.dot(n));
            }
            CHECK(agreement(v, n) == Approx(nearest).margin(1e-5));
        }
    v.lean = kAnyNormal;
    CHECK(agreement(v, -v.n) == 1);
}

TEST_CASE("Moving one vertex again and again ends where its differences vanish, always lower", "[remesh][property]") {
    std::mt19937 random(15);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (const bool curved : {false, true})
        for (const Aim aim : {Aim::Mean, Aim::Worst})
            for (int i = 0; i < 40; ++i) {
                CAPTURE(curved, static_cast<int>(aim), i);
                const SimpleSupport support = curved ? ball(4, 1) : plane();
                const Star star = random_star(support, curved ? Vector3d(0, 0, 4) : Vector3d(0, 0, 0), 1, random);
                std::vector<Vertex> vertices{star.centre};
                vertices[0].h = vertices[0].g = 1;
                vertices.insert(vertices.end(), star.ring.begin(), star.ring.end());
                std::vector<Triangle> triangles;
                const int count = static_cast<int>(star.ring.size());
                for (int k = 0; k < count; ++k) triangles.push_back({0, 1 + k, 1 + (k + 1) % count});
                Editor editor(support, support, vertices, Connectivity(count + 1, triangles));
                const auto energy = [&](const Vector3d& p) {
                    Star now = star;
                    now.centre = editor.vertex(0);
                    now.centre.n = support.normal(p);
                    return now.energy(p, aim);
                };
                const double at_first = energy(editor.vertex(0).p);
                double last = at_first;
                for (int step = 0; step < 60; ++step) {
                    const double moved = editor.relax(0, aim);
                    const double now = energy(editor.vertex(0).p);
                    CHECK((moved > 0 ? now < last : now == last));
                    last = now;
                    if (moved == 0) break;
                }
                const Vertex& x = editor.vertex(0);
                CHECK((support.project(x.p) - x.p).norm() <= 1e-12);
                const Vector3d u = any_tangent(x.n), v = x.n.cross(u);
                const Derivatives d =
                    differences([&](double s, double t) { return energy(support.project(x.p + s * u + t * v)); }, 1e-3);
                // What Newton's method would still move it by; moves below 0.002 are not made.
                Eigen::Matrix2d hessian;
                hessian << d.hxx, d.hxy, d.hxy, d.hyy;
                CHECK(hessian.determinant() > 0);
                CHECK(hessian.ldlt().solve(Eigen::Vector2d(d.gx, d.gy)).norm() <= (curved ? 0.02 : 0.004));
            }
}

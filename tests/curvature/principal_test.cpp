#include "gradus/curvature/principal.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "support/models.hpp"

using namespace gradus;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

void check_frame(const PrincipalCurvatures& k) {
    Eigen::Matrix3d frame;
    frame << k.d1, k.d2, k.normal;
    CHECK((frame.transpose() * frame - Eigen::Matrix3d::Identity()).norm() < 1e-9);
    CHECK(frame.determinant() > 0);
    CHECK(k.k1 >= k.k2);
}

/// Curvature of the normal section towards d, from the height of nearby surface points over the tangent plane.
double section_curvature(const ParametricSurface& surface, const Vector2d& uv, const Vector3d& d,
                         const Vector3d& normal) {
    const Jet1 jet = surface.jet1(uv);
    Eigen::Matrix<double, 3, 2> J;
    J << jet.du, jet.dv;
    const Vector2d way = (J.transpose() * J).inverse() * (J.transpose() * d);
    double h = 1e-3 / way.norm();
    const auto bend = [&](double step) {
        // Second difference along a straight parameter line of speed d, whose normal part is the section's curvature.
        return (surface.position(uv + step * way) - 2 * jet.p + surface.position(uv - step * way)).dot(normal) /
               (step * step);
    };
    return (4 * bend(h / 2) - bend(h)) / 3;
}

}  // namespace

TEST_CASE("Spheres have one curvature everywhere, poles included", "[curvature][exact]") {
    const double radius = 2;
    std::vector<models::Patch> spheres;
    for (const double stretch : {1.0, 1e3, 1e-3, 1e6}) spheres.push_back(models::stretched_sphere(stretch, radius));
    for (const BezierNet& net : models::shuffled(models::sphere_octants(radius)))
        spheres.push_back(make_bezier_patch(net));
    for (const BezierNet& net : models::sphere_cube(radius)) spheres.push_back(make_bezier_patch(net));
    for (const models::Patch& sphere : spheres) {
        const Domain d = sphere->domain();
        for (const double u : {0.0, 1e-10, 1e-5, 3e-4, 0.3, 0.99995, 1.0})
            for (const double v : {0.0, 1e-10, 1e-6, 2e-4, 1e-3, 0.4, 0.99995, 1 - 1e-9, 1.0}) {
                const Vector2d uv = d.min + Vector2d(u, v).cwiseProduct(d.max - d.min);
                const PrincipalCurvatures k = principal_curvatures(*sphere, uv);
                CAPTURE(u, v);
                check_frame(k);
                const double sign = k.normal.dot(sphere->position(uv)) > 0 ? -1 : 1;
                CHECK(k.k1 == Approx(sign / radius).epsilon(1e-6));
                CHECK(k.k2 == Approx(sign / radius).epsilon(1e-6));
                CHECK(minimal_radius(*sphere, uv) == Approx(radius).epsilon(1e-6));
            }
    }
}

TEST_CASE("A torus has 1 / r along the tube and cos v / (R + r cos v) around", "[curvature][exact]") {
    const double R = 3, r = 1;
    const models::Patch torus = make_torus({1, 2, 3}, R, r);
    for (double v = 0; v < 6.28; v += 0.37) {
        const Vector2d uv(0.7, v);
        const PrincipalCurvatures k = principal_curvatures(*torus, uv);
        check_frame(k);
        const double around = -std::cos(v) / (R + r * std::cos(v));
        CHECK(k.k2 == Approx(-1 / r));
        CHECK(k.k1 == Approx(around).margin(1e-12));
        CHECK(std::abs(k.d1.dot(torus->jet1(uv).du.normalized())) == Approx(1));
        CHECK(minimal_radius(*torus, uv) == Approx(r));
    }
    std::mt19937 random(1);
    std::uniform_real_distribution<double> in(0, 1);
    for (const BezierNet& net : models::torus(R, r)) {
        const models::Patch patch = make_bezier_patch(net);
        const Vector2d uv(in(random), in(random));
        const Vector3d p = patch->position(uv);
        const double rho = p.head<2>().norm();
        const PrincipalCurvatures k = principal_curvatures(*patch, uv);
        CHECK(k.k2 == Approx(-1 / r));
        CHECK(k.k1 == Approx(-(rho - R) / (r * rho)).margin(1e-10));
    }
}

TEST_CASE("Cylinders and planes have the curvatures they are known for", "[curvature][exact]") {
    const PrincipalCurvatures k = principal_curvatures(*make_cylinder({0, 0, 0}, 4, 1), {1, 0.5});
    check_frame(k);
    CHECK(k.k1 == Approx(0).margin(1e-14));
    CHECK(k.k2 == Approx(-0.25));
    CHECK(std::abs(k.d1.z()) == Approx(1));
    CHECK(minimal_radius(*make_plane({0, 0, 0}, {1, 0, 0}, {0.3, 1, 0}), {0.2, 0.3}) ==
          std::numeric_limits<double>::infinity());
    for (const double stretch : {1.0, 1e3, 1e6}) {
        const models::Patch uneven = make_bezier_patch(models::uneven_square(stretch));
        for (const double u : {0.0, 1e-6, 0.1, 1.0}) CHECK(minimal_radius(*uneven, {u, 0.4}) > 1e9);
    }
}

TEST_CASE("Graphs have the curvature of their second derivatives at a level point", "[curvature][exact]") {
    // z = (a x^2 + 2 b x y + c y^2) / 2 over [-1, 1]^2 as a biquadratic net.
    const double a = 1.5, b = 0.7, c = -0.4;
    BezierNet net{2, 2, {}, {}};
    const auto blossom = [&](double x1, double x2, double y1, double y2) {
        return (a * x1 * x2 + b * (x1 + x2) * (y1 + y2) / 2 + c * y1 * y2) / 2;
    };
    for (int j = 0; j < 3; ++j)
        for (int i = 0; i < 3; ++i)
            net.points.emplace_back(i - 1, j - 1,
                                    blossom(i == 2 ? 1 : -1, i == 0 ? -1 : 1, j == 2 ? 1 : -1, j == 0 ? -1 : 1));
    const PrincipalCurvatures k = principal_curvatures(*make_bezier_patch(net), {0.5, 0.5});
    check_frame(k);
    const double mean = (a + c) / 2, radius = std::hypot((a - c) / 2, b);
    CHECK(k.k1 == Approx(mean + radius));
    CHECK(k.k2 == Approx(mean - radius));
}

TEST_CASE("Curvatures are extremes of normal sections measured on the surface", "[curvature][property]") {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> in(0.1, 0.9);
    models::Nets nets = models::wavy_sheet(2, 0.2);
    nets.push_back(models::bump(0.7));
    const models::Nets teapot = models::teapot_nets();
    nets.insert(nets.end(), teapot.begin(), teapot.end());
    for (const BezierNet& net : nets) {
        const models::Patch patch = make_bezier_patch(net);
        const Vector2d uv(in(random), in(random));
        const PrincipalCurvatures k = principal_curvatures(*patch, uv);
        check_frame(k);
        const double scale = std::abs(k.k1) + std::abs(k.k2) + 0.1;
        CHECK(section_curvature(*patch, uv, k.d1, k.normal) == Approx(k.k1).margin(1e-3 * scale));
        CHECK(section_curvature(*patch, uv, k.d2, k.normal) == Approx(k.k2).margin(1e-3 * scale));
        CHECK(section_curvature(*patch, uv, (k.d1 + k.d2).normalized(), k.normal) ==
              Approx((k.k1 + k.k2) / 2).margin(1e-3 * scale));
    }
}

TEST_CASE("Curvature does not depend on the parametrisation, and scales", "[curvature][property]") {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> in(0, 1);
    const BezierNet net = models::bump(0.7);
    const models::Patch patch = make_bezier_patch(net);
    for (int n = 0; n < 20; ++n) {
        const Vector2d uv(in(random), in(random));
        const PrincipalCurvatures k = principal_curvatures(*patch, uv);
        Eigen::Matrix2d A;  // sheared and stretched by 1000
        A << 1, 0.5, 0, 1e-3;
        const Vector2d x = A.inverse() * uv;
        const PrincipalCurvatures sheared =
            principal_curvatures(*reparametrise(make_bezier_patch(net), A, {0, 0}, {{-1000, 0}, {1000, 1000}}), x);
        CHECK(sheared.k1 == Approx(k.k1).margin(1e-7));
        CHECK(sheared.k2 == Approx(k.k2).margin(1e-7));
        CHECK(sheared.normal.isApprox(k.normal, 1e-9));
        for (const double factor : {1e-6, 1e6}) {
            const models::Patch scaled = make_bezier_patch(models::scaled({net}, factor)[0]);
            CHECK(minimal_radius(*scaled, uv) == Approx(factor * minimal_radius(*patch, uv)));
        }
        const PrincipalCurvatures reversed =
            principal_curvatures(*make_bezier_patch(models::flip_u(net)), {1 - uv.x(), uv.y()});
        CHECK(reversed.k1 == Approx(-k.k2).margin(1e-12));
        CHECK(reversed.k2 == Approx(-k.k1).margin(1e-12));
    }
}

TEST_CASE("Curvature at the teapot's poles is the limit of its neighbourhood", "[curvature][converges]") {
    const models::Nets nets = models::teapot_nets();
    for (const int i : {20, 21, 28, 31}) {
        const models::Patch patch = make_bezier_patch(nets[i]);
        for (const double u : {0.0, 0.2, 0.5, 1.0}) {
            const double at_pole = minimal_radius(*patch, {u, 0});
            double last = std::numeric_limits<double>::infinity();
            for (const double v : {1e-1, 1e-2, 1e-3}) {
                const double error = std::abs(minimal_radius(*patch, {u, v}) / at_pole - 1);
                CHECK(error < 0.2 * last);
                last = error;
            }
            CHECK(last < 0.02);
            CHECK(std::abs(minimal_radius(*patch, {u, 0.99e-4}) / minimal_radius(*patch, {u, 1.01e-4}) - 1) < 1e-4);
        }
    }
    // Along the knob's meridian, with control points (r, z) = (0, 3.15), (.8, 3.15), (0, 2.85): k = (2/3) .3 / .8^2.
    CHECK(principal_curvatures(*make_bezier_patch(nets[20]), {0, 0}).k2 == Approx(-2.0 / 3 * 0.3 / 0.64).epsilon(1e-7));
}

TEST_CASE("Radii of many places are those of each", "[curvature][property]") {
    const models::Nets nets = models::teapot_nets();
    std::mt19937 random(4);
    std::uniform_real_distribution<double> in(0, 1);
    std::vector<Vector2d> uv;
    for (int k = 0; k < 150; ++k) uv.emplace_back(in(random), k % 10 == 0 ? 0.0 : in(random));
    for (const int i : {0, 18, 20}) {
        const models::Patch patch = make_bezier_patch(nets[i]);
        std::vector<double> radii(uv.size());
        minimal_radii(*patch, uv, radii);
        for (std::size_t k = 0; k < uv.size(); ++k) {
            CHECK(radii[k] == minimal_radius(*patch, uv[k]));
            CHECK(radii[k] > 0);
        }
        radii.pop_back();
        CHECK_THROWS_AS(minimal_radii(*patch, uv, radii), std::invalid_argument);
    }
}

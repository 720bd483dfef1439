#include "gradus/surface/unit_normal.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "support/models.hpp"

using namespace gradus;
using Eigen::Vector2d;
using Eigen::Vector3d;

TEST_CASE("The normal of a sphere is its radius, at and near the poles of any parametrisation", "[surface][exact]") {
    std::vector<models::Patch> spheres;
    spheres.push_back(make_sphere({0, 0, 0}, 1));
    spheres.push_back(models::stretched_sphere(1000));
    spheres.push_back(models::stretched_sphere(1e-3));
    for (const BezierNet& net : models::shuffled(models::sphere_octants())) spheres.push_back(make_bezier_patch(net));
    for (const models::Patch& sphere : spheres) {
        const Domain d = sphere->domain();
        const Vector2d middle = (d.min + d.max) / 2;
        const Vector3d n = unit_normal(*sphere, middle);
        const double sign = n.dot(sphere->position(middle)) > 0 ? 1 : -1;
        for (const double u : {0.0, 1e-12, 1e-9, 1e-7, 1e-5, 0.3, 1 - 1e-8, 1.0})
            for (const double v : {0.0, 1e-15, 1e-12, 1e-9, 1e-7, 1e-5, 0.4, 1 - 1e-10, 1.0}) {
                const Vector2d uv = d.min + Vector2d(u, v).cwiseProduct(d.max - d.min);
                CAPTURE(u, v);
                CHECK((sign * unit_normal(*sphere, uv) - sphere->position(uv)).norm() < 1e-6);
            }
    }
}

TEST_CASE("The normal at a corner without derivatives along a side is the limit", "[surface][exact]") {
    BezierNet net = models::bump(0.5);
    net.points[5].z() = 0;          // the corner has a tangent plane
    net.points[1] = net.points[0];  // S_u = 0 at the corner only
    const models::Patch patch = make_bezier_patch(net);
    for (const Vector2d& way : {Vector2d(1, 0), Vector2d(0, 1), Vector2d(1, 1)})
        CHECK((unit_normal(*patch, {0, 0}) - unit_normal(*patch, 1e-4 * way)).norm() < 1e-2);
    CHECK((unit_normal(*patch, {0, 0}) - Vector3d::UnitZ()).norm() < 1e-9);
    net.points[4] = net.points[0];  // and S_v = 0 as well
    const models::Patch both = make_bezier_patch(net);
    CHECK((unit_normal(*both, {0, 0}) - unit_normal(*both, {1e-3, 1e-3})).norm() < 1e-2);
}

TEST_CASE("The normal of a plane is found where its parametrisation is worst", "[surface][exact]") {
    for (const double stretch : {1.0, 1e3, 1e6, 1e9, 1e12}) {
        const models::Patch patch = make_bezier_patch(models::uneven_square(stretch));
        for (const double u : {0.0, 1e-9, 0.5, 1.0})
            for (const double v : {0.0, 0.5, 1.0})
                CHECK((unit_normal(*patch, {u, v}) - Vector3d::UnitZ()).norm() < 1e-9);
    }
    BezierNet pole = models::flat_square();  // a triangle: the bottom is collapsed with the row above it
    for (int k = 0; k < 8; ++k) pole.points[k] = Vector3d(0.5, 0, 0);
    const models::Patch triangle = make_bezier_patch(pole);
    for (const double u : {0.0, 0.5, 1.0}) CHECK((unit_normal(*triangle, {u, 0}) - Vector3d::UnitZ()).norm() < 1e-9);
}

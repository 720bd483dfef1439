#include "gradus/remesh/patch_chord_error.hpp"

#include "gradus/remesh/chord_error.hpp"
#include "support/zoo.hpp"

#include <catch2/catch.hpp>

#include <cmath>
#include <random>

using namespace gradus;
using Eigen::Vector3d;

namespace {

/// Farthest of dense samples of the triangles from the unit sphere.
double off_sphere(const SurfaceMesh& mesh) {
    constexpr int n = 8;
    double farthest = 0;
    for (const Triangle& t : mesh.triangles)
        for (int i = 0; i <= n; ++i)
            for (int j = 0; i + j <= n; ++j) {
                const Vector3d p =
                    (i * mesh.points[t[0]] + j * mesh.points[t[1]] + (n - i - j) * mesh.points[t[2]]) / double(n);
                farthest = std::max(farthest, std::abs(p.norm() - 1));
            }
    return farthest;
}

}  // namespace

TEST_CASE("Mesh and surface of patches stay within the chord error, both ways", "[remesh][property]") {
    const SurfaceModel model = models::model_of(models::sphere_octants());
    for (const double error : {0.03, 0.003}) {
        // Sizes that are too large to begin with are lowered.
        for (const bool too_large : {false, true}) {
            SizingRule rule = rule_within(error, {.hmax = 1});
            if (too_large) rule.value *= 10;
            SizedBackground map = make_background(model, rule);
            GradationOptions gradation;
            gradation.shock = 1.5;
            grade(map.background.mesh, map.sizes, gradation);
            const PatchChordErrorResult made = remesh_within(model, map, error, {.gradation = gradation});
            CHECK(made.kept);
            CHECK(made.deviation.bound() <= error);
            CHECK(made.facets <= error / 8);
            CHECK((made.lowerings > 0) == too_large);
            CHECK(off_sphere(made.result.mesh) <= error);
            const DistanceTarget mesh({made.result.mesh.points, made.result.mesh.triangles});
            std::mt19937 random(6);
            std::normal_distribution<double> normal;
            for (int i = 0; i < 3000; ++i) {
                const Vector3d p = Vector3d(normal(random), normal(random), normal(random)).normalized();
                CHECK(mesh.distance(p) <= error);
            }
        }
    }
}

TEST_CASE("A chord error that hmin leaves no room for is not kept", "[remesh]") {
    const SurfaceModel model = models::model_of(models::sphere_octants());
    SizedBackground map = make_background(model, {.hmin = 0.4, .hmax = 0.5});
    const PatchChordErrorResult made = remesh_within(model, map, 1e-3, {.hmin = 0.4});
    CHECK(!made.kept);
    CHECK(made.deviation.bound() > 1e-3);
    CHECK_THROWS_AS(remesh_within(model, map, 0), std::invalid_argument);
}

TEST_CASE("The chord error holds over trimmed patches too", "[remesh]") {
    const SurfaceModel model = models::sphere_with_hole();
    SizedBackground map = make_background(model, rule_within(0.01, {.hmax = 1}));
    const PatchChordErrorResult made = remesh_within(model, map, 0.01);
    CHECK(made.kept);
    CHECK(off_sphere(made.result.mesh) <= 0.01);
}

TEST_CASE("Elements as long as a torus lets them be keep the chord error with fewer triangles", "[remesh][property]") {
    const models::Kind kind = models::kind_of("torus");
    const SurfaceModel model = kind.make();
    const double error = 0.002 * model.diagonal();
    SizingRule rule = rule_within(error, {.hmax = 2});
    SizedBackground map = make_background(model, rule);
    GradationOptions gradation;
    gradation.shock = 1.5;
    grade(map.background.mesh, map.sizes, gradation);
    const PatchChordErrorResult round = remesh_within(model, map, error, {.gradation = gradation});
    REQUIRE(round.kept);
    const PatchChordErrorResult made = stretch_within(
        model, map, error, {.gradation = TensorGradationOptions{.shock = 2}, .bounds = {1e-3, model.diagonal(), 1000}});
    CHECK(made.kept);
    CHECK(made.deviation.bound() <= error);
    CHECK(made.result.mesh.triangles.size() < 0.7 * static_cast<double>(round.result.mesh.triangles.size()));
    for (std::size_t v = 0; v < made.result.mesh.points.size(); ++v)
        CHECK(made.result.mesh.points[v] == model.position(made.result.mesh.places[v]));
}

// Meshes that keep a chord error, as an independent measure finds both ways, and those that cannot.
#include "gradus/remesh/chord_error.hpp"

#include <catch2/catch.hpp>

#include "gradus/gradation/hold.hpp"
#include "support/triangulations.hpp"

using namespace gradus;
using Eigen::Vector3d;

namespace {

constexpr double kShock = 1.5;

ChordErrorResult within(const Triangulation& surface, double chord_error, const SizingRule& limits,
                        ChordErrorOptions options = {}) {
    TriangulationBackground map = make_background(surface, rule_within(chord_error, limits));
    options.gradation = GradationOptions{.shock = kShock};
    grade(map.background.mesh, map.sizes, *options.gradation);
    raise_to_held(map.background.mesh, frozen_edge_lengths(surface.soup().points, surface.mesh(), surface.frozen()),
                  kHoldSlope, map.sizes);
    return remesh_within(surface, map, chord_error, options);
}

// The largest distance that is attained, either way, by nothing that remesh_within used.
double deviation_of(const Triangulation& surface, const SurfaceMesh& mesh) {
    const MeshView reference{surface.soup().points, surface.soup().triangles}, view{mesh.points, mesh.triangles};
    return std::max(DistanceTarget(reference).measure_from(view, {.precision = 1e-3}).largest,
                    DistanceTarget(view).measure_from(reference, {.precision = 1e-3}).largest);
}

Triangulation surface_of(int kind, const TriangulationOptions& options) {
    if (kind == 0) return Triangulation(triangulations::soup(triangulations::sphere(4)), options);
    if (kind == 1) return Triangulation(triangulations::soup(triangulations::torus(60, 22)), options);
    return Triangulation(triangulations::soup(triangulations::cube(4)), options);
}

}  // namespace

TEST_CASE("a sphere, a torus and a sharp box keep their chord error, measured independently", "[property]") {
    const int kind = GENERATE(0, 1, 2);
    const double share = GENERATE(2e-3, 8e-3);
    CAPTURE(kind, share);
    const Triangulation surface = surface_of(kind, {});
    const double chord_error = share * surface.diagonal();
    int checks = 0;
    const ChordErrorResult made = within(surface, chord_error, {.hmax = surface.diagonal() / 5},
                                         {.on_check = [&](const SurfaceMesh&) { ++checks; }});
    CHECK(made.kept);
    CHECK(deviation_of(surface, made.result.mesh) <= chord_error);
    CHECK(made.deviation.bound() >= deviation_of(surface, made.result.mesh));
    CHECK(made.deviation.bound() <= chord_error);
    CHECK(measure_deviation(surface, made.result.mesh).bound() <= 1.02 * chord_error);
    CHECK(checks > made.lowerings);
    REQUIRE(made.map);
    CHECK(measure_gradation(make_mesh(made.map->points, made.map->triangles), made.map->sizes).shock_max <=
          kShock * (1 + 1e-9));
}

TEST_CASE("where sizes may not be small enough the chord error is not kept, and said so", "[property]") {
    const int kind = GENERATE(0, 1);
    const Triangulation surface = surface_of(kind, {});
    const double chord_error = 1e-4 * surface.diagonal(), hmin = surface.diagonal() / 8;
    const ChordErrorResult made = within(surface, chord_error, {.hmin = hmin, .hmax = 1.1 * hmin}, {.hmin = hmin});
    CHECK_FALSE(made.kept);
    CHECK(deviation_of(surface, made.result.mesh) > chord_error);
    CHECK(made.deviation.bound() >= deviation_of(surface, made.result.mesh));
    for (const double h : made.result.mesh.sizes) CHECK(h >= hmin * (1 - 1e-9));
}

TEST_CASE("where sizes were too large they are lowered until the chord error is kept", "[property]") {
    const Triangulation surface = surface_of(0, {});
    const double chord_error = 2e-3;
    const std::vector<double> large(surface.soup().points.size(), 0.7);
    const ChordErrorResult made = remesh_within(surface, make_background(surface, large), chord_error,
                                                {.gradation = GradationOptions{.shock = kShock}});
    CHECK(made.lowerings > 0);
    CHECK(made.kept);
    CHECK(deviation_of(surface, made.result.mesh) <= chord_error);
    REQUIRE(made.map);
    // No size of a map that is graded and was 0.7 is larger now.
    for (const double h : made.map->sizes) CHECK(h <= 0.7 * (1 + 1e-9));
}

TEST_CASE("frozen triangles that are farther off than the chord error stay, and it is said whether it is kept",
          "[property]") {
    TriangleSoup soup = triangulations::soup(triangulations::sphere(3));
    soup.required.triangles = {5, 6, 7, 40};
    const Triangulation surface(soup);
    const ChordErrorResult made = within(surface, 0.01, {.hmax = 0.5});
    CHECK(made.result.mesh.required.triangles.size() == 4);
    CHECK(made.kept == (made.deviation.bound() <= 0.01));
    if (made.kept)
        CHECK(deviation_of(surface, made.result.mesh) <= 0.01);
    else
        CHECK(made.deviation.bound() >= deviation_of(surface, made.result.mesh));
}

TEST_CASE("bad arguments of remesh_within are named", "[property]") {
    const Triangulation surface = surface_of(2, {});
    const TriangulationBackground map = make_background(surface, rule_within(0.01, {.hmax = 0.5}));
    CHECK_THROWS_AS(remesh_within(surface, map, 0), std::invalid_argument);
    CHECK_THROWS_AS(remesh_within(surface, map, std::nan("")), std::invalid_argument);
    CHECK_THROWS_AS(remesh_within(surface, map, 0.99 * least_chord_error(surface.soup().points)),
                    std::invalid_argument);
    CHECK_THROWS_AS(remesh_within(surface, map, 0.01, {.hmin = -1}), std::invalid_argument);
    CHECK_THROWS_AS(remesh_within(surface, map, 0.01, {.gradation = GradationOptions{.shock = 0.5}}),
                    std::invalid_argument);
    CHECK_THROWS_AS(remesh_within(surface, map, 0.01, {.gradation = GradationOptions{.shock = 1.5, .required = {0}}}),
                    std::invalid_argument);
}

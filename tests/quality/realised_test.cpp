#include "gradus/quality/realised.hpp"

#include "quality/meshes.hpp"

#include <catch2/catch.hpp>

using namespace gradus;
using namespace gradus::testing;

namespace {

RealisedGradation gradation_of(const Mesh& mesh) {
    return measure_realised_gradation(mesh.view(), edges_of(mesh.view()));
}

/// Rings of an annulus whose radii grow by a constant factor: every ring is the one before, scaled.
Mesh geometric_annulus(int n, int rings, double factor) {
    return grid(n, rings, true, false, [&](double u, double v) {
        const double a = 2 * std::numbers::pi * u, r = std::pow(factor, v * rings);
        return Eigen::Vector3d(r * std::cos(a), r * std::sin(a), 0);
    });
}

}  // namespace

TEST_CASE("a regular mesh has no gradation", "[quality][exact]") {
    const RealisedGradation report = gradation_of(octahedron());
    CHECK(report.size.min == Approx(std::sqrt(2.)));
    CHECK(report.shock.max == Approx(1));
    CHECK(report.variation.max == Approx(0).margin(1e-12));
    CHECK(report.neighbour_edges.max == Approx(1));
    CHECK(report.neighbour_areas.max == Approx(1));
}

TEST_CASE("a geometric progression of rings shows its factor", "[quality][exact]") {
    const double factor = GENERATE(1.1, 1.5);
    const Mesh mesh = geometric_annulus(24, 12, factor);
    const MeshEdges edges = edges_of(mesh.view());
    const std::vector<double> sizes = realised_sizes(mesh.view(), edges);
    // Inside, the sizes of successive rings differ by the factor.
    for (int ring = 2; ring < 11; ++ring) CHECK(sizes[24 * ring] / sizes[24 * (ring - 1)] == Approx(factor));
    // Sizes proportional to the radius have a slope: the variation on every radial edge, and half of the edges are no
    // steeper.
    const double slope = sizes[24 * 5] / std::pow(factor, 5);
    CHECK(gradation_of(mesh).variation.max >= slope * (1 - 1e-12));
    CHECK(gradation_of(mesh).variation.median <= slope);
    CHECK(gradation_of(mesh).shock.min >= 1);
}

TEST_CASE("neighbouring triangles are compared by edges and by area", "[quality][exact]") {
    // Areas 1/2 and 3/2 on the common edge of length 1.
    const RealisedGradation report =
        gradation_of({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -3, 0}}, {{0, 1, 2}, {1, 0, 3}}});
    CHECK(report.neighbour_areas.count == 1);
    CHECK(report.neighbour_areas.max == Approx(3));
    CHECK(report.neighbour_edges.max == Approx(std::sqrt(10.)));
}

TEST_CASE("H-shock of realised sizes follows its definition", "[quality][property]") {
    const Mesh mesh = shaken(square(12), .02, 1);
    const MeshEdges edges = edges_of(mesh.view());
    const std::vector<double> h = realised_sizes(mesh.view(), edges);
    double largest = 1, steepest = 0;
    for (const auto& [a, b] : edges.ends) {
        const double L = (mesh.points[a] - mesh.points[b]).norm();
        // The metric length by the rectangle rule on a fine division, not by its closed form.
        double length = 0;
        const int n = 2000;
        for (int i = 0; i < n; ++i) length += L / n / (h[a] * std::pow(h[b] / h[a], (i + .5) / n));
        largest = std::max(largest, std::pow(std::max(h[a] / h[b], h[b] / h[a]), 1 / length));
        steepest = std::max(steepest, std::abs(h[a] - h[b]) / L);
    }
    const RealisedGradation report = gradation_of(mesh);
    CHECK(report.shock.max == Approx(largest).epsilon(1e-6));
    CHECK(report.variation.max == Approx(steepest));
    CHECK(report.worst.front().value == report.shock.max);
    const RealisedGradation other = gradation_of(relabelled(moved(mesh, 1e4), 6));
    CHECK(other.shock.p99 == Approx(report.shock.p99));
    CHECK(other.variation.mean == Approx(report.variation.mean));
    CHECK(other.size.median == Approx(1e4 * report.size.median));
}

TEST_CASE("edges and triangles without extent are infinitely graded, never not-a-number", "[quality]") {
    const RealisedGradation report =
        gradation_of({{{0, 0, 0}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {1, 0, 3}}});
    CHECK(std::isinf(report.neighbour_edges.max));
    CHECK(report.shock.count == 5);
    const RealisedGradation nothing = gradation_of({{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}, {{0, 1, 2}}});
    CHECK(nothing.shock.max == 1);
    CHECK(nothing.variation.max == 0);
}

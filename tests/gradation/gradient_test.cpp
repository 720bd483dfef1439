#include "gradus/gradation/gradient.hpp"

#include "gradus/gradation/isotropic.hpp"
#include "gradus/gradation/measures.hpp"
#include "maps.hpp"

#include <catch2/catch.hpp>

using namespace gradus;
using namespace gradus::test;

namespace {

std::vector<double> point_source(const Tris& t, int source) {
    std::vector<double> size(t.points.size(), INFINITY);
    size[source] = .1;
    return size;
}

/// Largest distance of (h - h_source) / bound from the straight distance, relative, beyond ten edges from the source.
double distance_error(const Tris& t, const std::vector<double>& size, int source, double bound) {
    double error = 0;
    for (std::size_t v = 0; v < size.size(); ++v) {
        const double r = (t.points[v] - t.points[source]).norm();
        if (r > 10) error = std::max(error, std::abs((size[v] - size[source]) / (bound * r) - 1));
    }
    return error;
}

}  // namespace

TEST_CASE("Marching from a point gives the distance on a plane", "[gradation][converges]") {
    const double shake = GENERATE(0., .25);
    Tris t = random_tris(5, 60, 60, shake, 0);
    for (Eigen::Vector3d& p : t.points) p.z() = 0;
    const int source = 30 * 61 + 30;
    std::vector<double> marched = point_source(t, source), edges = marched;
    march_gradient(t.mesh(), .4, marched);
    limit_h_variation(t.mesh(), .4, edges);
    CHECK(distance_error(t, marched, source, .4) < .05);
    CHECK(distance_error(t, marched, source, .4) < .5 * distance_error(t, edges, source, .4));
    for (std::size_t v = 0; v < marched.size(); ++v) {
        CHECK(marched[v] <= edges[v] * (1 + 1e-14));
        CHECK(marched[v] >= .1 + .4 * (t.points[v] - t.points[source]).norm() * (1 - 1e-12));
    }
}

TEST_CASE("Across a fan of obtuse triangles marching is no worse than along edges", "[gradation][property]") {
    // Squares sheared so that every triangle is obtuse.
    Tris t = grid(40, 40, 1);
    for (Eigen::Vector3d& p : t.points) p.x() += 3 * p.y();
    std::vector<double> marched = point_source(t, 20 * 41 + 20), edges = marched;
    const GradientReduction result = march_gradient(t.mesh(), .4, marched);
    limit_h_variation(t.mesh(), .4, edges);
    CHECK(result.converged);
    for (std::size_t v = 0; v < marched.size(); ++v) CHECK(marched[v] <= edges[v] * (1 + 1e-14));
}

TEST_CASE("Limited maps meet the gradient bound in every triangle", "[gradation][property]") {
    const unsigned seed = GENERATE(range(1u, 5u));
    const double shake = GENERATE(0., .3, .45), scale = GENERATE(1e-6, 1., 1e6), bound = GENERATE(.1, .4055);
    Tris t = random_tris(seed, 20, 20, shake, shake);
    std::vector<double> size = random_sizes(seed, t.points.size(), .3, 100);
    for (std::size_t v = 0; v < size.size(); v += 3) size[v] = INFINITY;
    for (Eigen::Vector3d& p : t.points) p *= scale;
    for (double& h : size) h *= scale;
    const TriMesh mesh = t.mesh();
    std::vector<double> marched = size, limited = size;
    march_gradient(mesh, bound, marched);
    const GradientReduction result = limit_gradient(mesh, bound, limited);
    CHECK(result.converged);
    CHECK(result.above_bound == 0);
    CHECK(result.conflicts.empty());
    const GradationReport report = measure_gradation(mesh, limited);
    CHECK(report.gradient_max == Approx(result.gradient_max).epsilon(1e-14));
    CHECK(report.gradient_max <= bound * (1 + 1e-9));
    CHECK(report.variation_max <= bound * (1 + 1e-9));
    CHECK(report.shock_max <= std::exp(bound) * (1 + 1e-9));
    const double least = *std::min_element(size.begin(), size.end());
    for (std::size_t v = 0; v < size.size(); ++v) {
        CHECK(limited[v] <= size[v]);
        CHECK(limited[v] <= marched[v] * (1 + 1e-12));
        CHECK(limited[v] >= least);
    }
    std::vector<double> of_triangles = size;
    limit_gradient(points_of(mesh), triangles_of(mesh), bound, of_triangles);
    CHECK(of_triangles == limited);
    std::vector<double> again = limited;
    limit_gradient(mesh, bound, again);
    for (std::size_t v = 0; v < size.size(); ++v) CHECK(again[v] == Approx(limited[v]).epsilon(1e-8));
}

TEST_CASE("A map within the gradient bound is left alone", "[gradation][exact]") {
    Tris t = random_tris(2, 15, 15, .3, 0);
    std::vector<double> size;
    for (Eigen::Vector3d& p : t.points) {
        p.z() = 0;
        size.push_back(30 + .24 * p.x() - .31 * p.y());
    }
    const std::vector<double> input = size;
    CHECK(limit_gradient(t.mesh(), .4, size).lowered == 0);
    CHECK(size == input);
}

TEST_CASE("Two edges at full slope are flattened to the bound at least cost", "[gradation][exact]") {
    const double angle = GENERATE(.5, 1.0472, 1.5708);
    const Tris t{{{0, 0, 0}, {1, 0, 0}, {std::cos(angle), std::sin(angle), 0}}, {{0, 1, 2}}};
    std::vector<double> size{.1, INFINITY, INFINITY};
    const GradientReduction result = limit_gradient(t.mesh(), .4, size);
    // By symmetry both corners rise alike, as far as the bound along the bisector allows.
    CHECK(size[1] == Approx(.1 + .4 * std::cos(angle / 2)).epsilon(1e-9));
    CHECK(size[2] == Approx(size[1]).epsilon(1e-9));
    CHECK(result.gradient_max == Approx(.4).epsilon(1e-9));
}

TEST_CASE("Triangles without area are bounded by their edges", "[gradation]") {
    const Tris t{{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 1, 0}}, {{0, 1, 2}, {0, 3, 1}}};
    std::vector<double> size{1, 50, 50, 50};
    const TriMesh mesh = t.mesh();
    const GradientReduction result = limit_gradient(mesh, .3, size);
    CHECK(result.above_bound == 0);
    CHECK(measure_gradation(mesh, size).variation_max <= .3 * (1 + 1e-9));
}

TEST_CASE("Required sizes that are too steep are reported as triangles", "[gradation]") {
    const Tris t = grid(8, 8, 1);
    const TriMesh mesh = t.mesh();
    std::vector<double> size(t.points.size(), INFINITY);
    size[30] = .5;
    size[32] = 3;
    const GradientReduction result = limit_gradient(mesh, .4, size, std::vector<int>{30, 32});
    CHECK(size[30] == .5);
    CHECK(size[32] == 3);
    CHECK_FALSE(result.conflicts.empty());
    CHECK(static_cast<int>(result.conflicts.size()) == result.above_bound);
    const std::vector<Triangle> triangles = triangles_of(mesh);
    for (const int f : result.conflicts) CHECK(std::count(triangles[f].begin(), triangles[f].end(), 32) == 1);
}

TEST_CASE("Maps without any size stay without", "[gradation]") {
    std::vector<double> size(9, INFINITY);
    const GradientReduction result = limit_gradient(grid(2, 2, 1).mesh(), .4, size);
    CHECK(result.lowered == 0);
    CHECK(std::isinf(size[4]));
}

TEST_CASE("Strips of needles are flattened in few visits", "[gradation][property]") {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int strip = 0; strip < 2000; ++strip) {
        constexpr int n = 12;
        std::vector<Eigen::Vector3d> points;
        std::vector<Triangle> triangles;
        std::vector<double> size;
        for (int i = 0; i < n; ++i) {
            const double x = unit(random), y = .005 * unit(random);
            points.emplace_back(x, i % 2 == 1 ? y : -y, 0);
            size.push_back(.3 + unit(random));
        }
        for (int i = 0; i + 2 < n; ++i) triangles.push_back({i, i + 1 + (i + 1) % 2, i + 1 + i % 2});
        const GradientReduction reduction = limit_gradient(points, triangles, .4, size);
        CHECK(reduction.converged);
        CHECK(reduction.above_bound == 0);
        CHECK(reduction.visits < 300 * static_cast<long>(triangles.size()));
    }
}

#include "gradus/gradation/measures.hpp"

#include "maps.hpp"

#include <catch2/catch.hpp>

using namespace gradus;
using namespace gradus::test;

TEST_CASE("The measures of an edge are those of the paper", "[gradation][exact]") {
    CHECK(h_variation(2, 1, 4) == 1.5);
    CHECK(h_variation(2, 4, 1) == 1.5);
    // c = (h_Q / h_P)^(1/l), l by (7).
    const double l = 2 * 3 / (1 * 4 * std::log(4.));
    CHECK(h_shock(2, 1, 4) == Approx(std::pow(4, 1 / l)).epsilon(1e-14));
    CHECK(h_shock(2, 4, 1) == h_shock(2, 1, 4));
    CHECK(h_shock(2, 3, 3) == 1);
    CHECK(h_variation(0, 3, 3) == 0);
    CHECK(h_shock(0, 3, 3) == 1);
    CHECK(std::isinf(h_shock(1, 1, INFINITY)));
    CHECK(h_shock(1, INFINITY, INFINITY) == 1);
    CHECK(h_variation(1, INFINITY, INFINITY) == 0);
}

TEST_CASE("The shock tends to the exponential of the variation where sizes are nearly equal",
          "[gradation][converges]") {
    for (double d = 1e-15; d < 1e-5; d *= 10)
        CHECK(log_h_shock(1, 1, 1 + d) == Approx((1 + d) - 1).epsilon(2 * d + 1e-14));
}

TEST_CASE("A linear map has its slope as the gradient of every triangle", "[gradation][property]") {
    const Tris t = random_tris(3, 12, 9, .3, 0);
    Tris flat = t;
    std::vector<double> size;
    for (Eigen::Vector3d& p : flat.points) {
        p.z() = 0;
        size.push_back(20 + .3 * p.x() - .4 * p.y());
    }
    const TriMesh mesh = flat.mesh();
    for (const Eigen::Vector3d& g : size_gradients(mesh, size)) CHECK((g - Eigen::Vector3d(.3, -.4, 0)).norm() < 1e-13);
    const GradationReport report = measure_gradation(mesh, size);
    CHECK(report.gradient_max == Approx(.5));
    CHECK(report.gradient_p999 == Approx(.5));
    CHECK(report.variation_max <= .5 + 1e-12);
}

TEST_CASE("A report names the place of its maxima", "[gradation]") {
    const Tris t = grid(6, 5, 1);
    const TriMesh mesh = t.mesh();
    std::vector<double> size(t.points.size(), 1);
    size[16] = 3;
    const GradationReport report = measure_gradation(mesh, size);
    const auto holds = [](const std::array<int, 2>& edge) { return edge[0] == 16 || edge[1] == 16; };
    CHECK(holds(report.shock_edge));
    CHECK(holds(report.variation_edge));
    CHECK(report.variation_max == 2);
    CHECK(report.shock_max == Approx(h_shock(1, 1, 3)));
    CHECK(size_gradients(mesh, size)[report.gradient_triangle].norm() == report.gradient_max);
    const std::vector<double> shocks = vertex_shocks(mesh, size), variations = vertex_variations(mesh, size);
    CHECK(shocks[16] == report.shock_max);
    CHECK(shocks[0] == 1);
    CHECK(variations[16] == 2);
    CHECK(variations[15] == 2);
    CHECK(measure_gradation(mesh, std::vector<double>(t.points.size(), INFINITY)).shock_edge[0] == -1);
}

TEST_CASE("Coarse edges are those where a larger size allows a smaller neighbour", "[gradation][exact]") {
    // x = 4 (1 - e^(-x/2)) at the threshold.
    CHECK(kCoarseEdge == Approx(4 * -std::expm1(-kCoarseEdge / 2)).epsilon(1e-13));
    const TriMesh mesh =
        make_mesh(std::vector<Eigen::Vector3d>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, std::vector<Triangle>{{0, 1, 2}});
    const double h = std::log(2.) / kCoarseEdge;
    CHECK(count_coarse_edges(mesh, 2, std::vector<double>(3, h * 1.0001 * std::sqrt(2.))) == 0);
    CHECK(count_coarse_edges(mesh, 2, std::vector<double>(3, h * 1.0001)) == 1);
    CHECK(count_coarse_edges(mesh, 2, std::vector<double>(3, h * .9999)) == 3);
}

TEST_CASE("Measures refuse sizes that are none", "[gradation]") {
    const TriMesh mesh = grid(1, 1, 1).mesh();
    const double bad = GENERATE(0., -1., std::nan(""));
    std::vector<double> size{1, 1, bad, 1};
    CHECK_THROWS_WITH(measure_gradation(mesh, size), Catch::Contains("vertex 2"));
    size.pop_back();
    CHECK_THROWS_AS(measure_gradation(mesh, size), std::invalid_argument);
}

#include "gradus/quality/edges.hpp"

#include "quality/meshes.hpp"

#include <catch2/catch.hpp>

using namespace gradus;
using namespace gradus::testing;
using Eigen::Vector3d;

TEST_CASE("in a constant size map a metric length is the length over the size", "[quality][exact]") {
    const Mesh mesh = square(10);
    const MeshEdges edges = edges_of(mesh.view());
    const double h = .1;
    for (const std::vector<double>& lengths :
         {metric_lengths(mesh.view(), edges, std::vector<double>(mesh.points.size(), h)),
          metric_lengths(mesh.view(), edges, [&](const Vector3d&, int&) { return h; })}) {
        const EdgeReport report = measure_edges(edges, lengths);
        CHECK(report.length.min == Approx(1));
        CHECK(report.length.max == Approx(std::sqrt(2.)));
        CHECK(report.length.count == edges.ends.size());
        const double diagonals = 100, straight = 220;
        CHECK(report.length.mean == Approx((straight + diagonals * std::sqrt(2.)) / (straight + diagonals)));
        CHECK(report.efficiency == Approx(std::exp(diagonals * (1 / std::sqrt(2.) - 1) / (straight + diagonals))));
        CHECK(report.short_share == 0);
        REQUIRE(report.worst.size() == 10);
        CHECK(report.worst[0].value == Approx(std::sqrt(2.)));
        CHECK(report.log2_histogram.total() == edges.ends.size());
    }
}

TEST_CASE("metric lengths of one edge have closed forms", "[quality][exact]") {
    const Mesh mesh{{{0, 0, 0}, {2, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
    const MeshEdges edges = edges_of(mesh.view());
    const double h0 = .5, h1 = 2;
    SECTION("sizes at the ends, geometric between") {
        CHECK(metric_lengths(mesh.view(), edges, std::vector<double>{h0, h1, 1})[0] ==
              Approx(2 * (h1 - h0) / (h0 * h1 * std::log(h1 / h0))));
    }
    SECTION("the same map asked along the edge") {
        const auto size = [&](const Vector3d& p, int&) { return h0 * std::pow(h1 / h0, p[0] / 2); };
        CHECK(metric_lengths(mesh.view(), edges, size)[0] ==
              Approx(2 * (h1 - h0) / (h0 * h1 * std::log(h1 / h0))).epsilon(1e-6));
    }
    SECTION("a map that is linear along the edge has a logarithm for its length") {
        const auto size = [&](const Vector3d& p, int&) { return h0 + (h1 - h0) * p[0] / 2; };
        CHECK(metric_lengths(mesh.view(), edges, size)[0] == Approx(2 / (h1 - h0) * std::log(h1 / h0)).epsilon(1e-3));
    }
    SECTION("1/h of degree nine is integrated exactly") {
        const auto size = [&](const Vector3d& p, int&) { return 1 / (1 + std::pow(p[0], 9)); };
        CHECK(metric_lengths(mesh.view(), edges, size)[0] == Approx(2 + std::pow(2., 10) / 10).epsilon(1e-13));
    }
}

TEST_CASE("lengths outside the unit band are counted and listed", "[quality]") {
    const Mesh mesh{{{0, 0, 0}, {4, 0, 0}, {0, .1, 0}}, {{0, 1, 2}}};
    const MeshEdges edges = edges_of(mesh.view());
    const EdgeReport report = measure_edges(edges, metric_lengths(mesh.view(), edges, std::vector<double>(3, 1.)));
    CHECK(report.short_share == Approx(1. / 3));
    CHECK(report.long_share == Approx(2. / 3));
    CHECK(report.unit_share == 0);
    CHECK(report.worst.front().ends == std::array<int, 2>{0, 2});
}

TEST_CASE("hints travel along edges and start where the vertex says", "[quality]") {
    const Mesh mesh = octahedron();
    const MeshEdges edges = edges_of(mesh.view());
    const std::vector<int> hints{10, 11, 12, 13, 14, 15};
    std::vector<int> seen;
    metric_lengths(
        mesh.view(), edges, [&](const Vector3d&, int& hint) { return seen.push_back(hint), hint += 100, 1.; }, hints);
    REQUIRE(seen.size() == 5 * edges.ends.size());
    for (int e = 0; e < edges.size(); ++e)
        for (int i = 0; i < 5; ++i) CHECK(seen[5 * e + i] == hints[edges.ends[e][0]] + 100 * i);
}

TEST_CASE("metric lengths do not depend on place, unit or labels", "[quality][property]") {
    const Mesh mesh = shaken(torus(15, 8), .1, 9);
    std::vector<double> sizes(mesh.points.size());
    for (std::size_t v = 0; v < sizes.size(); ++v) sizes[v] = .3 + .01 * static_cast<double>(v % 37);
    const double scale = 1e3;
    std::vector<int> place;
    const Mesh other = relabelled(moved(mesh, scale), 4, &place);
    std::vector<double> other_sizes(sizes.size());
    for (std::size_t v = 0; v < sizes.size(); ++v) other_sizes[place[v]] = scale * sizes[v];
    const MeshEdges edges = edges_of(mesh.view()), other_edges = edges_of(other.view());
    const EdgeReport a = measure_edges(edges, metric_lengths(mesh.view(), edges, sizes));
    const EdgeReport b = measure_edges(other_edges, metric_lengths(other.view(), other_edges, other_sizes));
    CHECK(a.unit_share == b.unit_share);
    CHECK(a.efficiency == Approx(b.efficiency));
    CHECK(a.length.max == Approx(b.length.max));
    CHECK(a.length.p01 == Approx(b.length.p01));
}

TEST_CASE("sizes must be positive and as many as vertices, and infinite ones have no length", "[quality]") {
    const Mesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
    const MeshEdges edges = edges_of(mesh.view());
    const double infinity = std::numeric_limits<double>::infinity();
    CHECK_THROWS_AS(metric_lengths(mesh.view(), edges, std::vector<double>{1, 0, 1}), std::invalid_argument);
    CHECK_THROWS_AS(metric_lengths(mesh.view(), edges, std::vector<double>{1, std::nan(""), 1}), std::invalid_argument);
    CHECK_THROWS_AS(metric_lengths(mesh.view(), edges, std::vector<double>{1, 1}), std::invalid_argument);
    CHECK_THROWS_AS(metric_lengths(mesh.view(), edges, [](const Vector3d&, int&) { return -1.; }),
                    std::invalid_argument);
    const EdgeReport report =
        measure_edges(edges, metric_lengths(mesh.view(), edges, std::vector<double>(3, infinity)));
    CHECK(report.length.max == 0);
    CHECK(report.short_share == 1);
    CHECK(report.efficiency == Approx(std::exp(-1)));
}

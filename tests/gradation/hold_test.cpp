// Sizes are raised around held ones, no more than asked for.
#include "gradus/gradation/hold.hpp"

#include <catch2/catch.hpp>

#include "support/triangulations.hpp"

using namespace gradus;

TEST_CASE("sizes fall from a held one with the slope along the edges, down to what they were", "[property]") {
    const auto square = triangulations::graph(10, [](double, double) { return 0; });
    const TriMesh mesh = make_mesh(square.points, square.triangles);
    const double slope = GENERATE(0.3, 0.8);
    const std::vector<double> before(square.points.size(), 0.1);
    std::vector<double> held(20, 0), size = before;
    held[7] = 0.5;
    held[12] = 0.05;  // below the size: no bound
    const int raised = raise_to_held(mesh, held, slope, size);
    CHECK(size[7] == 0.5);
    int above = 0;
    for (std::size_t v = 0; v < size.size(); ++v) {
        CHECK(size[v] >= before[v]);
        CHECK(size[v] <= 0.5);
        above += size[v] > before[v];
        // Never more than along a straight line.
        CHECK(size[v] <= std::max(before[v], 0.5 - slope * (square.points[v] - square.points[7]).norm()) + 1e-12);
    }
    CHECK(above == raised);
    CHECK(raised > 5);
    for (const Triangle& t : square.triangles)
        for (int k = 0; k < 3; ++k) {
            const int a = t[k], b = t[(k + 1) % 3];
            CHECK(std::abs(size[a] - size[b]) <= slope * (square.points[a] - square.points[b]).norm() + 1e-12);
        }
    std::vector<double> again = size;
    CHECK(raise_to_held(mesh, held, slope, again) == 0);
    CHECK(again == size);
    CHECK(raise_to_held(mesh, {}, slope, again) == 0);
    CHECK_THROWS_AS(raise_to_held(mesh, held, 0, again), std::invalid_argument);
    CHECK_THROWS_AS(raise_to_held(mesh, std::vector<double>(999, 1.0), 1, again), std::invalid_argument);
}

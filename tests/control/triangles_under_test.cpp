#include "gradus/control/triangles_under.hpp"

#include <catch2/catch.hpp>

#include "gradus/mesh/closest.hpp"

using namespace gradus;

namespace {

// Adds a grid of n x n squares over the corner, first and second side.
void add_grid(std::vector<Eigen::Vector3d>& points, std::vector<Triangle>& triangles, int n,
              const Eigen::Vector3d& corner, const Eigen::Vector3d& first, const Eigen::Vector3d& second) {
    const int base = static_cast<int>(points.size());
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) points.push_back(corner + i * first / n + j * second / n);
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const int a = base + j * (n + 1) + i;
            triangles.push_back({a, a + 1, a + n + 2});
            triangles.push_back({a, a + n + 2, a + n + 1});
        }
}

}  // namespace

TEST_CASE("parts that run through each other keep to their own part of the background", "[exact]") {
    // Two squares that cross like an X, once as background, once finer as mesh, a little off.
    const Eigen::Vector3d off{0.001, 0.002, 0.0015};
    std::vector<Eigen::Vector3d> ground, points;
    std::vector<Triangle> cells, triangles;
    add_grid(ground, cells, 7, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
    const int first_part = static_cast<int>(cells.size());
    add_grid(ground, cells, 5, {-1, 0, -1}, {2, 0, 0}, {0, 0, 2});
    // The other way round, so that the order of parts says nothing.
    add_grid(points, triangles, 20, Eigen::Vector3d(-1, 0, -1) + off, {2, 0, 0}, {0, 0, 2});
    const std::size_t second = points.size();
    add_grid(points, triangles, 20, Eigen::Vector3d(-1, -1, 0) + off, {2, 0, 0}, {0, 2, 0});

    const std::vector<int> under = triangles_under(make_mesh(ground, cells), points, triangles);
    REQUIRE(under.size() == points.size());
    for (std::size_t v = 0; v < points.size(); ++v) {
        CHECK((under[v] < first_part) == (v >= second));
        const Triangle& t = cells[under[v]];
        CHECK((closest_point(points[v], ground[t[0]], ground[t[1]], ground[t[2]]) - points[v]).norm() <=
              off.norm() * (1 + 1e-9));
    }
}

TEST_CASE("a mesh in one piece may follow several parts of the background", "[exact]") {
    // One strip over two squares that are not joined.
    std::vector<Eigen::Vector3d> ground, points;
    std::vector<Triangle> cells, triangles;
    add_grid(ground, cells, 4, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    const int first_part = static_cast<int>(cells.size());
    add_grid(ground, cells, 4, {1, 0, 0}, {1, 0, 0}, {0, 1, 0});
    add_grid(points, triangles, 16, {0, 0, 0}, {2, 0, 0}, {0, 1, 0});
    const std::vector<int> under = triangles_under(make_mesh(ground, cells), points, triangles);
    for (std::size_t v = 0; v < points.size(); ++v) {
        if (points[v].x() < 0.8) CHECK(under[v] < first_part);
        if (points[v].x() > 1.2) CHECK(under[v] >= first_part);
    }
}

#include "gradus/mesh/tri_mesh.hpp"

#include <catch2/catch.hpp>

using namespace gradus;

namespace {
const std::vector<Eigen::Vector3d> kPoints{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 0, 1}};
}

TEST_CASE("make_mesh keeps indices and the order of corners", "[mesh]") {
    const std::vector<Triangle> triangles{{0, 1, 2}, {3, 2, 1}};
    const TriMesh mesh = make_mesh(kPoints, triangles);
    CHECK(triangles_of(mesh) == triangles);
    CHECK(points_of(mesh)[3] == kPoints[3]);
}

TEST_CASE("make_mesh refuses what is not an oriented manifold", "[mesh]") {
    using T = std::vector<Triangle>;
    const T bad = GENERATE(T{{0, 1, 1}}, T{{0, 1, 9}}, T{{0, 1, 2}, {1, 2, 3}}, T{{0, 1, 2}, {1, 0, 3}, {0, 1, 4}});
    CHECK_THROWS_AS(make_mesh(kPoints, bad), std::invalid_argument);
}

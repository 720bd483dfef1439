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

TEST_CASE("make_mesh links borders and vertices as OpenMesh expects", "[mesh]") {
    // Two triangles and one apart.
    std::vector<Eigen::Vector3d> points = kPoints;
    for (int i = 0; i < 3; ++i) points.push_back({5.0 + i, i * i * 1.0, 0});
    const std::vector<Triangle> triangles{{0, 1, 2}, {3, 2, 1}, {5, 6, 7}};
    const TriMesh mesh = make_mesh(points, triangles);
    CHECK(mesh.n_edges() == 8);
    int border = 0;
    for (const auto halfedge : mesh.halfedges()) {
        CHECK(halfedge.next().from() == halfedge.to());
        CHECK(halfedge.next().prev() == halfedge);
        CHECK(halfedge.next().is_boundary() == halfedge.is_boundary());
        border += halfedge.is_boundary();
    }
    CHECK(border == 7);
    for (const auto vertex : mesh.vertices()) {
        if (vertex.idx() == 4) continue;  // unused
        CHECK(vertex.is_boundary());
        CHECK(vertex.halfedge().from() == vertex);
        CHECK(mesh.is_manifold(vertex));
    }
    CHECK(mesh.valence(mesh.vertex_handle(1)) == 3);
}

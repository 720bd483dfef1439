#include "gradus/quality/topology.hpp"

#include "quality/meshes.hpp"

#include <catch2/catch.hpp>
#include <map>

using namespace gradus;
using namespace gradus::testing;

namespace {

TopologyReport topology_of(const Mesh& mesh) { return measure_topology(mesh.view(), edges_of(mesh.view())); }

}  // namespace

TEST_CASE("edges are those of the triangles", "[quality][property]") {
    const Mesh mesh = relabelled(together(torus(7, 5), square(4)), 2);
    std::map<std::array<int, 2>, int> expected;
    for (const Triangle& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) ++expected[{std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])}];
    const MeshEdges edges = edges_of(mesh.view());
    REQUIRE(edges.ends.size() == expected.size());
    int e = 0;
    for (const auto& [ends, uses] : expected) {
        CHECK(edges.ends[e] == ends);
        CHECK(edges.num_uses(e) == uses);
        for (const int use : edges.uses_of(e)) CHECK(edges.edge_of[use] == e);
        ++e;
    }
}

TEST_CASE("edges_of names a triangle with a bad index", "[quality]") {
    const Mesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 1, 3}}};
    CHECK_THROWS_WITH(edges_of(mesh.view()), Catch::Contains("triangle 1") && Catch::Contains("3"));
}

TEST_CASE("a sphere, a torus and an annulus are told apart", "[quality][exact]") {
    const unsigned seed = GENERATE(1u, 2u);
    const TopologyReport sphere = topology_of(relabelled(octahedron(), seed));
    CHECK(sphere.euler == 2);
    CHECK(sphere.genus == 0);
    CHECK(sphere.closed());
    const TopologyReport torus_report = topology_of(relabelled(torus(12, 7), seed));
    CHECK(torus_report.euler == 0);
    CHECK(torus_report.genus == 1);
    CHECK(torus_report.closed());
    const TopologyReport ring = topology_of(relabelled(annulus(12, 3), seed));
    CHECK(ring.euler == 0);
    CHECK(ring.genus == 0);
    CHECK(ring.boundary_loops == 2);
    CHECK(ring.boundary_edges == 24);
    const TopologyReport all =
        topology_of(relabelled(together(together(octahedron(), torus(9, 6)), moved(annulus(5, 2), 1)), seed));
    CHECK(all.components == 3);
    CHECK(all.boundary_loops == 2);
    CHECK(all.genus == 1);
    CHECK(all.oriented_manifold());
    CHECK(all.duplicate_positions == 0);
}

TEST_CASE("what is wrong with a mesh is counted", "[quality]") {
    SECTION("three triangles on an edge") {
        const TopologyReport report =
            topology_of({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}}, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}});
        CHECK(report.nonmanifold_edges == 1);
        CHECK(report.boundary_edges == 6);
        CHECK_FALSE(report.oriented_manifold());
        CHECK_FALSE(report.genus.has_value());
    }
    SECTION("neighbours that disagree") {
        Mesh mesh = octahedron();
        std::swap(mesh.triangles[0][0], mesh.triangles[0][1]);
        const TopologyReport report = topology_of(mesh);
        CHECK(report.misoriented_edges == 3);
        CHECK(report.nonmanifold_vertices == 0);
        CHECK_FALSE(report.genus.has_value());
    }
    SECTION("a Moebius strip cannot be oriented") {
        Mesh mesh;
        const int n = 9;
        for (int i = 0; i < n; ++i) {
            const double a = 2 * std::numbers::pi * i / n;
            for (const double w : {-.3, .3})
                mesh.points.push_back({(1 + w * std::cos(a / 2)) * std::cos(a), (1 + w * std::cos(a / 2)) * std::sin(a),
                                       w * std::sin(a / 2)});
        }
        for (int i = 0; i < n; ++i) {
            int c = 2 * (i + 1), d = 2 * (i + 1) + 1;
            if (i + 1 == n) c = 1, d = 0;
            mesh.triangles.push_back({2 * i, 2 * i + 1, d});
            mesh.triangles.push_back({2 * i, d, c});
        }
        const TopologyReport report = topology_of(mesh);
        CHECK(report.euler == 0);
        CHECK(report.boundary_loops == 1);
        CHECK(report.misoriented_edges == 1);
        CHECK(report.nonmanifold_vertices == 0);
    }
    SECTION("two fans that touch in a vertex") {
        const TopologyReport report =
            topology_of({{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}}, {{0, 1, 2}, {0, 3, 4}}});
        CHECK(report.nonmanifold_vertices == 1);
        CHECK(report.components == 1);
        CHECK(report.boundary_loops == 2);
        CHECK_FALSE(report.oriented_manifold());
    }
    SECTION("closed fans that touch in a vertex, and an open one that touches a closed one") {
        Mesh mesh = together(octahedron(), octahedron());
        for (Triangle& t : mesh.triangles)
            for (int& v : t)
                if (v == 6) v = 0;
        CHECK(topology_of(mesh).nonmanifold_vertices == 1);
        CHECK(topology_of(mesh).unused_vertices == 1);
        mesh.triangles.resize(9);
        CHECK(topology_of(mesh).nonmanifold_vertices <= 1);
        mesh.triangles[8] = {0, 7, 8};
        CHECK(topology_of(mesh).nonmanifold_vertices == 1);
        std::reverse(mesh.triangles.begin(), mesh.triangles.end());
        CHECK(topology_of(mesh).nonmanifold_vertices == 1);
    }
    SECTION("vertices: unused, twice in one place, not finite; triangles that name one twice") {
        Mesh mesh = octahedron();
        mesh.points.push_back(mesh.points[0] + Eigen::Vector3d(1e-14, 0, 0));
        mesh.points.push_back({std::nan(""), 0, 0});
        mesh.points.push_back({5, 0, 0});
        mesh.triangles.push_back({1, 1, 2});
        const TopologyReport report = topology_of(mesh);
        CHECK(report.vertices == 6);
        CHECK(report.unused_vertices == 3);
        CHECK(report.duplicate_positions == 1);
        CHECK(report.bad_points == 1);
        CHECK(report.repeated_corners == 1);
        CHECK(report.triangles == 9);
        CHECK(report.euler == 2);
    }
}

TEST_CASE("an empty mesh has nothing of anything", "[quality]") {
    const TopologyReport report = topology_of({});
    CHECK(report.components == 0);
    CHECK(report.euler == 0);
}

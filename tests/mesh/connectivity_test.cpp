#include "gradus/mesh/connectivity.hpp"

#include "gradus/quality/topology.hpp"
#include "quality/meshes.hpp"

#include <catch2/catch.hpp>
#include <functional>
#include <map>
#include <random>
#include <set>

using namespace gradus;

namespace {

std::vector<Triangle> grid(int n, bool closed) {
    // n x n squares cut in two, on a square or (glued both ways) on a torus
    std::vector<Triangle> triangles;
    const int row = closed ? n : n + 1;
    const auto at = [&](int i, int j) { return (j % row) * row + i % row; };
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    return triangles;
}

int euler(const Connectivity& mesh) {
    int vertices = 0, twice_edges = 0;
    for (int v = 0; v < mesh.num_vertices(); ++v)
        if (mesh.is_live_vertex(v)) ++vertices, twice_edges += mesh.valence(v);
    return vertices - twice_edges / 2 + mesh.num_live_triangles();
}

std::vector<Triangle> sorted_triangles(const Connectivity& mesh) {
    std::vector<Triangle> all;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        if (!mesh.is_live_triangle(t)) continue;
        Triangle x = mesh.triangle(t);
        std::rotate(x.begin(), std::min_element(x.begin(), x.end()), x.end());
        all.push_back(x);
    }
    std::sort(all.begin(), all.end());
    return all;
}

}  // namespace

TEST_CASE("connectivity stays valid under random flips, splits and collapses, and keeps its topology", "[property]") {
    const bool closed = GENERATE(false, true);
    const int n = 7;
    Connectivity mesh((n + !closed) * (n + !closed), grid(n, closed));
    REQUIRE(mesh.check().empty());
    const int before = euler(mesh);
    CHECK(before == (closed ? 0 : 1));
    std::mt19937 random(7);
    int done[3] = {0, 0, 0};
    for (int i = 0; i < 6000; ++i) {
        const int h = static_cast<int>(random() % (3 * mesh.num_triangles()));
        if (!mesh.is_live_triangle(h / 3)) continue;
        int kind = static_cast<int>(random() % 3);
        Connectivity::Journal journal;
        const bool undo = random() % 4 == 0;
        const auto was = undo ? sorted_triangles(mesh) : std::vector<Triangle>{};
        if (undo) mesh.record(&journal);
        if (kind == 0 && mesh.twin(h) >= 0 && mesh.find_edge(mesh.apex(h), mesh.apex(mesh.twin(h))) < 0 &&
            mesh.valence(mesh.origin(h)) > 3 && mesh.valence(mesh.target(h)) > 3)
            mesh.flip(h);
        else if (kind == 1 && mesh.num_live_triangles() < 400)
            mesh.split(h);
        else if (kind == 2 && mesh.can_collapse(h))
            mesh.collapse(h);
        else
            kind = -1;
        mesh.record(nullptr);
        if (kind >= 0) ++done[kind];
        INFO("step " << i << " kind " << kind << " undo " << undo);
        REQUIRE(mesh.check().empty());
        REQUIRE(euler(mesh) == before);
        if (undo) {
            mesh.undo(journal);
            REQUIRE(mesh.check().empty());
            REQUIRE(sorted_triangles(mesh) == was);
        }
    }
    CHECK(std::min({done[0], done[1], done[2]}) > 200);
}

TEST_CASE("renumbered breadth first a mesh is the same, without what was removed", "[property]") {
    // Two components and a vertex of neither; some edges collapse, and tags tell edges.
    std::vector<Triangle> triangles = grid(6, true);
    for (const Triangle& t : grid(4, false)) triangles.push_back({t[0] + 40, t[1] + 40, t[2] + 40});
    Connectivity mesh(65, triangles);
    std::mt19937 random(3);
    for (int collapses = 0; collapses < 12;) {
        const int h = static_cast<int>(random() % (3 * mesh.num_triangles()));
        if (!mesh.is_live_triangle(h / 3) || !mesh.can_collapse(h)) continue;
        mesh.collapse(h);
        ++collapses;
    }
    const auto tag_of = [](int a, int b) { return 100 * std::min(a, b) + std::max(a, b); };
    for (int h = 0; h < 3 * mesh.num_triangles(); ++h)
        if (mesh.is_live_triangle(h / 3)) mesh.set_tag(h, tag_of(mesh.origin(h), mesh.target(h)));

    const Connectivity::Numbering numbering = mesh.breadth_first();
    const Connectivity other = mesh.renumbered(numbering);
    CHECK(other.check().empty());
    CHECK(other.num_triangles() == mesh.num_live_triangles());
    CHECK(other.num_triangles() == other.num_live_triangles());
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        const int now = numbering.new_number[v];
        CHECK((now == Connectivity::kNone) == !mesh.is_live_vertex(v));
        if (now != Connectivity::kNone) CHECK(numbering.vertices[now] == v);
    }
    for (int t = 0; t < other.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) {
            const int a = numbering.vertices[other.triangle(t)[k]],
                      b = numbering.vertices[other.triangle(t)[(k + 1) % 3]];
            CHECK(mesh.triangle(numbering.triangles[t])[k] == a);
            CHECK(other.tag(3 * t + k) == tag_of(a, b));
        }
    // Neighbours are near: a vertex that is not the first of its component has one with a smaller number.
    int firsts = 0;
    for (int v = 0; v < other.num_vertices(); ++v) {
        int least = v;
        other.for_each_edge(v, [&](int, int w) { least = std::min(least, w); });
        firsts += least == v;
    }
    CHECK(firsts == 2);
}

TEST_CASE("connectivity refuses what is not an oriented manifold", "[mesh]") {
    using T = std::vector<Triangle>;
    const T bad = GENERATE(T{{0, 1, 1}}, T{{0, 1, 9}}, T{{0, 1, 2}, {1, 2, 3}}, T{{0, 1, 2}, {1, 0, 3}, {0, 1, 4}},
                           T{{0, 1, 2}, {0, 3, 4}});
    CHECK_THROWS_AS(Connectivity(5, bad), std::invalid_argument);
}

TEST_CASE("a vertex of no triangle has no edges", "[mesh]") {
    const Connectivity mesh(5, std::vector<Triangle>{{0, 1, 2}});
    CHECK(mesh.find_edge(0, 1) >= 0);
    CHECK(mesh.find_edge(3, 1) == Connectivity::kNone);
    CHECK(mesh.find_edge(4, 3) == Connectivity::kNone);
}

namespace {

// The triangles of a complex, all different and none with a corner twice, and its topology; nothing where it is no
// oriented manifold of triangles.
std::optional<TopologyReport> topology_of(const std::vector<Triangle>& triangles, int num_vertices) {
    std::set<std::set<int>> different;
    for (const Triangle& t : triangles) {
        const std::set<int> corners(t.begin(), t.end());
        if (corners.size() < 3 || !different.insert(corners).second) return std::nullopt;
    }
    std::vector<Eigen::Vector3d> points;
    for (int v = 0; v < num_vertices; ++v) points.push_back(Eigen::Vector3d(v, v * v, v * v * v));
    const MeshView view{points, triangles};
    const TopologyReport report = measure_topology(view, edges_of(view));
    if (!report.oriented_manifold()) return std::nullopt;
    return report;
}

// Whether the same surface is left where the origin of h is renamed to its target and the triangles at h are taken out.
bool may_collapse(const Connectivity& mesh, int h) {
    const int from = mesh.origin(h), to = mesh.target(h);
    std::vector<Triangle> before, after;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        if (!mesh.is_live_triangle(t)) continue;
        Triangle v = mesh.triangle(t);
        before.push_back(v);
        std::replace(v.begin(), v.end(), from, to);
        if (t != h / 3 && (mesh.twin(h) < 0 || t != mesh.twin(h) / 3)) after.push_back(v);
    }
    const auto was = topology_of(before, mesh.num_vertices()), is = topology_of(after, mesh.num_vertices());
    REQUIRE(was.has_value());
    return is && is->vertices + 1 == was->vertices && is->euler == was->euler && is->components == was->components &&
           is->boundary_loops == was->boundary_loops;
}

}  // namespace

TEST_CASE("an edge may collapse where that leaves the same surface, and nowhere else", "[property]") {
    using testing::Mesh;
    const auto points = [](int n) { return std::vector<Eigen::Vector3d>(n, Eigen::Vector3d::Zero()); };
    const std::vector<Mesh> meshes{
        {points(3), {{0, 1, 2}}},
        {points(4), {{0, 1, 2}, {1, 0, 3}}},
        {points(4), {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}}},
        {points(4), {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}}},
        testing::octahedron(),
        testing::square(3),
        testing::annulus(3, 1),
        testing::annulus(3, 2),
        testing::annulus(5, 2),
        testing::torus(3, 3),
        testing::torus(5, 4),
    };
    int may = 0, may_not = 0;
    std::mt19937 random(17);
    for (std::size_t m = 0; m < meshes.size(); ++m) {
        Connectivity mesh(static_cast<int>(meshes[m].points.size()), meshes[m].triangles);
        // As it is, then after operations that leave vertices of many valences.
        for (int round = 0; round < 12; ++round) {
            for (int h = 0; h < 3 * mesh.num_triangles(); ++h) {
                if (!mesh.is_live_triangle(h / 3)) continue;
                CAPTURE(m, round, mesh.origin(h), mesh.target(h));
                const bool expected = may_collapse(mesh, h);
                CHECK(mesh.can_collapse(h) == expected);
                ++(expected ? may : may_not);
            }
            for (int i = 0; i < 20; ++i) {
                const int h = static_cast<int>(random() % (3 * mesh.num_triangles()));
                if (!mesh.is_live_triangle(h / 3)) continue;
                if (i % 3 == 0 && mesh.num_live_triangles() < 80)
                    mesh.split(h);
                else if (i % 3 == 1 && mesh.can_collapse(h))
                    mesh.collapse(h);
                else if (i % 3 == 2 && mesh.twin(h) >= 0 && mesh.find_edge(mesh.apex(h), mesh.apex(mesh.twin(h))) < 0 &&
                         mesh.valence(mesh.origin(h)) > 3 && mesh.valence(mesh.target(h)) > 3)
                    mesh.flip(h);
            }
        }
    }
    CHECK(may >= 2000);
    CHECK(may_not >= 2000);
}

TEST_CASE("a broken connectivity is found, whatever is broken", "[exact]") {
    // What is undone from a journal that was made up is whatever the journal says.
    using Journal = Connectivity::Journal;
    // A square of 18 triangles on vertices 0 to 15, a triangle apart on 16 17 18.
    std::vector<Triangle> triangles = grid(3, false);
    triangles.push_back({16, 17, 18});
    const Connectivity sound(19, triangles);
    const auto state = [&](int t) {
        const Triangle v = sound.triangle(t);
        return Journal::TriangleState{t,
                                      v,
                                      {sound.twin(3 * t), sound.twin(3 * t + 1), sound.twin(3 * t + 2)},
                                      {sound.tag(3 * t), sound.tag(3 * t + 1), sound.tag(3 * t + 2)}};
    };
    const auto check_of = [&](Journal journal) {
        Connectivity mesh = sound;
        mesh.undo(journal);
        return mesh.check();
    };
    const auto with_triangle = [&](int t, const std::function<void(Journal::TriangleState&)>& change) {
        Journal journal;
        journal.triangles.push_back(state(t));
        change(journal.triangles.back());
        return check_of(journal);
    };
    const auto with_vertex = [&](int v, int outgoing, int valence) {
        Journal journal;
        journal.vertices.push_back({v, outgoing, valence});
        return check_of(journal);
    };
    using Catch::Contains;
    REQUIRE(check_of({}) == "");
    REQUIRE(with_triangle(8, [](auto&) {}) == "");
    REQUIRE(with_vertex(5, sound.outgoing(5), sound.valence(5)) == "");

    CHECK_THAT(with_triangle(8, [](auto& t) { t.origin[1] = 77; }), Contains("dead vertex"));
    CHECK_THAT(with_triangle(8, [](auto& t) { t.origin[1] = -5; }), Contains("dead vertex"));
    CHECK_THAT(with_triangle(8, [](auto& t) { t.origin[1] = -1; }), Contains("half a triangle"));
    CHECK_THAT(with_triangle(8, [](auto& t) { t.origin[1] = t.origin[0]; }), Contains("twice the same vertex"));
    CHECK_THAT(with_triangle(8, [](auto& t) { std::swap(t.origin[0], t.origin[1]); }), Contains("other ends"));
    CHECK_THAT(with_triangle(8, [](auto& t) { t.twin[0] = 1000; }), Contains("dead twin"));
    CHECK_THAT(with_triangle(8, [](auto& t) { t.twin[0] = -7; }), Contains("dead twin"));
    CHECK_THAT(with_triangle(8, [](auto& t) { t.twin[0] = -1; }), Contains("twins disagree"));
    CHECK_THAT(with_triangle(8, [](auto& t) { std::swap(t.twin[0], t.twin[1]); }), Contains("twins disagree"));
    CHECK_THAT(with_triangle(8, [](auto& t) { t.tag[0] = 3; }), Contains("tags differ"));
    CHECK_THAT(with_triangle(8, [](auto& t) { t.origin = {-1, -1, -1}; }), Contains("dead twin"));
    CHECK_THAT(with_triangle(18, [](auto& t) { t.origin = {-1, -1, -1}, t.tag[0] = 3; }), Contains("remains"));
    CHECK_THAT(with_triangle(18, [](auto& t) { t.origin = {-1, -1, -1}; }), Contains("outgoing"));
    CHECK_THAT(with_vertex(5, sound.outgoing(6), sound.valence(5)), Contains("outgoing"));
    CHECK_THAT(with_vertex(5, 1000, sound.valence(5)), Contains("outgoing"));
    CHECK_THAT(with_vertex(5, -2, sound.valence(5)), Contains("outgoing"));
    CHECK_THAT(with_vertex(5, sound.outgoing(5), sound.valence(5) + 1), Contains("valence of vertex 5"));
    CHECK_THAT(with_vertex(5, -1, 0), Contains("dead vertex"));
    // The fan of a vertex on the boundary begins there.
    REQUIRE(sound.is_boundary_vertex(1));
    CHECK_THAT(with_vertex(1, sound.rotate(sound.outgoing(1)), sound.valence(1)), Contains("fan of vertex 1"));

    const auto with_free = [&](std::vector<Journal::Recycling> of_triangles,
                               std::vector<Journal::Recycling> of_vertices) {
        Journal journal;
        // The triangle apart is removed.
        journal.triangles.push_back({18, {-1, -1, -1}, {-1, -1, -1}, {-1, -1, -1}});
        for (const int v : {16, 17, 18}) journal.vertices.push_back({v, -1, 0});
        journal.recycled_triangles = std::move(of_triangles);
        journal.recycled_vertices = std::move(of_vertices);
        return check_of(journal);
    };
    CHECK(with_free({{18, false}}, {{16, false}}) == "");
    CHECK_THAT(with_free({}, {}), Contains("removed and not free"));
    CHECK_THAT(with_free({{4, false}, {18, false}}, {}), Contains("free triangle 4 is alive"));
    CHECK_THAT(with_free({{18, false}, {18, false}}, {}), Contains("listed twice"));
    CHECK_THAT(with_free({{18, false}, {99, false}}, {}), Contains("out of range"));
    CHECK_THAT(with_free({{18, false}}, {{3, false}}), Contains("free vertex 3 is alive"));

    // Two triangles glued along two of their sides only: the third ones are two edges between the same vertices.
    Connectivity pillow(3, std::vector<Triangle>{{0, 1, 2}, {1, 0, 2}});
    REQUIRE(pillow.check() == "");
    Journal open;
    open.triangles.push_back({0, {0, 1, 2}, {-1, 5, 4}, {-1, -1, -1}});
    open.triangles.push_back({1, {1, 0, 2}, {-1, 2, 1}, {-1, -1, -1}});
    open.vertices.push_back({0, 0, 3});
    open.vertices.push_back({1, 3, 3});
    pillow.undo(open);
    CHECK_THAT(pillow.check(), Contains("two edges to the same neighbour of vertex 0"));
}

#include "gradus/mesh/connectivity.hpp"

#include <catch2/catch.hpp>
#include <map>
#include <random>

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

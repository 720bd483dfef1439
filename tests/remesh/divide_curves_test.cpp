// Runs of feature curves in pieces of one metric length, on surfaces in closed form.
#include "../../src/remesh/divide_curves.hpp"
#include "remesh/simple_supports.hpp"

#include <catch2/catch.hpp>

using namespace gradus;
using namespace gradus::testing;
using Eigen::Vector3d;

namespace {

constexpr double kMean = 1.04;  // metric length of edges where areas are as asked

// Metric lengths of the edges of a curve, in the order of its parameter.
std::vector<double> pieces_of(const Editor& editor, const SimpleSupport& support, int curve) {
    std::vector<std::pair<double, double>> pieces;
    const Connectivity& mesh = editor.mesh();
    for (int h = 0; h < 3 * mesh.num_triangles(); ++h) {
        if (!mesh.is_live_triangle(h / 3) || thawed_tag(mesh.tag(h)) != curve || mesh.twin(h) > h) continue;
        const Vector3d middle = (editor.vertex(mesh.origin(h)).p + editor.vertex(mesh.target(h)).p) / 2;
        pieces.emplace_back(support.curves[curve].parameter(middle), editor.length(h));
    }
    std::sort(pieces.begin(), pieces.end());
    std::vector<double> lengths;
    for (const auto& piece : pieces) lengths.push_back(piece.second);
    return lengths;
}

int wanted(double length, int least = 1) { return std::max(least, static_cast<int>(std::lround(length / kMean))); }

// Pieces are made even until no vertex moves by more than 0.02: a tenth or so is left from one end to the other.
void check_even(const std::vector<double>& lengths) {
    const double mean = std::accumulate(lengths.begin(), lengths.end(), 0.0) / static_cast<double>(lengths.size());
    for (const double length : lengths) CHECK(std::abs(length / mean - 1) <= 0.12);
    for (std::size_t i = 0; i + 1 < lengths.size(); ++i) CHECK(std::abs(lengths[i + 1] - lengths[i]) <= 0.06);
}

// The unit disc in rings of n around its middle.
Mesh disc(int n, int rings) {
    Mesh mesh{{{0, 0, 0}}, {}};
    for (int k = 1; k <= rings; ++k)
        for (int i = 0; i < n; ++i) {
            const double angle = 2 * std::numbers::pi * i / n;
            mesh.points.push_back(double(k) / rings * Vector3d(std::cos(angle), std::sin(angle), 0));
        }
    for (int i = 0; i < n; ++i) mesh.triangles.push_back({0, 1 + i, 1 + (i + 1) % n});
    for (int k = 1; k < rings; ++k)
        for (int i = 0; i < n; ++i) {
            const int a = 1 + (k - 1) * n + i, b = 1 + (k - 1) * n + (i + 1) % n;
            mesh.triangles.push_back({a, a + n, b + n});
            mesh.triangles.push_back({a, b + n, b});
        }
    return mesh;
}

// A good mesh with edges of a length, of what the support covers.
Mesh good_mesh(SimpleSupport support, double h, const Mesh& mesh) {
    support.wanted = [h](const Vector3d&) { return h; };
    Editor editor = editor_with_curves(support, mesh);
    StageClock::Stages stages;
    StageClock clock(stages);
    optimise(editor, {}, clock);
    return mesh_of(editor);
}

}  // namespace

TEST_CASE("Sides are divided into as many equal pieces as their linear sizes ask for", "[remesh][exact]") {
    int more = 0, fewer = 0;
    const Mesh start = good_mesh(square_support(1), 0.1, square(10));
    for (const auto& [h0, h1] : {std::pair{0.1, 0.1},
                                 {0.09, 0.09},
                                 {0.11, 0.11},
                                 {0.08, 0.12},
                                 {0.07, 0.14},
                                 {0.14, 0.07},
                                 {0.05, 0.15},
                                 {0.2, 0.1}}) {
        CAPTURE(h0, h1);
        SimpleSupport support = square_support(1);
        support.wanted = [h0 = h0, h1 = h1](const Vector3d& p) { return h0 + (h1 - h0) * p.x(); };
        Editor editor = editor_with_curves(support, start);
        const TopologyReport before = topology_of(editor);
        int edges_before = 0;
        for (int side = 0; side < 4; ++side) edges_before += static_cast<int>(pieces_of(editor, support, side).size());
        OptimiseReport report;
        divide_curves(editor, {}, report);
        // The integral of dx / h; that of the edges is as if sizes were geometric along each.
        const double along = h0 == h1 ? 1 / h0 : std::log(h1 / h0) / (h1 - h0);
        const double lengths[4] = {along, 1 / h1, along, 1 / h0};
        int edges = 0;
        for (int side = 0; side < 4; ++side) {
            const std::vector<double> pieces = pieces_of(editor, support, side);
            CAPTURE(side, lengths[side], pieces);
            CHECK(static_cast<int>(pieces.size()) == wanted(lengths[side]));
            CHECK(std::accumulate(pieces.begin(), pieces.end(), 0.0) == Approx(lengths[side]).epsilon(2e-3));
            edges += static_cast<int>(pieces.size());
            // Those that were as many as wanted stay where they were.
            if (pieces.size() != 10) check_even(pieces);
        }
        CHECK(report.splits - report.collapses == edges - edges_before);
        more += report.splits;
        fewer += report.collapses;
        CHECK(editor.mesh().check() == "");
        CHECK(topology_of(editor).euler == before.euler);
        CHECK(least_facing(editor) > 0);
    }
    CHECK(more >= 10);
    CHECK(fewer >= 10);
}

TEST_CASE("What has as many pieces as wanted is left as it is to the bit", "[remesh][exact]") {
    SimpleSupport support = square_support(0.1);
    Mesh mesh = square(10);
    mesh.points[3].x() = 0.33;
    Editor editor = editor_with_curves(support, mesh);
    const std::vector<Vertex> before = editor.vertices();
    OptimiseReport report;
    divide_curves(editor, {}, report);
    CHECK(report.splits + report.collapses + report.flips == 0);
    for (std::size_t v = 0; v < before.size(); ++v) CHECK(editor.vertex(static_cast<int>(v)).p == before[v].p);
    CHECK(mesh_of(editor).triangles == mesh.triangles);
}

TEST_CASE("A closed curve is divided all round, into three at least", "[remesh][exact]") {
    SimpleSupport round = plane(1);
    round.curves.push_back(circle(1));
    const Mesh start = good_mesh(round, 0.3, disc(20, 3));
    for (const double h : {0.2, 0.25, 0.3, 0.36, 0.42, 30.0}) {
        CAPTURE(h);
        SimpleSupport support = round;
        support.wanted = [h](const Vector3d&) { return h; };
        Editor editor = editor_with_curves(support, start);
        const std::vector<double> before = pieces_of(editor, support, 0);
        const double length = std::accumulate(before.begin(), before.end(), 0.0);
        // Chords are a little shorter than the circle.
        CHECK(length == Approx(2 * std::numbers::pi / h).epsilon(0.01));
        OptimiseReport report;
        divide_curves(editor, {}, report);
        const std::vector<double> pieces = pieces_of(editor, support, 0);
        CAPTURE(length, pieces);
        CHECK(pieces.size() >= 3);
        if (h < 1) CHECK(static_cast<int>(pieces.size()) == wanted(length, 3));
        if (h < 1 && pieces.size() != before.size()) check_even(pieces);
        CHECK(editor.mesh().check() == "");
        CHECK(topology_of(editor).boundary_loops == 1);
        CHECK(least_facing(editor) > 0);
        for (int v = 0; v < editor.mesh().num_vertices(); ++v)
            if (editor.mesh().is_live_vertex(v) && editor.mesh().is_boundary_vertex(v))
                CHECK(editor.vertex(v).p.norm() == Approx(1).epsilon(1e-12));
    }
}

TEST_CASE("Curves end at frozen edges, on either side of which they are divided for themselves", "[remesh][exact]") {
    for (const double h : {0.07, 0.1, 0.16}) {
        CAPTURE(h);
        const SimpleSupport support = square_support(h);
        const Editor plain = editor_with_curves(support, square(10));
        std::vector<Vertex> vertices = plain.vertices();
        Connectivity mesh = plain.mesh();
        mesh.set_tag(mesh.find_edge(3, 4), frozen_tag(0));
        vertices[3].bound = vertices[4].bound = Bound::Fixed;
        Editor editor(support, support, vertices, mesh);
        OptimiseReport report;
        divide_curves(editor, {}, report);
        const Connectivity& now = editor.mesh();
        const std::vector<double> pieces = pieces_of(editor, support, 0);
        int left = 0;  // pieces on the left of the frozen edge
        for (int e = 0; e < 3 * now.num_triangles(); ++e)
            left += now.is_live_triangle(e / 3) && now.tag(e) == 0 && editor.vertex(now.target(e)).p.x() < 0.31;
        const std::vector<double> before(pieces.begin(), pieces.begin() + left);
        const std::vector<double> after(pieces.begin() + left + 1, pieces.end());
        CAPTURE(before, after);
        CHECK(static_cast<int>(before.size()) == wanted(0.3 / h));
        CHECK(static_cast<int>(after.size()) == wanted(0.6 / h));
        if (before.size() != 3) check_even(before);
        if (after.size() != 6) check_even(after);
        CHECK(now.tag(now.find_edge(3, 4)) == frozen_tag(0));
        for (const int v : {3, 4}) CHECK(editor.vertex(v).p == plain.vertex(v).p);
        CHECK(now.check() == "");
        CHECK(least_facing(editor) > 0);
    }
}

TEST_CASE("Curves shorter than a piece become one edge, and one edge stays what it is", "[remesh][exact]") {
    const SimpleSupport support = square_support(10);
    Editor editor = editor_with_curves(support, square(4));
    OptimiseReport report;
    divide_curves(editor, {}, report);
    for (int side = 0; side < 4; ++side) CHECK(pieces_of(editor, support, side).size() == 1);
    CHECK(report.collapses == 12);
    CHECK(report.splits == 0);
    CHECK(editor.mesh().check() == "");
    CHECK(least_facing(editor) > 0);
    // An edge between corners has no vertex that slides, however long: it is for splits.
    const SimpleSupport fine = square_support(0.01);
    Editor four = editor_with_curves(fine, {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {{0, 1, 3}, {0, 3, 2}}});
    OptimiseReport none;
    divide_curves(four, {}, none);
    CHECK(none.splits + none.collapses == 0);
}

TEST_CASE("Curves are divided only where the mesh is worked at", "[remesh][exact]") {
    const SimpleSupport support = square_support(0.05);
    const Mesh mesh = square(10);
    Editor editor = editor_with_curves(support, mesh);
    OptimiseOptions options;
    options.active.assign(mesh.points.size(), 0);
    for (int v = 0; v < 11; ++v) options.active[v] = 1;
    OptimiseReport report;
    divide_curves(editor, options, report);
    CHECK(static_cast<int>(pieces_of(editor, support, 0).size()) == wanted(20));
    for (const int side : {1, 2, 3}) CHECK(pieces_of(editor, support, side).size() == 10);
}

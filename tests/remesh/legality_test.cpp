// What each operation refuses, and that what it allows leaves the same surface.
#include "remesh/simple_supports.hpp"

#include <catch2/catch.hpp>

#include <set>

using namespace gradus;
using namespace gradus::testing;
using Eigen::Vector3d;

namespace {

void check_same_surface(const Editor& editor, const TopologyReport& before) {
    CHECK(editor.mesh().check() == "");
    const TopologyReport now = topology_of(editor);
    CHECK(now.oriented_manifold());
    CHECK(now.duplicate_positions == 0);
    CHECK(now.euler == before.euler);
    CHECK(now.components == before.components);
    CHECK(now.boundary_loops == before.boundary_loops);
    CHECK(least_facing(editor) > 0);
}

// The unit square in n x n quads with features on its sides.
Editor square_editor(const SimpleSupport& support, int n) { return editor_with_curves(support, square(n)); }

// The half-edge from a to b.
int between(const Editor& editor, int a, int b) {
    const int h = editor.mesh().find_edge(a, b);
    REQUIRE(h >= 0);
    const int along = editor.mesh().origin(h) == a ? h : editor.mesh().twin(h);
    REQUIRE(along >= 0);
    return along;
}

// A vertex in the middle, number 0, with a ring around.
Mesh fan(const std::vector<Vector3d>& ring) {
    Mesh mesh{{{0, 0, 0}}, {}};
    mesh.points.insert(mesh.points.end(), ring.begin(), ring.end());
    const int count = static_cast<int>(ring.size());
    for (int k = 0; k < count; ++k) mesh.triangles.push_back({0, 1 + k, 1 + (k + 1) % count});
    return mesh;
}
std::vector<Vector3d> polygon(int count, double radius = 1, double turned = 0) {
    std::vector<Vector3d> points;
    for (int k = 0; k < count; ++k) {
        const double angle = 2 * std::numbers::pi * k / count + turned;
        points.push_back(radius * Vector3d(std::cos(angle), std::sin(angle), 0));
    }
    return points;
}
// The same with a second ring around, so that all of the first are inside.
Mesh two_rings(int count, double radius = 1) {
    Mesh mesh = fan(polygon(count, radius));
    const std::vector<Vector3d> outer = polygon(count, 2 * radius, std::numbers::pi / count);
    mesh.points.insert(mesh.points.end(), outer.begin(), outer.end());
    for (int k = 0; k < count; ++k) {
        const int a = 1 + k, b = 1 + (k + 1) % count, c = a + count, d = b + count;
        mesh.triangles.insert(mesh.triangles.end(), {{a, c, b}, {b, c, d}});
    }
    return mesh;
}

}  // namespace

TEST_CASE("An edge flips inside its two triangles, and no boundary or feature does", "[remesh][exact]") {
    SimpleSupport support = square_support(0.25);
    Editor editor = square_editor(support, 4);
    const TopologyReport before = topology_of(editor);
    CHECK_FALSE(editor.can_flip(between(editor, 1, 2)));
    const Editor untagged = editor_of(support, square(4));
    CHECK_FALSE(untagged.can_flip(between(untagged, 1, 2)));
    const int diagonal = between(editor, 6, 12);
    REQUIRE(editor.can_flip(diagonal));
    REQUIRE(editor.flip(diagonal));
    CHECK(editor.mesh().find_edge(6, 12) < 0);
    CHECK(editor.mesh().find_edge(7, 11) >= 0);
    check_same_surface(editor, before);

    // The same with a feature along the middle.
    const int upright = between(square_editor(support, 4), 7, 12);
    CHECK(square_editor(support, 4).can_flip(upright));
    support.curves.push_back(segment({0.5, 0, 0}, {0.5, 1, 0}));
    CHECK_FALSE(square_editor(support, 4).can_flip(upright));
}

TEST_CASE("No flip leaves a vertex with too few edges, or joins two vertices twice", "[remesh][exact]") {
    const SimpleSupport support = plane();
    for (const int spokes : {3, 4, 5, 6}) {
        CAPTURE(spokes);
        const Mesh mesh = two_rings(spokes);
        Editor editor = editor_of(support, mesh);
        CHECK(editor.can_flip(between(editor, 0, 1)) == (spokes > 4));
        std::vector<Vertex> vertices = editor.vertices();
        vertices[0].lean = kAnyNormal;
        vertices[0].bound = Bound::Fixed;
        // At a point of the surface three are enough. Of three spokes the other ends are joined.
        const Editor pointed(support, support, vertices, editor.mesh());
        CHECK(pointed.can_flip(between(pointed, 0, 1)) == (spokes > 3));
    }
    // A tetrahedron 0 1 2 3 with a vertex more on two of its sides: 2 and 3, across 0 1, are joined.
    const Mesh mesh{{{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, -1, -1}},
                    {{0, 1, 3}, {1, 0, 2}, {0, 3, 4}, {3, 2, 4}, {2, 0, 4}, {1, 2, 5}, {2, 3, 5}, {3, 1, 5}}};
    const SimpleSupport round = ball(1, 1);
    std::vector<Vertex> vertices = editor_of(round, mesh).vertices();
    for (Vertex& v : vertices) v.lean = kAnyNormal;
    const Editor solid(round, round, vertices, Connectivity(6, mesh.triangles));
    REQUIRE(topology_of(solid).closed());
    CHECK(solid.mesh().valence(0) == 4);
    CHECK(solid.mesh().valence(1) == 4);
    CHECK_FALSE(solid.can_flip(between(solid, 0, 1)));
    CHECK(solid.can_flip(between(solid, 0, 3)));
}

TEST_CASE("No flip folds a triangle over", "[remesh][exact]") {
    const SimpleSupport support = plane();
    // Two triangles that form an arrowhead, then a kite: only of the kite both diagonals are inside.
    for (const double tip : {0.4, -0.4}) {
        CAPTURE(tip);
        Mesh mesh{{{0, -1, 0}, {tip, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {3, -2, 0}, {3, 2, 0}, {-3, 0, 0}}, {}};
        mesh.triangles = {{0, 1, 3}, {1, 2, 3}, {0, 4, 1}, {4, 5, 1}, {1, 5, 2}, {2, 6, 3}, {6, 0, 3}};
        Editor editor = editor_of(support, mesh);
        const TopologyReport before = topology_of(editor);
        // Valences stay as they must for vertices of corners.
        std::vector<Vertex> vertices = editor.vertices();
        for (Vertex& v : vertices) v.bound = Bound::Fixed;
        Editor fixed(support, support, vertices, editor.mesh());
        const int inner = between(fixed, 1, 3);
        CHECK(fixed.flip(inner) == (tip > 0));
        check_same_surface(fixed, before);
    }
}

TEST_CASE("Corners stay, and vertices of features leave them by no collapse", "[remesh][exact]") {
    SimpleSupport support = square_support(0.4);
    support.curves.push_back(segment({0.5, 0, 0}, {0.5, 1, 0}));
    Editor editor = square_editor(support, 4);
    const TopologyReport before = topology_of(editor);
    REQUIRE(editor.vertex(0).bound == Bound::Fixed);
    REQUIRE(editor.vertex(1).bound == Bound::Curve);
    REQUIRE(editor.vertex(2).bound == Bound::Fixed);  // where the middle meets a side
    REQUIRE(editor.vertex(12).bound == Bound::Curve);
    REQUIRE(editor.vertex(6).bound == Bound::Free);
    int from_corners = 0, off_curves = 0;
    for (int h = 0; h < 3 * editor.mesh().num_triangles(); ++h) {
        const Vertex& from = editor.vertex(editor.mesh().origin(h));
        const bool along = editor.mesh().tag(h) >= 0 && from.place.curve == editor.mesh().tag(h);
        CAPTURE(editor.mesh().origin(h), editor.mesh().target(h));
        const bool off_curve = from.bound == Bound::Curve && !along;
        from_corners += from.bound == Bound::Fixed;
        off_curves += off_curve;
        if (from.bound == Bound::Fixed || off_curve) CHECK_FALSE(editor.can_collapse(h));
    }
    CHECK(from_corners >= 12);
    CHECK(off_curves >= 30);
    // Along the middle, and a free vertex to it.
    REQUIRE(editor.can_collapse(between(editor, 12, 17)));
    REQUIRE(editor.collapse(between(editor, 12, 17)));
    check_same_surface(editor, before);
    CHECK_FALSE(editor.mesh().is_live_vertex(12));
    CHECK(editor.mesh().tag(editor.mesh().find_edge(7, 17)) == 4);
    REQUIRE(editor.can_collapse(between(editor, 8, 7)));
    REQUIRE(editor.collapse(between(editor, 8, 7)));
    check_same_surface(editor, before);
}

TEST_CASE("No collapse changes the topology", "[remesh][exact]") {
    const SimpleSupport support = plane(0.5);
    // A strip around a hole, one quad wide: each edge across joins two boundaries.
    const Mesh ring = annulus(12, 1);
    const Editor editor = editor_of(support, ring);
    int across = 0;
    for (int h = 0; h < 3 * editor.mesh().num_triangles(); ++h) {
        if (editor.mesh().twin(h) < 0) continue;
        ++across;
        CHECK_FALSE(editor.can_collapse(h));
    }
    CHECK(across == 48);
    // A tube three edges around: 0 1 2 is no triangle, as inside there is nothing.
    const Mesh tube = grid(3, 4, true, false, [](double u, double v) {
        const double a = 2 * std::numbers::pi * u;
        return Vector3d(std::cos(a), std::sin(a), 4 * v);
    });
    SimpleSupport cylinder = plane(4);
    cylinder.project = [](const Vector3d& p) {
        return Vector3d(p.x() / std::hypot(p.x(), p.y()), p.y() / std::hypot(p.x(), p.y()), p.z());
    };
    cylinder.normal = [](const Vector3d& p) { return Vector3d(p.x(), p.y(), 0).normalized(); };
    const Editor around = editor_of(cylinder, tube);
    CHECK_FALSE(around.mesh().can_collapse(between(around, 6, 7)));
    CHECK_FALSE(around.can_collapse(between(around, 6, 7)));
    // Four edges around it may.
    const Mesh wide = grid(4, 4, true, false, [](double u, double v) {
        const double a = 2 * std::numbers::pi * u;
        return Vector3d(std::cos(a), std::sin(a), 4 * v);
    });
    CHECK(editor_of(cylinder, wide).mesh().can_collapse(between(editor_of(cylinder, wide), 8, 9)));
}

TEST_CASE("No collapse makes one edge of two features, or takes edges that a vertex needs", "[remesh][exact]") {
    SimpleSupport support = square_support(0.4);
    // The rows y = 1/2 and, above it, a feature that leaves from the middle of a quad's side to the corner beyond.
    support.curves.push_back(segment({0, 0.5, 0}, {1, 0.5, 0}));
    Editor plain = square_editor(support, 4);
    const int h = between(plain, 12, 13);
    REQUIRE(plain.can_collapse(h));
    const int beside = plain.mesh().apex(h);
    Connectivity tagged = plain.mesh();
    tagged.set_tag(tagged.find_edge(12, beside), 2);
    CHECK(Editor(support, support, plain.vertices(), tagged).can_collapse(h));
    tagged.set_tag(tagged.find_edge(13, beside), 2);
    CHECK_FALSE(Editor(support, support, plain.vertices(), tagged).can_collapse(h));

    // Apexes of valence four.
    for (const int spokes : {4, 5}) {
        const SimpleSupport flat = plane();
        const Editor editor = editor_of(flat, two_rings(spokes));
        CHECK(editor.mesh().can_collapse(between(editor, 1, 2)));
        CHECK(editor.can_collapse(between(editor, 1, 2)) == (spokes == 5));
    }
}

TEST_CASE("No collapse folds a triangle over or makes edges much too long", "[remesh][exact]") {
    // A ring with a notch: seen from vertex 1 what is behind vertex 3, at the notch, is hidden; from 3 all is seen.
    std::vector<Vector3d> ring = polygon(8, 1);
    ring[2] = {0, 0.2, 0};
    const SimpleSupport support = plane();
    for (const int to : {1, 3}) {
        CAPTURE(to);
        std::vector<Vertex> vertices = editor_of(support, fan(ring)).vertices();
        for (int v = 1; v <= 8; ++v) vertices[v].bound = Bound::Fixed;
        Editor editor(support, support, vertices, Connectivity(9, fan(ring).triangles));
        const TopologyReport before = topology_of(editor);
        REQUIRE(editor.can_collapse(between(editor, 0, to)));
        CHECK(editor.collapse(between(editor, 0, to)) == (to == 3));
        check_same_surface(editor, before);
    }
    // In a hexagon the edge through its middle becomes twice as long.
    for (const double h : {1.0, 1.2}) {
        CAPTURE(h);
        const SimpleSupport sized = plane(h);
        Editor editor = editor_of(sized, fan(polygon(6)));
        CHECK(editor.collapse(between(editor, 0, 1)) == (h > 1.1));
    }
    // A piece of a feature as long as two.
    for (const double h : {0.3, 0.4}) {
        CAPTURE(h);
        const SimpleSupport sides = square_support(h);
        Editor editor = square_editor(sides, 4);
        CHECK(editor.collapse(between(editor, 1, 2)) == (h > 0.36));
        Editor lenient = square_editor(sides, 4);
        CHECK(lenient.collapse(between(lenient, 1, 2), 2));
    }
}

TEST_CASE("A split puts a vertex on the surface, or on the feature, and none where that is another part of it",
          "[remesh][exact]") {
    const SimpleSupport sides = square_support(0.25);
    Editor editor = square_editor(sides, 4);
    const TopologyReport before = topology_of(editor);
    const int inside = editor.split(between(editor, 6, 12)), on_side = editor.split(between(editor, 2, 3));
    REQUIRE(inside >= 0);
    REQUIRE(on_side >= 0);
    check_same_surface(editor, before);
    CHECK(editor.vertex(inside).p == Vector3d(0.375, 0.375, 0));
    CHECK(editor.vertex(inside).bound == Bound::Free);
    CHECK(editor.vertex(on_side).p == Vector3d(0.625, 0, 0));
    CHECK(editor.vertex(on_side).bound == Bound::Curve);
    for (const int end : {2, 3}) CHECK(editor.mesh().tag(editor.mesh().find_edge(end, on_side)) == 0);
    CHECK(editor.mesh().find_edge(2, 3) < 0);

    // A support on which the middle of an edge is a tenth, or eight tenths, of the edge away.
    for (const double off : {0.1, 0.8}) {
        CAPTURE(off);
        SimpleSupport bent = plane();
        const Mesh hexagon = fan(polygon(6));
        std::vector<Vertex> vertices = editor_of(bent, hexagon).vertices();
        bent.project = [off](const Vector3d& p) { return Vector3d(p.x(), p.y(), off); };
        Editor over(bent, bent, vertices, Connectivity(7, hexagon.triangles));
        CHECK((over.split(between(over, 0, 1)) >= 0) == (off < 0.5));
    }

    // Arcs of less and more than half a circle, over their chords: the middle of the longer one is far from the chord.
    for (const double angle : {2.9, 4.7}) {
        CAPTURE(angle);
        SimpleSupport arc = plane();
        const auto at = [angle](double t) {
            return Vector3d(std::cos(angle * (t - 0.5)), std::sin(angle * (t - 0.5)), 0);
        };
        arc.curves.push_back({at, [angle](const Vector3d& p) { return std::atan2(p.y(), p.x()) / angle + 0.5; }});
        Mesh triangle{{at(0), at(1), {-4, 0, 0}}, {{0, 1, 2}}};
        std::vector<Vertex> vertices;
        for (const Vector3d& p : triangle.points) vertices.push_back(vertex_at(arc, p));
        Connectivity mesh(3, triangle.triangles);
        mesh.set_tag(0, 0);
        Editor one(arc, arc, vertices, mesh);
        CHECK((one.split(0) >= 0) == (angle < 3.2));
    }
}

TEST_CASE("Nothing that is frozen is touched", "[remesh][exact]") {
    const SimpleSupport sides = square_support(0.1);
    Editor plain = square_editor(sides, 4);
    std::vector<Vertex> vertices = plain.vertices();
    Connectivity mesh = plain.mesh();
    // The edge in the middle, and a side.
    for (const auto& [a, b] : {std::pair{12, 13}, {1, 2}}) {
        const int h = mesh.find_edge(a, b);
        mesh.set_tag(h, frozen_tag(mesh.tag(h)));
        CHECK(thawed_tag(mesh.tag(h)) == plain.mesh().tag(h));
        vertices[a].bound = vertices[b].bound = Bound::Fixed;
    }
    Editor editor(sides, sides, vertices, mesh);
    for (const auto& [a, b] : {std::pair{12, 13}, {1, 2}}) {
        const int h = between(editor, a, b);
        CHECK(editor.is_frozen(h));
        CHECK(editor.split(h) < 0);
        CHECK_FALSE(editor.can_flip(h));
        CHECK_FALSE(editor.can_collapse(h));
        if (const int g = editor.mesh().twin(h); g >= 0) CHECK_FALSE(editor.can_collapse(g));
        for (const int v : {a, b}) {
            CHECK(editor.relax(v) == 0);
            CHECK(editor.vertex(v).p == plain.vertex(v).p);
        }
        CHECK(plain.split(between(plain, a, b)) >= 0);
    }
}

TEST_CASE("A vertex of a feature moves along it, and corners not at all", "[remesh][exact]") {
    const SimpleSupport sides = square_support(0.25);
    Mesh mesh = square(4);
    mesh.points[2] = {0.42, 0, 0};
    Editor editor = editor_with_curves(sides, mesh);
    for (int round = 0; round < 20; ++round)
        for (int v = 0; v < 25; ++v) editor.relax(v);
    for (const int corner : {0, 4, 20, 24}) CHECK(editor.vertex(corner).p == mesh.points[corner]);
    for (int k = 1; k < 4; ++k) {
        CHECK(editor.vertex(k).p.y() == 0);
        CHECK(editor.vertex(5 * k).p.x() == 0);
        CHECK(editor.vertex(5 * k + 4).p.x() == 1);
        CHECK(editor.vertex(20 + k).p.y() == 1);
    }
    CHECK(editor.vertex(2).p.x() != mesh.points[2].x());
    check_same_surface(editor, topology_of(editor_with_curves(sides, mesh)));
}

TEST_CASE("A vertex of a feature is centred between its neighbours, unless a triangle would fold", "[remesh][exact]") {
    // On the x axis between 0 and 1; the edge from c to d, opposite to it, leans over what is half way, or does not.
    for (const bool leans : {false, true}) {
        CAPTURE(leans);
        SimpleSupport support = plane();
        support.curves.push_back(segment({-1, 0, 0}, {2, 0, 0}));
        const Vector3d c = leans ? Vector3d(0.3, 0.2, 0) : Vector3d(0.9, 0.9, 0),
                       d = leans ? Vector3d(0.24, 0.6, 0) : Vector3d(0.1, 0.9, 0);
        const Mesh mesh{{{0, 0, 0}, {1, 0, 0}, {0.2, 0, 0}, c, d, {0.3, -1, 0}},
                        {{2, 1, 3}, {2, 3, 4}, {2, 4, 0}, {2, 0, 5}, {2, 5, 1}}};
        std::vector<Vertex> vertices;
        for (int v = 0; v < 6; ++v)
            vertices.push_back(v < 3 ? vertex_on(support, 0, mesh.points[v]) : vertex_at(support, mesh.points[v]));
        Connectivity connectivity(6, mesh.triangles);
        connectivity.set_tag(connectivity.find_edge(0, 2), 0);
        connectivity.set_tag(connectivity.find_edge(1, 2), 0);
        Editor editor(support, support, vertices, connectivity);
        REQUIRE(least_facing(editor) > 0);
        const double moved = editor.centre(2, 0, 1);
        CHECK((moved > 0) == !leans);
        CHECK(editor.vertex(2).p.x() == Approx(leans ? 0.2 : 0.5).epsilon(1e-12));
        CHECK(editor.vertex(2).p.y() == 0);
        CHECK(least_facing(editor) > 0);
    }
}

TEST_CASE("Whatever operations are tried in a row, the mesh covers the same surface with the same features",
          "[remesh][property]") {
    enum Tried { kFlip, kCollapse, kSplit, kRelax };
    for (const bool closed : {false, true}) {
        SimpleSupport support = closed ? ball(1, 0.25) : square_support(0.2);
        if (!closed) support.curves.push_back(segment({0.5, 0, 0}, {0.5, 1, 0}));
        const auto start = [&] {
            if (closed) return editor_of(support, triangulations::sphere(3));
            const Editor plain = square_editor(support, 6);
            std::vector<Vertex> vertices = plain.vertices();
            Connectivity mesh = plain.mesh();
            mesh.set_tag(mesh.find_edge(29, 30), frozen_tag(-1));
            vertices[29].bound = vertices[30].bound = Bound::Fixed;
            return Editor(support, support, vertices, mesh);
        };
        Editor editor = start();
        const TopologyReport before = topology_of(editor);
        const std::vector<Vertex> first = editor.vertices();
        std::mt19937 random(21);
        int done[4] = {}, refused[4] = {};
        for (int i = 0; i < 8000; ++i) {
            const int h = static_cast<int>(random() % (3 * editor.mesh().num_triangles()));
            if (!editor.mesh().is_live_triangle(h / 3)) continue;
            const int live = editor.mesh().num_live_triangles(), tried = static_cast<int>(random() % 4);
            if ((tried == kSplit && live > 500) || (tried == kCollapse && live < 60)) continue;
            bool applied = false;
            if (tried == kFlip) applied = editor.can_flip(h) && editor.flip(h);
            if (tried == kCollapse) applied = editor.can_collapse(h) && editor.collapse(h);
            if (tried == kSplit) applied = editor.split(h) >= 0;
            if (tried == kRelax) applied = editor.relax(editor.mesh().origin(h)) > 0;
            ++(applied ? done : refused)[tried];
            if (!applied || i % 7 != 0) continue;
            CAPTURE(closed, i, tried);
            check_same_surface(editor, before);
            if (closed) continue;
            double area = 0, on_features = 0;
            for (int t = 0; t < editor.mesh().num_triangles(); ++t) {
                if (!editor.mesh().is_live_triangle(t)) continue;
                const Triangle v = editor.mesh().triangle(t);
                area += (editor.vertex(v[1]).p - editor.vertex(v[0]).p)
                            .cross(editor.vertex(v[2]).p - editor.vertex(v[0]).p)
                            .z() /
                        2;
                for (int e = 3 * t; e < 3 * t + 3; ++e)
                    if (editor.mesh().tag(e) >= 0 && !editor.is_frozen(e))
                        on_features += (editor.mesh().twin(e) < 0 ? 1 : 0.5) *
                                       (editor.vertex(v[e % 3]).p - editor.vertex(v[(e + 1) % 3]).p).norm();
            }
            CHECK(area == Approx(1).epsilon(1e-12));
            CHECK(on_features == Approx(5).epsilon(1e-12));
            CHECK(editor.mesh().find_edge(29, 30) >= 0);
        }
        for (std::size_t v = 0; v < first.size(); ++v)
            if (first[v].bound == Bound::Fixed) {
                CHECK(editor.mesh().is_live_vertex(static_cast<int>(v)));
                CHECK(editor.vertex(static_cast<int>(v)).p == first[v].p);
            }
        for (const int tried : {kFlip, kCollapse, kSplit, kRelax}) {
            CAPTURE(closed, tried, done[tried], refused[tried]);
            CHECK(done[tried] >= 50);
            if (tried != kSplit || !closed) CHECK(refused[tried] >= 20);
        }
    }
}

// What is tried and not kept leaves no trace.
#include "remesh/simple_supports.hpp"

#include <catch2/catch.hpp>

#include <cstring>

using namespace gradus;
using namespace gradus::testing;
using Eigen::Vector3d;

namespace {

template <class T>
bool same_bits(const T& a, const T& b) {
    return std::memcmp(&a, &b, sizeof(T)) == 0;
}

bool same(const Vertex& a, const Vertex& b) {
    const auto bits = [](const Vertex& v) {
        return std::array<double, 11>{v.p.x(),
                                      v.p.y(),
                                      v.p.z(),
                                      v.h,
                                      v.n.x(),
                                      v.n.y(),
                                      v.n.z(),
                                      v.g,
                                      v.place.t,
                                      double(v.lean),
                                      double(v.place.at.patch)};
    };
    return same_bits(bits(a), bits(b)) && a.bound == b.bound && a.place.curve == b.place.curve &&
           a.place.cell == b.place.cell && a.place.vertex == b.place.vertex && a.place.at.uv == b.place.at.uv;
}

// All that a mesh can be asked for, where it was long before. @returns an empty string or what differs
std::string difference(const Connectivity& was, const Connectivity& now) {
    if (now.num_live_triangles() != was.num_live_triangles()) return "number of triangles";
    for (int h = 0; h < 3 * now.num_triangles(); ++h) {
        const auto at = [h](const char* what) { return what + (" of half-edge " + std::to_string(h)); };
        if (h >= 3 * was.num_triangles()) {
            if (now.is_live_triangle(h / 3)) return at("a triangle more:");
            continue;
        }
        if (now.origin(h) != was.origin(h)) return at("origin");
        if (now.twin(h) != was.twin(h)) return at("twin");
        if (now.tag(h) != was.tag(h)) return at("tag");
    }
    for (int v = 0; v < now.num_vertices(); ++v) {
        const auto at = [v](const char* what) { return what + (" of vertex " + std::to_string(v)); };
        if (v >= was.num_vertices()) {
            if (now.is_live_vertex(v)) return at("a vertex more:");
            continue;
        }
        if (now.outgoing(v) != was.outgoing(v)) return at("outgoing half-edge");
        if (now.valence(v) != was.valence(v)) return at("valence");
    }
    return now.check();
}

std::string difference(const Editor& was, const Editor& now) {
    if (const std::string fault = difference(was.mesh(), now.mesh()); !fault.empty()) return fault;
    for (int v = 0; v < was.mesh().num_vertices(); ++v)
        if (was.mesh().is_live_vertex(v) && !same(was.vertex(v), now.vertex(v))) return "vertex " + std::to_string(v);
    return {};
}

// One operation drawn at random, where it is legal. @returns whether one was done
bool operate(Connectivity& mesh, std::mt19937& random) {
    const int h = static_cast<int>(random() % (3 * mesh.num_triangles())), kind = static_cast<int>(random() % 3);
    if (!mesh.is_live_triangle(h / 3)) return false;
    if (kind == 0) {
        if (mesh.twin(h) < 0 || mesh.find_edge(mesh.apex(h), mesh.apex(mesh.twin(h))) >= 0 ||
            mesh.valence(mesh.origin(h)) <= 3 || mesh.valence(mesh.target(h)) <= 3)
            return false;
        mesh.flip(h);
    } else if (kind == 1) {
        mesh.split(h);
    } else {
        if (!mesh.can_collapse(h)) return false;
        mesh.collapse(h);
    }
    return true;
}

}  // namespace

TEST_CASE("Any number of operations in one journal are undone, to what they were and to the numbers given next",
          "[remesh][property]") {
    for (const bool closed : {false, true}) {
        const Mesh start = closed ? torus(7, 5) : square(6);
        Connectivity mesh(static_cast<int>(start.points.size()), start.triangles);
        for (int h = 0; h < 3 * mesh.num_triangles(); ++h) mesh.set_tag(h, h % 5 - 1);
        std::mt19937 random(31);
        int undone = 0;
        for (int i = 0; i < 400; ++i) {
            CAPTURE(closed, i);
            const Connectivity was = mesh;
            const unsigned seed = random();
            const int count = 1 + static_cast<int>(random() % 20);
            const auto run = [&](Connectivity& on, unsigned from) {
                std::mt19937 same(from);
                for (int k = 0; k < count; ++k) undone += operate(on, same);
            };
            Connectivity::Journal journal;
            mesh.record(&journal);
            run(mesh, seed);
            mesh.undo(journal);
            REQUIRE(difference(was, mesh) == "");
            // What comes after that is as if nothing had been.
            if (i % 8 != 0) continue;
            Connectivity one = was, other = mesh;
            const auto split_all = [](Connectivity& on) {
                for (int h = 0; h < 12; ++h)
                    if (on.is_live_triangle(h / 3)) on.split(h);
            };
            split_all(one);
            split_all(other);
            REQUIRE(difference(one, other) == "");
            run(mesh, seed + 1);
            REQUIRE(mesh.check() == "");
        }
        CHECK(undone > 2000);
    }
}

TEST_CASE("Attempts that are not kept give back every bit", "[remesh][property]") {
    for (const bool closed : {false, true}) {
        SimpleSupport support = closed ? ball(1, 0.25) : square_support(0.15);
        if (!closed) support.curves.push_back(segment({0.5, 0, 0}, {0.5, 1, 0}));
        // Sizes that vary, so that vertices that move have others.
        support.wanted = [h = support.wanted({})](const Vector3d& p) { return h * (1 + 0.5 * std::sin(3 * p.x())); };
        Mesh mesh = closed ? triangulations::sphere(3) : square(6);
        if (!closed)
            for (Vector3d& p : mesh.points)
                if (p.x() > 0 && p.x() < 1 && p.y() > 0 && p.y() < 1 && p.x() != 0.5)
                    p += Vector3d(0.03 * std::sin(40 * p.y()), 0.03 * std::cos(50 * p.x()), 0);
        Editor editor = closed ? editor_of(support, mesh) : editor_with_curves(support, mesh);
        std::mt19937 random(32);
        // A guard that refuses half of what the energy lets pass.
        editor.set_guard([&](const Editor&, std::span<const int> around) {
            CHECK_FALSE(around.empty());
            return random() % 2 == 0;
        });
        using Operation = Editor::Operation;
        const Operation all[] = {Operation::Move, Operation::Push, Operation::Flip, Operation::Collapse,
                                 Operation::Split};
        int kept = 0, given_back = 0;
        for (int i = 0; i < 800; ++i) {
            const int h = static_cast<int>(random() % (3 * editor.mesh().num_triangles()));
            if (!editor.mesh().is_live_triangle(h / 3)) continue;
            const Operation operation = all[random() % 5];
            const bool possible = operation == Operation::Flip       ? editor.can_flip(h)
                                  : operation == Operation::Collapse ? editor.can_collapse(h)
                                                                     : true;
            if (!possible) continue;
            const Editor was = editor;
            const int way = static_cast<int>(random() % 4);
            const auto reach = random() % 2 == 0 ? Editor::Reach::Near : Editor::Reach::Wide;
            bool done = false;
            if (way < 2) done = editor.attempt(operation, h, way == 0 ? Aim::Mean : Aim::Worst, 1.1, reach);
            if (way == 2) done = editor.attempt_pair(operation, h, 1.1, Editor::Search::Quick);
            if (way == 3) {
                const Triangle t = editor.mesh().triangle(h / 3);
                done = editor.mend({t[0], t[1], t[2]}, editor.vertex(t[0]).p * 0.4 + editor.vertex(t[1]).p * 0.6);
            }
            ++(done ? kept : given_back);
            CAPTURE(closed, i, way, static_cast<int>(operation));
            REQUIRE(editor.mesh().check() == "");
            if (!done) REQUIRE(difference(was, editor) == "");
        }
        CHECK(kept >= 50);
        CHECK(given_back >= 200);
    }
}

TEST_CASE("Nothing is kept that the guard does not let pass", "[remesh][exact]") {
    const SimpleSupport support = ball(1, 0.3);
    for (const bool lets : {true, false}) {
        Editor editor = editor_of(support, triangulations::sphere(3));
        const Editor was = editor;
        int asked = 0, kept = 0;
        editor.set_guard([&](const Editor&, std::span<const int>) {
            ++asked;
            return lets;
        });
        for (int h = 0; h < 3 * editor.mesh().num_triangles(); h += 7)
            if (editor.mesh().is_live_triangle(h / 3) && editor.can_collapse(h))
                kept += editor.attempt(Editor::Operation::Collapse, h, Aim::Mean, 1.1);
        CHECK(asked > 0);
        CHECK((kept > 0) == lets);
        if (!lets) CHECK(difference(was, editor) == "");
    }
}

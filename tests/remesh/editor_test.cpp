// Operations one by one, on a plane.
#include "../../src/remesh/editor.hpp"

#include <catch2/catch.hpp>

using namespace gradus;
using Eigen::Vector3d;

namespace {

// The plane z = 0, with one size everywhere; halves of edges lie where they are told to.
class Plane : public Support, public MetricField<Size> {
  public:
    std::optional<Foot> move(const Place& from, const Vector3d&, const Vector3d& target) const override {
        return foot(from, target);
    }
    std::optional<Foot> between(const Place& a, const Place&, const Vector3d&) const override { return foot(a, half); }
    std::optional<Foot> slide(const Place&, const Vector3d&) const override { return std::nullopt; }
    int chain_of(int curve) const override { return curve; }
    Foot middle(int, const Foot& a, const Foot&) const override { return a; }

    Foot foot(const Place& place, const Vector3d& p) const { return {place, p, Vector3d::UnitZ()}; }
    double size(const Vector3d&, int&) const override { return wanted; }

    Vector3d half{0, 0, 0};
    double wanted = 1;
};

Editor edited(const Plane& plane, const std::vector<Vector3d>& points, const std::vector<Triangle>& triangles,
              const std::vector<int>& corners = {}) {
    std::vector<Vertex> vertices(points.size());
    for (std::size_t v = 0; v < points.size(); ++v) stand(vertices[v], plane.foot({}, points[v]), plane, plane);
    for (const int v : corners) vertices[v].bound = Bound::Fixed, vertices[v].lean = kAnyNormal;
    return {plane, plane, std::move(vertices), Connectivity(static_cast<int>(points.size()), triangles)};
}

// Twice the area seen from above.
double area(const Editor& editor, int t) {
    const Triangle v = editor.mesh().triangle(t);
    const Vector3d &a = editor.vertex(v[0]).p, &b = editor.vertex(v[1]).p, &c = editor.vertex(v[2]).p;
    return (b - a).cross(c - a).z();
}

}  // namespace

TEST_CASE("an edge beside a needle is halved in line, and not where a half would fold over", "[exact]") {
    // A needle of height 1/1000 over the edge from 0 to 1, and a good triangle under it.
    Plane plane;
    Editor editor = edited(plane, {{0, 0, 0}, {1, 0, 0}, {0.5, 0.001, 0}, {0.5, -0.9, 0}}, {{0, 1, 2}, {1, 0, 3}});
    plane.half = {0.5, 0.01, 0};
    CHECK(editor.split(0) < 0);
    CHECK(editor.mesh().num_live_triangles() == 2);
    plane.half = {0.5, 0, 0};
    CHECK(editor.split(0) >= 0);
    REQUIRE(editor.mesh().num_live_triangles() == 4);
    for (int t = 0; t < 4; ++t) CHECK(area(editor, t) > 0);
}

TEST_CASE("no flip puts a triangle between corners across a notch", "[exact]") {
    const Plane plane;
    // Seen from 3 the notch between 0 and 2 goes as far as 1.
    Editor editor = edited(plane, {{1, 1, 0}, {0, 0, 0}, {1, -1, 0}, {-1.5, 0, 0}}, {{0, 3, 1}, {3, 2, 1}}, {0, 1, 2});
    const int inner = editor.mesh().find_edge(1, 3);
    REQUIRE(editor.mesh().twin(inner) >= 0);
    CHECK_FALSE(editor.flip(inner));
    for (int t = 0; t < 2; ++t) CHECK(area(editor, t) > 0);
}

namespace {

// A hexagon of 24 triangles around its centre, vertex 0, in two rings.
struct Hexagon {
    std::vector<Vector3d> points{{0, 0, 0}};
    std::vector<Triangle> triangles;
    Hexagon() {
        const auto at = [](double r, double sixths) {
            return Vector3d(r * std::cos(sixths * std::acos(0.5)), r * std::sin(sixths * std::acos(0.5)), 0);
        };
        for (int i = 0; i < 6; ++i) points.push_back(at(1, i));
        for (int i = 0; i < 6; ++i) points.push_back(at(2, i)), points.push_back(at(std::sqrt(3.0), i + 0.5));
        for (int i = 0; i < 6; ++i) {
            const int a = 1 + i, b = 1 + (i + 1) % 6, out = 7 + 2 * i, between = out + 1, next = 7 + (2 * i + 2) % 12;
            triangles.insert(triangles.end(), {{0, a, b}, {a, out, between}, {a, between, b}, {b, between, next}});
        }
    }
};

double nearest_vertex(const Editor& editor, const Vector3d& p) {
    double nearest = std::numeric_limits<double>::infinity();
    for (int v = 0; v < editor.mesh().num_vertices(); ++v)
        if (editor.mesh().is_live_vertex(v)) nearest = std::min(nearest, (editor.vertex(v).p - p).norm());
    return nearest;
}

}  // namespace

TEST_CASE("a fault is mended by what its guard lets pass, or not at all", "[exact]") {
    const Plane plane;
    const Hexagon hexagon;
    Editor editor = edited(plane, hexagon.points, hexagon.triangles);
    REQUIRE(editor.mesh().check().empty());
    const Vector3d fault(0.3, 0.2, 0);
    const std::vector<Vertex> before = editor.vertices();
    const auto triangles = [&] {
        std::vector<Triangle> all;
        for (int t = 0; t < editor.mesh().num_triangles(); ++t)
            if (editor.mesh().is_live_triangle(t)) all.push_back(editor.mesh().triangle(t));
        return all;
    };
    const std::vector<Triangle> triangles_before = triangles();

    editor.set_guard([](const Editor&, std::span<const int>) { return false; });
    CHECK_FALSE(editor.mend({0, 1, 2}, fault));
    CHECK(triangles() == triangles_before);
    CHECK(editor.mesh().check().empty());
    for (std::size_t v = 0; v < before.size(); ++v) CHECK(editor.vertex(static_cast<int>(v)).p == before[v].p);

    editor.set_guard([&](const Editor& now, std::span<const int> around) {
        CHECK_FALSE(around.empty());
        return nearest_vertex(now, fault) < 1e-9;
    });
    CHECK(editor.mend({0, 1, 2}, fault));
    CHECK(nearest_vertex(editor, fault) < 1e-9);
    CHECK(editor.mesh().check().empty());
    for (int t = 0; t < editor.mesh().num_triangles(); ++t) CHECK(editor.quality(t) > 0.5);
}

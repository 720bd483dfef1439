// Frozen vertices, edges and triangles of a triangulation come out bit for bit, and the mesh around them is sound.
#include <catch2/catch.hpp>
#include <map>
#include <random>
#include <set>

#include "gradus/control/control_space.hpp"
#include "gradus/control/triangulation.hpp"
#include "gradus/gradation/grade.hpp"
#include "gradus/gradation/hold.hpp"
#include "gradus/quality/report.hpp"
#include "gradus/remesh/triangulated.hpp"
#include "support/triangulations.hpp"

using namespace gradus;
using Eigen::Vector3d;

namespace {

SizingRule uniform(double h) {
    return {.kind = SizingRule::Kind::Proportional, .value = 1e6, .hmin = 0.999999 * h, .hmax = h};
}

SurfaceMesh remeshed(const Triangulation& surface, const SizingRule& rule, const RemeshOptions& options = {}) {
    TriangulationBackground map = make_background(surface, rule);
    grade(map.background.mesh, map.sizes, {.shock = 1.5});
    raise_to_held(map.background.mesh, frozen_edge_lengths(surface.soup().points, surface.mesh(), surface.frozen()),
                  kHoldSlope, map.sizes);
    const ControlSpace control(map.background, map.sizes);
    const SmoothSupport support = surface.support();
    return remesh({support, surface.features(), surface.soup().labels, &surface.soup().required}, control, map.cells,
                  options)
        .mesh;
}

// Some of each kind, and a connected patch of triangles.
RequiredElements some_of(const TriangleSoup& soup, unsigned seed) {
    std::mt19937 random(seed);
    RequiredElements required;
    const auto any_triangle = [&] { return static_cast<int>(random() % soup.triangles.size()); };
    std::set<int> triangles;
    for (int i = 0; i < 6; ++i) {
        required.vertices.push_back(soup.triangles[any_triangle()][0]);
        const Triangle& t = soup.triangles[any_triangle()];
        required.edges.push_back({t[1], t[2]});
        triangles.insert(any_triangle());
    }
    const Connectivity mesh(static_cast<int>(soup.points.size()), soup.triangles);
    const int start = any_triangle();
    mesh.for_each_outgoing(soup.triangles[start][0], [&](int h) { triangles.insert(h / 3); });
    required.triangles.assign(triangles.begin(), triangles.end());
    return required;
}

using Bits = std::array<double, 3>;
Bits bits(const Vector3d& p) { return {p.x(), p.y(), p.z()}; }

// By coordinates, whatever the mesh says of itself.
void check_kept(const TriangleSoup& soup, const SurfaceMesh& mesh) {
    std::map<Bits, int> vertex;
    for (std::size_t v = 0; v < mesh.points.size(); ++v) CHECK(vertex.emplace(bits(mesh.points[v]), v).second);
    const auto number = [&](int v) {
        const auto found = vertex.find(bits(soup.points[v]));
        return found == vertex.end() ? -1 : found->second;
    };
    std::set<std::array<int, 2>> sides;
    std::set<Triangle> triangles;
    for (const Triangle& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) {
            sides.insert({t[k], t[(k + 1) % 3]});
            triangles.insert({t[k], t[(k + 1) % 3], t[(k + 2) % 3]});
        }
    const RequiredElements &in = soup.required, &out = mesh.required;
    REQUIRE(out.vertices.size() == in.vertices.size());
    REQUIRE(out.edges.size() == in.edges.size());
    REQUIRE(out.triangles.size() == in.triangles.size());
    for (std::size_t i = 0; i < in.vertices.size(); ++i) CHECK(out.vertices[i] == number(in.vertices[i]));
    for (std::size_t i = 0; i < in.edges.size(); ++i) {
        const std::array edge{number(in.edges[i][0]), number(in.edges[i][1])};
        CHECK((sides.contains(edge) || sides.contains({edge[1], edge[0]})));
        CHECK(out.edges[i] == edge);
    }
    for (std::size_t i = 0; i < in.triangles.size(); ++i) {
        const Triangle& t = soup.triangles[in.triangles[i]];
        const Triangle moved{number(t[0]), number(t[1]), number(t[2])};
        CHECK(triangles.contains(moved));
        const std::set<int> corners(moved.begin(), moved.end());
        const Triangle& found = mesh.triangles[out.triangles[i]];
        CHECK(std::set<int>(found.begin(), found.end()) == corners);
    }
}

void check_sound(const TriangleSoup& soup, const SurfaceMesh& mesh) {
    const MeshReport before = measure({soup.points, soup.triangles}), after = measure({mesh.points, mesh.triangles});
    CHECK(after.topology.oriented_manifold());
    CHECK(after.topology.euler == before.topology.euler);
    CHECK(after.topology.components == before.topology.components);
    CHECK(after.topology.boundary_loops == before.topology.boundary_loops);
    CHECK(after.topology.unused_vertices == 0);
    CHECK(after.topology.duplicate_positions == 0);
    CHECK(after.shape.degenerate == 0);
}

double signed_volume(std::span<const Vector3d> points, std::span<const Triangle> triangles) {
    double sum = 0;
    for (const Triangle& t : triangles) sum += points[t[0]].dot(points[t[1]].cross(points[t[2]])) / 6;
    return sum;
}

}  // namespace

TEST_CASE("frozen elements chosen at random are in the mesh bit for bit", "[property]") {
    const int shape = GENERATE(0, 1, 2, 3);
    const unsigned seed = GENERATE(1u, 2u, 3u);
    const double scale = GENERATE(0.5, 2.5);  // finer and coarser than the input
    const bool fast = GENERATE(false, true);
    CAPTURE(shape, seed, scale, fast);
    const auto mesh =
        shape == 0   ? triangulations::sphere(3)
        : shape == 1 ? triangulations::torus(30, 12)
        : shape == 2
            ? triangulations::cube(4)
            : triangulations::graph(10, [](double x, double y) { return 0.1 * std::sin(6 * x) * std::cos(5 * y); });
    TriangleSoup soup = triangulations::soup(mesh);
    soup.required = some_of(soup, seed);
    const Triangulation surface(soup);
    const SurfaceMesh made = remeshed(surface, uniform(scale * triangulations::mean_edge(mesh)), {.fast = fast});
    check_kept(soup, made);
    check_sound(soup, made);
    if (shape < 3)
        CHECK(signed_volume(made.points, made.triangles) ==
              Approx(signed_volume(soup.points, soup.triangles)).epsilon(0.02 + 0.07 * scale));
}

TEST_CASE("a mesh with everything frozen is the input, and one with nothing required is what it was", "[property]") {
    TriangleSoup soup = triangulations::soup(triangulations::cube(3));
    const Triangulation plain(soup);
    const SurfaceMesh before = remeshed(plain, uniform(0.2));
    CHECK(before.required.empty());
    for (int t = 0; t < static_cast<int>(soup.triangles.size()); ++t) soup.required.triangles.push_back(t);
    const Triangulation surface(soup);
    const SurfaceMesh made = remeshed(surface, uniform(0.2));
    check_kept(soup, made);
    CHECK(made.triangles.size() == soup.triangles.size());
    CHECK(made.points.size() == soup.points.size());
}

TEST_CASE("frozen elements are kept again from the mesh they came out in", "[property]") {
    TriangleSoup soup = triangulations::soup(triangulations::capped_cylinder(24, 8, 1, 2, 4));
    soup.required = some_of(soup, 5);
    const Triangulation surface(soup);
    const SurfaceMesh once = remeshed(surface, uniform(0.3));
    TriangleSoup again{once.points, once.triangles};
    again.edges = once.features;
    again.required = once.required;
    const Triangulation second(again);
    const SurfaceMesh twice = remeshed(second, uniform(0.15));
    check_kept(again, twice);
    // The input's own elements, still.
    TriangleSoup first = soup;
    check_kept(first, twice);
    check_sound(soup, twice);
}

TEST_CASE("sizes lead from the frozen edges to those asked for", "[property]") {
    // A cap of small triangles on a sphere that is to be coarse, and one of large triangles where it is to be fine.
    const bool small = GENERATE(true, false);
    CAPTURE(small);
    TriangleSoup soup = triangulations::soup(triangulations::sphere(small ? 5 : 3));
    for (int t = 0; t < static_cast<int>(soup.triangles.size()); ++t) {
        const Triangle& v = soup.triangles[t];
        if ((soup.points[v[0]] + soup.points[v[1]] + soup.points[v[2]]).z() > 3 * 0.92)
            soup.required.triangles.push_back(t);
    }
    REQUIRE(soup.required.triangles.size() > 10);
    const Triangulation surface(soup);
    const std::vector<double> lengths = frozen_edge_lengths(surface.soup().points, surface.mesh(), surface.frozen());
    const TriangulationBackground map = make_background(surface, uniform(small ? 0.4 : 0.06));
    for (std::size_t v = 0; v < lengths.size(); ++v)
        if (lengths[v] > 0)
            CHECK(map.sizes[v] == lengths[v]);
        else
            CHECK(map.sizes[v] == Approx(small ? 0.4 : 0.06));
    const SurfaceMesh made = remeshed(surface, uniform(small ? 0.4 : 0.06));
    check_kept(soup, made);
    check_sound(soup, made);
    // Around what is frozen the triangles are good.
    const std::set<int> kept(made.required.triangles.begin(), made.required.triangles.end());
    double sum = 0, worst = 1;
    for (int t = 0; t < static_cast<int>(made.triangles.size()); ++t) {
        if (kept.contains(t)) continue;
        const auto& [a, b, c] = made.triangles[t];
        const double quality = area_length(made.points[a], made.points[b], made.points[c]);
        sum += quality;
        worst = std::min(worst, quality);
    }
    CHECK(sum / static_cast<double>(made.triangles.size() - kept.size()) > 0.93);
    CHECK(worst > 0.6);
    CHECK(measure({made.points, made.triangles}).shape.adjacent_edge_ratio.max < 5);
}

TEST_CASE("a frozen needle does not keep the mesh around it from being good", "[property]") {
    TriangleSoup soup = triangulations::soup(triangulations::graph(
        14, [](double, double) { return 0; }, 0));
    // A vertex inside, moved next to a side of its triangle.
    const Connectivity mesh(static_cast<int>(soup.points.size()), soup.triangles);
    const int t = 200;
    const auto [a, b, c] = soup.triangles[t];
    soup.points[c] = 0.5 * soup.points[a] + 0.5 * soup.points[b] + 0.03 * (soup.points[c] - soup.points[a]);
    soup.required.triangles = {t};
    const Triangulation surface(soup);
    const SurfaceMesh made = remeshed(surface, uniform(0.05));
    check_kept(soup, made);
    check_sound(soup, made);
    double area = 0, worst = 1;
    for (std::size_t i = 0; i < made.triangles.size(); ++i) {
        const auto& [p, q, r] = made.triangles[i];
        const Vector3d n = (made.points[q] - made.points[p]).cross(made.points[r] - made.points[p]);
        CHECK(n.z() > 0);
        area += n.z() / 2;
        if (static_cast<int>(i) != made.required.triangles[0])
            worst = std::min(worst, area_length(made.points[p], made.points[q], made.points[r]));
    }
    CHECK(area == Approx(1).epsilon(1e-9));
    CHECK(worst > 0.4);
}

TEST_CASE("frozen elements do not depend on the number of threads or on chance", "[property]") {
    TriangleSoup soup = triangulations::soup(triangulations::torus(24, 10));
    soup.required = some_of(soup, 9);
    const Triangulation surface(soup);
    const SurfaceMesh a = remeshed(surface, uniform(0.3), {.threads = 1}),
                      b = remeshed(surface, uniform(0.3), {.threads = 2});
    CHECK(a.points == b.points);
    CHECK(a.triangles == b.triangles);
    CHECK(a.required == b.required);
}

TEST_CASE("a triangulation refuses what cannot be kept of it", "[property]") {
    TriangleSoup soup = triangulations::soup(triangulations::cube(1));
    soup.required.triangles = {12};
    CHECK_THROWS_WITH(Triangulation(soup), Catch::Contains("required triangle 12"));
}

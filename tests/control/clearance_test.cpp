// Distances between features that face each other, and between sheets: closed forms, a dull search as the oracle,
// invariances.
#include "gradus/control/clearance.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "gradus/control/control_space.hpp"
#include "gradus/mesh/closest.hpp"
#include "support/triangulations.hpp"

using namespace gradus;
using Eigen::Vector3d;
using triangulations::Mesh;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TriangleSoup strip(int along, double length, double width) {
    return triangulations::soup(
        testing::grid(along, 1, false, false, [=](double u, double v) { return Vector3d(length * u, width * v, 0); }));
}

// One triangle with an angle at the origin and sides of length 1 from it, cut into n rows from there.
TriangleSoup wedge(double degrees, int n) {
    const double angle = degrees * std::numbers::pi / 180;
    TriangleSoup soup{{{0, 0, 0}}, {}};
    for (int i = 1; i <= n; ++i) {
        const double s = double(i) / n;
        soup.points.push_back({s, 0, 0});
        soup.points.push_back({s * std::cos(angle), s * std::sin(angle), 0});
    }
    soup.triangles.push_back({0, 1, 2});
    for (int i = 1; i < n; ++i) {
        soup.triangles.push_back({2 * i - 1, 2 * i + 1, 2 * i + 2});
        soup.triangles.push_back({2 * i - 1, 2 * i + 2, 2 * i});
    }
    return soup;
}

// A box from the origin with a grid of n x n quads on each side.
TriangleSoup box(int n, double x, double y, double z) {
    Mesh mesh = triangulations::cube(n);
    for (Vector3d& p : mesh.points) p = p.cwiseProduct(Vector3d(x, y, z));
    return triangulations::soup(mesh);
}

double smallest(const std::vector<double>& values) { return *std::min_element(values.begin(), values.end()); }

// Size of the background at the vertex nearest to a point.
double size_near(const TriangulationBackground& map, const Vector3d& p) {
    const std::span<const Vector3d> points = points_of(map.background.mesh);
    const auto nearest = std::min_element(points.begin(), points.end(), [&](const Vector3d& a, const Vector3d& b) {
        return (a - p).squaredNorm() < (b - p).squaredNorm();
    });
    return map.sizes[nearest - points.begin()];
}

// Clearance of a vertex on a feature of a planar face by definition: for ever larger radii the triangles that the ball
// holds a part of, joined across edges it holds a part of, and the features met among them.
double by_growing(const Triangulation& surface, int v) {
    const auto& points = surface.soup().points;
    const Connectivity& mesh = surface.mesh();
    const Vector3d& p = points[v];
    const auto distance = [&](int h) {
        const Vector3d &a = points[mesh.origin(h)], &b = points[mesh.target(h)];
        return (closest_point(p, a, b, b) - p).norm();
    };
    // Ways along features: from every vertex to all, by relaxing until nothing changes.
    std::vector<double> way(points.size(), kInfinity);
    way[v] = 0;
    for (bool changes = true; changes;) {
        changes = false;
        for (int h = 0; h < 3 * mesh.num_triangles(); ++h) {
            if (mesh.tag(h) < 0) continue;
            const double length = (points[mesh.origin(h)] - points[mesh.target(h)]).norm();
            for (const auto& [a, b] :
                 {std::pair{mesh.origin(h), mesh.target(h)}, std::pair{mesh.target(h), mesh.origin(h)}})
                if (way[a] + length < way[b]) way[b] = way[a] + length, changes = true;
        }
    }
    double best = kInfinity;
    std::set<double> radii;
    for (int h = 0; h < 3 * mesh.num_triangles(); ++h) radii.insert(distance(h));
    for (const SidedPlace& side : sides_of_vertex(surface, v))
        for (const double radius : radii) {
            if (radius >= best) break;
            std::set<int> held;
            surface.wedges().for_each(mesh, side.wedge, [&](int h) { held.insert(h / 3); });
            for (bool grows = true; grows;) {
                grows = false;
                for (int h = 0; h < 3 * mesh.num_triangles(); ++h)
                    if (mesh.tag(h) < 0 && held.count(h / 3) && mesh.twin(h) >= 0 && distance(h) <= radius)
                        grows = held.insert(mesh.twin(h) / 3).second || grows;
            }
            for (const int t : held)
                for (int h = 3 * t; h < 3 * t + 3; ++h) {
                    if (mesh.tag(h) < 0 || distance(h) > radius) continue;
                    const Vector3d &a = points[mesh.origin(h)], &b = points[mesh.target(h)],
                                   q = closest_point(p, a, b, b);
                    const double along =
                        std::min(way[mesh.origin(h)] + (q - a).norm(), way[mesh.target(h)] + (q - b).norm());
                    if (along > 3.732 * radius) best = std::min(best, radius);
                }
        }
    return best;
}

}  // namespace

TEST_CASE("two parallel lines are as far apart as their distance, however long the triangles between them are",
          "[exact]") {
    const double length = GENERATE(10.0, 1000.0), width = GENERATE(1.0, 0.01);
    const int along = GENERATE(10, 11, 64);
    const Triangulation surface(strip(along, length, width));
    const std::vector<double> clearance = feature_clearance(surface);
    for (std::size_t v = 0; v < clearance.size(); ++v) {
        const double from_end = std::min(surface.soup().points[v].x(), length - surface.soup().points[v].x());
        if (from_end > 1.4 * width) CHECK(clearance[v] == Approx(width).epsilon(1e-12));
        if (from_end < 1.2 * width) CHECK(clearance[v] > 1.5 * width);
    }
    CHECK(feature_clearance(surface, 0.99 * width) == std::vector<double>(clearance.size(), kInfinity));
}

TEST_CASE("the circles of an annulus are as far apart as their radii", "[exact]") {
    const Triangulation surface(triangulations::soup(testing::annulus(96, 3)));
    for (const double c : feature_clearance(surface)) CHECK(c == Approx(1).epsilon(0.01));
}

TEST_CASE("a circle does not face itself", "[exact]") {
    const Triangulation tin(triangulations::soup(triangulations::capped_cylinder(48, 12, 1, 9, 4)));
    CHECK(tin.features().chains.size() == 2);
    // Its rims face each other along the wall, not across the lids.
    const std::vector<double> clearance = feature_clearance(tin);
    for (std::size_t v = 0; v < clearance.size(); ++v)
        if (const double z = tin.soup().points[v].z(); z < 1e-9 || z > 9 - 1e-9)
            CHECK((clearance[v] == kInfinity || clearance[v] == Approx(9)));
}

TEST_CASE("the sides of a narrow corner face each other, those of a wide one do not", "[exact]") {
    const Triangulation narrow(wedge(20, 16)), wide(wedge(60, 16));
    for (const double c : feature_clearance(wide)) CHECK(c == kInfinity);
    const std::vector<double> clearance = feature_clearance(narrow);
    const double slope = std::sin(20 * std::numbers::pi / 180);
    for (std::size_t v = 1; v < clearance.size(); ++v)
        if (const double s = narrow.soup().points[v].norm(); s < 0.7)
            CHECK(clearance[v] == Approx(s * slope).epsilon(1e-9));
}

TEST_CASE("near the tip of a narrow corner its sides do not face each other where that is asked for", "[exact]") {
    const Triangulation surface(wedge(20, 16));
    const ClearanceFinder finder(surface);
    for (int v = 1; v < surface.mesh().num_vertices(); ++v) {
        const double s = surface.soup().points[v].norm();
        if (s < 0.7)
            CHECK(std::isinf(finder.feature(sides_of_vertex(surface, v).front(), 1, 0.5).distance) == (s < 0.5));
    }
}

TEST_CASE("a cube has no features that face each other nearer than its edge, a flat box has", "[exact]") {
    const int n = GENERATE(1, 4, 9);
    CHECK(smallest(feature_clearance(Triangulation(box(n, 1, 1, 1)))) >= 1 - 1e-12);
    if (n > 1) CHECK(smallest(feature_clearance(Triangulation(box(n, 1, 1, 0.01)))) == Approx(0.01));
}

TEST_CASE("clearances of vertices are those found by growing a ball, on jittered strips with holes", "[property]") {
    const unsigned seed = GENERATE(range(1u, 9u));
    CAPTURE(seed);
    std::mt19937 random(seed);
    TriangleSoup soup = triangulations::soup(triangulations::graph(
        9, [](double, double) { return 0.0; }, 0.3, seed));
    for (Vector3d& p : soup.points) p.y() *= 0.4;
    // A slot two quads long.
    const int first = 2 * static_cast<int>(9 * (3 + seed % 3) + 2 + random() % 4);
    soup.triangles.erase(soup.triangles.begin() + first, soup.triangles.begin() + first + 4);
    const Triangulation surface(soup);
    const std::vector<double> clearance = feature_clearance(surface);
    int finite = 0;
    for (int v = 0; v < surface.mesh().num_vertices(); ++v) {
        if (!surface.mesh().is_live_vertex(v) || !surface.mesh().is_boundary_vertex(v)) continue;
        CHECK(clearance[v] == by_growing(surface, v));
        finite += std::isfinite(clearance[v]);
    }
    CHECK(finite > 20);
}

TEST_CASE("places between features have the clearance of the nearest one", "[property]") {
    const Triangulation surface(triangulations::soup(
        testing::grid(40, 5, false, false, [](double u, double v) { return Vector3d(8 * u, v, 0); })));
    const std::vector<double> clearance = feature_clearance(surface);
    for (std::size_t v = 0; v < clearance.size(); ++v)
        if (const double x = surface.soup().points[v].x(); x > 2 && x < 6) CHECK(clearance[v] == Approx(1));
    // Within a wide face there is none.
    const Triangulation wide(triangulations::soup(testing::square(12)));
    for (const double c : feature_clearance(wide)) CHECK(c == kInfinity);
}

TEST_CASE("clearances scale with the input, and do not depend on the order of its vertices or where it lies",
          "[property]") {
    const bool sheets = GENERATE(false, true);
    const auto of = [&](const Mesh& mesh) {
        const Triangulation surface(triangulations::soup(mesh));
        return sheets ? sheet_clearance(surface) : feature_clearance(surface);
    };
    Mesh mesh = triangulations::cube(6);
    for (Vector3d& p : mesh.points) p.z() *= 0.1 + 0.05 * p.x();
    const std::vector<double> clearance = of(mesh);
    CHECK(std::count_if(clearance.begin(), clearance.end(), [](double c) { return std::isfinite(c); }) > 20);
    std::vector<int> place;
    const std::vector<double> other = of(testing::relabelled(mesh, 5, &place));
    const double scale = GENERATE(1e-3, 250.0);
    const std::vector<double> scaled = of(testing::moved(mesh, scale));
    for (std::size_t v = 0; v < clearance.size(); ++v) {
        if (std::isinf(clearance[v])) {
            CHECK(std::isinf(other[place[v]]));
            CHECK(std::isinf(scaled[v]));
            continue;
        }
        CHECK(other[place[v]] == Approx(clearance[v]).epsilon(1e-9));
        CHECK(scaled[v] == Approx(scale * clearance[v]).epsilon(1e-9));
    }
}

TEST_CASE("the sheets of a plate are as far apart as it is thick", "[exact]") {
    const double thickness = GENERATE(0.2, 0.01);
    const Triangulation plate(box(8, 1, 1, thickness));
    const std::vector<double> clearance = sheet_clearance(plate);
    for (std::size_t v = 0; v < clearance.size(); ++v) {
        const Vector3d& p = plate.soup().points[v];
        const double from_rim = std::min({p.x(), p.y(), 1 - p.x(), 1 - p.y()});
        if (from_rim > 0.5 * thickness) CHECK(clearance[v] == Approx(thickness));
        CHECK(clearance[v] > 0.999 * thickness);
    }
}

TEST_CASE("two parts see each other through the void", "[exact]") {
    Mesh near = triangulations::cube(4);
    for (Vector3d& p : near.points) p += Vector3d(0.1, -0.2, 1.05);
    const Triangulation both(triangulations::soup(testing::together(triangulations::cube(4), near)));
    const std::vector<double> clearance = sheet_clearance(both);
    CHECK(smallest(clearance) == Approx(0.05));
    for (std::size_t v = 0; v < clearance.size(); ++v)
        if (both.soup().points[v].isApprox(Vector3d(0.5, 0.5, 1))) CHECK(clearance[v] == Approx(0.05));
}

TEST_CASE("the sheets of a torus are as far apart as its tube is thick, or its hole wide", "[converges]") {
    const double major = GENERATE(3.0, 1.4);
    const Triangulation torus(triangulations::soup(triangulations::torus(96, 48, major, 1, 0.02)));
    const std::vector<double> clearance = sheet_clearance(torus);
    for (std::size_t v = 0; v < clearance.size(); ++v) {
        const Vector3d& p = torus.soup().points[v];
        // Within 60 degrees of the diameter chords are shorter, down to half.
        CHECK(clearance[v] > 0.79 * std::min(1.0, major - 1));
        if (std::hypot(p.x(), p.y()) < major - 0.99) CHECK(clearance[v] < 1.03 * 2 * std::min(1.0, major - 1));
    }
}

TEST_CASE("noise does not make a sheet face itself", "[property]") {
    const Mesh smooth = triangulations::sphere(5);
    const Triangulation noisy(
        triangulations::soup(triangulations::noisy(smooth, 0.12 * triangulations::mean_edge(smooth))));
    CHECK(smallest(sheet_clearance(noisy)) > 0.8);
}

TEST_CASE("a background resolves what lies between the vertices of large facets", "[exact]") {
    // A strip of two triangles, whose four vertices face nothing.
    const Triangulation surface(strip(1, 10, 0.5));
    const SizingRule rule{.hmin = 0.01, .hmax = 5, .feature_clearance = 1};
    const TriangulationBackground map = make_background(surface, rule);
    const std::span<const Vector3d> points = points_of(map.background.mesh);
    for (std::size_t v = 0; v < points.size(); ++v) {
        CHECK(map.sizes[v] > 0.499);
        if (points[v].x() > 1 && points[v].x() < 9) CHECK(map.sizes[v] == Approx(0.5));
    }
    CHECK(size_near(map, {5, 0, 0}) == Approx(0.5));
    SizingRule off = rule;
    off.feature_clearance = 0;
    CHECK(smallest(make_background(surface, off).sizes) == 5);
    SizingRule half = rule;
    half.feature_clearance = 0.5;
    CHECK(size_near(make_background(surface, half), {5, 0.5, 0}) == Approx(0.25));
    half.hmin = 0.4;
    CHECK(smallest(make_background(surface, half).sizes) == 0.4);
    CHECK_THROWS_AS(make_background(surface, SizingRule{.feature_clearance = -1}), std::invalid_argument);
    CHECK_THROWS_AS(make_background(surface, SizingRule{.sheet_clearance = std::nan("")}), std::invalid_argument);
}

TEST_CASE("a background has the size of a place that a corner elsewhere comes near to", "[exact]") {
    // A triangle points at the long side of another face of the same sheet: a square with a notch whose tip nearly
    // reaches the bottom.
    TriangleSoup soup;
    soup.points = {{0, 0, 0}, {10, 0, 0}, {10, 6, 0}, {4.5, 6, 0}, {3, 0.1, 0}, {1.5, 6, 0}, {0, 6, 0}};
    soup.triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {4, 5, 6}, {4, 6, 0}};
    const Triangulation surface(soup);
    CHECK(feature_clearance(surface)[4] == Approx(0.1));
    const TriangulationBackground map = make_background(surface, {.hmin = 0.01, .hmax = 2, .feature_clearance = 1});
    CHECK(size_near(map, {3, 0, 0}) < 0.2);
    CHECK(size_near(map, {8, 0, 0}) > 1);
}

TEST_CASE("sheets bound the sizes of a plate of large facets where asked", "[exact]") {
    const Triangulation plate(box(1, 1, 1, 0.02));
    SizingRule rule{.hmin = 1e-4, .hmax = 0.25, .feature_clearance = 0};
    CHECK(smallest(make_background(plate, rule).sizes) == 0.25);
    rule.sheet_clearance = 2;
    const TriangulationBackground map = make_background(plate, rule);
    CHECK(size_near(map, {0.5, 0.5, 0}) == Approx(0.04));
    CHECK(smallest(map.sizes) == Approx(0.04));
}

TEST_CASE("sizes of a label hold in its triangles and on their border", "[exact]") {
    TriangleSoup soup = box(2, 1, 1, 1);
    for (const Triangle& t : soup.triangles) {
        const Vector3d middle = (soup.points[t[0]] + soup.points[t[1]] + soup.points[t[2]]) / 3;
        soup.labels.push_back(middle.z() > 0.999 ? 7 : 3);
    }
    const bool borders = GENERATE(true, false);
    const Triangulation surface(soup, {.label_borders = borders});
    const SizingRule rule{.hmin = 0.05, .hmax = 0.5, .regions = {{7, 0.04}}};
    for (const TriangulationBackground& map : {make_background(surface, rule)}) {
        const std::span<const Vector3d> points = points_of(map.background.mesh);
        for (std::size_t v = 0; v < points.size(); ++v) CHECK(map.sizes[v] == (points[v].z() > 0.999 ? 0.04 : 0.5));
        CHECK(std::any_of(points.begin(), points.end(), [](const Vector3d& p) { return p.z() > 0.9 && p.z() < 0.99; }));
    }
    CHECK_THROWS_WITH(make_background(surface, SizingRule{.regions = {{4, 0.1}}}),
                      Catch::Contains("label 4") && Catch::Contains("3, 7"));
    CHECK_THROWS_AS(make_background(surface, SizingRule{.regions = {{7, 0}}}), std::invalid_argument);
    soup.labels.clear();
    CHECK_THROWS_WITH(make_background(Triangulation(soup), SizingRule{.regions = {{4, 0.1}}}),
                      Catch::Contains("there are none"));
}

// A triangulation with its sizes: what is refused, and backgrounds that resolve what the rule asks for.
#include "gradus/control/triangulation.hpp"

#include <catch2/catch.hpp>

#include "support/parts.hpp"
#include "support/triangulations.hpp"

using namespace gradus;
using Eigen::Vector3d;

TEST_CASE("a soup that is no oriented surface with an extent makes no triangulation", "[exact]") {
    TriangleSoup cube = triangulations::soup(triangulations::cube(1));
    CHECK_NOTHROW(Triangulation(cube));
    CHECK_THROWS_AS(Triangulation(TriangleSoup{}), std::invalid_argument);
    CHECK_THROWS_AS(Triangulation(TriangleSoup{cube.points, {}}), std::invalid_argument);
    TriangleSoup flipped = cube;
    std::swap(flipped.triangles[3][0], flipped.triangles[3][1]);
    CHECK_THROWS_AS(Triangulation(flipped), std::invalid_argument);
    TriangleSoup flat = cube;
    for (Vector3d& p : flat.points) p.setConstant(2);
    CHECK_THROWS_AS(Triangulation(flat), std::invalid_argument);
    TriangleSoup far = cube;
    far.points[2].y() = std::numeric_limits<double>::infinity();
    CHECK_THROWS_AS(Triangulation(far), std::invalid_argument);
}

TEST_CASE("sizes of a sphere are those of its radius, and scale with it", "[property]") {
    const double radius = GENERATE(1.0, 1e-4, 1e5);
    const Triangulation surface(triangulations::soup(triangulations::sphere(4, radius)));
    CHECK(surface.diagonal() == Approx(2 * std::sqrt(3.0) * radius).epsilon(0.02));
    const std::vector<double> sizes = geometric_sizes(surface, {.value = 0.3});
    CHECK(*std::min_element(sizes.begin(), sizes.end()) > 0.97 * 0.3 * radius);
    CHECK(*std::max_element(sizes.begin(), sizes.end()) < 1.01 * 0.3 * radius);
    CHECK_THROWS_AS(geometric_sizes(surface, {.value = -1}), std::invalid_argument);
}

TEST_CASE("the first vertices of a background are those of the triangulation, and each has a cell", "[property]") {
    const Triangulation surface(triangulations::soup(triangulations::capped_cylinder(16, 3)));
    const TriangulationBackground map = make_background(surface, SizingRule{.value = 0.2, .hmin = 0.01, .hmax = 1});
    const auto points = points_of(map.background.mesh);
    REQUIRE(points.size() > surface.soup().points.size());
    REQUIRE(map.sizes.size() == points.size());
    for (std::size_t v = 0; v < surface.soup().points.size(); ++v) CHECK(points[v] == surface.soup().points[v]);
    const auto triangles = triangles_of(map.background.mesh);
    for (std::size_t v = 0; v < points.size(); ++v) {
        const Triangle& t = triangles[map.cells[v]];
        CHECK(std::count(t.begin(), t.end(), static_cast<int>(v)) == 1);
    }
    // It is the same surface, so it has the same area.
    const auto area = [](std::span<const Vector3d> p, std::span<const Triangle> all) {
        double sum = 0;
        for (const Triangle& t : all) sum += (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]).norm() / 2;
        return sum;
    };
    CHECK(area(points, triangles) == Approx(area(surface.soup().points, surface.soup().triangles)).epsilon(1e-12));
}

TEST_CASE("the inside of a flat facet beside a small round has large sizes", "[property]") {
    // Caps are fans of facets as long as the radius, beside rims of that radius: their flat insides want hmax.
    const Triangulation surface(triangulations::soup(triangulations::capped_cylinder(32, 8, 1, 2)));
    const SizingRule rule{.value = 0.05, .hmin = 0.001, .hmax = 0.5};
    const TriangulationBackground map = make_background(surface, rule);
    const auto points = points_of(map.background.mesh);
    double largest = 0, rim = 0;
    for (std::size_t v = 0; v < points.size(); ++v) {
        const double r = std::hypot(points[v].x(), points[v].y());
        const bool cap = points[v].z() < 1e-9 || points[v].z() > 2 - 1e-9;
        if (cap && r < 0.7) largest = std::max(largest, map.sizes[v]);
        if (cap && r > 0.999) rim = std::max(rim, map.sizes[v]);
        if (cap && r > 0.01 && r < 0.5) CHECK(map.sizes[v] > 0.4);
    }
    CHECK(largest == Approx(0.5));
    CHECK(rim == Approx(0.05).epsilon(0.1));
    // Without cuts nothing inside the fans' triangles would say so: more vertices than the triangulation has.
    CHECK(points.size() > surface.soup().points.size() + 32);
}

TEST_CASE("a curve between corners asks for elements no longer than it is", "[exact]") {
    // A sheet with a step of .02 in one of its sides.
    const double step = 0.02;
    const Triangulation surface(
        TriangleSoup{.points = {{0, 0, 0}, {1, 0, 0}, {1, 1 + step, 0}, {0.5, 1 + step, 0}, {0.5, 1, 0}, {0, 1, 0}},
                     .triangles = {{0, 4, 5}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}}});
    const SizingRule rule{.value = 0.05, .hmin = 0.001, .hmax = 0.5};
    const auto smallest = [&](const SizingRule& by) {
        const std::vector<double> sizes = geometric_sizes(surface, by);
        return *std::min_element(sizes.begin(), sizes.end());
    };
    SizingRule coarse = rule, unbounded = rule;
    coarse.hmin = 0.04;
    unbounded.feature_clearance = 0;
    CHECK(smallest(rule) == Approx(1.5 * step));
    CHECK(smallest(coarse) == Approx(0.04));
    CHECK(smallest(unbounded) > 0.1);
}

TEST_CASE("a rim with one corner asks for no more than one without", "[exact]") {
    // A disc, as a fan.
    const int sides = 32;
    TriangleSoup disc;
    disc.points.emplace_back(0, 0, 0);
    for (int i = 0; i < sides; ++i) {
        disc.points.emplace_back(std::cos(2 * std::numbers::pi * i / sides), std::sin(2 * std::numbers::pi * i / sides),
                                 0);
        disc.triangles.push_back({0, 1 + i, 1 + (i + 1) % sides});
    }
    const SizingRule rule{.value = 0.05, .hmin = 0, .hmax = 0.5};
    const auto smallest = [&] {
        const std::vector<double> sizes = geometric_sizes(Triangulation(disc), rule);
        return *std::min_element(sizes.begin(), sizes.end());
    };
    const double without = smallest();
    disc.corners = {1};
    CHECK(smallest() == Approx(without).epsilon(0.01));
    CHECK(without > 0.04);
}

TEST_CASE("a background of given sizes has them, and one of too many triangles stops", "[exact]") {
    const Triangulation surface(triangulations::soup(triangulations::capped_cylinder(16, 2)));
    std::vector<double> sizes(surface.soup().points.size());
    for (std::size_t v = 0; v < sizes.size(); ++v) sizes[v] = 1 + double(v);
    const TriangulationBackground map = make_background(surface, sizes);
    CHECK(map.sizes == sizes);
    CHECK(map.background.mesh.n_faces() == surface.soup().triangles.size());
    const SizingRule fine{.value = 1e-3, .hmin = 1e-6, .hmax = 0.5};
    CHECK(make_background(surface, fine, 200).background.mesh.n_faces() <= 202);
}

TEST_CASE("sizes given on another mesh of the surface are found from the triangulation", "[property]") {
    TriangleSoup fine = triangulations::soup(triangulations::sphere(4));
    const Triangulation surface(triangulations::soup(triangulations::sphere(3)));
    // Linear in space in their logarithms, so that they can be told anywhere.
    const auto size_there = [](const Vector3d& p) { return 0.1 * std::exp(0.5 * p.x()); };
    std::vector<double> sizes;
    for (const Vector3d& p : fine.points) sizes.push_back(size_there(p));
    const TriangulationBackground map = make_background(surface, fine, sizes);
    CHECK(map.sizes == sizes);
    const auto triangles = triangles_of(map.background.mesh);
    const std::vector<double> found = sizes_at(map, surface.soup());
    for (std::size_t v = 0; v < surface.soup().points.size(); ++v) {
        const Vector3d& p = surface.soup().points[v];
        CHECK((fine.points[triangles[map.cells[v]][0]] - p).norm() < 0.3);
        CHECK(found[v] == Approx(size_there(p)).epsilon(0.02));
    }
    sizes.pop_back();
    CHECK_THROWS_AS(make_background(surface, fine, sizes), std::invalid_argument);
    for (Vector3d& p : fine.points) p *= 1.2;
    sizes.push_back(1);
    CHECK_THROWS_AS(make_background(surface, fine, sizes), std::invalid_argument);
    CHECK_THROWS_AS(sizes_at(map, fine), std::invalid_argument);
}

TEST_CASE("a background with required elements begins with the vertices of the surface, and heeds them", "[property]") {
    TriangleSoup cube = triangulations::soup(triangulations::cube(4));
    cube.required.triangles = {0, 5};
    const Triangulation surface(cube);
    const std::vector<double> sizes(cube.points.size(), 1.0);
    CHECK(make_background(surface, surface.soup(), sizes).sizes == make_background(surface, sizes).sizes);
    std::reverse(cube.points.begin(), cube.points.end());
    for (Triangle& t : cube.triangles)
        for (int& v : t) v = static_cast<int>(cube.points.size()) - 1 - v;
    CHECK_THROWS_AS(make_background(surface, cube, sizes), std::invalid_argument);
}

TEST_CASE("a size prescribed at a point holds at the vertex nearest to it", "[exact]") {
    const Triangulation surface(triangulations::soup(triangulations::sphere(3)));
    SizingRule rule{.value = 0.3};
    rule.at.push_back({surface.soup().points[17], 0.01});
    CHECK(geometric_sizes(surface, rule)[17] == 0.01);
    CHECK(make_background(surface, rule).sizes[17] == 0.01);
}

TEST_CASE("a surface that cannot be computed with is refused for what it is", "[control][regression]") {
    const auto with = [](double length, double third) {
        return TriangleSoup{{{0, 0, 0}, {length, 0, 0}, {third, third, 0}}, {{0, 1, 2}}};
    };
    CHECK_THROWS_WITH(Triangulation(TriangleSoup{}), Catch::Contains("without triangles"));
    CHECK_THROWS_WITH(Triangulation(with(0, 0)), Catch::Contains("without extent"));
    CHECK_THROWS_WITH(Triangulation(with(1, 0)), Catch::Contains("without area"));
    CHECK_THROWS_WITH(Triangulation(with(1e200, 1)),
                      Catch::Contains("vertex 1 has a coordinate of size 1e+200, beyond 1e+40"));
    CHECK_THROWS_WITH(Triangulation(with(1, -1.7e308)), Catch::Contains("vertex 2 has a coordinate of size 1.7e+308"));
    CHECK_THROWS_WITH(Triangulation(with(1e-200, 1e-200)), Catch::Contains("a diagonal of 1.41e-200, below 1e-40"));
    CHECK(Triangulation(with(1e39, 1e39)).diagonal() > 1e39);
    CHECK(Triangulation(with(1e-39, 1e-39)).diagonal() > 1e-39);
}

TEST_CASE("strips of a round have the curvature of the circle, flat faces beside it none across", "[exact]") {
    const int facets = GENERATE(3, 6, 12);
    const double radius = 5, half = std::numbers::pi / (4 * facets);
    const Triangulation box(parts::prism(parts::rounded(100, 80, radius, facets), 60));
    CAPTURE(facets);
    int strips = 0;
    for (int t = 0; t < box.mesh().num_triangles(); ++t) {
        if (box.flats().of(t) >= 0) continue;
        for (int h = 3 * t; h < 3 * t + 3; ++h) {
            const WedgeCurvature& at = box.curvature()[box.wedges().of_corner[h]];
            // The turn of a chord over its length.
            CHECK(std::abs(at.k1) == Approx(half / (radius * std::sin(half))).epsilon(1e-9));
            CHECK(std::abs(at.normal.z()) < 1e-12);
            ++strips;
        }
    }
    CHECK(strips == 4 * facets * 2 * 3);
}

TEST_CASE("bends that are negligible ask for no sizes", "[exact]") {
    const TriangleSoup soup = parts::prism(parts::rounded(100, 80, 0.1, 4), 60);
    const SizingRule rule{.hmin = 0.001, .hmax = 10};
    const auto smallest = [&](double height) {
        const Triangulation box(soup, {.negligible_height = height});
        const std::vector<double> sizes = geometric_sizes(box, rule);
        return *std::min_element(sizes.begin(), sizes.end());
    };
    CHECK(smallest(0) < 0.04);
    CHECK(smallest(0.1) == Approx(10));
}

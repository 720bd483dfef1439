#include "gradus/mesh/repair.hpp"

#include <bit>
#include <catch2/catch.hpp>
#include <limits>
#include <map>
#include <random>

#include "support/parts.hpp"
#include "support/soups.hpp"

using namespace gradus;
using support::grid;
using support::tetrahedron;

namespace {

using Items = std::vector<std::vector<int>>;

Items items_of(const Repaired& repaired, RepairKind kind) {
    for (const RepairStep& step : repaired.steps)
        if (step.kind == kind) return step.items.first;
    return {};
}

bool same(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    for (int k = 0; k < 3; ++k)
        if (std::bit_cast<std::uint64_t>(a[k]) != std::bit_cast<std::uint64_t>(b[k])) return false;
    return true;
}

/// Bit by bit.
bool same(const TriangleSoup& a, const TriangleSoup& b) {
    return a.triangles == b.triangles && a.labels == b.labels && a.edges == b.edges && a.corners == b.corners &&
           a.required == b.required &&
           std::equal(a.points.begin(), a.points.end(), b.points.begin(), b.points.end(),
                      [](const Eigen::Vector3d& p, const Eigen::Vector3d& q) { return same(p, q); }) &&
           std::equal(a.parameters.begin(), a.parameters.end(), b.parameters.begin(), b.parameters.end(),
                      [](const auto& p, const auto& q) {
                          return p.vertex == q.vertex && p.at.patch == q.at.patch && p.at.uv == q.at.uv;
                      });
}

double area(const TriangleSoup& soup) {
    double sum = 0;
    for (const auto& [a, b, c] : soup.triangles)
        sum += (soup.points[b] - soup.points[a]).cross(soup.points[c] - soup.points[a]).norm() / 2;
    return sum;
}

double volume(const TriangleSoup& soup) {
    double sum = 0;
    for (const auto& [a, b, c] : soup.triangles) sum += soup.points[a].dot(soup.points[b].cross(soup.points[c])) / 6;
    return sum;
}

/// Every triangle with vertices of its own.
TriangleSoup loose(const TriangleSoup& soup) {
    TriangleSoup result;
    for (const Triangle& t : soup.triangles) {
        const int first = static_cast<int>(result.points.size());
        for (const int v : t) result.points.push_back(soup.points[v]);
        result.triangles.push_back({first, first + 1, first + 2});
    }
    return result;
}

/// The cube [0, 1]^3 moved, outside outside.
void add_cube(TriangleSoup& soup, const Eigen::Vector3d& at) {
    const int n = static_cast<int>(soup.points.size());
    for (int i = 0; i < 8; ++i) soup.points.push_back(at + Eigen::Vector3d(i & 1, i >> 1 & 1, i >> 2));
    for (const auto& [a, b, c, d] : std::initializer_list<std::array<int, 4>>{
             {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
        soup.triangles.push_back({n + a, n + b, n + c});
        soup.triangles.push_back({n + a, n + c, n + d});
    }
}

/// A strip of n quadrilaterals, closed with half a turn.
TriangleSoup moebius(int n) {
    TriangleSoup soup;
    for (int i = 0; i < n; ++i) {
        const double u = 2 * M_PI * i / n;
        for (const double side : {-1.0, 1.0}) {
            const double r = 3 + side * std::cos(u / 2);
            soup.points.push_back({r * std::cos(u), r * std::sin(u), side * std::sin(u / 2)});
        }
    }
    for (int i = 0; i < n; ++i) {
        const bool last = i + 1 == n;
        const int a = 2 * i, b = 2 * i + 1, c = last ? 1 : 2 * i + 2, d = last ? 0 : 2 * i + 3;
        soup.triangles.push_back({a, c, d});
        soup.triangles.push_back({a, d, b});
    }
    return soup;
}

/// What holds for every result.
void check_repaired(const TriangleSoup& soup, const RepairOptions& options = {}) {
    const Repaired once = repair(soup, options);
    const Diagnosis d = diagnose(once.soup);
    CAPTURE(summary(once.steps), summary(d));
    CHECK(is_manifold(d));
    CHECK(d.unused_vertices.empty());
    CHECK(d.bad_numbers.empty());
    CHECK_NOTHROW(to_mesh(once.soup));
    if (once.steps.empty()) CHECK(same(once.soup, soup));
    const Repaired twice = repair(once.soup, options);
    CAPTURE(summary(twice.steps));
    CHECK(twice.steps.empty());
    CHECK(same(twice.soup, once.soup));
    CHECK((soup.labels.empty() || once.soup.labels.size() == once.soup.triangles.size()));
    const int n = static_cast<int>(once.soup.points.size());
    for (const auto& edge : once.soup.edges)
        for (const int v : edge) CHECK((v >= 0 && v < n));
    for (const int v : once.soup.corners) CHECK((v >= 0 && v < n));
    const RequiredElements& required = once.soup.required;
    for (const int v : required.vertices) CHECK((v >= 0 && v < n));
    for (const auto& edge : required.edges)
        for (const int v : edge) CHECK((v >= 0 && v < n));
    for (const int t : required.triangles) CHECK((t >= 0 && t < static_cast<int>(once.soup.triangles.size())));
    for (const auto& entry : once.soup.parameters) CHECK((entry.vertex >= 0 && entry.vertex < n));
}

}  // namespace

TEST_CASE("a sound soup comes back bit by bit, with nothing done", "[mesh][repair][property]") {
    TriangleSoup soup = grid(6);
    soup.points[0].x() = -0.0;
    soup.labels.assign(soup.triangles.size(), 3);
    soup.edges = {{0, 1}, {2, 1}, {0, 1}, {1, 0}};
    soup.corners = {6, 0, 6};
    soup.required = {.vertices = {9, 3, 9}, .edges = {{0, 1}, {8, 7}, {1, 0}}, .triangles = {4, 1}};
    soup.parameters = {{5, {1, {0.25, 0.5}}}, {5, {2, {0, 1}}}, {5, {2, {0, 1}}}};
    const Repaired same_again = repair(soup);
    CHECK(same_again.steps.empty());
    CHECK(summary(same_again.steps).empty());
    CHECK(same(same_again.soup, soup));
    CHECK(same(repair({}).soup, {}));

    TriangleSoup inside_out = tetrahedron();
    for (Triangle& t : inside_out.triangles) std::swap(t[0], t[1]);
    CHECK(same(repair(inside_out).soup, inside_out));
}

TEST_CASE("loose triangles become the surface they came from", "[mesh][repair][property]") {
    const Repaired square = repair(loose(grid(7)));
    CHECK(is_clean_manifold(diagnose(square.soup)));
    CHECK(square.soup.points.size() == grid(7).points.size());
    CHECK(diagnose(square.soup).boundary_loops == 1);
    CHECK(items_of(square, RepairKind::WeldedVertices).front().size() == 2);

    TriangleSoup cube;
    add_cube(cube, {3, 2, 1});
    std::mt19937_64 random(5);
    for (int run = 0; run < 20; ++run) {
        TriangleSoup turned = loose(cube);
        for (Triangle& t : turned.triangles)
            if (random() % 2) std::swap(t[0], t[1]);
        turned.triangles.insert(turned.triangles.begin() + static_cast<int>(random() % 12), {5, 5, 2});
        const Repaired whole = repair(turned);
        CHECK(is_clean_manifold(diagnose(whole.soup)));
        CHECK(diagnose(whole.soup).closed);
        CHECK(volume(whole.soup) == Approx(1));
        CHECK(items_of(whole, RepairKind::RepeatedIndex).size() == 1);
        check_repaired(turned);
    }
}

TEST_CASE("each fault is repaired, and listed by the numbers of the input", "[mesh][repair][exact]") {
    TriangleSoup soup = tetrahedron();
    SECTION("what is not a triangle goes") {
        soup.triangles.insert(soup.triangles.begin(), {{0, 1, 9}, {-1, 2, 3}, {2, 2, 3}, {0, 1, 4}});
        soup.points.push_back({0, 0, std::numeric_limits<double>::infinity()});
        const Repaired repaired = repair(soup);
        CHECK(items_of(repaired, RepairKind::OutOfRange) == Items{{0}, {1}});
        CHECK(items_of(repaired, RepairKind::RepeatedIndex) == Items{{2}});
        CHECK(items_of(repaired, RepairKind::BadNumbers) == Items{{3}});
        CHECK(items_of(repaired, RepairKind::UnusedVertices) == Items{{4}});
        CHECK(same(repaired.soup, tetrahedron()));
    }
    SECTION("copies go") {
        soup.triangles.push_back({2, 1, 0});
        soup.triangles.push_back({1, 3, 2});
        const Repaired repaired = repair(soup);
        CHECK(items_of(repaired, RepairKind::DuplicateTriangles) == Items{{0, 4}, {2, 5}});
        CHECK(same(repaired.soup, tetrahedron()));
    }
    SECTION("the minority is turned") {
        std::swap(soup.triangles[1][0], soup.triangles[1][1]);
        const Repaired repaired = repair(soup);
        CHECK(items_of(repaired, RepairKind::TurnedTriangles) == Items{{1}});
        CHECK(repaired.steps.size() == 1);
        CHECK(volume(repaired.soup) == Approx(1.0 / 6));
    }
    SECTION("a fin is cut off, what it stood on stays whole") {
        soup.points.push_back({2, 2, 2});
        soup.triangles.insert(soup.triangles.begin(), {3, 1, 4});
        const Repaired repaired = repair(soup);
        CHECK(items_of(repaired, RepairKind::NonManifoldEdges) == Items{{1, 3}});
        CHECK(repaired.steps.size() == 1);
        CHECK(diagnose(repaired.soup).components == 2);
        CHECK(diagnose(repaired.soup).boundary_edges == 3);
    }
    SECTION("a bow tie comes apart") {
        soup.points.insert(soup.points.end(), {{2, 0, 0}, {2, 1, 0}});
        soup.triangles.push_back({1, 4, 5});
        const Repaired repaired = repair(soup);
        CHECK(items_of(repaired, RepairKind::NonManifoldVertices) == Items{{1}});
        CHECK(repaired.steps.size() == 1);
        CHECK(repaired.soup.points.size() == 7);
        CHECK(repaired.soup.points[6] == soup.points[1]);
    }
}

TEST_CASE("solids that touch along an edge come apart as solids", "[mesh][repair][exact]") {
    TriangleSoup soup;
    add_cube(soup, {0, 0, 0});
    add_cube(soup, {1, 1, 0});
    const Repaired apart = repair(soup);  // as their edges have their own vertices
    CHECK(apart.steps.empty());

    const TriangleSoup crowded = loose(soup);
    const Repaired repaired = repair(crowded);
    const Diagnosis d = diagnose(repaired.soup);
    CHECK(is_manifold(d));
    CHECK(d.closed);
    CHECK(d.components == 2);
    CHECK(volume(repaired.soup) == Approx(2));
    CHECK(repaired.soup.points.size() == 16);
}

TEST_CASE("a wall is cut off the floor it stands on", "[mesh][repair][exact]") {
    TriangleSoup soup;
    soup.points = {{0, 0, 0}, {0, 1, 0}, {-1, 0, 0.1}, {-1, 1, 0.1}, {1, 0, 0}, {1, 1, 0}, {0, 0, 1}, {0, 1, 1}};
    soup.triangles = {{0, 1, 6}, {1, 7, 6}, {0, 1, 2}, {1, 3, 2}, {0, 4, 1}, {1, 4, 5}};
    const Repaired repaired = repair(soup);
    CHECK(items_of(repaired, RepairKind::NonManifoldEdges) == Items{{0, 1}});
    const Diagnosis d = diagnose(repaired.soup);
    CHECK(d.components == 2);
    CHECK(d.euler_characteristic == 2);
    // Floor: the two halves still share the edge.
    CHECK(d.boundary_edges == 6 + 4);
    check_repaired(soup);
}

TEST_CASE("a strip with one side is cut across", "[mesh][repair][exact]") {
    const TriangleSoup soup = moebius(20);
    CHECK(diagnose(soup).boundary_loops == 1);
    const Repaired repaired = repair(soup);
    const Diagnosis d = diagnose(repaired.soup);
    CHECK(items_of(repaired, RepairKind::OneSidedEdges) == Items{{0, 1}});
    CHECK(repaired.steps.size() == 1);
    CHECK(d.components == 1);
    CHECK(d.euler_characteristic == 1);
    check_repaired(soup);
    check_repaired(loose(soup));
}

TEST_CASE("flat triangles are resolved without a crack", "[mesh][repair][exact]") {
    // A square of two triangles whose common edge has a vertex in its middle on one side only, filled with a flat
    // triangle.
    TriangleSoup soup;
    soup.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 0}};
    soup.triangles = {{0, 1, 4}, {1, 2, 4}, {0, 4, 2}, {0, 2, 3}};
    soup.labels = {1, 1, 2, 3};
    soup.edges = {{0, 2}};
    REQUIRE(diagnose(soup).zero_area.count == 1);
    const Repaired repaired = repair(soup);
    const Diagnosis d = diagnose(repaired.soup);
    CHECK(items_of(repaired, RepairKind::FlatTriangles) == Items{{2, 3}});
    CHECK(is_clean_manifold(d));
    CHECK(d.boundary_edges == 4);
    CHECK(d.euler_characteristic == 1);
    CHECK(area(repaired.soup) == Approx(1));
    CHECK(repaired.soup.labels == std::vector{1, 1, 3, 3});
    CHECK(repaired.soup.edges == std::vector<std::array<int, 2>>{{0, 4}, {4, 2}});
    check_repaired(soup);
}

TEST_CASE("a closed surface with flat triangles stays closed", "[mesh][repair][property]") {
    // Edges of a cube are split again and again, with flat triangles to fill; vertices shake onto their lines.
    std::mt19937_64 random(11);
    for (int run = 0; run < 60; ++run) {
        TriangleSoup soup;
        add_cube(soup, {0, 0, 0});
        for (int i = 0; i < 30; ++i) {
            // Triangle abc becomes amc and mbc below a flat triangle a b m that keeps its neighbour across ab as it
            // was.
            const std::size_t t = random() % soup.triangles.size();
            const auto [a, b, c] = soup.triangles[t];
            const int m = static_cast<int>(soup.points.size());
            soup.points.push_back((soup.points[a] + soup.points[b]) / 2);
            soup.triangles[t] = {a, m, c};
            soup.triangles.push_back({m, b, c});
            soup.triangles.push_back({a, b, m});
        }
        const Repaired repaired = repair(soup);
        const Diagnosis d = diagnose(repaired.soup);
        CAPTURE(run, summary(repaired.steps), summary(d));
        CHECK(d.closed);
        CHECK(d.zero_area.empty());
        CHECK(volume(repaired.soup) == Approx(1));
        CHECK(area(repaired.soup) == Approx(6));
        check_repaired(soup);
    }
}

TEST_CASE("welding with a tolerance moves nothing further than that", "[mesh][repair][property]") {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> shake(-1e-5, 1e-5);
    TriangleSoup soup = loose(grid(9));
    for (Eigen::Vector3d& p : soup.points) p += Eigen::Vector3d(shake(random), shake(random), shake(random));
    CHECK(repair(soup).soup.points.size() == soup.points.size());
    const Repaired repaired = repair(soup, {.weld_tolerance = 1e-4});
    CHECK(repaired.soup.points.size() == 100);
    CHECK(diagnose(repaired.soup).euler_characteristic == 1);
    CHECK(diagnose(repaired.soup).boundary_edges == 36);
    check_repaired(soup, {.weld_tolerance = 1e-4});

    // A line of vertices, each close to the next, keeps its length.
    TriangleSoup strip;
    const int n = 1000;
    for (int i = 0; i <= n; ++i)
        for (const double y : {0.0, 0.5}) strip.points.push_back({i / double(n), y, 0});
    for (int i = 0; i < n; ++i) {
        strip.triangles.push_back({2 * i, 2 * i + 2, 2 * i + 1});
        strip.triangles.push_back({2 * i + 2, 2 * i + 3, 2 * i + 1});
    }
    const Repaired thinned = repair(strip, {.weld_tolerance = 0.0025});
    CHECK(diagnose(thinned.soup).euler_characteristic == 1);
    CHECK(thinned.soup.points.size() > 600);
    CHECK(thinned.soup.points.size() < 900);
    CHECK(area(thinned.soup) == Approx(0.5).epsilon(0.01));

    CHECK_THROWS_AS(repair(soup, {.weld_tolerance = -1}), std::invalid_argument);
    CHECK_THROWS_AS(repair(soup, {.weld_tolerance = std::numeric_limits<double>::quiet_NaN()}), std::invalid_argument);
}

TEST_CASE("required elements follow what is welded, turned, dropped and split", "[mesh][repair]") {
    // Two copies of a square that share points by place, the second triangle the wrong way round, a copy of the first,
    // one that is flat.
    TriangleSoup soup;
    soup.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}, {1, 1, 0}, {0, 1, 0}, {9, 9, 9}};
    soup.triangles = {{6, 6, 0}, {0, 1, 2}, {4, 3, 5}, {1, 2, 0}, {0, 0, 2}};
    soup.required = {.vertices = {3, 6}, .edges = {{4, 5}}, .triangles = {3, 2, 0}};
    const Repaired repaired = repair(soup);
    const RequiredElements& required = repaired.soup.required;
    REQUIRE(repaired.soup.triangles.size() == 2);
    const auto at = [&](int v) { return repaired.soup.points[v]; };
    REQUIRE(required.vertices.size() == 1);
    CHECK(at(required.vertices[0]) == Eigen::Vector3d(0, 0, 0));
    REQUIRE(required.edges.size() == 1);
    CHECK(at(required.edges[0][0]) == Eigen::Vector3d(1, 1, 0));
    CHECK(at(required.edges[0][1]) == Eigen::Vector3d(0, 1, 0));
    CHECK(required.triangles == std::vector{0, 1});
    const auto lost = std::find_if(repaired.steps.begin(), repaired.steps.end(),
                                   [](const RepairStep& s) { return s.kind == RepairKind::LostFeatures; });
    REQUIRE(lost != repaired.steps.end());
    CHECK(lost->items.first == std::vector<std::vector<int>>{{6}, {6, 6, 0}});
}

TEST_CASE("a required triangle that repair splits is required no more, its edges are as they were", "[mesh][repair]") {
    // A flat triangle along the long side of another.
    TriangleSoup soup;
    soup.points = {{0, 0, 0}, {2, 0, 0}, {1, 2, 0}, {1, 0, 0}};
    soup.triangles = {{0, 1, 2}, {1, 0, 3}};
    soup.required = {.edges = {{1, 2}, {0, 1}}, .triangles = {0}};
    const Repaired repaired = repair(soup);
    CHECK(repaired.soup.triangles.size() == 2);
    CHECK(repaired.soup.required.triangles.empty());
    // The edge that was split is two.
    CHECK(repaired.soup.required.edges == std::vector<std::array<int, 2>>{{1, 2}, {0, 3}, {3, 1}});
    CHECK_THAT(summary(repaired.steps),
               Catch::Contains("features and required elements without a place in the result dropped: 0-1-2"));
}

TEST_CASE("any soup becomes a manifold, and stays what it has become", "[mesh][repair][property]") {
    SECTION("few places, so that everything meets everything") {
        std::mt19937_64 random(7);
        for (int run = 0; run < 3000; ++run) {
            CAPTURE(run);
            TriangleSoup soup;
            const int n = 5 + static_cast<int>(random() % 12), side = 2 + static_cast<int>(random() % 3),
                      m = 2 + static_cast<int>(random() % 40);
            for (int i = 0; i < n; ++i)
                soup.points.push_back({double(random() % side), double(random() % side), double(random() % side)});
            for (int t = 0; t < m; ++t) {
                soup.triangles.push_back({int(random() % n), int(random() % n), int(random() % n)});
                soup.labels.push_back(int(random() % 3));
            }
            for (int i = 0; i < 4; ++i) soup.edges.push_back({int(random() % n), int(random() % n)});
            for (int i = 0; i < 3; ++i) soup.required.triangles.push_back(int(random() % m));
            soup.required.edges = {soup.edges[1], {int(random() % n), int(random() % n)}};
            soup.required.vertices = {int(random() % n)};
            check_repaired(soup);
            check_repaired(soup, {.weld_tolerance = 0.1});
        }
    }
    SECTION("no three on a line") {
        std::mt19937_64 random(8);
        for (int run = 0; run < 3000; ++run) {
            CAPTURE(run);
            TriangleSoup soup;
            const int n = 4 + static_cast<int>(random() % 6), m = 2 + static_cast<int>(random() % 40);
            for (int i = 0; i < n; ++i)
                soup.points.push_back({double(random() % 1000), double(random() % 1000), double(random() % 1000)});
            for (int t = 0; t < m; ++t)
                soup.triangles.push_back({int(random() % n), int(random() % n), int(random() % n)});
            check_repaired(soup);
            check_repaired(loose(repair(soup).soup));
        }
    }
    SECTION("numbers of any magnitude") {
        for (unsigned seed = 0; seed < 300; ++seed) {
            CAPTURE(seed);
            check_repaired(support::wild_soup(seed));
            check_repaired(support::wild_soup(seed), {.weld_tolerance = 0.01});
        }
    }
}

TEST_CASE("a book of many leaves takes no more than its time", "[mesh][repair]") {
    TriangleSoup soup;
    soup.points = {{0, 0, 0}, {0, 0, 1}};
    const int n = 20000;
    for (int i = 0; i < n; ++i) {
        soup.points.push_back({std::cos(i), std::sin(i), 0.3});
        soup.triangles.push_back({0, 1, i + 2});
    }
    const Repaired repaired = repair(soup);
    CHECK(diagnose(repaired.soup).components == n);
}

TEST_CASE("the result says where its points and triangles are from, and fields follow", "[property]") {
    // Loose triangles with a flat one, a copy and an unused point among them: welded, split, dropped.
    TriangleSoup soup = loose(grid(5));
    soup.points.push_back({9, 9, 9});
    const int n = static_cast<int>(soup.points.size());
    soup.points.insert(soup.points.end(), {{3, 0, 0}, {4, 0, 0}, {5, 0, 0}, {4, 1, 0}, {4, -1, 0}});
    soup.triangles.insert(soup.triangles.begin() + 3, {n, n + 1, n + 2});
    soup.triangles.push_back({n, n + 2, n + 3});
    soup.triangles.push_back({n + 2, n, n + 4});
    soup.triangles.push_back(soup.triangles[0]);
    for (std::size_t t = 0; t < soup.triangles.size(); ++t) soup.labels.push_back(static_cast<int>(t));
    const Repaired repaired = repair(soup);
    REQUIRE_FALSE(repaired.steps.empty());
    REQUIRE(repaired.point_source.size() == repaired.soup.points.size());
    REQUIRE(repaired.triangle_source.size() == repaired.soup.triangles.size());
    CHECK(repaired.triangle_source == repaired.soup.labels);

    Field place{"place", 3}, number{"number", 1, {}, true};
    for (const Eigen::Vector3d& p : soup.points) place.values.insert(place.values.end(), p.begin(), p.end());
    for (std::size_t t = 0; t < soup.triangles.size(); ++t) number.values.push_back(static_cast<double>(t));
    const Field at_points = follow(std::vector{place}, repaired.point_source)[0];
    for (std::size_t v = 0; v < repaired.soup.points.size(); ++v)
        CHECK(Eigen::Vector3d(at_points.values[3 * v], at_points.values[3 * v + 1], at_points.values[3 * v + 2]) ==
              repaired.soup.points[v]);
    const Field on_triangles = follow(std::vector{number}, repaired.triangle_source)[0];
    CHECK(std::equal(on_triangles.values.begin(), on_triangles.values.end(), repaired.soup.labels.begin()));
    CHECK(on_triangles.integer);
    CHECK(at_points.name == "place");
    CHECK_THROWS_AS(follow(std::vector{Field{"short", 1, {1}}}, repaired.point_source), std::invalid_argument);

    const TriangleSoup sound = grid(4);
    const Repaired untouched = repair(sound);
    for (std::size_t v = 0; v < sound.points.size(); ++v) CHECK(untouched.point_source[v] == static_cast<int>(v));
}

TEST_CASE("a sliver that holds a gap is resolved as a flat triangle is, needles of a plane are left", "[exact]") {
    // A cube, the middle of one edge a gap beside it on one side: the triangle across the gap is a sliver.
    const double gap = GENERATE(1e-12, 1e-8, 5e-5);
    TriangleSoup cube = parts::prism({{0, 0}, {1, 0}, {1, 1}, {0, 1}}, 1);
    const auto top = std::find(cube.triangles.begin(), cube.triangles.end(), Triangle{4, 5, 6}),
               side = std::find(cube.triangles.begin(), cube.triangles.end(), Triangle{0, 5, 4});
    REQUIRE((top != cube.triangles.end() && side != cube.triangles.end()));
    cube.points.emplace_back(0.5, gap, 1);
    *top = {4, 8, 6};
    cube.triangles.insert(cube.triangles.end(), {{8, 5, 6}, {4, 5, 8}});
    const Repaired repaired = repair(cube, default_repair(cube));
    REQUIRE(repaired.steps.size() == 1);
    CHECK(repaired.steps[0].kind == RepairKind::FlatTriangles);
    CHECK(repaired.steps[0].items.count == 1);
    CHECK(repaired.soup.triangles.size() == 14);
    CHECK(diagnose(repaired.soup).closed);
    CHECK(parts::volume(repaired.soup) == Approx(1).epsilon(1e-4));
    CHECK(repair(repaired.soup, default_repair(repaired.soup)).steps.empty());
    // Caps of needles far lower than that are planes.
    const TriangleSoup cylinder = parts::prism(parts::polygon(2000), 1);
    CHECK(repair(cylinder, default_repair(cylinder)).steps.empty());
}

TEST_CASE("faces of a box divided each in their own way are joined where their edges run along each other",
          "[mesh][repair][exact]") {
    // Each face a grid of its own, so that its rim has vertices in the middle of the edges of others, to within a gap.
    const double gap = GENERATE(0., 1e-12, 2e-5);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> off(-gap, gap);
    TriangleSoup box;
    for (int face = 0; face < 6; ++face) {
        const int n = 1 + face, first = static_cast<int>(box.points.size()), axis = face / 2;
        for (int i = 0; i <= n; ++i)
            for (int j = 0; j <= n; ++j) {
                Eigen::Vector3d p;
                p[axis] = face % 2;
                p[(axis + 1) % 3] = static_cast<double>(i) / n;
                p[(axis + 2) % 3] = static_cast<double>(j) / n;
                box.points.push_back(p + Eigen::Vector3d(off(random), off(random), off(random)));
            }
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) {
                const int a = first + i * (n + 1) + j, b = a + n + 1;
                if (face % 2)
                    box.triangles.insert(box.triangles.end(), {{a, b, b + 1}, {a, b + 1, a + 1}});
                else
                    box.triangles.insert(box.triangles.end(), {{a, b + 1, b}, {a, a + 1, b + 1}});
                box.labels.insert(box.labels.end(), {face, face});
            }
    }
    CHECK(find_cracks(box).junctions > 20);
    const Repaired repaired = repair(box, default_repair(box));
    const Diagnosis found = diagnose(repaired.soup);
    CHECK(is_clean_manifold(found));
    CHECK(found.closed);
    CHECK(found.euler_characteristic == 2);
    CHECK(volume(repaired.soup) == Approx(1).epsilon(10 * gap + 1e-12));
    CHECK(repair(repaired.soup, default_repair(repaired.soup)).steps.empty());
    // Every face keeps its own area, so no triangle came from elsewhere.
    std::array<double, 6> area{};
    for (std::size_t t = 0; t < repaired.soup.triangles.size(); ++t) {
        const auto& [a, b, c] = repaired.soup.triangles[t];
        const Eigen::Vector3d u = repaired.soup.points[b] - repaired.soup.points[a],
                              v = repaired.soup.points[c] - repaired.soup.points[a];
        area[repaired.soup.labels[t]] += u.cross(v).norm() / 2;
    }
    for (const double a : area) CHECK(a == Approx(1).epsilon(20 * gap + 1e-12));
}

TEST_CASE("an open edge is split only where another one runs along it", "[mesh][repair][exact]") {
    // A triangle stands with a corner on the edge of another one.
    const TriangleSoup standing{.points = {{0, 0, 0}, {2, 0, 0}, {1, -2, 0}, {1, 0, 0}, {2, 2, 0}, {0, 2, 0}},
                                .triangles = {{0, 2, 1}, {3, 4, 5}}};
    CHECK(find_cracks(standing).empty());
    CHECK(repair(standing, default_repair(standing)).steps.empty());
    // Two that lie along each other in part: the edge of each is split at the corner of the other.
    TriangleSoup shifted{.points = {{0, 0, 0}, {2, 0, 0}, {1, -2, 0}, {1, 0, 0}, {3, 0, 0}, {2, 2, 0}},
                         .triangles = {{0, 2, 1}, {3, 4, 5}}};
    shifted.edges = {{0, 1}};
    CHECK(find_cracks(shifted).junctions == 2);
    const Repaired repaired = repair(shifted, default_repair(shifted));
    CHECK(repaired.soup.triangles.size() == 4);
    CHECK(repaired.soup.edges == std::vector<std::array<int, 2>>{{0, 3}, {3, 1}});
    CHECK(diagnose(repaired.soup).components == 1);
    REQUIRE(repaired.steps.size() == 1);
    CHECK(repaired.steps[0].kind == RepairKind::SplitEdges);
    CHECK(repaired.steps[0].items.first == std::vector<std::vector<int>>{{3, 0, 1}, {1, 3, 4}});
}

TEST_CASE("closed parts that share a face stay apart and closed", "[mesh][repair][exact]") {
    TriangleSoup soup;
    add_cube(soup, {0, 0, 0});
    const TriangleSoup one = soup;
    const int n = static_cast<int>(one.points.size());
    // Its mirror image in its face at x = 1, so that the triangles there are the same but for their sides.
    for (const Eigen::Vector3d& p : one.points) soup.points.push_back({2 - p.x(), p.y(), p.z()});
    for (const Triangle& t : one.triangles) soup.triangles.push_back({n + t[0], n + t[2], n + t[1]});
    const Repaired repaired = repair(soup);
    const Diagnosis found = diagnose(repaired.soup);
    CHECK(found.closed);
    CHECK(found.components == 2);
    CHECK(volume(repaired.soup) == Approx(2));
    CHECK(repaired.soup.triangles.size() == soup.triangles.size());
}

TEST_CASE("a vertex that is required stays where it is when others are welded to it", "[mesh][repair][exact]") {
    TriangleSoup soup{.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1e-9, 0}, {1, 1, 0}, {0, 1, 0}},
                      .triangles = {{0, 1, 2}, {3, 4, 5}}};
    soup.required.vertices = {3};
    const Repaired repaired = repair(soup, {.weld_tolerance = 1e-6});
    REQUIRE(repaired.soup.points.size() == 4);
    REQUIRE(repaired.soup.required.vertices.size() == 1);
    CHECK(repaired.soup.points[repaired.soup.required.vertices[0]] == Eigen::Vector3d(1, 1e-9, 0));
}

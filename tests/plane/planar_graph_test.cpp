#include "gradus/plane/planar_graph.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>
#include <set>

#include "gradus/mesh/diagnose.hpp"

using namespace gradus;

namespace {

// A closed polygon of further points and segments.
void add_loop(PlanarGraph& graph, const std::vector<Eigen::Vector2d>& corners) {
    const int first = static_cast<int>(graph.points.size()), n = static_cast<int>(corners.size());
    for (int i = 0; i < n; ++i) {
        graph.points.push_back(corners[i]);
        graph.segments.push_back({first + i, first + (i + 1) % n});
    }
}

std::vector<Eigen::Vector2d> square(double low, double high) {
    return {{low, low}, {high, low}, {high, high}, {low, high}};
}

std::vector<Eigen::Vector2d> circle(double x, double y, double radius, int sides) {
    std::vector<Eigen::Vector2d> corners;
    for (int k = 0; k < sides; ++k) {
        const double angle = 2 * std::numbers::pi * k / sides;
        corners.emplace_back(x + radius * std::cos(angle), y + radius * std::sin(angle));
    }
    return corners;
}

double area(const TriangleSoup& soup) {
    double sum = 0;
    for (const auto& [a, b, c] : soup.triangles)
        sum += (soup.points[b] - soup.points[a]).cross(soup.points[c] - soup.points[a]).z() / 2;
    return sum;
}

bool has_edges(const TriangleSoup& soup) {
    std::set<std::array<int, 2>> sides;
    for (const Triangle& t : soup.triangles)
        for (int k = 0; k < 3; ++k) sides.insert({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
    return std::all_of(soup.edges.begin(), soup.edges.end(), [&](const auto& e) {
        return sides.contains({std::min(e[0], e[1]), std::max(e[0], e[1])});
    });
}

std::string refusal_of(const PlanarGraph& graph) {
    try {
        triangulate(graph);
    } catch (const std::invalid_argument& error) {
        return error.what();
    }
    return "";
}

}  // namespace

TEST_CASE("outlines in outlines are holes, those in holes islands", "[exact]") {
    PlanarGraph graph;
    add_loop(graph, square(0, 10));
    add_loop(graph, square(1, 9));
    add_loop(graph, square(2, 8));
    add_loop(graph, square(3, 7));
    const TriangleSoup soup = triangulate(graph);
    CHECK(area(soup) == Approx(100 - 64 + 36 - 16).epsilon(1e-14));
    CHECK(has_edges(soup));
    CHECK(soup.dimension == 2);
    CHECK(std::set<int>(soup.labels.begin(), soup.labels.end()) == std::set<int>{1, 2});
    const Diagnosis found = diagnose(soup);
    CHECK(is_clean_manifold(found));
    CHECK(found.components == 2);
    CHECK(found.boundary_loops == 4);
}

TEST_CASE("regions that share segments are both inside, a hole may touch the border in a point", "[exact]") {
    // Two squares side by side, in the second one a triangle that touches its side.
    PlanarGraph graph{
        .points = {{0, 0}, {2, 0}, {4, 0}, {4, 2}, {2, 2}, {0, 2}, {4, 1}, {3, 0.5}, {3, 1.5}},
        .segments = {{0, 1}, {1, 4}, {4, 5}, {5, 0}, {1, 2}, {2, 6}, {6, 3}, {3, 4}, {6, 8}, {8, 7}, {7, 6}}};
    const TriangleSoup soup = triangulate(graph);
    CHECK(area(soup) == Approx(8 - 0.5).epsilon(1e-14));
    CHECK(std::set<int>(soup.labels.begin(), soup.labels.end()) == std::set<int>{1, 2});
    // With a list of holes, which is empty, all that is enclosed is inside.
    graph.holes.emplace();
    CHECK(area(triangulate(graph)) == Approx(8).epsilon(1e-14));
    graph.holes->emplace_back(1, 1);
    CHECK(area(triangulate(graph)) == Approx(4).epsilon(1e-14));
}

TEST_CASE("lines and points inside are kept, with labels and corners", "[exact]") {
    PlanarGraph graph;
    add_loop(graph, square(0, 4));
    graph.points.insert(graph.points.end(), {{1, 1}, {2, 2}, {3, 1.5}, {1, 3}, {9, 9}});
    graph.segments.insert(graph.segments.end(), {{4, 5}, {5, 6}});
    graph.labels = {1, 1, 2, 2, 7, 7};
    graph.regions = {{{3, 3}, 5}};
    const TriangleSoup soup = triangulate(graph);
    CHECK(area(soup) == Approx(16).epsilon(1e-14));
    CHECK(has_edges(soup));
    CHECK(soup.edge_labels == graph.labels);
    CHECK(std::all_of(soup.labels.begin(), soup.labels.end(), [](int label) { return label == 5; }));
    CHECK(soup.required.vertices == std::vector<int>{7});  // not the one outside
    CHECK(diagnose(soup).unused_vertices.first == std::vector<int>{8});
}

TEST_CASE("what is wrong with a planar domain is named with its place", "[exact]") {
    PlanarGraph crossing{
        .points = {{0, 0}, {2, 0}, {0, 2}, {2, 2}}, .segments = {{0, 1}, {1, 2}, {2, 3}, {3, 0}}, .first_number = 1};
    CHECK_THAT(refusal_of(crossing), Catch::Contains("crosses") && Catch::Contains("(1, 1)"));
    PlanarGraph open{.points = {{0, 0}, {2, 0}, {2, 2}}, .segments = {{0, 1}, {1, 2}}, .first_number = 1};
    CHECK_THAT(refusal_of(open), Catch::Contains("enclose nothing") && Catch::Contains("open at point 1 at (0, 0)"));
    PlanarGraph repeated{
        .points = {{0, 0}, {2, 0}, {2, 2}, {2, 0}}, .segments = {{0, 1}, {3, 2}, {2, 0}}, .first_number = 1};
    CHECK_THAT(refusal_of(repeated), Catch::Contains("coincides with point") && Catch::Contains("(2, 0)"));
    PlanarGraph touching{.points = {{0, 0}, {2, 0}, {2, 2}, {1, 0}, {1.5, 1}},
                         .segments = {{0, 1}, {1, 2}, {2, 0}, {3, 4}}};
    CHECK_THAT(refusal_of(touching), Catch::Contains("segment 0-1 touches point 3 at (1, 0)"));
    PlanarGraph outside;
    add_loop(outside, square(0, 1));
    outside.points.insert(outside.points.end(), {{2, 2}, {3, 3}});
    outside.segments.push_back({4, 5});
    CHECK_THAT(refusal_of(outside), Catch::Contains("segment 4-5 at (2, 2) is not in the domain"));
    PlanarGraph hole;
    add_loop(hole, square(0, 1));
    hole.holes = {{Eigen::Vector2d(5, 5)}};
    CHECK_THAT(refusal_of(hole), Catch::Contains("the hole at (5, 5) is in no region"));
    hole.holes = {{Eigen::Vector2d(0.5, 0.5)}};
    CHECK_THAT(refusal_of(hole), Catch::Contains("nothing is left"));
    hole.holes.reset();
    hole.regions = {{{0.1, 0.1}, 1}, {{0.9, 0.9}, 2}};
    CHECK_THAT(refusal_of(hole), Catch::Contains("two labels, 1 and 2"));
    hole.regions = {{{-1, 0}, 1}};
    CHECK_THAT(refusal_of(hole), Catch::Contains("(-1, 0) is in none"));
}

TEST_CASE("added points make triangles well shaped but where segments are long, and change nothing else",
          "[property]") {
    PlanarGraph graph;
    add_loop(graph, square(0, 10));
    add_loop(graph, circle(3, 4, 0.5, 400));
    add_loop(graph, circle(7, 6, 0.01, 16));
    const TriangleSoup plain = triangulate(graph), refined = triangulate(graph, InnerPoints::Added);
    REQUIRE(is_clean_manifold(diagnose(refined)));
    CHECK(std::equal(plain.points.begin(), plain.points.end(), refined.points.begin()));
    CHECK(refined.edges == plain.edges);
    CHECK(has_edges(refined));
    CHECK(refined.required.empty());
    CHECK(area(refined) == Approx(area(plain)).epsilon(1e-14));
    // The usual triangle; some have a side of the square, which stays whole.
    std::vector<double> smallest;
    for (const Triangle& t : refined.triangles) {
        double angle = 180;
        for (int k = 0; k < 3; ++k) {
            const Eigen::Vector3d a = refined.points[t[(k + 1) % 3]] - refined.points[t[k]],
                                  b = refined.points[t[(k + 2) % 3]] - refined.points[t[k]];
            angle = std::min(angle, 180 / std::numbers::pi * std::atan2(a.cross(b).norm(), a.dot(b)));
        }
        smallest.push_back(angle);
    }
    std::sort(smallest.begin(), smallest.end());
    CHECK(smallest[smallest.size() / 20] > 20);
    CHECK(refined.triangles.size() < 5000);
}

TEST_CASE("parts that meet in a point get a vertex each there", "[exact]") {
    PlanarGraph graph;
    graph.points = {{-1, -1}, {0, 0}, {-1, 1}, {1, -1}, {1, 1}};
    graph.segments = {{0, 1}, {1, 2}, {2, 0}, {1, 3}, {3, 4}, {4, 1}};
    graph.labels = {1, 2, 3, 4, 5, 6};
    graph.required.vertices = {1};
    const TriangleSoup soup = triangulate(graph);
    CHECK(is_manifold(diagnose(soup)));
    REQUIRE(soup.points.size() == 6);
    CHECK(soup.points[5] == soup.points[1]);
    CHECK(has_edges(soup));
    CHECK(soup.edge_labels == graph.labels);
    CHECK(soup.required.vertices == std::vector{1, 5});
    CHECK(area(soup) == Approx(2));
}

TEST_CASE("areas of random holes, holes in holes and lines agree with those of the polygons", "[property]") {
    const unsigned seed = GENERATE(range(1U, 9U));
    CAPTURE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(0, 1);
    PlanarGraph graph;
    add_loop(graph, square(0, 1));
    double expected = 1;
    std::vector<Eigen::Vector3d> discs;
    while (discs.size() < 40) {
        const double radius = 0.005 + 0.08 * uniform(random);
        const Eigen::Vector2d at(radius + (1 - 2 * radius) * uniform(random),
                                 radius + (1 - 2 * radius) * uniform(random));
        const auto meets = [&](const Eigen::Vector3d& disc) {
            return (disc.head<2>() - at).norm() < disc.z() + radius;
        };
        if (std::min({at.x(), at.y(), 1 - at.x(), 1 - at.y()}) <= radius ||
            std::any_of(discs.begin(), discs.end(), meets)) {
            if (uniform(random) < 0.01) break;
            continue;
        }
        discs.emplace_back(at.x(), at.y(), radius);
        const int sides = 3 + static_cast<int>(20 * uniform(random));
        const double one = sides * std::sin(2 * std::numbers::pi / sides) / 2;
        add_loop(graph, circle(at.x(), at.y(), 0.99 * radius, sides));
        add_loop(graph, circle(at.x(), at.y(), 0.3 * radius, sides));  // an island
        expected -= one * radius * radius * (0.99 * 0.99 - 0.3 * 0.3);
    }
    // Neither the order of points nor that of segments tells.
    std::shuffle(graph.segments.begin(), graph.segments.end(), random);
    for (auto& segment : graph.segments)
        if (uniform(random) < 0.5) std::swap(segment[0], segment[1]);
    const TriangleSoup soup = triangulate(graph);
    CHECK(area(soup) == Approx(expected).epsilon(1e-12));
    CHECK(has_edges(soup));
    CHECK(is_manifold(diagnose(soup)));
    for (const auto& [a, b, c] : soup.triangles)
        CHECK((soup.points[b] - soup.points[a]).cross(soup.points[c] - soup.points[a]).z() > 0);
}

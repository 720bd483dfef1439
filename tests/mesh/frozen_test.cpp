// What is required of a mesh, with all it is made of, and what cannot be.
#include "gradus/mesh/frozen.hpp"

#include <catch2/catch.hpp>

#include "support/triangulations.hpp"

using namespace gradus;

namespace {

struct Given {
    TriangleSoup soup = triangulations::soup(triangulations::cube(2));
    Connectivity mesh{static_cast<int>(soup.points.size()), soup.triangles};
    Frozen frozen(const RequiredElements& required) const { return frozen_elements(soup.points, mesh, required); }
};

int count(const std::vector<char>& set) { return static_cast<int>(std::count(set.begin(), set.end(), 1)); }

}  // namespace

TEST_CASE("a triangle is frozen with its edges and vertices, an edge with its ends", "[mesh][exact]") {
    const Given given;
    CHECK(given.frozen({}).empty());
    CHECK(frozen_edge_lengths(given.soup.points, given.mesh, given.frozen({})).empty());
    const Frozen of_triangle = given.frozen({.triangles = {5}});
    CHECK(count(of_triangle.triangle) == 1);
    CHECK(count(of_triangle.vertex) == 3);
    CHECK(count(of_triangle.half_edge) == 6);
    for (int k = 0; k < 3; ++k) {
        CHECK(of_triangle.has_vertex(given.soup.triangles[5][k]));
        CHECK(of_triangle.has_edge(15 + k));
        CHECK(of_triangle.has_edge(given.mesh.twin(15 + k)));
    }
    const int a = given.soup.triangles[9][0], b = given.soup.triangles[9][1];
    const Frozen of_edge = given.frozen({.vertices = {a}, .edges = {{b, a}}});
    CHECK(count(of_edge.triangle) == 0);
    CHECK(count(of_edge.vertex) == 2);
    CHECK(count(of_edge.half_edge) == 2);
    // Right isosceles triangles with legs of 1/2: at the right angle two legs meet, at the others a leg and a diagonal.
    const auto lengths = frozen_edge_lengths(given.soup.points, given.mesh, of_triangle);
    std::vector<double> found;
    for (const int v : given.soup.triangles[5]) found.push_back(lengths[v]);
    std::sort(found.begin(), found.end());
    CHECK(found[0] == Approx(0.5));
    CHECK(found[1] == Approx((1 + std::sqrt(2)) / 4));
    CHECK(found[2] == Approx((1 + std::sqrt(2)) / 4));
    CHECK(std::count(lengths.begin(), lengths.end(), 0) == static_cast<int>(lengths.size()) - 3);
}

TEST_CASE("what cannot be kept is refused with its number and place", "[mesh]") {
    Given given;
    const auto refuses = [&](const RequiredElements& required, const std::string& what) {
        CHECK_THROWS_WITH(given.frozen(required), Catch::Contains(what));
        CHECK_THROWS_AS(given.frozen(required), std::invalid_argument);
    };
    refuses({.vertices = {26}}, "required vertex 26");
    refuses({.vertices = {-1}}, "there are 26");
    refuses({.edges = {{0, 99}}}, "required edge to vertex 99");
    refuses({.edges = {{3, 3}}}, "required edge 3-3");
    refuses({.triangles = {48}}, "required triangle 48");
    // Opposite corners of the cube.
    const auto index = [&](const Eigen::Vector3d& p) {
        return static_cast<int>(std::find(given.soup.points.begin(), given.soup.points.end(), p) -
                                given.soup.points.begin());
    };
    refuses({.edges = {{index({1, 1, 1}), index({0, 0, 0})}}}, "at 1 1 1 is no side of a triangle");
    const auto [a, b, c] = given.soup.triangles[7];
    given.soup.points[c] = (given.soup.points[a] + given.soup.points[b]) / 2;
    refuses({.triangles = {7}}, "required triangle 7 (counted from 0) at");
    refuses({.triangles = {7}}, "has no area");
    given.soup.points[b] = given.soup.points[a];
    refuses({.edges = {{a, b}}}, "has no length");
    given.soup.points.push_back({5, 6, 7});
    given.mesh = Connectivity(static_cast<int>(given.soup.points.size()), given.soup.triangles);
    refuses({.vertices = {26}}, "at 5 6 7 is in no triangle");
}

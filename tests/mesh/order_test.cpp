#include "gradus/mesh/order.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <numeric>
#include <random>

#include "support/triangulations.hpp"

using namespace gradus;
using Eigen::Vector3d;

namespace {

// A sphere whose points and triangles are in random order, with everything that names them.
TriangleSoup shuffled_sphere() {
    TriangleSoup soup = triangulations::soup(triangulations::sphere(3));
    std::mt19937 random(5);
    std::vector<int> to(soup.points.size());
    std::iota(to.begin(), to.end(), 0);
    std::shuffle(to.begin(), to.end(), random);
    std::vector<Vector3d> points(soup.points.size());
    for (std::size_t v = 0; v < to.size(); ++v) points[to[v]] = soup.points[v];
    soup.points = points;
    for (Triangle& t : soup.triangles)
        for (int& v : t) v = to[v];
    std::shuffle(soup.triangles.begin(), soup.triangles.end(), random);
    for (std::size_t t = 0; t < soup.triangles.size(); ++t) soup.labels.push_back(static_cast<int>(t % 7));
    const auto& [a, b, c] = soup.triangles[10];
    soup.corners = {a};
    soup.edges = {{a, b}};
    soup.required = {{c}, {{b, c}}, {10, 20}};
    soup.parameters = {{b, {3, {0.25, 0.5}}}};
    return soup;
}

double mean_step(const TriangleSoup& soup) {
    double sum = 0;
    for (const Triangle& t : soup.triangles)
        for (int k = 0; k < 3; ++k) sum += std::abs(t[k] - t[(k + 1) % 3]);
    return sum / (3.0 * static_cast<double>(soup.triangles.size()));
}

}  // namespace

TEST_CASE("a soup along a curve is the same soup, and neighbours are near in it", "[property]") {
    const TriangleSoup soup = shuffled_sphere();
    const auto [ordered, point_source, triangle_source] = along_curve(soup);
    REQUIRE(ordered.points.size() == soup.points.size());
    REQUIRE(ordered.triangles.size() == soup.triangles.size());
    for (std::size_t v = 0; v < soup.points.size(); ++v) CHECK(ordered.points[v] == soup.points[point_source[v]]);
    for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
        CHECK(ordered.labels[t] == soup.labels[triangle_source[t]]);
        for (int k = 0; k < 3; ++k)
            CHECK(point_source[ordered.triangles[t][k]] == soup.triangles[triangle_source[t]][k]);
    }
    CHECK(point_source[ordered.corners.at(0)] == soup.corners[0]);
    CHECK(point_source[ordered.edges.at(0)[1]] == soup.edges[0][1]);
    CHECK(point_source[ordered.required.vertices.at(0)] == soup.required.vertices[0]);
    CHECK(point_source[ordered.required.edges.at(0)[0]] == soup.required.edges[0][0]);
    CHECK(triangle_source[ordered.required.triangles.at(1)] == soup.required.triangles[1]);
    CHECK(point_source[ordered.parameters.at(0).vertex] == soup.parameters[0].vertex);
    CHECK(mean_step(ordered) < 0.3 * mean_step(soup));
}

TEST_CASE("codes along a curve interleave the bits of coordinates", "[exact]") {
    const double most = (1 << 21) - 1;
    const ZCurve curve(Eigen::AlignedBox3d(Vector3d::Zero(), Vector3d::Constant(most)));
    CHECK(curve.code({0, 0, 0}) == 0);
    CHECK(curve.code({1, 0, 0}) == 1);
    CHECK(curve.code({0, 1, 0}) == 2);
    CHECK(curve.code({0, 0, 1}) == 4);
    CHECK(curve.code({2, 3, 0}) == 0b011'010);
    CHECK(curve.code(Vector3d::Constant(most)) == (std::uint64_t{1} << 63) - 1);
    const Vector3d only(1, 2, 3);
    CHECK(ZCurve(Eigen::AlignedBox3d(only, only)).code(only) == 0);
}

TEST_CASE("coordinates that have no place on a curve leave a soup as it is", "[exact]") {
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300}) {
        const TriangleSoup soup{{{3, 0, 0}, {bad, 0, 0}, {0, 1, 0}}, {{2, 0, 1}}};
        const Ordered ordered = along_curve(soup);
        CHECK(ordered.point_source == std::vector<int>{0, 1, 2});
        CHECK(ordered.soup.triangles == soup.triangles);
        CHECK(ordered.soup.points[0] == soup.points[0]);
    }
}

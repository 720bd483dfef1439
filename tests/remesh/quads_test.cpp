#include "gradus/remesh/quads.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <random>

#include "../../src/remesh/matching.hpp"
#include "gradation/maps.hpp"
#include "support/triangulations.hpp"

using namespace gradus;
using namespace gradus::test;
using Eigen::Vector3d;

namespace {

// The largest weight of all matchings, by trying all.
long brute(int nodes, const std::vector<std::array<int, 2>>& edges, const std::vector<long>& weights, std::size_t from,
           unsigned used) {
    if (from == edges.size()) return 0;
    long best = brute(nodes, edges, weights, from + 1, used);
    const unsigned ends = 1U << edges[from][0] | 1U << edges[from][1];
    if (!(used & ends)) best = std::max(best, weights[from] + brute(nodes, edges, weights, from + 1, used | ends));
    return best;
}

TriangleSoup shaken(unsigned seed, int n) {
    Random random(seed);
    const Tris t = random_tris(seed, n, n, 0, 0);
    TriangleSoup soup{t.points, t.triangles};
    for (Vector3d& p : soup.points) {
        p.z() = 0;
        if (p.x() > .5 && p.x() < n - .5 && p.y() > .5 && p.y() < n - .5)
            p += Vector3d(random(-.2, .2), random(-.2, .2), 0);
    }
    soup.dimension = 2;
    return soup;
}

struct Facts {
    double area = 0, worst = 1;
    std::map<std::pair<int, int>, int> sides;  // uses of each edge
};

Facts facts_of(const QuadMesh& mesh) {
    Facts facts;
    const auto add = [&](const auto& v) {
        const int n = static_cast<int>(v.size());
        for (int k = 0; k < n; ++k) {
            ++facts.sides[std::minmax(v[k], v[(k + 1) % n])];
            const Vector3d &a = mesh.points[v[k]], &b = mesh.points[v[(k + 1) % n]];
            facts.area += (a.x() * b.y() - b.x() * a.y()) / 2;
        }
    };
    for (const auto& v : mesh.quads) {
        add(v);
        facts.worst = std::min(
            facts.worst, quad_quality({mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]], mesh.points[v[3]]},
                                      Vector3d::UnitZ()));
    }
    for (const auto& v : mesh.triangles) add(v);
    return facts;
}

int borders(const Facts& facts) {
    int count = 0;
    for (const auto& [side, uses] : facts.sides) {
        CHECK(uses <= 2);
        count += uses == 1;
    }
    return count;
}

}  // namespace

TEST_CASE("The matching is the heaviest of all", "[exact]") {
    Random random(3);
    for (int trial = 0; trial < 60; ++trial) {
        const int nodes = 3 + random.below(7);
        std::vector<std::array<int, 2>> edges;
        std::vector<long> weights;
        for (int a = 0; a < nodes; ++a)
            for (int b = a + 1; b < nodes; ++b)
                if (edges.size() < 16 && random(0, 1) < .45) {
                    edges.push_back({a, b});
                    weights.push_back(1 + random.below(1000));
                }
        const std::vector<int> mate = detail::heaviest_matching(nodes, edges, weights);
        long weight = 0;
        for (std::size_t e = 0; e < edges.size(); ++e)
            if (mate[edges[e][0]] == edges[e][1]) {
                CHECK(mate[edges[e][1]] == edges[e][0]);
                weight += weights[e];
            }
        CHECK(weight == brute(nodes, edges, weights, 0, 0));
    }
}

TEST_CASE("Quality of a quadrilateral is its least corner", "[exact]") {
    const Vector3d n = Vector3d::UnitZ();
    CHECK(quad_quality({Vector3d(0, 0, 0), {3, 0, 0}, {3, 1, 0}, {0, 1, 0}}, n) == Approx(1));
    CHECK(quad_quality({Vector3d(0, 0, 0), {2, 0, 0}, {3, 1, 0}, {1, 1, 0}}, n) == Approx(std::sqrt(.5)));
    CHECK(quad_quality({Vector3d(0, 0, 0), {2, 0, 0}, {.2, .2, 0}, {0, 2, 0}}, n) < 0);
    // A parallelogram that is a square in the metric.
    Eigen::Matrix3d stretch;
    stretch << 1, .5, 0, 0, .1, 0, 0, 0, 1;
    const Tensor metric = tensor_of((stretch * stretch.transpose()).inverse());
    const std::array<Vector3d, 4> square{Vector3d(0, 0, 0), {1, 0, 0}, {1.5, .1, 0}, {.5, .1, 0}};
    CHECK(quad_quality(square, n) < .2);
    CHECK(quad_quality(square, {metric, metric, metric, metric}, n) == Approx(1).epsilon(1e-9));
}

TEST_CASE("All quadrilaterals, where their number is even, keep area and boundary", "[property]") {
    for (const unsigned seed : {1U, 2U, 3U, 4U}) {
        const TriangleSoup soup = shaken(seed, 12);
        QuadStatistics statistics;
        const QuadMesh mesh = to_quads(soup, {.mode = QuadOptions::Mode::All}, &statistics);
        CHECK(mesh.triangles.empty());
        CHECK(statistics.odd_parts == 0);
        CHECK(mesh.dimension == 2);
        const Facts facts = facts_of(mesh);
        CHECK(facts.area == Approx(144).epsilon(1e-12));
        CHECK(borders(facts) == 48);
        CHECK(facts.worst > .25);
    }
}

TEST_CASE("Triangles that no pairing serves are led to each other", "[property]") {
    // Two triangles at opposite ends of a strip, each with two open edges.
    TriangleSoup soup;
    const int n = 9;
    for (int i = 0; i <= n; ++i)
        for (const double y : {0.0, 1.0}) soup.points.emplace_back(i, y, 0);
    for (int i = 0; i < n; ++i) {
        const int a = 2 * i, b = a + 2, c = a + 3, d = a + 1;
        soup.triangles.push_back({a, b, c});
        soup.triangles.push_back({a, c, d});
    }
    soup.points.emplace_back(-.8, .5, 0);
    soup.points.emplace_back(n + .8, .5, 0);
    soup.triangles.push_back({0, 1, static_cast<int>(soup.points.size()) - 2});
    soup.triangles.push_back({2 * n + 1, 2 * n, static_cast<int>(soup.points.size()) - 1});
    const QuadMesh mesh = to_quads(soup, {.mode = QuadOptions::Mode::All});
    CHECK(mesh.triangles.empty());
    CHECK(mesh.quads.size() == n + 1);
    CHECK(facts_of(mesh).area == Approx(n + .8).epsilon(1e-12));
}

TEST_CASE("An odd part keeps a triangle, and refinement leaves none", "[exact]") {
    TriangleSoup soup = shaken(5, 6);
    soup.triangles.pop_back();
    QuadStatistics statistics;
    const QuadMesh odd = to_quads(soup, {.mode = QuadOptions::Mode::All}, &statistics);
    CHECK(odd.triangles.size() == 1);
    CHECK(statistics.odd_parts == 1);
    const QuadMesh fine = to_quads(soup, {.mode = QuadOptions::Mode::Refined});
    CHECK(fine.triangles.empty());
    CHECK(facts_of(fine).area == Approx(facts_of(odd).area).epsilon(1e-12));
}

TEST_CASE("Pairs do not cross labels and feature edges", "[property]") {
    TriangleSoup soup = shaken(6, 10);
    for (const auto& v : soup.triangles) {
        const double x = (soup.points[v[0]].x() + soup.points[v[1]].x() + soup.points[v[2]].x()) / 3;
        soup.labels.push_back(x < 5 ? 1 : 2);
    }
    std::vector<std::array<int, 2>> border;
    std::map<std::pair<int, int>, int> seen;
    for (std::size_t t = 0; t < soup.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) {
            const int a = soup.triangles[t][k], b = soup.triangles[t][(k + 1) % 3];
            const auto [at, fresh] = seen.try_emplace(std::minmax(a, b), soup.labels[t]);
            if (!fresh && at->second != soup.labels[t]) border.push_back({a, b});
        }
    REQUIRE(border.size() >= 10);
    const QuadMesh mesh = to_quads(soup);
    double left = 0, expected = 0;
    for (std::size_t q = 0; q < mesh.quads.size(); ++q)
        if (mesh.quad_labels[q] == 1) {
            const auto& v = mesh.quads[q];
            left += (mesh.points[v[2]] - mesh.points[v[0]]).cross(mesh.points[v[3]] - mesh.points[v[1]]).z() / 2;
        }
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        if (mesh.triangle_labels[t] == 1) {
            const auto& v = mesh.triangles[t];
            left += (mesh.points[v[1]] - mesh.points[v[0]]).cross(mesh.points[v[2]] - mesh.points[v[0]]).z() / 2;
        }
    for (std::size_t t = 0; t < soup.triangles.size(); ++t)
        if (soup.labels[t] == 1) {
            const auto& v = soup.triangles[t];
            expected += (soup.points[v[1]] - soup.points[v[0]]).cross(soup.points[v[2]] - soup.points[v[0]]).z() / 2;
        }
    CHECK(left == Approx(expected).epsilon(1e-12));
}

TEST_CASE("On a sphere vertices stay on the triangles, and the mesh closed", "[property]") {
    const auto sphere = triangulations::sphere(4);
    const QuadMesh mesh = to_quads({sphere.points, sphere.triangles}, {.mode = QuadOptions::Mode::All});
    CHECK(mesh.triangles.empty());
    const Facts facts = facts_of(mesh);
    CHECK(borders(facts) == 0);
    CHECK(static_cast<int>(mesh.points.size()) - static_cast<int>(facts.sides.size()) +
              static_cast<int>(mesh.quads.size()) ==
          2);
    for (const Vector3d& p : mesh.points) {
        CHECK(p.norm() <= 1 + 1e-12);
        CHECK(p.norm() > .98);
    }
    for (const auto& v : mesh.quads) {
        const Vector3d middle = (mesh.points[v[0]] + mesh.points[v[1]] + mesh.points[v[2]] + mesh.points[v[3]]) / 4;
        CHECK(quad_quality({mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]], mesh.points[v[3]]},
                           middle.normalized()) > .2);
    }
}

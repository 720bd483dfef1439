#include "gradus/mesh/diagnose.hpp"

#include <catch2/catch.hpp>
#include <limits>
#include <map>
#include <set>

#include "support/soups.hpp"

using namespace gradus;
using support::grid;
using support::tetrahedron;

namespace {

/// A torus of n x m quadrilaterals, split.
TriangleSoup torus(int n, int m) {
    TriangleSoup soup;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < m; ++j) {
            const double u = 2 * M_PI * i / n, v = 2 * M_PI * j / m;
            soup.points.push_back({(3 + std::cos(v)) * std::cos(u), (3 + std::cos(v)) * std::sin(u), std::sin(v)});
        }
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < m; ++j) {
            const int a = i * m + j, b = (i + 1) % n * m + j, c = (i + 1) % n * m + (j + 1) % m,
                      d = i * m + (j + 1) % m;
            soup.triangles.push_back({a, b, c});
            soup.triangles.push_back({a, c, d});
        }
    return soup;
}

/// `a` and `b` side by side.
TriangleSoup together(TriangleSoup a, const TriangleSoup& b) {
    const int shift = static_cast<int>(a.points.size());
    for (const Eigen::Vector3d& p : b.points) a.points.push_back(p + Eigen::Vector3d(100, 0, 0));
    for (const Triangle& t : b.triangles) a.triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
    return a;
}

}  // namespace

TEST_CASE("the topology of known surfaces is found", "[mesh][exact]") {
    const Diagnosis sphere = diagnose(tetrahedron());
    CHECK(sphere.closed);
    CHECK(sphere.euler_characteristic == 2);
    CHECK(sphere.num_edges == 6);
    CHECK(is_clean_manifold(sphere));

    const Diagnosis square = diagnose(grid(5));
    CHECK_FALSE(square.closed);
    CHECK(square.euler_characteristic == 1);
    CHECK(square.boundary_loops == 1);
    CHECK(square.boundary_edges == 20);
    CHECK(square.components == 1);
    CHECK(is_clean_manifold(square));

    const Diagnosis ring = diagnose(torus(9, 7));
    CHECK(ring.closed);
    CHECK(ring.euler_characteristic == 0);
    CHECK(is_clean_manifold(ring));

    const Diagnosis both = diagnose(together(torus(9, 7), grid(3)));
    CHECK(both.components == 2);
    CHECK(both.boundary_loops == 1);
    CHECK(both.euler_characteristic == 1);

    TriangleSoup holed = torus(9, 7);
    holed.triangles.erase(holed.triangles.begin() + 60);
    holed.triangles.erase(holed.triangles.begin());
    CHECK(diagnose(holed).boundary_loops == 2);
    CHECK(diagnose(holed).boundary_edges == 6);
}

TEST_CASE("nothing is no mesh, and does no harm", "[mesh]") {
    const Diagnosis nothing = diagnose({});
    CHECK_FALSE(nothing.closed);
    CHECK(nothing.components == 0);
    CHECK(is_clean_manifold(nothing));
    CHECK(to_mesh({}).n_faces() == 0);
}

TEST_CASE("each fault is found, and by its own name", "[mesh][exact]") {
    TriangleSoup soup = tetrahedron();
    const auto n = static_cast<int>(soup.triangles.size());

    SECTION("a number that is not finite") {
        soup.points[2].y() = std::numeric_limits<double>::quiet_NaN();
        CHECK(diagnose(soup).bad_numbers.first == std::vector{2});
        CHECK_FALSE(is_manifold(diagnose(soup)));
    }
    SECTION("an index out of range") {
        soup.triangles.push_back({0, 1, 4});
        soup.triangles.push_back({-1, 1, 2});
        CHECK(diagnose(soup).out_of_range.first == std::vector{n, n + 1});
        CHECK(diagnose(soup).closed);
    }
    SECTION("a repeated index") {
        soup.triangles.push_back({2, 1, 2});
        CHECK(diagnose(soup).repeated_index.first == std::vector{n});
        CHECK(diagnose(soup).non_manifold_edges.empty());
    }
    SECTION("no area") {
        soup.points.insert(soup.points.end(), {{0.1, 0.1, 0.1}, {0.2, 0.2, 0.2}, {0.7, 0.7, 0.7}});
        soup.triangles.push_back({4, 5, 6});
        CHECK(diagnose(soup).zero_area.first == std::vector{n});
        CHECK(is_manifold(diagnose(soup)));
        CHECK_FALSE(is_clean_manifold(diagnose(soup)));
    }
    SECTION("the same triangle twice, turned and mirrored") {
        soup.triangles.push_back({2, 1, 0});
        soup.triangles.push_back({1, 3, 2});
        CHECK(diagnose(soup).duplicate_triangles.first == std::vector<Diagnosis::Copy>{{0, n}, {2, n + 1}});
        CHECK(diagnose(soup).non_manifold_edges.empty());
    }
    SECTION("the same vertex twice") {
        soup.points.push_back({-0.0, 1, 0});
        CHECK(diagnose(soup).duplicate_vertices.first == std::vector<Diagnosis::Copy>{{2, 4}});
        CHECK(diagnose(soup).unused_vertices.first == std::vector{4});
        CHECK(is_manifold(diagnose(soup)));
    }
    SECTION("three triangles at an edge") {
        soup.points.push_back({2, 2, 2});
        soup.triangles.push_back({3, 1, 4});
        const Diagnosis d = diagnose(soup);
        CHECK(d.non_manifold_edges.first == std::vector<Diagnosis::Edge>{{1, 3}});
        CHECK(d.non_manifold_vertices.empty());
    }
    SECTION("a bow tie") {
        soup.points.insert(soup.points.end(), {{2, 0, 0}, {2, 1, 0}});
        soup.triangles.push_back({1, 4, 5});
        const Diagnosis d = diagnose(soup);
        CHECK(d.non_manifold_vertices.first == std::vector{1});
        CHECK(d.components == 2);
        CHECK(d.boundary_loops == 1);
        CHECK_THROWS_AS(to_mesh(soup), std::invalid_argument);
    }
    SECTION("a triangle the wrong way round") {
        std::swap(soup.triangles[1][0], soup.triangles[1][1]);
        const Diagnosis d = diagnose(soup);
        CHECK(d.inconsistent_edges.first == std::vector<Diagnosis::Edge>{{0, 1}, {0, 3}, {1, 3}});
        CHECK(d.closed);
    }
    SECTION("two holes that touch at a vertex are two") {
        soup = grid(4);
        std::erase(soup.triangles, Triangle{6, 7, 12});
        std::erase(soup.triangles, Triangle{12, 18, 17});
        const Diagnosis d = diagnose(soup);
        CHECK(d.non_manifold_vertices.first == std::vector{12});
        CHECK(d.components == 1);
    }
}

TEST_CASE("flatness does not depend on scale or place, and spares what is merely thin", "[mesh][property]") {
    const double scale = GENERATE(1e-310, 1e-150, 1.0, 1e150, 1e307);
    TriangleSoup soup;
    soup.points = {
        {scale, scale, 0}, {2 * scale, scale, 0}, {1.5 * scale, scale * (1 + 1e-13), 0}, {3 * scale, scale, 0}};
    soup.triangles = {{0, 1, 2}, {0, 1, 3}};
    if (scale < 1e-300) soup.points[2].y() = 1.1 * scale;  // denormal numbers have few digits
    CHECK(diagnose(soup).zero_area.first == std::vector{1});
}

TEST_CASE("everything is counted, a part is listed", "[mesh]") {
    TriangleSoup soup = grid(20);
    soup.triangles.insert(soup.triangles.end(), 500, Triangle{1, 1, 2});
    const Diagnosis d = diagnose(soup);
    CHECK(d.repeated_index.count == 500);
    CHECK(d.repeated_index.first.size() == Findings<int>::kListed);
    CHECK(summary(d).find("500 triangles that have a vertex twice: 800 801") != std::string::npos);
}

TEST_CASE("to_mesh keeps indices and gives its reasons", "[mesh]") {
    const TriangleSoup soup = torus(6, 5);
    CHECK(triangles_of(to_mesh(soup)) == soup.triangles);
    TriangleSoup bad = soup;
    std::swap(bad.triangles[0][0], bad.triangles[0][1]);
    CHECK_THROWS_WITH(to_mesh(bad), Catch::Contains("3 edges whose two triangles are oriented differently"));
}

TEST_CASE("diagnosis agrees with brute force on random soups", "[mesh][property]") {
    std::mt19937_64 random(7);
    for (int run = 0; run < 300; ++run) {
        TriangleSoup soup;
        const int n = 5 + static_cast<int>(random() % 6);
        for (int i = 0; i < n; ++i)
            soup.points.push_back({double(random() % 3), double(random() % 3), double(random() % 3)});
        for (int t = 0; t < 8; ++t) soup.triangles.push_back({int(random() % n), int(random() % n), int(random() % n)});
        const Diagnosis d = diagnose(soup);

        std::set<std::set<int>> seen;
        std::vector<Triangle> sound;
        std::map<std::set<int>, std::vector<std::array<int, 2>>> edges;
        std::size_t repeated = 0, copies = 0;
        for (const Triangle& t : soup.triangles) {
            const std::set<int> corners(t.begin(), t.end());
            if (corners.size() < 3) {
                ++repeated;
            } else if (!seen.insert(corners).second) {
                ++copies;
            } else {
                sound.push_back(t);
                for (int k = 0; k < 3; ++k) edges[{t[k], t[(k + 1) % 3]}].push_back({t[k], t[(k + 1) % 3]});
            }
        }
        std::size_t boundary = 0, crowded = 0, inconsistent = 0;
        for (const auto& [edge, uses] : edges) {
            boundary += uses.size() == 1;
            crowded += uses.size() > 2;
            inconsistent += uses.size() == 2 && uses[0] == uses[1];
        }
        // Fans at a vertex: flood from triangle to triangle over edges at the vertex.
        std::size_t bow_ties = 0;
        for (int v = 0; v < n; ++v) {
            std::vector<Triangle> around;
            for (const Triangle& t : sound)
                if (std::count(t.begin(), t.end(), v)) around.push_back(t);
            std::vector<char> reached(around.size(), 0);
            std::size_t fans = 0;
            for (std::size_t start = 0; start < around.size(); ++start) {
                if (reached[start]) continue;
                ++fans;
                std::vector<std::size_t> stack{start};
                reached[start] = 1;
                while (!stack.empty()) {
                    const Triangle t = around[stack.back()];
                    stack.pop_back();
                    for (std::size_t k = 0; k < around.size(); ++k) {
                        int shared = 0;
                        for (const int w : around[k]) shared += std::count(t.begin(), t.end(), w) > 0;
                        if (shared == 2 && !reached[k]) {
                            reached[k] = 1;
                            stack.push_back(k);
                        }
                    }
                }
            }
            bow_ties += fans > 1;
        }
        CHECK(d.repeated_index.count == repeated);
        CHECK(d.duplicate_triangles.count == copies);
        CHECK(d.num_edges == edges.size());
        CHECK(d.boundary_edges == boundary);
        CHECK(d.non_manifold_edges.count == crowded);
        CHECK(d.inconsistent_edges.count == inconsistent);
        CHECK(d.non_manifold_vertices.count == bow_ties);
        if (is_manifold(d)) CHECK_NOTHROW(to_mesh(soup));
    }
}

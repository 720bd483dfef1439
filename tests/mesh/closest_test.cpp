#include "gradus/mesh/closest.hpp"

#include <catch2/catch.hpp>
#include <random>

#include "gradus/mesh/parts.hpp"

using namespace gradus;

namespace {

struct Random {
    std::mt19937 generator{7};
    double operator()() { return std::uniform_real_distribution<double>(-1, 1)(generator); }
    Eigen::Vector3d point() { return {(*this)(), (*this)(), (*this)()}; }
};

}  // namespace

TEST_CASE("the closest point of a triangle is on it, and no point of it is closer", "[property]") {
    Random random;
    for (int round = 0; round < 200; ++round) {
        const Eigen::Vector3d a = random.point(), b = random.point(),
                              c = round % 5 == 0 ? Eigen::Vector3d(2 * b - a) : random.point(), p = 2 * random.point();
        const Eigen::Vector3d q = closest_point(p, a, b, c);
        double least = std::numeric_limits<double>::infinity(), from_q = least;
        for (int i = 0; i <= 40; ++i)
            for (int j = 0; i + j <= 40; ++j) {
                const Eigen::Vector3d x = a + i / 40.0 * (b - a) + j / 40.0 * (c - a);
                least = std::min(least, (x - p).norm());
                from_q = std::min(from_q, (x - q).norm());
            }
        CHECK((q - p).norm() <= least + 1e-12);
        CHECK(from_q <= 0.1);
    }
    CHECK(closest_point({0.2, 0.3, 5}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}).isApprox(Eigen::Vector3d(0.2, 0.3, 0)));
    CHECK(closest_point({3, -1, 0}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}) == Eigen::Vector3d(1, 0, 0));
}

namespace {

// Small triangles here and there, and two of three of them.
struct Scattered {
    std::vector<Eigen::Vector3d> points = {};
    std::vector<Triangle> triangles = {};
    std::vector<int> chosen = {};
};

Scattered scattered(Random& random, int count) {
    Scattered s;
    for (int t = 0; t < count; ++t) {
        const Eigen::Vector3d middle = random.point();
        for (int k = 0; k < 3; ++k) s.points.push_back(middle + 0.1 * random.point());
        s.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
        if (t % 3 != 1) s.chosen.push_back(t);
    }
    return s;
}

}  // namespace

TEST_CASE("the tree finds the triangle that brute force finds", "[property]") {
    Random random;
    const int count = GENERATE(1, 2, 5, 300);
    const auto [points, triangles, chosen] = scattered(random, count);
    const ClosestTriangle tree(points, triangles, chosen);
    for (int round = 0; round < 100; ++round) {
        const Eigen::Vector3d p = 1.5 * random.point();
        ClosestTriangle::Hit expected;
        for (const int t : chosen)
            if (const double d = (closest_point(p, points[3 * t], points[3 * t + 1], points[3 * t + 2]) - p).norm();
                d < expected.distance)
                expected = {t, d};
        const auto hit = tree.closest(p);
        CHECK(hit.triangle == expected.triangle);
        CHECK(hit.distance == expected.distance);
    }
}

TEST_CASE("equally close triangles are told by their index", "[exact]") {
    const std::vector<Eigen::Vector3d> points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
    const std::vector<Triangle> triangles{{1, 3, 2}, {0, 1, 2}, {0, 1, 2}};
    CHECK(ClosestTriangle(points, triangles, {2, 1, 0}).closest({0.5, 0.5, 1}).triangle == 0);
    CHECK(ClosestTriangle(points, triangles, {2, 1}).closest({0.2, 0.2, 1}).triangle == 1);
}

TEST_CASE("connected parts are numbered by their first vertices", "[exact]") {
    const std::vector<Triangle> triangles{{5, 6, 4}, {0, 2, 8}, {8, 7, 2}};
    CHECK(connected_parts(9, triangles) == std::vector<int>{0, 1, 0, 2, 3, 3, 3, 0, 0});
    CHECK(connected_parts(0, {}).empty());
}

TEST_CASE("the tree finds all triangles within a distance", "[property]") {
    Random random;
    const int count = GENERATE(1, 5, 300);
    const auto [points, triangles, chosen] = scattered(random, count);
    const ClosestTriangle tree(points, triangles, chosen);
    for (int round = 0; round < 50; ++round) {
        const Eigen::Vector3d p = random.point();
        const double distance = 0.02 * round;
        std::vector<int> expected;
        for (const int t : chosen)
            if ((closest_point(p, points[3 * t], points[3 * t + 1], points[3 * t + 2]) - p).norm() <= distance)
                expected.push_back(t);
        CHECK(tree.within(p, distance) == expected);
    }
}

// Distances that hold everywhere, against sampling and against surfaces whose distance is known.
#include "gradus/quality/hausdorff.hpp"

#include <tbb/global_control.h>

#include <catch2/catch.hpp>
#include <map>
#include <numbers>
#include <set>

#include "support/triangulations.hpp"

using namespace gradus;
using Eigen::Vector3d;
using testing::Mesh;

namespace {

// Of one point, by asking every triangle.
double brute_distance(const Mesh& target, const Vector3d& p) {
    double least = std::numeric_limits<double>::infinity();
    for (const Triangle& t : target.triangles)
        least = std::min(least,
                         (p - closest_point(p, target.points[t[0]], target.points[t[1]], target.points[t[2]])).norm());
    return least;
}

// Largest distance over points of one triangle, a grid of n steps.
double sampled(const Mesh& target, const Mesh& from, int triangle, int n) {
    const Triangle& t = from.triangles[triangle];
    double largest = 0;
    for (int i = 0; i <= n; ++i)
        for (int j = 0; i + j <= n; ++j) {
            const double b = double(i) / n, c = double(j) / n;
            largest = std::max(largest, brute_distance(target, (1 - b - c) * from.points[t[0]] + b * from.points[t[1]] +
                                                                   c * from.points[t[2]]));
        }
    return largest;
}

double sampled(const Mesh& target, const Mesh& from, int n) {
    double largest = 0;
    for (int t = 0; t < static_cast<int>(from.triangles.size()); ++t)
        largest = std::max(largest, sampled(target, from, t, n));
    return largest;
}

// A sheet with bumps of its own.
Mesh bumpy(int n, unsigned seed, double height = 0.03) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> number(0, 1);
    std::array<std::array<double, 4>, 4> waves;
    for (auto& w : waves)
        for (double& x : w) x = number(random);
    return triangulations::graph(
        n,
        [&](double x, double y) {
            double z = 0;
            for (const auto& [a, b, c, d] : waves)
                z += height * (0.5 + d) * std::sin(6 * (a - 0.5) * x + 6 * (b - 0.5) * y + 6 * c);
            return z;
        },
        0.3, seed);
}

}  // namespace

TEST_CASE("the distance of bumpy surfaces is that of samples, never below, and its bounds are close together",
          "[property]") {
    const unsigned seed = GENERATE(range(1u, 9u));
    const Mesh a = bumpy(7, seed), b = bumpy(5, seed + 100 * (seed % 2));
    CAPTURE(seed);
    const double precision = GENERATE(0.02, 0.2);
    const OneSidedDistance d = DistanceTarget(b.view()).measure_from(a.view(), {.precision = precision});
    const double by_samples = sampled(b, a, 12);
    CHECK(d.bound >= by_samples * (1 - 1e-9));
    CHECK(d.largest <= d.bound);
    CHECK(d.bound <= d.largest * (1 + precision) * (1 + 1e-9));
    CHECK(brute_distance(b, d.point) == Approx(d.largest).epsilon(1e-9));
    // Samples miss little, and `largest` is attained, so it cannot be far above them.
    CHECK(d.largest <= 1.15 * by_samples);
    CHECK(d.beyond.empty());
}

TEST_CASE("the point that is farthest lies on the surface", "[property]") {
    const Mesh a = bumpy(6, 3), b = bumpy(6, 4);
    const OneSidedDistance d = DistanceTarget(b.view()).measure_from(a.view());
    CHECK(brute_distance(a, d.point) < 1e-12);
}

TEST_CASE("a plane that was shifted is exactly as far away", "[exact]") {
    const Mesh plane = triangulations::graph(
        6, [](double, double) { return 0; }, 0.3);
    Mesh above = triangulations::graph(
        9, [](double, double) { return 0.125; }, 0.3, 8);
    const OneSidedDistance d = DistanceTarget(plane.view()).measure_from(above.view());
    CHECK(d.largest == Approx(0.125).epsilon(1e-12));
    CHECK(d.bound >= 0.125);
    CHECK(d.bound <= 1.02 * 0.125 * (1 + 1e-12));
    for (Vector3d& p : above.points) p.x() += 0.5;
    const OneSidedDistance aside = DistanceTarget(plane.view()).measure_from(above.view());
    CHECK(aside.largest == Approx(std::hypot(0.5, 0.125)).epsilon(0.02));
    CHECK(aside.bound >= std::hypot(0.5, 0.125) * (1 - 1e-12));
}

TEST_CASE("the same surface cut otherwise is at no distance", "[exact]") {
    const Mesh coarse = triangulations::cube(2), fine = triangulations::cube(7);
    CHECK(DistanceTarget(coarse.view()).measure_from(fine.view()).bound < 1e-9);
    CHECK(DistanceTarget(fine.view()).measure_from(fine.view()).bound < 1e-9);
    CHECK(DistanceTarget(fine.view()).measure_from(coarse.view()).bound < 1e-9);
    const Mesh whole = triangulations::cube(1), finest = triangulations::cube(60);
    CHECK(DistanceTarget(finest.view()).measure_from(whole.view()).bound < 1e-9);
    CHECK(DistanceTarget(finest.view()).measure_from(whole.view(), {.limit = 1e-6}).beyond.empty());
}

TEST_CASE("needles over a fine mesh and back: the bounds are close together", "[exact]") {
    const Mesh needles = triangulations::capped_cylinder(400, 1, 1, 30, 1),
               fine = triangulations::capped_cylinder(24, 60, 1, 30, 4);
    const double sagitta = 1 - std::cos(std::numbers::pi / 24);
    for (const auto& [from, to] : {std::pair(&needles, &fine), std::pair(&fine, &needles)}) {
        const OneSidedDistance d = DistanceTarget(to->view()).measure_from(from->view());
        CHECK(d.bound <= 1.02 * d.largest * (1 + 1e-9));
        CHECK(d.largest == Approx(sagitta).epsilon(0.02));
    }
}

TEST_CASE("a spike is far from the plane, and the plane is near to the spike", "[exact]") {
    // A thin pyramid of height 2 on a triangle of side 0.01 in the middle of one of the plane's facets.
    const Mesh plane{{{0, 0, 0}, {3, 0, 0}, {0, 3, 0}}, {{0, 1, 2}}};
    const Vector3d a(1, 1, 0), b(1.01, 1, 0), c(1, 1.01, 0), top(1.003, 1.003, 2);
    Mesh spiked{{plane.points[0], plane.points[1], plane.points[2], a, b, c, top}, {}};
    spiked.triangles = {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}, {2, 0, 3},
                        {2, 3, 5}, {3, 4, 6}, {4, 5, 6}, {5, 3, 6}};
    CHECK(DistanceTarget(plane.view()).measure_from(spiked.view()).largest == Approx(2));
    CHECK(DistanceTarget(spiked.view()).measure_from(plane.view()).bound < 0.011);
    const OneSidedDistance limited = DistanceTarget(plane.view()).measure_from(spiked.view(), {.limit = 0.5});
    REQUIRE(limited.beyond.size() == 3);
    for (const TooFar& far : limited.beyond) {
        CHECK(far.triangle >= 6);
        CHECK(far.nearest == 0);
        CHECK(far.distance > 0.5);
    }
}

TEST_CASE("a hole is found from the surface that has none", "[exact]") {
    const Mesh whole = testing::square(20);
    Mesh open = whole;
    std::erase_if(open.triangles, [&](const Triangle& t) {
        return ((whole.points[t[0]] + whole.points[t[1]] + whole.points[t[2]]) / 3 - Vector3d(.5, .5, 0)).norm() < 0.3;
    });
    CHECK(DistanceTarget(whole.view()).measure_from(open.view()).bound < 1e-9);
    const OneSidedDistance d = DistanceTarget(open.view()).measure_from(whole.view());
    CHECK(d.largest > 0.2);
    CHECK(d.largest < 0.3);
    CHECK(d.bound <= d.largest * 1.02 + 1e-12);
}

TEST_CASE("with a limit, the bound is within it exactly where no triangle is beyond, and those beyond are",
          "[property]") {
    const unsigned seed = GENERATE(range(1u, 7u));
    const Mesh a = bumpy(6, seed), b = bumpy(5, seed);
    const DistanceTarget target(b.view());
    const double largest = target.measure_from(a.view(), {.precision = 0.001}).largest;
    for (const double share : {0.3, 0.6, 0.9, 0.99, 1.01, 1.1, 1.5}) {
        CAPTURE(seed, share);
        const double limit = share * largest;
        const OneSidedDistance d = target.measure_from(a.view(), {.limit = limit});
        CHECK((d.bound <= limit) == d.beyond.empty());
        CHECK(d.beyond.empty() == (share > 1));
        CHECK(d.largest <= d.bound);
        std::set<int> named;
        for (const TooFar& far : d.beyond) {
            named.insert(far.triangle);
            CHECK(far.distance > limit);
            CHECK(brute_distance(b, far.point) == Approx(far.distance).epsilon(1e-9));
            const Triangle& t = b.triangles[far.nearest];
            CHECK((far.point - closest_point(far.point, b.points[t[0]], b.points[t[1]], b.points[t[2]])).norm() ==
                  Approx(far.distance).epsilon(1e-9));
        }
        CHECK(std::is_sorted(d.beyond.begin(), d.beyond.end(),
                             [](const TooFar& x, const TooFar& y) { return x.triangle < y.triangle; }));
        for (int t = 0; t < static_cast<int>(a.triangles.size()); ++t)
            if (sampled(b, a, t, 6) > limit * (1 + 1e-9)) CHECK(named.count(t) == 1);
    }
}

TEST_CASE("samples name the triangles of which the middle or that of a side is beyond a limit, by the largest of them",
          "[property]") {
    const unsigned seed = GENERATE(range(1u, 4u));
    const Mesh target = bumpy(9, seed), from = bumpy(6, seed + 10);
    const DistanceTarget surface({target.points, target.triangles});
    std::vector<int> near(from.points.size());
    for (std::size_t v = 0; v < near.size(); ++v) near[v] = surface.closest(from.points[v]).triangle;
    const double limit = 0.02;
    std::map<int, double> named;
    for (const TooFar& f : surface.sample_from({from.points, from.triangles}, limit, near)) {
        named[f.triangle] = f.distance;
        CHECK(brute_distance(target, f.point) == Approx(f.distance).epsilon(1e-12));
    }
    std::size_t beyond = 0;
    for (int t = 0; t < static_cast<int>(from.triangles.size()); ++t) {
        const Vector3d &a = from.points[from.triangles[t][0]], &b = from.points[from.triangles[t][1]],
                       &c = from.points[from.triangles[t][2]];
        double largest = 0;
        for (const Vector3d& p :
             {Vector3d((a + b + c) / 3), Vector3d((a + b) / 2), Vector3d((b + c) / 2), Vector3d((c + a) / 2)})
            largest = std::max(largest, brute_distance(target, p));
        CHECK(named.count(t) == (largest > limit));
        if (largest > limit) CHECK(named[t] == Approx(largest).epsilon(1e-12));
        beyond += largest > limit;
    }
    CHECK(beyond > 0);
    CHECK(beyond < from.triangles.size());
}

TEST_CASE("a sphere is as far from its inscribed triangulation as its facets are deep", "[property]") {
    const Mesh coarse = triangulations::sphere(3),
               fine = triangulations::halved(triangulations::halved(coarse, triangulations::sphere_known(1)),
                                             triangulations::sphere_known(1));
    double deepest = 0;
    for (const Triangle& t : coarse.triangles) {
        const Vector3d n =
            (coarse.points[t[1]] - coarse.points[t[0]]).cross(coarse.points[t[2]] - coarse.points[t[0]]).normalized();
        deepest = std::max(deepest, 1 - n.dot(coarse.points[t[0]]));
    }
    const OneSidedDistance d = DistanceTarget(coarse.view()).measure_from(fine.view());
    CHECK(d.bound <= deepest * 1.02);
    CHECK(d.largest > 0.8 * deepest);
}

TEST_CASE("hints and threads change nothing of a distance", "[property]") {
    const Mesh a = bumpy(9, 5), b = bumpy(8, 6);
    const DistanceTarget target(b.view());
    const OneSidedDistance plain = target.measure_from(a.view());
    std::vector<int> near;
    for (std::size_t v = 0; v < a.points.size(); ++v) near.push_back(static_cast<int>(v % b.triangles.size()));
    const OneSidedDistance hinted = target.measure_from(a.view(), {.near = near});
    CHECK(hinted.bound == Approx(plain.bound).epsilon(0.02));
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    const OneSidedDistance single = target.measure_from(a.view());
    CHECK(single.largest == plain.largest);
    CHECK(single.bound == plain.bound);
    CHECK(single.point == plain.point);
}

TEST_CASE("a surface without triangles is no target, and is at no distance from one", "[exact]") {
    const Mesh square = testing::square(2);
    CHECK_THROWS_AS(DistanceTarget(MeshView{}), std::invalid_argument);
    CHECK(DistanceTarget(square.view()).measure_from(MeshView{}).bound == 0);
    CHECK(DistanceTarget(square.view()).distance({0.5, 0.5, -3}) == Approx(3));
}

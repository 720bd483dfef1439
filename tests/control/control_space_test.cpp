#include "gradus/control/control_space.hpp"

#include "gradus/control/geometric_size.hpp"
#include "support/zoo.hpp"

#include <catch2/catch.hpp>

#include <cmath>
#include <limits>
#include <random>

using namespace gradus;

namespace {

/// Background of a model, and sizes by a function of space.
struct Mapped {
    Background background;
    std::vector<double> sizes;
};

Mapped mapped(const SurfaceModel& model, const std::function<double(const Eigen::Vector3d&)>& size) {
    SizingRule rule;
    rule.hmax = model.diagonal() / 10;
    Mapped result{make_background(model, rule).background, {}};
    for (const Eigen::Vector3d& p : points_of(result.background.mesh)) result.sizes.push_back(size(p));
    return result;
}

double linear(const Eigen::Vector3d& p) { return 0.1 * (4 + p.x() - 0.5 * p.y()); }

SurfacePoint random_place(const SurfaceModel& model, std::mt19937& random) {
    std::uniform_real_distribution<double> uniform(0, 1);
    const int patch = static_cast<int>(random() % model.num_patches());
    const Domain d = model.patch(patch).domain();
    const Eigen::Vector2d s(uniform(random), uniform(random));
    return {patch, d.min + s.cwiseProduct(d.max - d.min)};
}

Eigen::Vector3d random_point_of(const std::vector<Eigen::Vector3d>& points, const Triangle& triangle,
                                std::mt19937& random) {
    std::uniform_real_distribution<double> uniform(0, 1);
    double a = uniform(random), b = uniform(random);
    if (a + b > 1) a = 1 - a, b = 1 - b;
    const auto& [u, v, w] = triangle;
    return (1 - a - b) * points[u] + a * points[v] + b * points[w];
}

}  // namespace

TEST_CASE("Linear sizes are reproduced in the plane, by place and by point", "[control][exact]") {
    const SurfaceModel model = models::model_of({models::flat_square()});
    const Mapped map = mapped(model, linear);
    const ControlSpace space(map.background, map.sizes);
    std::mt19937 random(1);
    int walked = 0;
    for (int i = 0; i < 2000; ++i) {
        const SurfacePoint at = random_place(model, random);
        const Eigen::Vector3d p = model.position(at);
        CHECK(space.size(at) == Approx(linear(p)).epsilon(1e-12));
        CHECK(space.size(p, walked) == Approx(linear(p)).epsilon(1e-12));
        CHECK(walked >= 0);
        CHECK(walked < space.num_triangles());
    }
}

TEST_CASE("The predicted count is the integral of the density", "[control][exact]") {
    const SurfaceModel model = models::model_of({models::flat_square()});
    const double ideal = std::sqrt(3.0) / 4;
    const Mapped constant = mapped(model, [](const Eigen::Vector3d&) { return 0.02; });
    CHECK(ControlSpace(constant.background, constant.sizes).predicted_triangles() ==
          Approx(1 / (ideal * 0.0004)).epsilon(1e-12));
    // Integral of 100 / (4 + x - y / 2)^2 over the unit square: by x, then by y.
    const Mapped map = mapped(model, linear);
    const double integral = 100 * 2 * std::log(36.0 / 35);
    CHECK(ControlSpace(map.background, map.sizes).predicted_triangles() == Approx(integral / ideal).epsilon(1e-7));
}

TEST_CASE("The predicted count is exact however much sizes differ", "[control][exact]") {
    const std::vector<Eigen::Vector3d> points{{0, 0, 0}, {2, 0, 0}, {0, 1, 0}};
    const std::vector<Triangle> triangles{{0, 1, 2}};
    const Connectivity mesh(3, triangles);
    const std::array<double, 3> h =
        GENERATE(std::array<double, 3>{0.1, 0.1, 0.1}, std::array<double, 3>{0.1, 0.12, 0.13},
                 std::array<double, 3>{0.1, 0.149, 0.151}, std::array<double, 3>{0.1, 0.1, 3},
                 std::array<double, 3>{3, 0.1, 3}, std::array<double, 3>{1, 1000, 30});
    CAPTURE(h[0], h[1], h[2]);
    // By rows: 1 / h^2 has a primitive along each, and what is left is summed finely, more so towards the end where it
    // is steep.
    const int rows = 200000;
    double sum = 0;
    for (int i = 0; i < rows; ++i) {
        const auto grade = [&](double s) { return std::pow(s, 4); };
        const double y0 = grade(static_cast<double>(i) / rows), y1 = grade((i + 1.0) / rows), y = (y0 + y1) / 2;
        const double from = h[0] + y * (h[2] - h[0]), to = h[1] + y * (h[2] - h[1]);
        sum += (y1 - y0) * 2 * (1 - y) / (from * to);
    }
    CHECK(ControlSpace(points, mesh, h).predicted_triangles() == Approx(sum / (std::sqrt(3.0) / 4)).epsilon(1e-7));
}

TEST_CASE("A walk from far away and one from near end at the same size", "[control][property]") {
    // On a surface a walk goes by the projection to triangles: from any start on a convex closed surface, or along a
    // sheet.
    for (const std::string name : {"bump", "sphere of octants", "sphere with seam", "cylinder", "torus", "wavy sheet"})
        DYNAMIC_SECTION(name) {
            const SurfaceModel model = models::kind_of(name).make();
            const Mapped map = mapped(model, linear);
            const ControlSpace space(map.background, map.sizes);
            std::mt19937 random(2);
            double worst = 0;
            for (int i = 0; i < 2000; ++i) {
                const SurfacePoint at = random_place(model, random);
                int near = space.locate(at);
                CHECK(map.background.patch[near] == at.patch);
                const double by_point = space.size(model.position(at), near), by_place = space.size(at);
                worst = std::max(worst, std::abs(std::log(by_point / by_place)));
            }
            // Both interpolate; they differ by the curvature of the parameters over a triangle, which is most at poles.
            CHECK(worst <= 0.15);
        }
}

TEST_CASE("The size at a vertex is the one given, from every patch around it", "[control][property]") {
    for (const models::Kind& kind : models::zoo()) {
        CAPTURE(kind.name);
        const SurfaceModel model = kind.make();
        const Mapped map = mapped(
            model, [](const Eigen::Vector3d& p) { return 1 + 0.3 * std::sin(7 * p.x() + 5 * p.y() + 3 * p.z()); });
        const ControlSpace space(map.background, map.sizes);
        const auto triangles = triangles_of(map.background.mesh);
        const auto points = points_of(map.background.mesh);
        double by_place = 0, by_point = 0;
        for (int t = 0; t < space.num_triangles(); ++t)
            for (int k = 0; k < 3; ++k) {
                const double exact = map.sizes[triangles[t][k]];
                int walked = t;
                const SurfacePoint at{map.background.patch[t], map.background.uv[t][k]};
                CAPTURE(at.uv.transpose(), points[triangles[t][k]].transpose());
                by_place = std::max(by_place, std::abs(space.size(at) / exact - 1));
                CHECK(by_place <= 1e-6);
                by_point = std::max(by_point, std::abs(space.size(points[triangles[t][k]], walked) / exact - 1));
            }
        CHECK(by_place <= 1e-6);
        CHECK(by_point <= 1e-6);
    }
}

TEST_CASE("Sizes that cannot be used are refused", "[control]") {
    const SurfaceModel model = models::model_of({models::flat_square()});
    Mapped map = mapped(model, linear);
    std::vector<double> sizes = map.sizes;
    for (const double bad :
         {0., -1., std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
        sizes[3] = bad;
        CHECK_THROWS_AS(ControlSpace(map.background, sizes), std::invalid_argument);
        CHECK_THROWS_WITH(ControlSpace(map.background, sizes), Catch::Contains("vertex 3"));
    }
    sizes = map.sizes;
    sizes.pop_back();
    CHECK_THROWS_AS(ControlSpace(map.background, sizes), std::invalid_argument);
}

TEST_CASE("a walk goes on over the folds of a surface of few triangles", "[control]") {
    // A cube of twelve triangles; h is linear in space, so that it is known everywhere on it.
    const std::vector<Eigen::Vector3d> points{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                              {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    const std::vector<Triangle> triangles{{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}, {0, 1, 5}, {0, 5, 4},
                                          {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}};
    // Squashed, so that folds are of any angle.
    const double squash = GENERATE(1.0, 0.4);
    std::vector<Eigen::Vector3d> box;
    for (const Eigen::Vector3d& p : points) box.emplace_back(p.x() + (1 - squash) * p.z(), p.y(), squash * p.z());
    const auto size = [](const Eigen::Vector3d& p) { return 0.01 * (2 + 1.5 * p.x() - p.y() + 0.7 * p.z()); };
    std::vector<double> sizes;
    for (const Eigen::Vector3d& p : box) sizes.push_back(size(p));
    const Connectivity mesh(static_cast<int>(box.size()), triangles);
    const ControlSpace control(box, mesh, sizes);
    std::mt19937 random(1);
    for (int t = 0; t < std::ssize(triangles); ++t)
        for (int k = 0; k < 3; ++k)
            for (int i = 0; i < 50; ++i) {
                const Eigen::Vector3d p = random_point_of(box, triangles[t], random);
                int from = mesh.twin(3 * t + k) / 3;
                CAPTURE(t, k, p.transpose(), from);
                REQUIRE(control.size(p, from) == Approx(size(p)));
            }
}

TEST_CASE("a size is that of the closest triangle from wherever the walk begins", "[control]") {
    // A tetrahedron with edges sharper than a right angle: the walk from below a face ends under it. h is linear in
    // space.
    const std::vector<Eigen::Vector3d> points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.1, 0.5}};
    const std::vector<Triangle> triangles{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    const auto size = [](const Eigen::Vector3d& p) { return 0.004 * (2 + 1.5 * p.x() - p.y() + 5 * p.z()); };
    std::vector<double> sizes;
    for (const Eigen::Vector3d& p : points) sizes.push_back(size(p));
    const ControlSpace control(points, Connectivity(4, triangles), sizes);
    std::mt19937 random(1);
    for (int t = 0; t < 4; ++t)
        for (int start = 0; start < 4; ++start)
            for (int i = 0; i < 200; ++i) {
                const Eigen::Vector3d p = random_point_of(points, triangles[t], random);
                int found = start;
                CAPTURE(t, start, p.transpose());
                // Nearer to another face than a quarter of the size that may be the one found.
                REQUIRE(control.size(p, found) == Approx(size(p)).margin(0.25 * 0.06 * 0.02));
            }
}

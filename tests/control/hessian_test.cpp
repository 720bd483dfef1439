#include "gradus/control/hessian.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "gradation/maps.hpp"
#include "support/triangulations.hpp"

using namespace gradus;
using namespace gradus::test;
using Eigen::Vector3d;

namespace {

Tris shaken_square(int n, unsigned seed) {
    Random random(seed);
    Tris t = grid(n, n, 1.0 / n);
    for (Vector3d& p : t.points) {
        const bool inside = p.x() > 0 && p.x() < 1 - 1e-9 && p.y() > 0 && p.y() < 1 - 1e-9;
        if (inside) p += Vector3d(random(-.3, .3), random(-.3, .3), 0) / n;
    }
    return t;
}

template <class F>
std::vector<double> values_of(const Tris& t, const F& f) {
    std::vector<double> values;
    for (const Vector3d& p : t.points) values.push_back(f(p));
    return values;
}

}  // namespace

TEST_CASE("Hessians of quadratics are exact, at boundaries and corners too", "[exact]") {
    const Tris t = shaken_square(8, 5);
    const auto values = values_of(t, [](const Vector3d& p) {
        return 3 + p.x() - 2 * p.y() + 4 * p.x() * p.x() - 6 * p.x() * p.y() + p.y() * p.y();
    });
    for (const Tensor& h : recovered_hessians(t.mesh(), values)) {
        CHECK(h.v[0] == Approx(8).epsilon(1e-9));
        CHECK(h.v[1] == Approx(-6).epsilon(1e-9));
        CHECK(h.v[2] == Approx(2).epsilon(1e-9));
        CHECK(std::abs(h.v[5]) < 1e-9);
    }
}

TEST_CASE("Hessians of smooth fields converge", "[convergence]") {
    const auto error = [](int n) {
        const Tris t = shaken_square(n, 6);
        const auto values = values_of(t, [](const Vector3d& p) { return std::sin(3 * p.x()) * std::cos(2 * p.y()); });
        const auto hessians = recovered_hessians(t.mesh(), values);
        double sum = 0;
        for (std::size_t v = 0; v < t.points.size(); ++v) {
            const Vector3d& p = t.points[v];
            sum += std::abs(hessians[v].v[0] + 9 * std::sin(3 * p.x()) * std::cos(2 * p.y()));
        }
        return sum / static_cast<double>(t.points.size());
    };
    const double coarse = error(16), fine = error(32), finest = error(64);
    CHECK(coarse / fine > 1.8);
    CHECK(fine / finest > 1.8);
}

TEST_CASE("A metric by error keeps the error of an equilateral element", "[exact]") {
    const Tris t = shaken_square(6, 7);
    const auto values = values_of(t, [](const Vector3d& p) { return 2 * p.x() * p.x() + 50 * p.y() * p.y(); });
    const std::vector<std::vector<Tensor>> hessians{recovered_hessians(t.mesh(), values)};
    const HessianMetrics result = metrics_of_hessians(t.mesh(), hessians, {.error = 0.02, .bounds = {1e-6, 1e3, 1e6}});
    // |H| 2 / (9 E) with H = diag(4, 100).
    for (const Tensor& m : result.metrics) {
        CHECK(m.v[0] == Approx(4 * 2 / (9 * 0.02)).epsilon(1e-8));
        CHECK(m.v[2] == Approx(100 * 2 / (9 * 0.02)).epsilon(1e-8));
        CHECK(std::abs(m.v[1]) < 1e-6);
    }
    // A triangle that is equilateral in it has at its middle the error of a quadratic: sum of squares / 18.
    const double l2 = 9 * 0.02 / 2;  // of its edges, in |H|
    CHECK(3 * l2 / 18 <= 0.02);
    CHECK(result.expected_triangles == Approx(4 / std::sqrt(3.0) * std::sqrt(400.0) * 2 / (9 * 0.02)).epsilon(1e-8));
}

TEST_CASE("The number of vertices is met, with bounds that hold somewhere too", "[property]") {
    const Tris t = shaken_square(20, 8);
    const auto step = values_of(t, [](const Vector3d& p) { return std::tanh(30 * (p.x() + p.y() * p.y() - .8)); });
    const auto wave = values_of(t, [](const Vector3d& p) { return std::sin(9 * p.y()); });
    const std::vector<std::vector<Tensor>> hessians{recovered_hessians(t.mesh(), step),
                                                    recovered_hessians(t.mesh(), wave)};
    for (const std::size_t fields : {1, 2})
        for (const double n : {200.0, 5000.0}) {
            const auto result = metrics_of_hessians(t.mesh(), std::span(hessians).first(fields),
                                                    {.vertices = n, .bounds = {1e-4, 0.2, 50}});
            CHECK(result.expected_vertices == Approx(n).epsilon(1e-3));
            for (const Tensor& m : result.metrics) {
                const Vector3d h = axes_of(size_tensor(m)).values;
                CHECK(h[2] <= 0.2 * (1 + 1e-9));
                CHECK(h[2] <= 50 * h[0] * (1 + 1e-9));
            }
        }
}

TEST_CASE("On a sphere second derivatives are those along it", "[convergence]") {
    // z on the unit sphere: along it its Hessian is -z times the identity.
    const auto error = [](int halvings) {
        const auto mesh = triangulations::sphere(halvings);
        std::vector<double> values;
        for (const Vector3d& p : mesh.points) values.push_back(p.z());
        const auto hessians = recovered_hessians(make_mesh(mesh.points, mesh.triangles), values);
        double worst = 0;
        for (std::size_t v = 0; v < values.size(); ++v) {
            const Vector3d u = mesh.points[v].unitOrthogonal();
            worst = std::max(worst, std::abs(squared_in(hessians[v], u) + values[v]));
        }
        return worst;
    };
    CHECK(error(3) < 0.3);
    CHECK(error(5) < 0.5 * error(3));
}

TEST_CASE("What makes no metric is refused", "[exact]") {
    const Tris t = grid(3, 3, 1);
    const TriMesh mesh = t.mesh();
    std::vector<double> values(t.points.size(), 1);
    const std::vector<std::vector<Tensor>> hessians{recovered_hessians(mesh, values)};
    // A constant asks for the largest size.
    const auto flat = metrics_of_hessians(mesh, hessians, {.error = 1, .bounds = {0.1, 2, 10}});
    for (const Tensor& m : flat.metrics) CHECK(axes_of(size_tensor(m)).values[0] == Approx(2));
    CHECK_THROWS_AS(metrics_of_hessians(mesh, hessians, {.bounds = {0, 1, 10}}), std::invalid_argument);
    CHECK_THROWS_AS(metrics_of_hessians(mesh, hessians, {.error = 1}), std::invalid_argument);
    CHECK_THROWS_AS(metrics_of_hessians(mesh, hessians, {.error = -1, .bounds = {0, 1, 10}}), std::invalid_argument);
    values[3] = std::nan("");
    CHECK_THROWS_WITH(recovered_hessians(mesh, values), Catch::Contains("vertex 3"));
}

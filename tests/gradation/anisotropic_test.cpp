#include "gradus/gradation/anisotropic.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "gradus/gradation/isotropic.hpp"
#include "maps.hpp"
#include "support/triangulations.hpp"

using namespace gradus;
using namespace gradus::test;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Method = TensorGradationMethod;

namespace {

constexpr std::array kIntersections{Method::Metric, Method::Physical, Method::Mixed};

Tensor planar_metric(double angle, double along, double across) {
    Matrix3d axes;
    axes << std::cos(angle), -std::sin(angle), 0, std::sin(angle), std::cos(angle), 0, 0, 0, 1;
    return metric_along(axes, {along, across, std::sqrt(along * across)});
}

Tris flat_tris(unsigned seed, int n) {
    Tris t = random_tris(seed, n, n, .3, 0);
    for (Vector3d& p : t.points) p.z() = 0;
    return t;
}

std::vector<Tensor> random_metrics(const Tris& t, unsigned seed, double aspect) {
    Random random(seed);
    std::vector<Tensor> metrics;
    for (std::size_t v = 0; v < t.points.size(); ++v) {
        const double h = std::exp(random(-2, 2));
        metrics.push_back(planar_metric(random(0, 3.14), h, h * std::pow(aspect, random(0, 1))));
    }
    return metrics;
}

// The same mesh with vertices in another order.
struct Shuffled {
    Tris tris;
    std::vector<int> old;
};
Shuffled shuffled(const Tris& t, unsigned seed) {
    Random random(seed);
    Shuffled s;
    s.old.resize(t.points.size());
    std::iota(s.old.begin(), s.old.end(), 0);
    for (std::size_t i = s.old.size(); i > 1; --i) std::swap(s.old[i - 1], s.old[random.below(static_cast<int>(i))]);
    std::vector<int> now(s.old.size());
    for (std::size_t i = 0; i < s.old.size(); ++i)
        now[s.old[i]] = static_cast<int>(i), s.tris.points.push_back(t.points[s.old[i]]);
    for (const Triangle& v : t.triangles) s.tris.triangles.push_back({now[v[0]], now[v[1]], now[v[2]]});
    for (std::size_t i = s.tris.triangles.size(); i > 1; --i)
        std::swap(s.tris.triangles[i - 1], s.tris.triangles[random.below(static_cast<int>(i))]);
    return s;
}

double difference(const Tensor& a, const Tensor& b) {
    return (matrix_of(a) - matrix_of(b)).norm() / matrix_of(b).norm();
}

}  // namespace

TEST_CASE("On sizes all methods give what those of sizes give", "[property]") {
    for (const unsigned seed : {1U, 2U, 3U}) {
        const Tris t = flat_tris(seed, 12);
        const TriMesh mesh = t.mesh();
        Random random(seed + 10);
        std::vector<double> sizes;
        for (std::size_t v = 0; v < t.points.size(); ++v) sizes.push_back(std::exp(random(0, 4)));
        std::vector<double> by_variation = sizes, by_shock = sizes;
        limit_h_variation(mesh, .4, by_variation);
        limit_h_shock(mesh, 1.5, by_shock);
        REQUIRE(count_coarse_edges(mesh, 1.5, by_shock) == 0);
        const auto metrics = [&] {
            std::vector<Tensor> all;
            for (const double h : sizes) all.push_back(round_metric(h));
            return all;
        };
        for (const Method method : {Method::Shape, Method::Metric, Method::Physical, Method::Mixed}) {
            CAPTURE(static_cast<int>(method));
            std::vector<Tensor> result = metrics();
            CHECK(grade(mesh, result, {.method = method, .variation = .4}).met);
            const double tolerance = method == Method::Physical ? 1e-3 : 1e-10;
            for (std::size_t v = 0; v < sizes.size(); ++v)
                CHECK(size_along(result[v], Vector3d(1, 2, 0)) == Approx(by_variation[v]).epsilon(tolerance));
        }
        std::vector<Tensor> result = metrics();
        CHECK(grade(mesh, result, {.shock = 1.5}).met);
        for (std::size_t v = 0; v < sizes.size(); ++v)
            CHECK(size_along(result[v], Vector3d::UnitY()) == Approx(by_shock[v]).epsilon(1e-12));
    }
}

TEST_CASE("Scaling keeps shapes, meets the bound, and is the largest that does", "[property]") {
    for (const unsigned seed : {1U, 2U, 3U})
        for (const bool by_shock : {false, true}) {
            const Tris t = flat_tris(seed, 8);
            const TriMesh mesh = t.mesh();
            const std::vector<Tensor> input = random_metrics(t, seed, 20);
            const TensorGradationOptions options{.shock = by_shock ? std::optional(1.6) : std::nullopt,
                                                 .variation = by_shock ? std::nullopt : std::optional(.5)};
            std::vector<Tensor> metrics = input;
            const TensorGradationResult result = grade(mesh, metrics, options);
            CHECK(result.met);
            CHECK(result.lowered > 10);
            CHECK(check_shape_certificate(mesh, options, input, metrics, result.parent) == std::nullopt);
            if (!by_shock) CHECK(result.after.variation_max <= .5 * (1 + 1e-9));
            if (by_shock) CHECK(result.after.shock_max <= 1.6 * (1 + 1e-9));
            // Sweeps over all edges from the input lead to the same, from above.
            std::vector<double> factor(input.size(), 1);
            for (int sweep = 0; sweep < 3000; ++sweep)
                for (const Triangle& v : t.triangles)
                    for (int k = 0; k < 3; ++k)
                        for (const auto& [p, q] : {std::pair{v[k], v[(k + 1) % 3]}, std::pair{v[(k + 1) % 3], v[k]}}) {
                            const Vector3d e = t.points[q] - t.points[p];
                            const double h = factor[p] * size_along(input[p], e), L = e.norm();
                            const double coarse = by_shock ? L * std::log(1.6) / kCoarseEdge : 0;
                            const double limit = by_shock ? shock_limit(std::max(h, coarse), L, 1.6) : h + .5 * L;
                            factor[q] = std::min(factor[q], limit / size_along(input[q], e));
                        }
            for (std::size_t v = 0; v < input.size(); ++v)
                CHECK(difference(metrics[v], (1 / (factor[v] * factor[v])) * input[v]) < 1e-9);
        }
}

TEST_CASE("Certificates fail when something is tampered with", "[exact]") {
    const Tris t = flat_tris(4, 8);
    const TriMesh mesh = t.mesh();
    const std::vector<Tensor> input = random_metrics(t, 4, 20);
    TensorGradationOptions options{.shock = 1.5};
    std::vector<Tensor> metrics = input;
    TensorGradationResult result = grade(mesh, metrics, options);
    int lowered = 0;
    while (result.parent[lowered] < 0) ++lowered;
    const auto check = [&] { return check_shape_certificate(mesh, options, input, metrics, result.parent); };
    REQUIRE(check() == std::nullopt);
    const Tensor was = metrics[lowered];
    metrics[lowered] = 1.02 * was;  // smaller than needed
    CHECK(check() != std::nullopt);
    metrics[lowered] = 0.98 * was;  // too large
    CHECK(check() != std::nullopt);
    metrics[lowered] = was + Tensor{{0.1 * was.v[0], 0, 0, 0, 0, 0}};  // another shape
    CHECK(check() != std::nullopt);
    metrics[lowered] = was;
    const int parent = std::exchange(result.parent[lowered], -1);
    CHECK(check() != std::nullopt);
    result.parent[lowered] = parent;
    REQUIRE(check() == std::nullopt);
    for (const Method method : kIntersections) {
        options = {.method = method, .shock = 1.5};
        std::vector<Tensor> inside = input;
        CHECK(grade(mesh, inside, options).met);
        CHECK(check_intersection_certificate(mesh, options, input, inside) == std::nullopt);
        inside[lowered] = 0.9 * input[lowered];
        CHECK(check_intersection_certificate(mesh, options, input, inside) != std::nullopt);
    }
}

TEST_CASE("The order of vertices and triangles does not matter", "[property]") {
    const Tris t = flat_tris(5, 10);
    const std::vector<Tensor> input = random_metrics(t, 5, 30);
    for (const Method method : {Method::Shape, Method::Metric, Method::Physical, Method::Mixed}) {
        CAPTURE(static_cast<int>(method));
        const TensorGradationOptions options{.method = method, .shock = 1.5};
        std::vector<Tensor> first = input;
        grade(t.mesh(), first, options);
        for (unsigned seed = 0; seed < 20; ++seed) {
            const Shuffled s = shuffled(t, seed);
            std::vector<Tensor> other;
            for (const int v : s.old) other.push_back(input[v]);
            grade(s.tris.mesh(), other, options);
            double worst = 0;
            for (std::size_t v = 0; v < other.size(); ++v)
                worst = std::max(worst, difference(other[v], first[s.old[v]]));
            CHECK(worst < 1e-9);
        }
    }
}

TEST_CASE("A boundary layer keeps its aspect", "[exact]") {
    // h_x = .1, h_y from .001 on growing by 1.2 from row to row.
    Tris t;
    std::vector<Tensor> input;
    std::vector<double> rows{0};
    for (double h = .001; rows.back() < .2; h *= 1.2) rows.push_back(rows.back() + h);
    const int columns = 11, n = static_cast<int>(rows.size());
    for (const double y : rows)
        for (int i = 0; i < columns; ++i) {
            t.points.emplace_back(.1 * i, y, 0);
            input.push_back(planar_metric(0, .1, .001 + .2 * y));
        }
    for (int j = 0; j + 1 < n; ++j)
        for (int i = 0; i + 1 < columns; ++i) {
            const int a = j * columns + i;
            t.triangles.push_back({a, a + 1, a + columns + 1});
            t.triangles.push_back({a, a + columns + 1, a + columns});
        }
    for (const Method method : {Method::Shape, Method::Paper, Method::Metric, Method::Physical, Method::Mixed}) {
        CAPTURE(static_cast<int>(method));
        std::vector<Tensor> metrics = input;
        grade(t.mesh(), metrics, {.method = method, .shock = 1.25});
        for (int i = 0; i < columns; ++i) {
            const Vector3d h = axes_of(size_tensor(metrics[i])).values;
            CHECK(h[2] / h[0] == Approx(100).epsilon(.05));
        }
    }
}

TEST_CASE("The paper's correction meets its bound, and lowers more", "[property]") {
    const Tris t = flat_tris(6, 10);
    const TriMesh mesh = t.mesh();
    const std::vector<Tensor> input = random_metrics(t, 6, 20);
    std::vector<Tensor> exact = input, paper = input;
    CHECK(grade(mesh, exact, {.shock = 1.5}).met);
    const TensorGradationResult result = grade(mesh, paper, {.method = Method::Paper, .shock = 1.5});
    CHECK(result.met);
    CHECK(result.converged);
    double elements = 0, paper_elements = 0;
    for (std::size_t v = 0; v < input.size(); ++v) {
        elements += std::sqrt(exact[v].v[0] * exact[v].v[2] - exact[v].v[1] * exact[v].v[1]);
        paper_elements += std::sqrt(paper[v].v[0] * paper[v].v[2] - paper[v].v[1] * paper[v].v[1]);
    }
    CHECK(paper_elements > elements);
}

TEST_CASE("On a surface metrics turn with it before they are intersected", "[property]") {
    const auto torus = triangulations::torus(40, 20);
    const TriMesh mesh = make_mesh(torus.points, torus.triangles);
    std::vector<Tensor> input;
    for (const Vector3d& p : torus.points) {
        const Vector3d around = Vector3d(-p.y(), p.x(), 0).normalized(), out = Vector3d(p.x(), p.y(), 0).normalized(),
                       n = (p - 3 * out).normalized();
        Matrix3d axes;
        axes << around, n.cross(around), n;
        const double h = p.x() > 2 ? .05 : 1;
        input.push_back(metric_along(axes, {2 * h, h, h}));
    }
    for (const Method method : {Method::Shape, Method::Metric, Method::Mixed}) {
        const TensorGradationOptions options{.method = method, .shock = 1.4};
        std::vector<Tensor> metrics = input;
        const TensorGradationResult result = grade(mesh, metrics, options);
        CHECK(result.met);
        CHECK(result.lowered > 100);
        const auto fault = method == Method::Shape
                               ? check_shape_certificate(mesh, options, input, metrics, result.parent)
                               : check_intersection_certificate(mesh, options, input, metrics);
        CHECK(fault == std::nullopt);
    }
}

TEST_CASE("What makes no sense is refused", "[exact]") {
    const Tris t = grid(2, 2, 1);
    std::vector<Tensor> metrics(9, round_metric(1));
    CHECK_THROWS_AS(grade(t.mesh(), metrics, TensorGradationOptions{}), std::invalid_argument);
    CHECK_THROWS_AS(grade(t.mesh(), metrics, {.shock = 1.0}), std::invalid_argument);
    CHECK_THROWS_AS(grade(t.mesh(), metrics, {.variation = -1.0}), std::invalid_argument);
    CHECK_THROWS_AS(grade(t.mesh(), metrics, {.shock = 2.0, .mixing = 2}), std::invalid_argument);
    metrics[4] = planar_tensor(1, 2, 1);
    CHECK_THROWS_WITH(grade(t.mesh(), metrics, {.shock = 2.0}), Catch::Contains("vertex 4"));
    metrics.pop_back();
    CHECK_THROWS_AS(grade(t.mesh(), metrics, {.shock = 2.0}), std::invalid_argument);
}

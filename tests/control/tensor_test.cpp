#include "gradus/control/tensor.hpp"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

using namespace gradus;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

class Random {
  public:
    explicit Random(unsigned seed) : engine_(seed) {}
    double operator()(double low, double high) { return low + (high - low) * (engine_() / 4294967296.); }
    Vector3d direction() { return Vector3d((*this)(-1, 1), (*this)(-1, 1), (*this)(-1, 1)).normalized(); }
    Matrix3d axes() {
        const Vector3d a = direction(), b = a.unitOrthogonal();
        const double angle = (*this)(0, 6.28);
        Matrix3d m;
        m.col(0) = a;
        m.col(1) = std::cos(angle) * b + std::sin(angle) * a.cross(b);
        m.col(2) = m.col(0).cross(m.col(1));
        return m;
    }
    // Sizes that differ by up to the aspect.
    Tensor metric(double aspect) {
        const auto size = [&] { return std::pow(aspect, (*this)(0, 1)); };
        return metric_along(axes(), {size(), size(), size()});
    }

  private:
    std::mt19937 engine_;
};

double difference(const Tensor& a, const Tensor& b) {
    return (matrix_of(a) - matrix_of(b)).norm() / matrix_of(b).norm();
}

}  // namespace

TEST_CASE("Algebra of tensors is that of matrices", "[exact]") {
    Random random(1);
    for (int i = 0; i < 50; ++i) {
        const Tensor t = random.metric(100);
        const Vector3d e = random.direction();
        CHECK(squared_in(t, e) == Approx(e.dot(matrix_of(t) * e)).epsilon(1e-12));
        CHECK((times(t, e) - matrix_of(t) * e).norm() < 1e-12);
        CHECK(determinant(t) == Approx(matrix_of(t).determinant()).epsilon(1e-9));
        CHECK(difference(inverse(t), tensor_of(matrix_of(t).inverse())) < 1e-8);
        CHECK(difference(metric_of(size_tensor(t)), t) < 1e-10);
        const Axes axes = axes_of(t);
        CHECK(difference(tensor_of(axes.directions * axes.values.asDiagonal() * axes.directions.transpose()), t) <
              1e-12);
    }
}

TEST_CASE("The axes of a planar tensor are right however long it is", "[exact]") {
    for (const double aspect : {1.0, 3.0, 1e3, 1e6})
        for (const double angle : {0.0, 0.3, 1.5, 2.9}) {
            CAPTURE(aspect, angle);
            Matrix3d axes;
            axes << std::cos(angle), -std::sin(angle), 0, std::sin(angle), std::cos(angle), 0, 0, 0, 1;
            const Tensor m = metric_along(axes, {1, aspect, std::sqrt(aspect)});
            const Tensor planar = planar_tensor(m.v[0], m.v[1], m.v[2]);
            const Vector3d h = axes_of(size_tensor(planar)).values;
            CHECK(h[0] == Approx(1).epsilon(1e-9));
            // Rounding of the entries is eps times the large eigenvalue, which the small one is compared with.
            CHECK(h[2] == Approx(aspect).epsilon(1e-15 * aspect * aspect + 1e-12));
        }
}

TEST_CASE("The intersection is the largest ball inside both", "[property]") {
    Random random(2);
    for (int i = 0; i < 100; ++i) {
        const Tensor a = random.metric(50), b = random.metric(50), both = intersection(a, b);
        CHECK(largest_ratio(both, a) <= 1 + 1e-9);
        CHECK(largest_ratio(both, b) <= 1 + 1e-9);
        CHECK(difference(both, intersection(b, a)) < 1e-8);
        // In three conjugate directions it touches one of the two.
        Eigen::GeneralizedSelfAdjointEigenSolver<Matrix3d> solver(matrix_of(b), matrix_of(a));
        for (int k = 0; k < 3; ++k) {
            const Vector3d e = solver.eigenvectors().col(k);
            CHECK(squared_in(both, e) == Approx(std::max(squared_in(a, e), squared_in(b, e))).epsilon(1e-8));
        }
        const Tensor inside = (1 / 0.81) * a;
        CHECK(intersection(inside, a) == inside);
        CHECK(intersection(a, inside) == inside);
        CHECK(largest_ratio(a, inside) == Approx(1 / 0.9).epsilon(1e-12));
    }
}

TEST_CASE("Lengths in metrics that vary are those of their closed forms", "[exact]") {
    const Vector3d e(3, 0, 0);
    const double p = 0.5, q = 2;
    // h linear: L ln(q/p) / (q - p); geometric: L (q - p) / (p q ln(q/p)).
    const double linear = 3 * std::log(q / p) / (q - p), geometric = 3 * (q - p) / (p * q * std::log(q / p));
    CHECK(interpolated_length(e, round_metric(p), round_metric(q)) == Approx(linear).epsilon(1e-9));
    for (const auto how : {Interpolation::LogEuclidean, Interpolation::Simultaneous})
        CHECK(interpolated_length(e, round_metric(p), round_metric(q), how) == Approx(geometric).epsilon(1e-9));
    CHECK(metric_length(e, round_metric(p), round_metric(q)) == Approx(geometric).epsilon(1e-12));
    CHECK(metric_length(e, round_metric(p), round_metric(q)) == metric_length(-e, round_metric(q), round_metric(p)));
}

TEST_CASE("Bounds, transport and mean sizes", "[exact]") {
    Random random(3);
    for (int i = 0; i < 50; ++i) {
        const Matrix3d axes = random.axes();
        const Tensor m = metric_along(axes, {0.01, 1, 5});
        const Vector3d h = axes_of(size_tensor(bounded(m, {0.05, 2, 20}))).values;
        CHECK(h[0] == Approx(0.05));
        CHECK(h[1] == Approx(1));
        CHECK(h[2] == Approx(1));  // 20 times the smallest
        CHECK(bounded(m, {0.001, 10, 1000}) == m);
        const Vector3d n = random.direction(), to = random.direction();
        const Tensor turned = transported(m, n, to);
        CHECK((axes_of(turned).values - axes_of(m).values).norm() < 1e-9 * axes_of(m).values[2]);
        // The size across the normal goes with it.
        CHECK(squared_in(turned, to) == Approx(squared_in(m, n)).epsilon(1e-9));
        CHECK(mean_square_size(size_tensor(m), axes.col(0)) == Approx(5).epsilon(1e-9));
        CHECK(mean_square_size(size_tensor(m), axes.col(2)) == Approx(0.01).epsilon(1e-9));
    }
}

TEST_CASE("A triangle that is equilateral in its metric has quality 1, and the worst corner counts", "[exact]") {
    const double r = std::numbers::sqrt3 / 2;
    Matrix3d axes = Matrix3d::Identity();
    const Tensor m = metric_along(axes, {0.01, 2, 1});
    const std::array<Vector3d, 3> corners{Vector3d(0, 0, 0), Vector3d(0.01, 0, 0), Vector3d(0.005, 2 * r, 0)};
    CHECK(triangle_quality_in(corners, {m, m, m}) == Approx(1).epsilon(1e-12));
    const Tensor other = metric_along(axes, {0.02, 2, 1});
    // Seen from there it is half as wide: 4 sqrt(3) A / sum l^2 with A halved.
    const double expected = 4 * std::numbers::sqrt3 * (r / 4) / (0.25 + 2 * (1.0 / 16 + r * r));
    CHECK(triangle_quality_in(corners, {m, other, m}) == Approx(expected).epsilon(1e-12));
    CHECK(triangle_quality_in({corners[0], corners[1], Vector3d(0.5, 0, 0)}, {m, m, m}) == 0);
}

TEST_CASE("What is no metric is told", "[exact]") {
    CHECK(is_positive_definite(round_metric(1e-5)));
    CHECK_FALSE(is_positive_definite(planar_tensor(1, 2, 1)));
    CHECK_FALSE(is_positive_definite({{1, 0, -1, 0, 0, 1}}));
    CHECK_FALSE(is_positive_definite({{1, 0, 1, 0, 0, std::nan("")}}));
    CHECK_FALSE(is_positive_definite({}));
}

#include "gradus/control/tensor.hpp"

#include "gradus/control/metric.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace gradus {

namespace {

// The tensor with other eigenvalues.
template <class Function>
Tensor with_values(const Tensor& t, const Function& f) {
    const Axes axes = axes_of(t);
    const Eigen::Vector3d values = axes.values.unaryExpr(f);
    return tensor_of(axes.directions * values.asDiagonal() * axes.directions.transpose());
}

// P = L L^T and Q = L U D U^T L^T: the columns of the inverse of (L U)^T are conjugate in both.
struct Reduced {
    Eigen::Matrix3d root;    // L U
    Eigen::Vector3d values;  // D: squares of lengths in Q over those in P
};
Reduced reduced(const Tensor& p, const Tensor& q) {
    const Eigen::Matrix3d l = Eigen::LLT<Eigen::Matrix3d>(matrix_of(p)).matrixL();
    Eigen::Matrix3d x = l.triangularView<Eigen::Lower>().solve(matrix_of(q));
    x = l.triangularView<Eigen::Lower>().solve(x.transpose().eval());
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver((x + x.transpose()) / 2);
    return {l * solver.eigenvectors(), solver.eigenvalues()};
}
Tensor with_root(const Eigen::Matrix3d& root, const Eigen::Vector3d& values) {
    return tensor_of(root * values.asDiagonal() * root.transpose());
}

}  // namespace

Eigen::Matrix3d matrix_of(const Tensor& tensor) {
    const auto& v = tensor.v;
    Eigen::Matrix3d m;
    m << v[0], v[1], v[3], v[1], v[2], v[4], v[3], v[4], v[5];
    return m;
}

Tensor tensor_of(const Eigen::Matrix3d& m) {
    return {{m(0, 0), (m(0, 1) + m(1, 0)) / 2, m(1, 1), (m(0, 2) + m(2, 0)) / 2, (m(1, 2) + m(2, 1)) / 2, m(2, 2)}};
}

Tensor planar_tensor(double xx, double xy, double yy) { return {{xx, xy, yy, 0, 0, std::sqrt(xx * yy - xy * xy)}}; }

Tensor metric_along(const Eigen::Matrix3d& axes, const Eigen::Vector3d& h) {
    const Eigen::Vector3d values = h.array().square().inverse();
    return tensor_of(axes * values.asDiagonal() * axes.transpose());
}

double determinant(const Tensor& t) {
    const auto& v = t.v;
    return v[0] * (v[2] * v[5] - v[4] * v[4]) - v[1] * (v[1] * v[5] - v[4] * v[3]) + v[3] * (v[1] * v[4] - v[2] * v[3]);
}

Tensor inverse(const Tensor& t) {
    const auto& v = t.v;
    const double xx = v[2] * v[5] - v[4] * v[4], yx = v[3] * v[4] - v[1] * v[5], zx = v[1] * v[4] - v[2] * v[3];
    const double i = 1 / (v[0] * xx + v[1] * yx + v[3] * zx);
    return {{i * xx, i * yx, i * (v[0] * v[5] - v[3] * v[3]), i * zx, i * (v[1] * v[3] - v[0] * v[4]),
             i * (v[0] * v[2] - v[1] * v[1])}};
}

Axes axes_of(const Tensor& t) {
    // In the plane the third axis is its normal, to the bit.
    if (t.v[3] == 0 && t.v[4] == 0) {
        const double half = (t.v[0] - t.v[2]) / 2, r = std::hypot(half, t.v[1]);
        const double middle = (t.v[0] + t.v[2]) / 2, large = middle + r;
        // The small eigenvalue from the determinant: the difference would cancel.
        const double small = large != 0 ? (t.v[0] * t.v[2] - t.v[1] * t.v[1]) / large : middle - r;
        Eigen::Vector3d e(1, 0, 0);  // of the large one
        if (r > 0) e = half > 0 ? Eigen::Vector3d(half + r, t.v[1], 0) : Eigen::Vector3d(t.v[1], r - half, 0);
        e.normalize();
        std::array<std::pair<double, Eigen::Vector3d>, 3> all{
            {{small, {-e.y(), e.x(), 0}}, {large, e}, {t.v[5], {0, 0, 1}}}};
        std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
        Axes axes;
        for (int k = 0; k < 3; ++k) axes.values[k] = all[k].first, axes.directions.col(k) = all[k].second;
        return axes;
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(matrix_of(t));
    return {solver.eigenvalues(), solver.eigenvectors()};
}

bool is_positive_definite(const Tensor& t) {
    constexpr double kRounding = 1e-14;
    if (!std::all_of(t.v.begin(), t.v.end(), [](double x) { return std::isfinite(x); })) return false;
    const Eigen::Vector3d values = axes_of(t).values;
    return values[0] > kRounding * values[2] && values[0] > 0;
}

Tensor size_tensor(const Tensor& metric) {
    return with_values(metric, [](double m) { return 1 / std::sqrt(m); });
}

Tensor metric_of(const Tensor& size_tensor) {
    const Eigen::Matrix3d i = matrix_of(inverse(size_tensor));
    return tensor_of(i * i);
}

double mean_square_size(const Tensor& size_tensor, const Eigen::Vector3d& n) {
    return determinant(size_tensor) / times(size_tensor, n).norm();
}

double mean_metric_length(double in_p, double in_q) {
    // metric_length with a length of 1 and sizes of 1 / in_p and 1 / in_q.
    if (in_p < in_q) std::swap(in_p, in_q);
    if (!(in_q > 0)) return 0;
    const double u = log_size_ratio(in_q, in_p);
    return u > 0 ? -std::expm1(-u) / u * in_p : in_p;
}

double metric_length(const Eigen::Vector3d& e, const Tensor& metric_p, const Tensor& metric_q) {
    return mean_metric_length(std::sqrt(squared_in(metric_p, e)), std::sqrt(squared_in(metric_q, e)));
}

Tensor interpolated(const Tensor& p, const Tensor& q, double t, Interpolation how) {
    switch (how) {
        case Interpolation::SizeTensor:
            return metric_of((1 - t) * size_tensor(p) + t * size_tensor(q));
        case Interpolation::LogEuclidean: {
            const auto log = [](const Tensor& m) { return with_values(m, [](double x) { return std::log(x); }); };
            return with_values((1 - t) * log(p) + t * log(q), [](double x) { return std::exp(x); });
        }
        case Interpolation::Simultaneous: {
            const Reduced both = reduced(p, q);
            return with_root(both.root, both.values.unaryExpr([t](double d) { return std::pow(d, t); }));
        }
    }
    return p;
}

double interpolated_length(const Eigen::Vector3d& e, const Tensor& p, const Tensor& q, Interpolation how) {
    constexpr std::array<double, 4> kNode{0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                          0.9602898564975363};
    constexpr std::array<double, 4> kWeight{0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                            0.1012285362903763};
    constexpr int kMostPieces = 4096;
    constexpr double kEnough = 1e-10;
    double before = -1;
    for (int pieces = 1; pieces <= kMostPieces; pieces *= 2) {
        double sum = 0;
        for (int i = 0; i < pieces; ++i)
            for (int k = 0; k < 4; ++k)
                for (const double side : {-1.0, 1.0}) {
                    const double t = (i + 0.5 + side * kNode[k] / 2) / pieces;
                    sum += kWeight[k] / (2 * pieces) * std::sqrt(squared_in(interpolated(p, q, t, how), e));
                }
        if (std::abs(sum - before) <= kEnough * sum) return sum;
        before = sum;
    }
    return before;
}

Tensor intersection(const Tensor& a, const Tensor& b) {
    const Reduced both = reduced(a, b);
    if (both.values.maxCoeff() <= 1) return a;
    if (both.values.minCoeff() >= 1) return b;
    return with_root(both.root, both.values.cwiseMax(1.0));
}

double largest_ratio(const Tensor& a, const Tensor& b) {
    return std::sqrt(std::max(0.0, reduced(a, b).values.maxCoeff()));
}

Tensor bounded(const Tensor& metric, const TensorBounds& bounds) {
    const Axes axes = axes_of(metric);
    const auto bring = [&](double m) { return std::clamp(1 / std::sqrt(m), bounds.smallest, bounds.largest); };
    Eigen::Vector3d h = axes.values.unaryExpr(bring);
    h = h.cwiseMin(h.minCoeff() * bounds.aspect);
    // What is within the bounds stays, to the bit.
    bool same = true;
    for (int k = 0; k < 3; ++k) same = same && h[k] == 1 / std::sqrt(axes.values[k]);
    return same ? metric : metric_along(axes.directions, h);
}

Tensor transported(const Tensor& metric, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    const Eigen::Matrix3d turn = Eigen::Quaterniond::FromTwoVectors(from, to).toRotationMatrix();
    return tensor_of(turn * matrix_of(metric) * turn.transpose());
}

double triangle_quality_in(const std::array<Eigen::Vector3d, 3>& corners, const std::array<Tensor, 3>& metrics) {
    const Eigen::Vector3d e1 = corners[1] - corners[0], e2 = corners[2] - corners[0];
    double worst = 1;
    for (const Tensor& m : metrics) {
        const double a = squared_in(m, e1), c = squared_in(m, e2), b = e1.dot(times(m, e2));
        const double area2 = a * c - b * b, lengths = 2 * (a + c - b);
        if (!(area2 > 0) || !(lengths > 0)) return 0;
        worst = std::min(worst, 2 * std::numbers::sqrt3 * std::sqrt(area2) / lengths);
    }
    return worst;
}

}  // namespace gradus

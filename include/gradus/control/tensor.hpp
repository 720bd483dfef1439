/// Metrics that ask for different sizes in different directions: symmetric positive definite tensors, on surfaces 3x3,
/// in the plane 2x2 embedded in 3x3. The wanted length of an edge in the direction e, |e| = 1, is 1 / sqrt(e^T M e).
/// [Borouchaki 1998, section 2]
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <limits>

namespace gradus {

/// Symmetric 3x3 matrix by rows of its lower triangle: xx, yx, yy, zx, zy, zz, the order of files. The first three are
/// the 2x2 matrix of the plane.
struct Tensor {
    std::array<double, 6> v{};

    friend bool operator==(const Tensor&, const Tensor&) = default;
};

Eigen::Matrix3d matrix_of(const Tensor& tensor);
/// The symmetric part of a matrix.
Tensor tensor_of(const Eigen::Matrix3d& matrix);

/// c I
inline Tensor round_tensor(double c) { return {{c, 0, c, 0, 0, c}}; }
/// Metric of a size h in all directions.
inline Tensor round_metric(double h) { return round_tensor(1 / (h * h)); }
/// The tensor of the plane with these entries. Across the plane it has the geometric mean of its eigenvalues, so that
/// nothing there is larger or smaller than what is in it. @pre positive definite
Tensor planar_tensor(double xx, double xy, double yy);
/// Metric with the sizes h[k] along three orthogonal unit directions, the columns of `axes`.
Tensor metric_along(const Eigen::Matrix3d& axes, const Eigen::Vector3d& h);

inline Tensor operator+(const Tensor& a, const Tensor& b) {
    Tensor sum;
    for (int k = 0; k < 6; ++k) sum.v[k] = a.v[k] + b.v[k];
    return sum;
}
inline Tensor operator*(double s, const Tensor& a) {
    Tensor scaled;
    for (int k = 0; k < 6; ++k) scaled.v[k] = s * a.v[k];
    return scaled;
}

/// T e
inline Eigen::Vector3d times(const Tensor& t, const Eigen::Vector3d& e) {
    const auto& v = t.v;
    return {v[0] * e.x() + v[1] * e.y() + v[3] * e.z(), v[1] * e.x() + v[2] * e.y() + v[4] * e.z(),
            v[3] * e.x() + v[4] * e.y() + v[5] * e.z()};
}
/// e^T T e
inline double squared_in(const Tensor& t, const Eigen::Vector3d& e) {
    const auto& v = t.v;
    return v[0] * e.x() * e.x() + v[2] * e.y() * e.y() + v[5] * e.z() * e.z() +
           2 * (v[1] * e.x() * e.y() + v[3] * e.x() * e.z() + v[4] * e.y() * e.z());
}
double determinant(const Tensor& t);
Tensor inverse(const Tensor& t);  ///< @pre not singular

/// Eigenvalues, ascending, and unit eigenvectors, the columns.
struct Axes {
    Eigen::Vector3d values;
    Eigen::Matrix3d directions;
};
Axes axes_of(const Tensor& t);

/// Whether all entries are finite and all eigenvalues > 0 beyond rounding (the smallest above 1e-14 of the largest).
bool is_positive_definite(const Tensor& t);

/// The size tensor H = M^(-1/2), whose eigenvalues are the sizes, and back. @pre positive definite
Tensor size_tensor(const Tensor& metric);
Tensor metric_of(const Tensor& size_tensor);

/// Wanted length along a direction of any length > 0.
inline double size_along(const Tensor& metric, const Eigen::Vector3d& e) {
    return std::sqrt(e.squaredNorm() / squared_in(metric, e));
}
/// h^2 = 1 / sqrt(det M) of the metric on the plane with the unit normal n: the area asked for is sqrt(3)/4 h^2.
/// @param size_tensor  H
double mean_square_size(const Tensor& size_tensor, const Eigen::Vector3d& n);

/// Length of an edge from the lengths that it has in the metrics of its two ends, the size in its direction varying
/// geometrically between them. [Borouchaki 1998, eq. 12 with 7] Symmetric to the last bit.
double mean_metric_length(double in_p, double in_q);
/// The same of the metrics of the ends. @param e  the edge
double metric_length(const Eigen::Vector3d& e, const Tensor& metric_p, const Tensor& metric_q);

/// How a metric varies along an edge or over a triangle.
enum class Interpolation {
    SizeTensor,    ///< H = M^(-1/2) linear: sizes in eigendirections that two metrics share are linear
    LogEuclidean,  ///< ln M linear [Arsigny et al. 2006]: they are geometric
    Simultaneous   ///< sizes along the directions that are conjugate in both metrics are geometric; of two metrics only
};
/// Metric at t in [0, 1] between two. @pre both positive definite
Tensor interpolated(const Tensor& p, const Tensor& q, double t, Interpolation how = Interpolation::SizeTensor);
/// Length of an edge in metrics interpolated along it, by Gauss's quadrature with 8 points on each of 2^k pieces, until
/// halving changes less than 1e-10 of it. [Borouchaki 1998, eq. 4]
double interpolated_length(const Eigen::Vector3d& e, const Tensor& p, const Tensor& q,
                           Interpolation how = Interpolation::SizeTensor);

/// Metric whose unit ball is the largest inside both others' in the directions that are conjugate in both. [eq. 17;
/// simultaneous reduction by Cholesky's factor of `a` and the symmetric eigenproblem] Equal to `a` where that is inside
/// `b`, to the bit. @pre both positive definite
Tensor intersection(const Tensor& a, const Tensor& b);
/// Largest factor by which a length in `b` exceeds that in `a`: at most 1 where the unit ball of `a` is inside that of
/// `b`.
double largest_ratio(const Tensor& a, const Tensor& b);

struct TensorBounds {
    double smallest = 0;  ///< sizes, 0 <= smallest <= largest
    double largest = std::numeric_limits<double>::infinity();
    double aspect = std::numeric_limits<double>::infinity();  ///< largest over smallest size, >= 1
};
/// The metric with its sizes brought between bounds; then, where the aspect is above its bound, the larger ones
/// lowered.
Tensor bounded(const Tensor& metric, const TensorBounds& bounds);

/// The metric turned as the unit normal `from` turns to `to` the shortest way: that of one tangent plane in another.
Tensor transported(const Tensor& metric, const Eigen::Vector3d& from, const Eigen::Vector3d& to);

/// Area-length quality of a triangle in the metric of one of its corners, that in which it is worst: 1 for one that is
/// equilateral there, 0 without area. Metrics are taken in the plane of the triangle.
double triangle_quality_in(const std::array<Eigen::Vector3d, 3>& corners, const std::array<Tensor, 3>& metrics);

}  // namespace gradus

/// Exact signs of two determinants of the plane: a floating filter first, expansions where it is unsure.
/// Exact for coordinates whose differences are 0 or between 1e-70 and 1e70 (beyond, products of four under- or
/// overflow).
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace gradus {

namespace detail {
int orient2d_exact(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c);
}

/// Sign of the area of triangle abc: 1 counter-clockwise, -1 clockwise, 0 exactly on a line. [Shewchuk 1997]
inline int orient2d(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
    const double left = (a.x() - c.x()) * (b.y() - c.y());
    const double right = (a.y() - c.y()) * (b.x() - c.x());
    const double det = left - right;
    constexpr double kBound = 3.3306690738754716e-16;  // (3 + 16 u) u, u = 2^-53
    const double error = kBound * (std::abs(left) + std::abs(right));
    if (det > error) return 1;
    if (det < -error) return -1;
    return detail::orient2d_exact(a, b, c);
}

/// Sign of the incircle determinant: 1 if d lies strictly inside the circle through a, b, c (counter-clockwise), -1
/// outside, 0 exactly on it. [Shewchuk 1997] @pre orient2d(a, b, c) > 0
int incircle(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c, const Eigen::Vector2d& d);

}  // namespace gradus

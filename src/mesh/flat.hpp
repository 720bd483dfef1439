/// Private to the sources: what rounding of the coordinates leaves of lengths and triangles.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace gradus {

/// What a product of a few coordinates may be off, as a fraction of the largest.
inline constexpr double kRoundingOfProducts = 4 * std::numeric_limits<double>::epsilon();

inline Eigen::Vector3d scaled_by_power(const Eigen::Vector3d& p, int exponent) {
    return {std::ldexp(p[0], exponent), std::ldexp(p[1], exponent), std::ldexp(p[2], exponent)};
}

/// Whether the corners are on a line: the height over the longest side is below what rounding of the coordinates makes
/// of it.
inline bool is_flat(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    const double largest = std::max({a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff(), c.cwiseAbs().maxCoeff()});
    if (largest == 0) return true;
    // A power of two scales without rounding and keeps the squares in range.
    int exponent = 0;
    std::frexp(largest, &exponent);
    const Eigen::Vector3d p = scaled_by_power(a, -exponent), u = scaled_by_power(b, -exponent) - p,
                          v = scaled_by_power(c, -exponent) - p, w = v - u;
    const double longest = std::sqrt(std::max({u.squaredNorm(), v.squaredNorm(), w.squaredNorm()}));
    return u.cross(v).norm() <= kRoundingOfProducts * longest;
}

}  // namespace gradus

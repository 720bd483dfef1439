/// Curves in space as gluing, models and their diagnosis follow them. Private to the room.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

namespace gradus {

// Pieces a curve is sampled at: enough that two curves of degree 25 that agree at the samples agree between them.
inline constexpr int curve_pieces = 32;

// Gauss-Legendre, 5 points, on [0, 1].
inline constexpr std::array<double, 5> gauss_points{0.04691007703066800, 0.23076534494715845, 0.5, 0.76923465505284155,
                                                    0.95308992296933200};
inline constexpr std::array<double, 5> gauss_weights{0.11846344252809454, 0.23931433524968324, 0.28444444444444444,
                                                     0.23931433524968324, 0.11846344252809454};

/// Exact at both ends, and for [0, 1] everywhere.
inline double interpolate(double low, double high, double s) { return (1 - s) * low + s * high; }

// A Trace has point(s) and derivative(s) for s in [0, 1].

template <class Trace>
double gauss_length(const Trace& curve, double from, double to) {
    double sum = 0;
    for (int k = 0; k < 5; ++k)
        sum += gauss_weights[k] * curve.derivative(interpolate(from, to, gauss_points[k])).norm();
    return sum * (to - from);
}

/// Halves an interval until both halves agree with the whole to the tolerance.
template <class Trace>
double adaptive_length(const Trace& curve, double from, double to, double whole, double tolerance, int depth) {
    const double middle = (from + to) / 2;
    const double left = gauss_length(curve, from, middle), right = gauss_length(curve, middle, to);
    if (depth == 0 || std::abs(left + right - whole) <= tolerance) return left + right;
    return adaptive_length(curve, from, middle, left, tolerance, depth - 1) +
           adaptive_length(curve, middle, to, right, tolerance, depth - 1);
}

/// Arc length, to about 1e-10 of itself.
template <class Trace>
double length_of(const Trace& curve) {
    const double rough = gauss_length(curve, 0, 1);
    constexpr int depth = 12;  // a cusp inside costs accuracy only in an interval of 1/4096
    return adaptive_length(curve, 0, 1, rough, 1e-10 * rough, depth);
}

/// Parameter in [low, high] of the point of the curve closest to p, when the distance has one minimum there: Newton's
/// method on (C - p) . C' with the curvature of C left out, kept inside a shrinking bracket by bisection.
template <class Trace>
double closest_between(const Trace& curve, const Eigen::Vector3d& p, double low, double high) {
    double s = (low + high) / 2;
    for (int step = 0; step < 100 && high - low > 1e-15; ++step) {
        const Eigen::Vector3d c = curve.derivative(s);
        const double slope = (curve.point(s) - p).dot(c);
        if (slope == 0) break;
        (slope > 0 ? high : low) = s;
        const double square = c.squaredNorm();
        const double newton = square > 0 ? s - slope / square : low - 1;
        const double next = newton > low && newton < high ? newton : (low + high) / 2;
        if (std::abs(next - s) < 1e-16) break;
        s = next;
    }
    return s;
}

/// Parameter in [low, high] of the closest point of the curve, by samples first.
template <class Trace>
double closest_from(const Trace& curve, const Eigen::Vector3d& p, double low, double high) {
    double best = low, best_distance = (curve.point(low) - p).norm();
    for (int k = 1; k <= curve_pieces; ++k) {
        const double s = interpolate(low, high, static_cast<double>(k) / curve_pieces);
        const double distance = (curve.point(s) - p).norm();
        if (distance < best_distance) {
            best = s;
            best_distance = distance;
        }
    }
    const double step = (high - low) / curve_pieces;
    const double s = closest_between(curve, p, std::max(low, best - step), std::min(high, best + step));
    return (curve.point(s) - p).norm() < best_distance ? s : best;
}

}  // namespace gradus

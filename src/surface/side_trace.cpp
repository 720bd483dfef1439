#include "side_trace.hpp"

#include <algorithm>
#include <cmath>

namespace gradus {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

double gauss_length(const SideTrace& curve, double from, double to) {
    double sum = 0;
    for (int k = 0; k < 5; ++k)
        sum += gauss_weights[k] * curve.derivative(interpolate(from, to, gauss_points[k])).norm();
    return sum * (to - from);
}

/// Halves an interval until both halves agree with the whole to 1e-10 of the curve.
double adaptive_length(const SideTrace& curve, double from, double to, double whole, double tolerance, int depth) {
    const double middle = (from + to) / 2;
    const double left = gauss_length(curve, from, middle), right = gauss_length(curve, middle, to);
    if (depth == 0 || std::abs(left + right - whole) <= tolerance) return left + right;
    return adaptive_length(curve, from, middle, left, tolerance, depth - 1) +
           adaptive_length(curve, middle, to, right, tolerance, depth - 1);
}

}  // namespace

Vector2d side_uv(const Domain& d, Side side, double s) {
    if (along_u(side))
        return {s == 1 ? d.max.x() : interpolate(d.min.x(), d.max.x(), s),
                side == Side::Bottom ? d.min.y() : d.max.y()};
    return {side == Side::Left ? d.min.x() : d.max.x(), s == 1 ? d.max.y() : interpolate(d.min.y(), d.max.y(), s)};
}

Vector3d SideTrace::point(double s) const { return surface->position(side_uv(surface->domain(), side, s)); }

Vector3d SideTrace::derivative(double s) const {
    const Domain d = surface->domain();
    const Jet1 jet = surface->jet1(side_uv(d, side, s));
    return along_u(side) ? Vector3d(jet.du * (d.max.x() - d.min.x())) : Vector3d(jet.dv * (d.max.y() - d.min.y()));
}

double length_of(const SideTrace& curve) {
    const double rough = gauss_length(curve, 0, 1);
    constexpr int depth = 12;  // a cusp inside costs accuracy only in an interval of 1/4096
    return adaptive_length(curve, 0, 1, rough, 1e-10 * rough, depth);
}

// Newton's method on (C - p) . C' with the curvature of C left out, kept inside a shrinking bracket by bisection.
double closest_between(const SideTrace& curve, const Vector3d& p, double low, double high) {
    double s = (low + high) / 2;
    for (int step = 0; step < 100 && high - low > 1e-15; ++step) {
        const Vector3d c = curve.derivative(s);
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

double closest_from(const SideTrace& curve, const Vector3d& p, double low, double high) {
    double best = low, best_distance = (curve.point(low) - p).norm();
    for (int k = 1; k <= side_pieces; ++k) {
        const double s = interpolate(low, high, static_cast<double>(k) / side_pieces);
        const double distance = (curve.point(s) - p).norm();
        if (distance < best_distance) {
            best = s;
            best_distance = distance;
        }
    }
    const double step = (high - low) / side_pieces;
    const double s = closest_between(curve, p, std::max(low, best - step), std::min(high, best + step));
    return (curve.point(s) - p).norm() < best_distance ? s : best;
}

}  // namespace gradus

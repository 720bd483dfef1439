/// A side of a patch as a curve: what gluing and its diagnosis share. Private to the room.
#pragma once

#include <array>

#include "gradus/surface/patch_model.hpp"

namespace gradus {

// Pieces a side is sampled at: enough that two curves of degree 25 that agree at the samples agree between them.
inline constexpr int side_pieces = 32;

// Gauss-Legendre, 5 points, on [0, 1].
inline constexpr std::array<double, 5> gauss_points{0.04691007703066800, 0.23076534494715845, 0.5, 0.76923465505284155,
                                                    0.95308992296933200};
inline constexpr std::array<double, 5> gauss_weights{0.11846344252809454, 0.23931433524968324, 0.28444444444444444,
                                                     0.23931433524968324, 0.11846344252809454};

/// Exact at both ends, and for [0, 1] everywhere.
inline double interpolate(double low, double high, double s) { return (1 - s) * low + s * high; }

/// Parameters of the place at s in [0, 1] along a side.
Eigen::Vector2d side_uv(const Domain& d, Side side, double s);

/// A side as a curve over s in [0, 1].
struct SideTrace {
    const ParametricSurface* surface;
    Side side;

    Eigen::Vector3d point(double s) const;
    Eigen::Vector3d derivative(double s) const;
};

/// Arc length, to about 1e-10 of itself.
double length_of(const SideTrace& curve);

/// Parameter in [low, high] of the point of the curve closest to p, when the distance has one minimum there.
double closest_between(const SideTrace& curve, const Eigen::Vector3d& p, double low, double high);

/// Parameter in [low, high] of the closest point of the curve, by samples first.
double closest_from(const SideTrace& curve, const Eigen::Vector3d& p, double low, double high);

}  // namespace gradus

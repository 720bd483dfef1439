/// Normals where S_u x S_v vanishes: at poles (collapsed sides) and at corners with a zero derivative.
#pragma once

#include <cmath>
#include <optional>

#include "gradus/surface/parametric_surface.hpp"

namespace gradus {

/// Whether S_u x S_v is too short, for its parametrisation, to be trusted at `uv`: |S_u| or |S_v|, times the extent of
/// the domain, is below `threshold` times what the second derivatives change it by over the domain, or the angle
/// between them is below `threshold`. Then: the direction, in parameters, in which to leave the degenerate place for
/// the inside of the domain (towards the opposite side from a collapsed side; towards the opposite corner from a corner
/// where both derivatives or the angle vanish). An ordinary point, however stretched its parametrisation, gives
/// nothing.
std::optional<Eigen::Vector2d> way_out_of_degeneracy(const Domain& domain, const Eigen::Vector2d& uv, const Jet2& jet,
                                                     double threshold);

/// Unit vector along S_u x S_v. Where that vanishes, its limit along the way out: by the first derivative of S_u x S_v,
/// and if that vanishes too, by extrapolating unit normals from nearby. Zero only for a surface that has no normal
/// there.
Eigen::Vector3d unit_normal(const ParametricSurface& surface, const Eigen::Vector2d& uv);

/// A unit vector across the unit vector n.
inline Eigen::Vector3d any_tangent(const Eigen::Vector3d& n) {
    return (std::abs(n.x()) < 0.6 ? Eigen::Vector3d(0, n.z(), -n.y()) : Eigen::Vector3d(-n.z(), 0, n.x())).normalized();
}

}  // namespace gradus

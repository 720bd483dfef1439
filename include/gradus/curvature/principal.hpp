/// Principal curvatures of a parametric surface, from its fundamental forms.
#pragma once

#include <Eigen/Core>
#include <span>

#include "gradus/surface/parametric_surface.hpp"

namespace gradus {

/// Curvatures in 1 / length, k1 >= k2, of normal sections towards d1 and d2. Positive where the surface bends towards
/// the normal n = S_u x S_v / |S_u x S_v|: a sphere of radius R whose normal points outward has k1 = k2 = -1 / R.
struct PrincipalCurvatures {
    double k1, k2;
    Eigen::Vector3d d1, d2, normal;  ///< orthonormal, d1 x d2 = normal
};

/// From a jet with S_u x S_v != 0, by the first and second fundamental forms in an orthonormal frame of the tangent
/// plane: the lengths of S_u and S_v cancel, so a stretched parametrisation costs no accuracy.
PrincipalCurvatures principal_curvatures(const Jet2& jet);

/// At a place of a surface. Where S_u x S_v vanishes (a pole, a corner with a zero derivative) or nearly does, the
/// limit along the way into the domain (see way_out_of_degeneracy): curvature tensors at 1/32, 1/64 ... 1/1024 of the
/// domain from it are extrapolated. If they do not settle, the curvature is not bounded (or not continuous) there and
/// the closest one is returned.
PrincipalCurvatures principal_curvatures(const ParametricSurface& surface, const Eigen::Vector2d& uv);

/// Smallest radius of curvature of normal sections, 1 / max(|k1|, |k2|), in units of length; +infinity where the
/// surface is planar.
double minimal_radius(const ParametricSurface& surface, const Eigen::Vector2d& uv);

/// The same at many places at once.
/// @throws std::invalid_argument if the spans differ in size
void minimal_radii(const ParametricSurface& surface, std::span<const Eigen::Vector2d> uv, std::span<double> radii);

}  // namespace gradus

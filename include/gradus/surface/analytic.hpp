/// Surfaces in closed form: models for tests, primitives, planar domains.
#pragma once

#include <memory>

#include "gradus/surface/parametric_surface.hpp"

namespace gradus {

/// origin + u a + v b.
/// @throws std::invalid_argument if a and b are parallel
std::unique_ptr<const ParametricSurface> make_plane(const Eigen::Vector3d& origin, const Eigen::Vector3d& a,
                                                    const Eigen::Vector3d& b, const Domain& domain = {});

/// u: longitude in [0, 2 pi] from +x, v: latitude in [-pi/2, pi/2]. A seam at u = 0, poles at either end of v; S_u x
/// S_v points outward.
/// @param radius  > 0
std::unique_ptr<const ParametricSurface> make_sphere(const Eigen::Vector3d& centre, double radius);

/// u: angle around the z axis, v: angle around the tube from the outer equator, both in [0, 2 pi], with seams both
/// ways; S_u x S_v points outward.
/// @param major, minor  radius of the tube's centre line and of the tube, 0 < minor < major
std::unique_ptr<const ParametricSurface> make_torus(const Eigen::Vector3d& centre, double major, double minor);

/// u: angle in [0, 2 pi] from +x, v: height in [0, height] along z, open at both ends. A seam at u = 0; S_u x S_v
/// points outward.
/// @param radius, height  > 0
std::unique_ptr<const ParametricSurface> make_cylinder(const Eigen::Vector3d& base, double radius, double height);

/// The same surface over other parameters: S'(x) = S(A x + b). Reverses, swaps or stretches a parametrisation.
/// @param domain  of the new parameters; A must map it onto the old domain or into it
/// @throws std::invalid_argument if A is singular
std::unique_ptr<const ParametricSurface> reparametrise(std::unique_ptr<const ParametricSurface> surface,
                                                       const Eigen::Matrix2d& A, const Eigen::Vector2d& b,
                                                       const Domain& domain);

}  // namespace gradus

/// Closest points on a parametric surface.
#pragma once

#include "gradus/surface/parametric_surface.hpp"

namespace gradus {

struct PatchProjection {
    Eigen::Vector2d uv;
    double distance;  ///< from the surface point at uv
};

/// A point of the surface near p, by Gauss-Newton steps from `start`; a local minimum of the distance.
/// @param inside  keep to the domain; else the surface is continued a little beyond its sides
PatchProjection project(const ParametricSurface& surface, const Eigen::Vector3d& p, const Eigen::Vector2d& start,
                        bool inside = true);

/// The same from the best of a grid of starts: a global minimum for patches without finer detail than the grid.
PatchProjection project(const ParametricSurface& surface, const Eigen::Vector3d& p, int cells = 8);

}  // namespace gradus

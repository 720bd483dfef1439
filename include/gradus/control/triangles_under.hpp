/// Which triangles of a background lie under a mesh that came from elsewhere.
#pragma once

#include <span>
#include <vector>

#include "gradus/control/background.hpp"

namespace gradus {

/// A triangle of the background under each vertex, to start the walks of a ControlSpace from. Each connected part of
/// the mesh is taken to the part of the background it is closest to as a whole, so that parts which touch or run
/// through each other are not confused; a vertex far from there (more than half the edge of a triangle) is taken to the
/// closest triangle of all.
/// @param points, triangles  the mesh; indices must be in range
/// @returns one per vertex; 0 for a vertex that is not finite
std::vector<int> triangles_under(const TriMesh& background, std::span<const Eigen::Vector3d> points,
                                 std::span<const Triangle> triangles);

}  // namespace gradus

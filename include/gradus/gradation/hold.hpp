/// Sizes around elements that stay as they are: the one way in which sizes go up.
#pragma once

#include "gradus/mesh/tri_mesh.hpp"

#include <span>

namespace gradus {

/// Slope of sizes from frozen edges down to smaller ones. An edge that cannot be divided has a triangle whose other
/// edges are half as long at least: at that distance sizes are to be no smaller.
inline constexpr double kHoldSlope = 0.8;

/// Raises sizes so that from each held size they fall by at most `slope` times the distance along the edges of the
/// mesh. Other bounds, on gradation or on the distance to the surface, may not hold there any more.
/// @param held  for the first vertices of the mesh the least size, unit of length; 0: none
/// @param size  one size > 0 per vertex; raised in place
/// @returns number of vertices whose size went up
/// @throws std::invalid_argument if slope <= 0, there are more held sizes than vertices, or sizes are not one per
/// vertex
int raise_to_held(const TriMesh& mesh, std::span<const double> held, double slope, std::span<double> size);

}  // namespace gradus

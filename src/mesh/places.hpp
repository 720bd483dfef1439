/// Private to the sources: vertices at one place.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace gradus {

using Points = std::vector<Eigen::Vector3d>;

/// Points scaled by a power of two into [-1, 1], so that products of a few stay in range. Those not used are 0.
Points to_unit_box(const Points& points, const std::vector<char>& used);

/// The first vertex at the place of each, by coordinates; -1 for those not used.
std::vector<int> equal_places(const Points& points, const std::vector<char>& used);

/// The closest earlier vertex that stays, if within a distance; else the vertex itself, which then stays; -1 for those
/// not used.
/// @param points     in [-1, 1]
/// @param tolerance  the distance, as a fraction of the diagonal of the bounding box
std::vector<int> close_places(const Points& points, const std::vector<char>& used, double tolerance);

}  // namespace gradus

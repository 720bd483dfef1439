/// Private to the sources: exact signs of determinants of points in space, a floating filter first.
/// Exact for coordinates whose differences are 0 or between 1e-90 and 1e90 (beyond, products of three under- or
/// overflow).
#pragma once

#include <Eigen/Core>

namespace gradus::exact {

/// Sign of the volume of the tetrahedron abcd: 0 exactly if they are in a plane; it changes as two points change
/// places.
int orient3d(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, const Eigen::Vector3d& d);

/// Sign of the area of the triangle abc seen along an axis: 0 exactly if they are on a line there.
int orient2d(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, int axis);

}  // namespace gradus::exact

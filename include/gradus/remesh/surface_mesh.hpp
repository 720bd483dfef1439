/// A triangle mesh of a surface of patches whose vertices know where on the surface they lie.
#pragma once

#include "gradus/mesh/soup.hpp"

#include <vector>

namespace gradus {

struct SurfaceMesh {
    std::vector<Eigen::Vector3d> points;   ///< exactly on the surface: points[i] == position(places[i])
    std::vector<Triangle> triangles;       ///< outside counter-clockwise
    std::vector<SurfacePoint> places;      ///< one per vertex
    std::vector<int> patches;              ///< one per triangle: the patch under (most of) it
    std::vector<double> sizes;             ///< one per vertex: the size the map asks for there
    std::vector<std::array<int, 2>> features;  ///< edges on creases and boundaries
    RequiredElements required = {};            ///< those of the surface, in their order, by index in this mesh
};

}  // namespace gradus

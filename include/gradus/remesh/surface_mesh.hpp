/// A triangle mesh of a surface, of patches or of triangles, whose vertices know where on it they lie.
#pragma once

#include "gradus/mesh/soup.hpp"

#include <vector>

namespace gradus {

struct SurfaceMesh {
    std::vector<Eigen::Vector3d> points;  ///< on the surface; of patches exactly: points[i] == position(places[i])
    std::vector<Triangle> triangles;      ///< outside counter-clockwise
    std::vector<SurfacePoint>
        places;  ///< one per vertex: patch and parameters, or triangle and weights of its second and third corner
    std::vector<int> patches;  ///< one per triangle: the patch under (most of) it, or its label, 0 where there are none
    std::vector<double> sizes;                 ///< one per vertex: the size the map asks for there
    std::vector<std::array<int, 2>> features;  ///< edges on creases, boundaries and other feature curves
    std::vector<int> feature_labels =
        {};             ///< one per feature: that of the surface's edges there, 0 for none; empty if none has one
    int dimension = 3;  ///< 2: of the plane, z is 0
    RequiredElements required = {};  ///< those of the surface, in their order, by index in this mesh
};

}  // namespace gradus

/// Private to the sources: triangles joined along their sides to oriented manifolds.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "gradus/mesh/tri_mesh.hpp"

namespace gradus {

struct Sheets {
    std::vector<int>
        fan;  ///< per corner 3 t + k: the corner that stands for all that stay together with it at a vertex
    std::vector<char> turned;   ///< per triangle
    std::vector<char> crowded;  ///< per side 3 t + k, from corner k: at an edge of three triangles or more
    bool has_cuts = false;      ///< there are such edges, or one-sided pieces
};

/// Steps 6 to 8 of repair().
/// @param points     of places, in [-1, 1]
/// @param places     of the corners of each triangle, three different ones, no three twice; points of different places
/// differ
/// @param vertices   of the corners of each triangle: those at one place may be different
Sheets join_sheets(std::span<const Eigen::Vector3d> points, std::span<const Triangle> places,
                   std::span<const Triangle> vertices);

}  // namespace gradus

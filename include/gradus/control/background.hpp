/// The background mesh: one triangle mesh in space for the whole model, whose vertices carry the size map.
#pragma once

#include "gradus/surface/patch_model.hpp"

#include <array>
#include <vector>

namespace gradus {

/// Faces know their patch, corners their (u, v). Corner k of face f is the k-th vertex of triangles_of(mesh)[f].
struct Background {
    TriMesh mesh;
    std::vector<int> patch;                          ///< one per face
    std::vector<std::array<Eigen::Vector2d, 3>> uv;  ///< one per face: parameters of its corners on that patch
};

}  // namespace gradus

/// The background mesh: one triangle mesh in space for the whole model, whose vertices carry the size map.
#pragma once

#include "gradus/surface/surface_model.hpp"

#include <array>
#include <vector>

namespace gradus {

/// Faces know their patch, corners their (u, v). Corner k of face f is the k-th vertex of triangles_of(mesh)[f].
struct Background {
    TriMesh mesh;
    std::vector<int> patch;                          ///< one per face
    std::vector<std::array<Eigen::Vector2d, 3>> uv;  ///< one per face: parameters of its corners on that patch
};

/// The background of a mesh read from a file, whose parameters are those of the soup where it has them; the others are
/// found by projection to the patch of the triangle's label.
/// @throws std::invalid_argument for triangles without a patch, or a vertex farther from its patch than 1e-6 of the
/// diagonal
Background background_from_soup(const SurfaceModel& model, const TriangleSoup& soup);

/// As a file holds it: labels are patches, each vertex with its parameters on every patch around it.
TriangleSoup soup_from_background(const Background& background);

}  // namespace gradus

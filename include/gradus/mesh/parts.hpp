/// Connected parts of a mesh.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "gradus/mesh/tri_mesh.hpp"

namespace gradus {

/// Number of the connected part of each vertex, from 0 in the order of their first vertices; a vertex without triangles
/// is a part of its own.
std::vector<int> connected_parts(std::size_t vertices, std::span<const Triangle> triangles);

}  // namespace gradus

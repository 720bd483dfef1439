/// Lists of elements that remeshing is not to touch, for formats of meshes that have no place for them.
#pragma once

#include <cstddef>
#include <string>

#include "gradus/mesh/soup.hpp"

namespace gradus {

/// Reads a text with one element a line, counted from 1 in the order of the mesh's file: `vertex 12`, `edge 3 4` by its
/// two vertices, or `triangle 7`; polygons are counted in the triangles that they are read as. What follows a `#` is a
/// comment.
/// @throws IoError naming the file and the line if it cannot be read, for another word, and for an index out of range
RequiredElements read_required(const std::string& path, std::size_t num_points, std::size_t num_triangles);

}  // namespace gradus

/// Meshes of quadrilaterals, and triangles that are left, in files.
#pragma once

#include <string>

#include "gradus/remesh/quads.hpp"

namespace gradus {

/// Writes in the format of the extension: .mesh (Medit, text, of dimension 2 for planar ones; with labels, feature
/// edges as ridges, corners), .vtu (text; with labels and feature edges), .obj and .off (elements alone).
/// @throws IoError if the file cannot be written or the extension is another one
void write_quads(const std::string& path, const QuadMesh& mesh);

/// The extensions that it takes: ".mesh .vtu .obj .off"
bool holds_quads(const std::string& path);

}  // namespace gradus

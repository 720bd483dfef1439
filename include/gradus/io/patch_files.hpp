/// Files of Bezier patches.
#pragma once

#include <string>
#include <vector>

#include "gradus/io/error.hpp"
#include "gradus/surface/bezier_patch.hpp"
#include "gradus/surface/glue.hpp"
#include "gradus/surface/surface_model.hpp"

namespace gradus {

/// What a patch file holds.
struct PatchFile {
    std::vector<BezierNet> nets;
    std::string origin;  ///< text of the comment lines above the patch count, one line each; may be empty
};

/// Reads Bezier patches; the layout is told from the content. In all of them '#' starts a comment, commas count as
/// blanks, empty lines are skipped, and points run along u first.
///  - `.bpt`: the number of patches; then for each a line "m n" (degrees along u and v, 1 to 25) and (m + 1)(n + 1)
///  lines of a
///    point "x y z", or "x y z w" with w > 0 its weight (x, y, z are the point itself, not multiplied by w).
///  - `.bez`: the number of patches; then 16 lines of a point for each, as above: all are bicubic.
///  - indexed, the teapot's classic one: the number of patches; a line of 16 vertex numbers (from 1) for each; the
///  number of
///    vertices; a line "x y z" for each.
/// @throws IoError with path and line if the file cannot be opened or is malformed
PatchFile read_patches(const std::string& path);

/// The same from the text of such a file. @param path  name for messages
PatchFile parse_patches(const std::string& text, const std::string& path);

/// Writes the `.bpt` layout, numbers in the shortest decimals that read back exactly.
/// @throws IoError if the file cannot be written
void write_patches(const std::string& path, const PatchFile& file);

/// Patches of a file, glued.
/// @throws std::invalid_argument like make_bezier_patch and SurfaceModel
SurfaceModel make_model(const PatchFile& file, const ModelOptions& options = {});

}  // namespace gradus

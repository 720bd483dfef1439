/// Size maps for other programs, and to look at.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gradus/io/colour_map.hpp"
#include "gradus/mesh/soup.hpp"

namespace gradus {

/// Writes a size map as a view `size` that Gmsh takes as a background field (`gmsh -bgm FILE`, or `Merge` and
/// `Background Mesh View[0]`).
/// `.pos`: a list of scalar triangles, which brings no mesh along. `.msh`: the mesh with `$NodeData`, version 4.1.
/// @param sizes  one per vertex, > 0, unit of length; +inf (unset) is written as 1e22, Gmsh's own word for no limit
/// @throws std::invalid_argument if the sizes are not one per vertex or not > 0, and as write_mesh does
/// @throws IoError if the file cannot be written or its extension is another
void write_size_view(const std::string& path, const TriangleSoup& soup, std::span<const double> sizes);

struct ColouredPlyOptions {
    std::string name = "size";  ///< of the property with the values, a word
    ColourMap map = ColourMap::Sequential;
    Scale scale = Scale::Linear;
    std::optional<Range> range = {};  ///< default: that of the values
};

/// Writes a binary `.ply` whose vertices have the properties red, green, blue (a value's place on the colour map) and
/// the value itself.
/// @param values  one per point; those the scale cannot show are grey
/// @throws std::invalid_argument if the values are not one per point, a name is no word, and as write_mesh does
/// @throws IoError if the file cannot be written or its extension is not .ply
void write_coloured_ply(const std::string& path, std::span<const Eigen::Vector3d> points,
                        std::span<const Triangle> triangles, std::span<const double> values,
                        const ColouredPlyOptions& options = {});

}  // namespace gradus

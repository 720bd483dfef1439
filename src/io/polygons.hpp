/// Private to the sources: faces of more than three corners become triangles.
#pragma once

#include <cstddef>
#include <vector>

#include "gradus/mesh/soup.hpp"

namespace gradus::io {

/// A polygon that was read as the fan from its first corner.
struct Fan {
    std::size_t first;      ///< its first triangle
    std::size_t triangles;  ///< and how many follow each other; two fewer than corners
};

/// Gives polygons that are not convex, seen along their normal, the triangles of ears instead of a fan; as many. What
/// has no ears though its sides do not meet, as it is folded, and what is left after some seconds, stays as it is. To
/// be called once all points are known.
/// @throws IoError naming the path and a polygon whose sides cross each other
void clip_ears(const std::string& path, TriangleSoup& soup, const std::vector<Fan>& fans);

}  // namespace gradus::io

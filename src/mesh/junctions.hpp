/// Private to the sources: vertices of open edges in the middle of other open edges, where a mesh is not joined.
#pragma once

#include <array>
#include <vector>

#include "gradus/mesh/soup.hpp"
#include "places.hpp"

namespace gradus {

/// An edge of one triangle, and the vertex across it there.
struct OpenEdge {
    std::array<int, 2> ends;
    int across;
};

/// Open edges between vertices that stand for their place (-1 for none), the smaller end first, in order.
std::vector<OpenEdge> open_edges(const std::vector<Triangle>& triangles, const std::vector<int>& place);

/// An open edge, and the vertices within it, from its first end on.
struct Junctions {
    std::array<int, 2> edge;
    std::vector<int> vertices;
};

/// T-junctions: a vertex lies within a distance of an open edge, farther from its ends, and an open edge that ends in
/// the vertex runs along it. The vertex across the edge in its triangle is none. In the order of the edges. O(n log n),
/// by a grid.
/// @param points  in [-1, 1], at least those of the triangles
std::vector<Junctions> find_junctions(const Points& points, const std::vector<Triangle>& triangles, double distance);

}  // namespace gradus

/// Planar domains as they are drawn: points joined by segments, which bound regions and holes.
#pragma once

#include <optional>
#include <vector>

#include "gradus/mesh/soup.hpp"

namespace gradus {

/// A planar straight-line graph. Segments meet in points only. What they enclose is the domain, cut by them into
/// regions; a line inside a region stays a line of edges there, a point in no segment a vertex.
struct PlanarGraph {
    std::vector<Eigen::Vector2d> points;
    std::vector<std::array<int, 2>> segments;
    std::vector<int> labels = {};  ///< one per segment, or empty

    /// Given: everything enclosed is inside but the regions that hold one of these. Not given: an outline inside a
    /// region is a hole, one inside a hole an island, and so on. An outline is what holds together though any one point
    /// of it is taken away, so that regions that share segments are of one, and a hole that touches the border around
    /// it in a point is a hole still.
    std::optional<std::vector<Eigen::Vector2d>> holes = {};

    /// A label for the region that holds a point.
    struct Region {
        Eigen::Vector2d point;
        int label;
    };
    std::vector<Region> regions = {};

    std::vector<int> corners = {};
    RequiredElements required = {};  ///< vertices and edges
    int first_number = 0;            ///< what messages call the first point
};

/// Whether a triangulation has vertices that are no points of the graph.
enum class InnerPoints {
    None,
    Added  ///< inside, so that triangles are well shaped as far as the segments let them, which stay whole
};

/// The domain as triangles in z = 0, constrained Delaunay, counter-clockwise: the surface that the way of the data
/// begins with. Points keep their numbers, those that are added come behind them; segments of the domain are feature
/// edges with their labels, and points of no segment are required. Where parts of the domain meet in a point only each
/// has a vertex there, behind all others. The labels of triangles are those of `regions`, 0 elsewhere; without any
/// given, regions are numbered from 1 in the order of their first segments, if there are several.
/// @throws std::invalid_argument naming points and segments with their places: numbers out of range or not finite,
/// coinciding points, repeated,
///         crossing or touching segments, segments that are not in the domain (but between listed holes), nothing
///         enclosed, a hole or region at a point that is in no region, two regions of different labels in one
TriangleSoup triangulate(const PlanarGraph& graph, InnerPoints inner = InnerPoints::None);

}  // namespace gradus

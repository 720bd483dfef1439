/// Order in memory: what is next to each other in space is to be next to each other there, which all that walks over a mesh is faster for.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gradus/mesh/soup.hpp"

namespace gradus {

/// Places on a Z-curve through the cube around some points, along which points that are near each other on the curve are so in space:
/// 21 bits of each coordinate, interleaved. @pre the points are finite
std::vector<std::uint64_t> z_codes(std::span<const Eigen::Vector3d> points);

/// A soup in another order.
struct Ordered {
    TriangleSoup soup;
    std::vector<int> point_source, triangle_source;  ///< for each of its points and triangles the number it had
};

/// Items in the order of their sources. @param source  for each that there is to be the number it has
template <class Item>
void reorder(std::vector<Item>& items, std::span<const int> source) {
    std::vector<Item> ordered;
    ordered.reserve(source.size());
    for (const int i : source) ordered.push_back(items[i]);
    items = std::move(ordered);
}

Ordered as_it_is(TriangleSoup soup);
/// Points along a Z-curve, triangles by the first of their points; equal places in the order they had. Nothing else changes.
/// Coordinates too large for it, or not finite, leave the soup as it is.
Ordered along_curve(TriangleSoup soup);

}  // namespace gradus

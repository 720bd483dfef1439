/// Order in memory: what is next to each other in space is to be next to each other there, which all that walks over a
/// mesh is faster for.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "gradus/mesh/soup.hpp"

namespace gradus {

/// A Z-curve through the cube around a box: places that are near each other on it are so in space.
class ZCurve {
  public:
    explicit ZCurve(const Eigen::AlignedBox3d& box);
    /// The place of a point of the box on the curve: 21 bits of each coordinate, interleaved.
    std::uint64_t code(const Eigen::Vector3d& p) const;

  private:
    Eigen::Vector3d low_;
    double scale_;  // 0 for a box without extent
};

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
/// Points along a Z-curve, triangles by the first of their points; equal places in the order they had. Nothing else
/// changes. Coordinates too large for it, or not finite, leave the soup as it is.
Ordered along_curve(TriangleSoup soup);

}  // namespace gradus

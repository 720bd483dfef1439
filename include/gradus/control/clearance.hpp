/// How far places of a triangulation are from what faces them: elements there can be no larger without being bad or
/// bridging a gap.
///
/// Features divide the surface into faces. The *feature clearance* of a place p on a feature, seen from one side of it,
/// is the radius of the smallest ball about p in which p is joined, on its face and without crossing a feature, to a
/// place q of a feature that faces it: one that is more than 3.73 = 1 / tan(15 degrees) times as far along the feature
/// curves, or not joined to p by them at all. So two curves from a common corner face each other where they enclose
/// less than 30 degrees, the sides of a slot do from about 1.4 times its width from its end, a circle never faces
/// itself, and what follows p on its own curve does not face it. Distances are straight ones, as elements are, and do
/// not depend on how the face is cut into triangles. A place within a face, no farther from the nearest feature than
/// the clearance there, has that clearance, others none.
///
/// The *sheet clearance* is the distance to the nearest place q of the surface that p sees face to face, through the
/// material or the void: normals at p and q are opposite within 60 degrees, and pq is within 60 degrees of both. q is
/// no neighbour: the way to it along the surface is more than 1.4 times as long; it is pi / 2 times where a round turns
/// back. Normals are the fitted ones; facets within which these turn by more than 60 degrees, as noise may do that
/// folds them over, neither see nor are seen.
#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "gradus/control/triangulation.hpp"

namespace gradus {

/// What a place faces; nothing within reach: infinitely far.
struct Clearance {
    double distance = std::numeric_limits<double>::infinity();
    int triangle = -1;                                ///< that holds the place faced
    Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< the place faced
};

/// A place of a triangulation as one side of the features sees it.
struct SidedPlace {
    Eigen::Vector3d point;
    int triangle;        ///< that holds it
    int half_edge = -1;  ///< of the triangle, that holds it; or -1
    int wedge = -1;      ///< whose vertex it is; or -1
};

/// One per wedge of vertex v.
std::vector<SidedPlace> sides_of_vertex(const Triangulation& surface, int v);
/// A place of half-edge h: one side, or where h is a feature both (one on a boundary).
std::vector<SidedPlace> sides_of_edge(const Triangulation& surface, int h, const Eigen::Vector3d& point);

/// Clearances of single places. Calls from several threads are fine. The triangulation must outlive it.
class ClearanceFinder {
  public:
    explicit ClearanceFinder(const Triangulation& surface);
    ~ClearanceFinder();
    ClearanceFinder(const ClearanceFinder&) = delete;
    ClearanceFinder& operator=(const ClearanceFinder&) = delete;

    /// @param reach  what is farther is not looked for, >= 0
    /// @param tip    a place this near to the apex of a narrow corner faces nothing across it: the element there has
    /// the corner's angle,
    ///               whatever its size
    Clearance feature(const SidedPlace& place, double reach, double tip = 0) const;
    Clearance sheet(const SidedPlace& place, double reach) const;

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

/// One per vertex, the smallest of its sides; infinite where nothing is within reach.
std::vector<double> feature_clearance(const Triangulation& surface,
                                      double reach = std::numeric_limits<double>::infinity());
std::vector<double> sheet_clearance(const Triangulation& surface,
                                    double reach = std::numeric_limits<double>::infinity());

}  // namespace gradus

/// Flat faces of a triangulation, told from facets of rounds by what lies beside them.
///
/// A facet is evidence of how finely the surface was sampled there. Facets of one plane are one region; a region that
/// reaches farther from an edge than the one beyond it is no part of the round that the other is a facet of: there the
/// surface is flat, and meets the round with a common tangent plane or in a ridge.
#pragma once

#include "gradus/mesh/connectivity.hpp"

#include <Eigen/Core>
#include <limits>
#include <span>
#include <vector>

namespace gradus {

/// Largest rounding of the coordinates, unit of length: half a unit in the last place of single precision, or of the
/// decimals that all coordinates have in common, where these are 6 to 9; else what a few operations in double precision
/// leave. 0 for no points.
double resolution_of(std::span<const Eigen::Vector3d> points);

/// One side of a bend: a part of a section across the surface, or of a curve, from the bend to where it turns again.
struct BendSide {
    double width = 0;       ///< from the bend to the next one, unit of length
    double reach = 0;       ///< as far as it would be if no crease cut it off: at least the width
    double next_turn = 0;   ///< angle there, radians, about the same axis; positive: the same way as the bend
    double next_width = 0;  ///< of the part behind that
    /// Whether it ends there along a line. Else it comes to a corner, and the turn is that to the farthest of the
    /// facets around it: as of a round it is at least the bend's, or two of them.
    bool is_strip = true;
};

/// Parts of a round are about as wide as each other: within this factor.
constexpr double kAlikeWidths = 2;

/// Rounds turn by no more from facet to facet, radians: 55 degrees.
constexpr double kSharpestRound = 0.96;

/// What is left of a bend, radians, once both sides have explained their share as facets of a round: each half of its
/// next turn, as for points of a circle. A side that is wider than the other one, or than what follows it, is flat and
/// explains nothing. Nothing is left where a side turns on by more, up to 55 degrees: where the bend is where a round
/// begins.
/// @param turn  of the bend, radians, >= 0
double unexplained_turn(double turn, const BendSide& one, const BendSide& other);

/// Whether two planes meet in a ridge rather than in a round: most of the turn is unexplained.
bool is_ridge(double turn, const BendSide& one, const BendSide& other);

/// Facets by the plane they are in.
class PlanarRegions {
  public:
    /// Facets are of one plane where their corners are within a few roundings of it, or 1e-7 of the longest side of its
    /// largest facet. Both must outlive this. Removed triangles are in no region (-1).
    PlanarRegions(std::span<const Eigen::Vector3d> points, const Connectivity& mesh);

    int size() const { return static_cast<int>(normals_.size()); }
    int of(int triangle) const { return region_[triangle]; }
    int num_facets(int region) const { return num_facets_[region]; }
    /// Whether it is sure to be a plane: it has several facets, or its one facet is among regions that have.
    bool is_plane(int region) const { return is_plane_[region]; }
    /// Whether it meets so many others that it is no facet of a round, but a face.
    bool is_many_sided(int region) const { return is_many_sided_[region]; }
    /// Unit; zero where no facet of it has an area.
    const Eigen::Vector3d& normal(int region) const { return normals_[region]; }
    /// The normal of the region of a triangle: also of facets that are too narrow to have one of their own.
    const Eigen::Vector3d& normal_at(int triangle) const { return normals_[region_[triangle]]; }

    /// Straight over the region of the triangle of half-edge h, beginning at that part of its length.
    struct Way {
        double length = 0;  ///< unit of length; `farthest` where it is not left before
        int exit = -1;      ///< half-edge of the region where it is left; -1: it was not left before `farthest`
    };
    Way across(int h, double farthest = std::numeric_limits<double>::infinity(), double start = 0.5) const;
    /// The angle by which the surface bends at an edge, radians, positive where it bends to the inside; 0 at
    /// boundaries.
    double turn_at(int h) const;
    /// Whether two edges of a region run the same way, so that it is a strip between them.
    bool is_parallel(int h, int g) const;
    /// Of the section across the edge of h, on the side of the triangle of h.
    BendSide side_of(int h) const;

  private:
    void find_planes();
    void find_reaches();

    std::span<const Eigen::Vector3d> points_;
    const Connectivity* mesh_;
    std::vector<int> region_, num_facets_;
    std::vector<char> is_plane_, is_many_sided_;
    std::vector<double> reach_;  // of regions of more than two facets, from most of their joints; else 0
    std::vector<Eigen::Vector3d> normals_;
};

/// The flat faces among the planar regions.
struct FlatFaces {
    std::vector<int> of_triangle;          ///< number of the face, or -1; empty where there are none at all
    std::vector<Eigen::Vector3d> normals;  ///< of each face, unit

    bool empty() const { return normals.empty(); }
    int of(int triangle) const { return empty() ? -1 : of_triangle[triangle]; }
};

/// A region is a flat face rather than a facet of a round if it is wider than what is beyond along most of what it
/// meets without a ridge; one or two facets must be so on all sides, and what has many sides is one anyhow. What a
/// single facet is wider than must be planes of several facets.
FlatFaces find_flat_faces(std::span<const Eigen::Vector3d> points, const Connectivity& mesh,
                          const PlanarRegions& regions);

}  // namespace gradus

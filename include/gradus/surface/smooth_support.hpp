/// A smooth surface over a triangulation: what the facets stand for, so that new points do not lie on flat triangles.
#pragma once

#include "gradus/mesh/features.hpp"
#include "gradus/mesh/flats.hpp"

#include <array>
#include <limits>
#include <span>
#include <vector>

namespace gradus {

/// The part of the surface over one triangle: control points of a quartic whose inner three follow the nearest sides
/// [Gregory].
struct GregoryPatch {
    std::array<Eigen::Vector3d, 3> corner;
    std::array<std::array<Eigen::Vector3d, 3>, 3> side;   ///< those between the ends of side k, from corner k to k + 1
    std::array<std::array<Eigen::Vector3d, 2>, 3> inner;  ///< beside side k, near its start and its end
    std::array<Eigen::Vector3d, 3> normals;               ///< of the corners

    Eigen::Vector3d point(double b, double c) const;
    /// Unit; interpolated between the corners.
    Eigen::Vector3d normal(double b, double c) const {
        return ((1 - b - c) * normals[0] + b * normals[1] + c * normals[2]).stableNormalized();
    }
};

/// One quartic Gregory patch per triangle, bounded by cubic curves, with the tangent planes given at the vertices.
/// Neighbours meet with one tangent plane along their edge [Walton, Meek 1996], except at features, where they share
/// only the curve. The boundary cubics have the handles that make them exact to fourth order for a circle; patches then
/// are for smooth surfaces with exact normals. Points of a patch are given by the barycentric coordinates (b, c) of
/// corners 1 and 2.
class SmoothSupport {
  public:
    struct Options {
        /// The middle of an edge curve stays this near to the edge, and a patch as near to its facet, about: unit of
        /// length. No curve rises more than a quarter of the width of the facets beside it either, about: on needles
        /// the surface would fold.
        double largest_bulge = std::numeric_limits<double>::infinity();
    };
    /// @param mesh     its half-edges tagged with the chain they belong to, or -1; must outlive this, as `points` and
    /// `wedges` must
    /// @param flats    faces that stay in their planes; must outlive this
    /// @param normals  one per wedge, unit, or zero where unknown; at features they are turned to hold the curves'
    /// tangents, and beside a flat
    ///                 face they are its own
    SmoothSupport(std::span<const Eigen::Vector3d> points, const Connectivity& mesh, const Features& features,
                  const Wedges& wedges, const FlatFaces& flats, std::vector<Eigen::Vector3d> normals,
                  const Options& options);

    GregoryPatch patch(int triangle) const;
    Eigen::Vector3d point(int triangle, double b, double c) const { return patch(triangle).point(b, c); }
    /// At corner k of a triangle, on its side of features.
    const Eigen::Vector3d& corner_normal(int triangle, int k) const {
        return normals_[wedges_->of_corner[3 * triangle + k]];
    }
    /// What the patch has there, unit: not far off the facet's normal.
    Eigen::Vector3d normal_at_corner(int triangle, int k) const {
        return held_normal(triangle, k, facet_normal(triangle)).stableNormalized();
    }
    /// Point of the curve over half-edge h, s in [0, 1] from its origin.
    Eigen::Vector3d curve_point(int h, double s) const;

    struct Foot {
        int triangle;
        double b, c;
        bool barred = false;   ///< the way to a closer triangle leads across a feature
        double distance2 = 0;  ///< squared, to the facet
    };
    /// The facet closest to p among those reached from `triangle` by ever closer ones, without crossing a feature.
    Foot walk(int triangle, const Eigen::Vector3d& p) const;
    /// The same of one facet alone.
    Foot within(int triangle, const Eigen::Vector3d& p) const;

    /// Edges that are no features and yet turn by more than 40 degrees are folds: whether one is at this facet or
    /// within two rings.
    bool folds_near(int triangle) const { return normal_near_folds_[triangle] >= 0; }
    static constexpr double kFold = 0.77;  ///< cosine of that angle
    /// Unit, or zero.
    Eigen::Vector3d facet_normal(int triangle) const;

    const Connectivity& mesh() const { return *mesh_; }
    std::span<const Eigen::Vector3d> points() const { return points_; }

  private:
    struct Handles {
        Eigen::Vector3d from, to;  // inner control points of the cubic over a half-edge
    };
    Handles handles(int h) const;
    double width_beside(int h) const;
    Eigen::Vector3d held_normal(int triangle, int k, const Eigen::Vector3d& facing) const;
    void turn_normals(const Features& features);
    void hold_flats();
    void find_tangents(const Features& features);
    void find_folds();

    std::vector<int> normal_near_folds_;  // of each triangle its number among the facet normals that are kept, or -1
    std::vector<Eigen::Vector3d> facet_normals_;
    std::span<const Eigen::Vector3d> points_;
    const Connectivity* mesh_;
    const Wedges* wedges_;
    const FlatFaces* flats_;
    std::vector<char> is_tip_;  // vertices that are corners and on no feature curve
    Options options_;
    std::vector<Eigen::Vector3d> normals_;  // per wedge
    std::vector<Eigen::Vector3d>
        tangents_;  // of the feature curve at its inner vertices; zero elsewhere, and at corners
};

/// Normal of each wedge, exact for points of a sphere [Max 1999]; zero where all its triangles are flat.
std::vector<Eigen::Vector3d> wedge_normals(std::span<const Eigen::Vector3d> points, const Connectivity& mesh,
                                           const Wedges& wedges);

}  // namespace gradus

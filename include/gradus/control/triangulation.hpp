/// A triangulated surface with what the way of the data needs of it: features, curvature, sizes on a background that
/// resolves them.
#pragma once

#include "gradus/control/background.hpp"
#include "gradus/control/sizing.hpp"
#include "gradus/curvature/estimate.hpp"
#include "gradus/mesh/features.hpp"
#include "gradus/mesh/frozen.hpp"
#include "gradus/mesh/thin_rounds.hpp"
#include "gradus/surface/smooth_support.hpp"

#include <vector>

namespace gradus {

struct TriangulationOptions {
    FeatureOptions features = {};
    bool label_borders = true;   ///< edges between different labels are features
    double least_curvature = 0;  ///< see EstimateOptions
    /// What elements cannot or need not follow: rounds between flat faces, and bends of feature curves between a
    /// straight part and a corner, that leave those by no more than the height, or are no longer than the finest size.
    /// They ask for no sizes, and the middle of such a round is a ridge (ThinRounds). Units of length; the finest size
    /// of a connected part is in proportion to its diagonal if it goes by part.
    double negligible_height = 0, finest = 0;
    bool finest_by_part = false;
};

/// Immutable after construction; not to be moved, as its parts refer to each other.
class Triangulation {
  public:
    /// @throws std::invalid_argument for a soup that is no oriented manifold, has no triangles, no area, no extent or
    /// one below 1e-40, or a
    ///         coordinate that is not finite or beyond 1e40, or for required elements as frozen_elements does
    explicit Triangulation(TriangleSoup soup, const TriangulationOptions& options = {});
    Triangulation(const Triangulation&) = delete;
    Triangulation& operator=(const Triangulation&) = delete;

    const TriangleSoup& soup() const { return soup_; }
    const Connectivity& mesh() const { return mesh_; }
    const Features& features() const { return features_; }
    const Frozen& frozen() const { return frozen_; }  ///< what the soup requires
    const Wedges& wedges() const { return wedges_; }
    const FlatFaces& flats() const { return flats_; }
    const std::vector<WedgeCurvature>& curvature() const { return curvature_; }  ///< one per wedge
    /// The larger principal curvature at each corner of the triangles, absolute: that of its wedge, but of flat faces
    /// none, and of a long strip that ends at a round its own, across it.
    const std::vector<double>& corner_curvature() const { return corner_curvature_; }
    /// Curvature of the feature curve through each vertex, 1 / length; 0 off features and at corners.
    const std::vector<double>& curve_curvature() const { return curve_curvature_; }
    /// The largest of both at a vertex.
    double largest_curvature(int vertex) const;
    double diagonal() const { return diagonal_; }
    /// Diagonal of the connected part of each vertex over that of all; 1 in no triangle.
    const std::vector<double>& part_share() const { return part_share_; }
    /// The smooth surface over it. It must not outlive this.
    SmoothSupport support(const SmoothSupport::Options& options = {}) const;

  private:
    void heed_strips(const PlanarRegions& regions, const ThinRounds& thin, std::span<const int> face,
                     std::span<const Eigen::Vector3d> normals);

    TriangleSoup soup_;
    Connectivity mesh_;
    Features features_;
    Frozen frozen_;
    Wedges wedges_;
    FlatFaces flats_;
    std::vector<WedgeCurvature> curvature_;
    std::vector<double> corner_curvature_, curve_curvature_, part_share_;
    double diagonal_ = 0;
};

/// A background for a triangulation; its first vertices are those of the triangulation, in order, unless it is another
/// mesh that was given.
struct TriangulationBackground {
    Background background;      ///< without patches
    std::vector<double> sizes;  ///< one per vertex, by the rule or as given
    std::vector<int> cells;     ///< for each vertex of the triangulation, and those that came after them, a triangle of
                                ///< the background at it
};

/// Cuts the edges of the triangulation in half where sizes between their ends are not what interpolation says: beside a
/// small round a large flat facet is to have large elements, and where large facets are narrow, small ones. Curvature
/// varies linearly along an edge, on each side of features on its own; clearances are found anew at each cut. At
/// vertices of frozen edges the size is their mean length, though larger than hmax only as far as curvature and
/// clearances allow.
/// @throws std::invalid_argument for a bad rule, or a region whose label no triangle has
TriangulationBackground make_background(const Triangulation& surface, const SizingRule& rule,
                                        int max_triangles = 20'000'000);

/// Sizes by the rule at the vertices of the triangulation, at features the smallest of their sides and of the curve's
/// own, at frozen edges as make_background does.
/// @throws std::invalid_argument for a bad rule, or a region whose label no triangle has
std::vector<double> geometric_sizes(const Triangulation& surface, const SizingRule& rule);

/// The triangulation itself with sizes given at its vertices; at those of frozen edges their mean length takes their
/// place, though it is above the given size only up to .3 of the smallest radius of curvature.
TriangulationBackground make_background(const Triangulation& surface, std::span<const double> sizes);

/// Sizes given at the vertices of another mesh of the same surface, as is where it begins with the vertices of the
/// triangulation, which then know their places in it and heed frozen edges as above; else they are taken to the closest
/// ones.
/// @throws std::invalid_argument for a mesh that is no oriented manifold or has no triangles, a wrong number of sizes,
/// a vertex of the
///         triangulation farther from the mesh than .01 of its diagonal, and where elements are required but the
///         vertices do not come first
TriangulationBackground make_background(const Triangulation& surface, const TriangleSoup& mesh,
                                        std::span<const double> sizes);

/// Sizes of a map at the vertices of another mesh of the same surface, by their closest places; those in no triangle
/// have them too.
/// @throws std::invalid_argument for a vertex of a triangle that is farther from the background than .01 of its
/// diagonal
std::vector<double> sizes_at(const TriangulationBackground& map, const TriangleSoup& mesh);

}  // namespace gradus

/// Size maps from curvature, and the background mesh that resolves them.
#pragma once

#include "gradus/control/background.hpp"
#include "gradus/control/sizing.hpp"

#include <limits>
#include <vector>

namespace gradus {

/// A background mesh with one size per vertex.
struct SizedBackground {
    Background background;
    std::vector<double> sizes;
    double largest_error = 0;  ///< largest |ln(interpolated / exact size)| seen on edges longer than `finest`
    bool resolved = true;      ///< false where max_triangles stopped the refinement
};

struct BackgroundOptions {
    int cells = 10;  ///< edges across a square patch to begin with; fewer of more patches than SurfaceModel::kMany
    double size_tolerance = 0.05;   ///< largest |ln(interpolated / exact size)| at edge middles and centroids
    double chord_tolerance = 0.05;  ///< largest gap between an edge and the surface above its middle, per edge length
    double finest = 1;              ///< edges of at most this metric length are never cut: the mesh could not show more
    int max_triangles = 20'000'000;
    double max_unit_triangles =
        std::numeric_limits<double>::infinity();  ///< refuse sizes for which a unit mesh needs about twice as many
};

/// Meshes every patch with edges of one length, then bisects longest edges, across patches, until the size map is
/// represented. Sizes follow from the minimal radius of curvature of the surface, at curves the smallest of their
/// sides; on creases and boundaries the curvature of the curve counts as well.
/// @throws std::invalid_argument for a bad rule or options
/// @throws std::length_error naming the estimate, made on the first mesh, where max_unit_triangles is far exceeded
SizedBackground make_background(const SurfaceModel& model, const SizingRule& rule,
                                const BackgroundOptions& options = {});

/// A background as facets that stand for the surface.
struct FacetedSurface {
    Background facets;
    double gap =
        0;  ///< no distance of the surface from them is larger that was seen at the middles of edges and triangles
};

/// Cuts a background until gaps are within a tolerance, unit of length.
/// @throws std::length_error where that takes more triangles than max_triangles
FacetedSurface facets_within(const SurfaceModel& model, const Background& background, double tolerance,
                             int max_triangles = 20'000'000);

/// Sizes by the rule at the vertices of a given background (prescribed points included).
std::vector<double> geometric_sizes(const SurfaceModel& model, const Background& background, const SizingRule& rule);

/// Cuts the edges that are too long for their sizes (metric length above `longest`, and more than ln 1.1 apart in
/// size), so that gradation on edges is the largest reduction; sizes of new vertices are exact by the rule. @returns
/// number of cuts
int refine_for_gradation(const SurfaceModel& model, const SizingRule& rule, double longest, SizedBackground& sized,
                         std::vector<double>& graded, int max_triangles = 20'000'000);

}  // namespace gradus

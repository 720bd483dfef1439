/// Curvature of the surface that a triangle mesh stands for, at its vertices, by local fits.
#pragma once

#include "gradus/mesh/features.hpp"

#include <span>
#include <vector>

namespace gradus {

struct EstimateOptions {
    int rings = 2;            ///< neighbours of a fit to begin with, in edges; off features more where few edges meet
    int most_rings = 6;       ///< and at most
    double precision = 0.05;  ///< standard error of the curvature, over itself, above which a fit takes another ring
    /// Curvatures below this, 1 / length, need no precision.
    double least_curvature = 0;
};

/// What is known at a wedge, the one side of a feature or the whole of a vertex.
struct WedgeCurvature {
    double k1 = 0, k2 = 0;  ///< principal, |k1| >= |k2|; positive where the surface bends to the inside
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< unit; zero where nothing could be fitted
    double error = 0;                                  ///< standard error of the larger curvature, from the residuals
    int rings = 0;                                     ///< of the fit that was taken
};

/// A height function is fitted to the vertices some rings around each wedge, none of them beyond a feature, by weighted
/// least squares, not through the vertex itself [Cazals, Pouget 2005]: a cubic, or a quartic where the first rings show
/// it to be clearly better. Its heights z are less k z^2 / 2, so that spheres and cylinders of curvature k are
/// quadratics, however coarse. Noise: rings are added to a cubic until the standard error that the residuals tell is
/// below `precision`. Vertices whose normals are turned by more than 45 degrees are left out, and then no rings are
/// added: no polynomial follows such a round. So the smoothing grows with the noise, over the second power of the
/// edges; without noise errors fall with the third power of the edges where there are 17 vertices in two rings, else
/// with the second. Where few vertices can be had, as beside features, a quadratic is fitted to their places and
/// normals.
/// @param normals  a first guess, one per wedge: wedge_normals()
std::vector<WedgeCurvature> estimate_curvature(std::span<const Eigen::Vector3d> points, const Connectivity& mesh,
                                               const Wedges& wedges, std::span<const Eigen::Vector3d> normals,
                                               const EstimateOptions& options = {});

}  // namespace gradus

/// How fast an isotropic size map changes: over edges, vertices and triangles of its background mesh.
/// Sizes are lengths h > 0; an infinite size means "not set". Source: [Borouchaki 1998, section 3.1].
#pragma once

#include "gradus/control/metric.hpp"
#include "gradus/mesh/tri_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

namespace gradus {

/// H-variation |h_p - h_q| / L of an edge of length L, in [0, inf]; 0 between equal sizes, even where L is 0. [eq. 9]
inline double h_variation(double L, double h_p, double h_q) { return h_p == h_q ? 0 : std::abs(h_q - h_p) / L; }

/// Logarithm of the H-shock of an edge of length L, in [0, inf]; 0 between equal sizes, even where L is 0. [eq. 10]
inline double log_h_shock(double L, double h_p, double h_q) {
    if (h_p == h_q) return 0;
    if (std::isinf(h_p) || std::isinf(h_q)) return std::numeric_limits<double>::infinity();
    return log_size_ratio(std::min(h_p, h_q), std::max(h_p, h_q)) / metric_length(L, h_p, h_q);
}

/// H-shock max(h_p/h_q, h_q/h_p)^(1/l) of an edge of length L, in [1, inf]: how much sizes grow over one unit of metric
/// length, which is the growth rate between successive elements of a unit mesh. [eq. 10]
inline double h_shock(double L, double h_p, double h_q) { return std::exp(log_h_shock(L, h_p, h_q)); }

/// Gradient of the linear interpolant of three sizes over the triangle abc, in its plane; zero for a triangle without
/// area (its edges say what there is to say), infinite where some but not all sizes are.
Eigen::Vector3d size_gradient(const std::array<Eigen::Vector3d, 3>& corners, const std::array<double, 3>& sizes);

/// Largest H-variation, respectively H-shock, of the edges at each vertex. [eq. 11]
/// @throws std::invalid_argument if sizes do not match the vertices or one is not positive
std::vector<double> vertex_variations(const TriMesh& mesh, std::span<const double> size);
std::vector<double> vertex_shocks(const TriMesh& mesh, std::span<const double> size);

/// size_gradient of each triangle. @throws as above
std::vector<Eigen::Vector3d> size_gradients(const TriMesh& mesh, std::span<const double> size);

/// Where x = L ln(beta) / h_small passes this value (the root of x = 4 (1 - e^(-x/2))), a larger h_small allows a
/// *smaller* neighbour: the background mesh is too coarse for its map.
inline constexpr double kCoarseEdge = 3.18724852008008018;

/// Edges of the background mesh that are too coarse for their sizes under an H-shock bound beta > 1. @throws as above
int count_coarse_edges(const TriMesh& mesh, double shock, std::span<const double> size);

struct GradationReport {
    double shock_max = 1;                   ///< largest H-shock of an edge
    std::array<int, 2> shock_edge{-1, -1};  ///< its ends, lower index first; -1 while no edge changes size
    double shock_p999 = 1;                  ///< 99.9 % of the edges have at most this H-shock
    double variation_max = 0;               ///< largest H-variation of an edge
    std::array<int, 2> variation_edge{-1, -1};
    double gradient_max = 0;  ///< largest norm of the gradient of a triangle
    int gradient_triangle = -1;
    double gradient_p999 = 0;
};

/// All measures of a map, in one sweep over edges and one over triangles. Ties go to the lowest index. @throws as above
GradationReport measure_gradation(const TriMesh& mesh, std::span<const double> size);

}  // namespace gradus

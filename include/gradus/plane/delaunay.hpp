/// Triangulates a planar domain so that its edges have length 1 in a metric: an advancing front inside a constrained
/// Delaunay triangulation. [George & Borouchaki, Delaunay Triangulation and Meshing, 1998; Rebay 1993]
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <functional>
#include <vector>

namespace gradus {

/// Region inside closed loops (even-odd), in any order and direction. Fastest when points of a loop follow each other.
/// Points that belong to no segment become vertices too, when they lie inside.
/// A side collapsed to a point (a pole) is one segment, or several, of length below 1e-3: distances to it are measured
/// to the nearest place on it, so that triangles fan out from its points; those on the segment itself are degenerate in
/// space.
struct PlanarDomain {
    std::vector<Eigen::Vector2d> points;
    std::vector<std::array<int, 2>> segments;  ///< of about unit length in the metric, or collapsed
    std::vector<int> hints;                    ///< one per point, first value of the metric's hint; empty: all -1
};

/// Metric M at a point: the wanted length in direction e is 1 / sqrt(e^T M e) for |e| = 1. Symmetric positive definite;
/// it may be semi-definite at the ends of a collapsed side. Called only with points of the domain. `hint` is the
/// caller's: it holds what the call for a nearby point left in it.
using PlaneMetric = std::function<Eigen::Matrix2d(const Eigen::Vector2d& uv, int& hint)>;

struct DelaunayOptions {
    double target = 1;                    ///< wanted length of edges in the metric, > 0
    std::size_t max_points = 50'000'000;  ///< refused above
};

/// What the generator did. Counters of bounds reached are 0 in a sound run.
struct DelaunayStatistics {
    int front_points = 0;         ///< inserted ahead of the front
    int split_points = 0;         ///< inserted into long edges left by fronts that met
    int refused = 0;              ///< candidates too close to a vertex, or outside
    int flips = 0;                ///< before the front starts and in the closing sweeps
    int long_edges = 0;           ///< interior edges above sqrt(2) left as no point fits in their middle
    int lost_walks = 0;           ///< walks given up at their bound (10 000 triangles)
    int unused_points = 0;        ///< points of the domain that lie outside its loops
    bool splits_bounded = false;  ///< splitting stopped at its bound (40 sweeps)
    bool flips_bounded = false;   ///< flipping stopped at its bound (10 flips per edge)
};

struct PlanarMesh {
    std::vector<Eigen::Vector2d> points;        ///< first those of the domain, unchanged
    std::vector<std::array<int, 3>> triangles;  ///< counter-clockwise by exact sign (orient2d)
    std::vector<int> hints;                     ///< one per point, as the metric left them
    DelaunayStatistics statistics;
};

/// Meshes the domain; segments stay as they are. The same input gives the same mesh. Loops end by the packing of points
/// at distances bounded below, by max_points, and by the bounds above.
/// @throws std::invalid_argument for open, repeated, crossing or touching segments, repeated points, a metric that is
/// not finite
///         or has a negative diagonal, options out of range
/// @throws std::length_error when the mesh would have more than max_points points
PlanarMesh mesh_domain(const PlanarDomain& domain, const PlaneMetric& metric, const DelaunayOptions& options = {});

}  // namespace gradus

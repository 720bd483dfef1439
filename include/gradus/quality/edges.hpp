/// Lengths of the edges of a mesh in the metric of a size map: how nearly it is a unit mesh.
#pragma once

#include "gradus/quality/mesh_edges.hpp"
#include "gradus/quality/statistics.hpp"

#include <functional>

namespace gradus {

/// Metric lengths are dimensionless; 1 is wanted.
struct EdgeReport {
    Summary length;
    std::size_t num_short = 0, num_long = 0;  ///< edges below and above [1/sqrt(2), sqrt(2)]
    double unit_share = 0;                    ///< share of edges within [1/sqrt(2), sqrt(2)]
    double short_share = 0;                   ///< below
    double long_share = 0;                    ///< above
    double efficiency = 0;                    ///< exp(mean(min(l, 1/l) - 1)), in (1/e, 1]
    Histogram log2_histogram{-1.5, 1.5, 12};  ///< of log2 of the length; the unit band is [-.5, .5]
    std::vector<EdgeOffender> worst;          ///< metric lengths; largest max(l, 1/l) first
};

struct EdgeOptions {
    std::size_t worst = 10;  ///< how many of the worst edges to list
};

/// Metric length of each edge for sizes that vary geometrically between its ends. [Borouchaki 1998, eq. 7]
/// @param sizes  one per vertex, > 0, may be infinite
/// @throws std::invalid_argument for a size of a used vertex that is not positive, or another number of sizes than
/// vertices
std::vector<double> metric_lengths(const MeshView& mesh, const MeshEdges& edges, std::span<const double> sizes);

/// Size at a point in space. `hint` says where the map was asked last (for instance a triangle of its background mesh,
/// -1: nothing is known) and is updated: with a ControlSpace, [&](const Eigen::Vector3d& p, int& hint) { return
/// space.size(p, hint); }.
using SizeQuery = std::function<double(const Eigen::Vector3d& p, int& hint)>;

/// Metric length of each edge by five Gauss points along it, for a size map that is no part of the mesh.
/// @param hints  one per vertex, to start from on an edge whose smaller vertex it is; empty: each edge starts where the
/// one before it ended
/// @throws std::invalid_argument for a size that is not positive
std::vector<double> metric_lengths(const MeshView& mesh, const MeshEdges& edges, const SizeQuery& size,
                                   std::span<const int> hints = {});

/// @param lengths  metric length of each edge
EdgeReport measure_edges(const MeshEdges& edges, std::span<const double> lengths, const EdgeOptions& options = {});

}  // namespace gradus

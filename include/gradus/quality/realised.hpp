/// Gradation that a mesh has, whatever its size map asked for: the realised size at a vertex is the mean length of its
/// edges.
#pragma once

#include "gradus/quality/mesh_edges.hpp"
#include "gradus/quality/statistics.hpp"

namespace gradus {

struct RealisedGradation {
    Summary size;             ///< over used vertices, unit of length
    Summary shock;            ///< H-shock of the realised sizes over edges, >= 1 [Borouchaki 1998, eq. 10]
    Summary variation;        ///< H-variation over edges, >= 0 [eq. 9]
    Summary neighbour_edges;  ///< over pairs of triangles with a common edge: longest / shortest of their five edges
    Summary neighbour_areas;  ///< over the same pairs: larger / smaller area
    std::vector<EdgeOffender> worst;  ///< edges of the largest shock
};

struct RealisedOptions {
    std::size_t worst = 10;  ///< how many of the worst edges to list
};

/// Mean length of the edges at each vertex, not a number where there is none.
std::vector<double> realised_sizes(const MeshView& mesh, const MeshEdges& edges);

/// Ratios are infinite at edges without length and triangles without area.
/// @param edges  edges_of(mesh)
RealisedGradation measure_realised_gradation(const MeshView& mesh, const MeshEdges& edges,
                                             const RealisedOptions& options = {});

}  // namespace gradus

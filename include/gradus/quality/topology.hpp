/// Counts that say what a triangle mesh is: pieces, holes, handles, and where it is no oriented manifold.
#pragma once

#include "gradus/quality/mesh_edges.hpp"

#include <cstddef>
#include <optional>

namespace gradus {

struct TopologyReport {
    std::size_t vertices = 0;  ///< that a triangle uses
    std::size_t edges = 0;
    std::size_t triangles = 0;   ///< all of them
    std::size_t components = 0;  ///< joined through vertices
    std::size_t boundary_edges = 0;
    std::size_t boundary_loops = 0;        ///< chains of boundary edges; they end at a non-manifold edge
    std::size_t nonmanifold_edges = 0;     ///< more than two triangles
    std::size_t nonmanifold_vertices = 0;  ///< the triangles around it are not one fan
    std::size_t misoriented_edges = 0;     ///< two triangles that run along it in the same direction
    std::size_t unused_vertices = 0;
    std::size_t duplicate_positions = 0;  ///< vertices that lie on an earlier one (to 1e-12 of the extent)
    std::size_t repeated_corners = 0;     ///< triangles that name a vertex twice; they count for nothing else below
    std::size_t bad_points = 0;           ///< coordinates that are not finite
    long long euler = 0;                  ///< vertices - edges + triangles
    std::optional<long long> genus;       ///< handles, summed over components; only for an oriented manifold

    /// Every edge has one or two triangles, every vertex one fan, and neighbours agree in orientation.
    bool oriented_manifold() const {
        return nonmanifold_edges == 0 && nonmanifold_vertices == 0 && misoriented_edges == 0 && repeated_corners == 0;
    }
    bool closed() const { return boundary_edges == 0; }
};

/// @param edges  edges_of(mesh)
TopologyReport measure_topology(const MeshView& mesh, const MeshEdges& edges);

}  // namespace gradus

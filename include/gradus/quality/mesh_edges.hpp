/// The edges of any triangle mesh, manifold or not, with the triangles that use them.
#pragma once

#include "gradus/mesh/tri_mesh.hpp"
#include "gradus/quality/statistics.hpp"

#include <span>
#include <vector>

namespace gradus {

/// A mesh as it is measured. It need not be manifold, so it is no TriMesh.
struct MeshView {
    std::span<const Eigen::Vector3d> points;
    std::span<const Triangle> triangles;
};

/// Undirected edges in lexicographic order. A triangle that names a vertex twice has no edges.
/// The use 3 t + k is the side of triangle t from its corner k to its corner k + 1 (mod 3).
struct MeshEdges {
    std::vector<std::array<int, 2>> ends;  ///< smaller vertex first
    std::vector<int>
        first_use;  ///< uses of edge e are uses[first_use[e]] ... uses[first_use[e + 1] - 1]; size() + 1 entries
    std::vector<int> uses;
    std::vector<int> edge_of;  ///< edge of each use, -1 where the triangle has none

    int size() const { return static_cast<int>(ends.size()); }
    int num_uses(int edge) const { return first_use[edge + 1] - first_use[edge]; }
    std::span<const int> uses_of(int edge) const { return std::span(uses).subspan(first_use[edge], num_uses(edge)); }
};

/// Linear in the size of the mesh for bounded valence.
/// @throws std::invalid_argument naming the first triangle with an index out of range
MeshEdges edges_of(const MeshView& mesh);

/// Something bad about an edge.
struct EdgeOffender {
    std::array<int, 2> ends{-1, -1};
    double value = 0;
};

/// Names edges by their ends rather than by their index.
std::vector<EdgeOffender> by_ends(const MeshEdges& edges, std::span<const Offender> offenders);

}  // namespace gradus

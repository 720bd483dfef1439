/// The vertices and edges of a mesh as compact adjacency, and the checks every gradation starts with.
#pragma once

#include "gradus/mesh/tri_mesh.hpp"

#include <span>
#include <string>
#include <vector>

namespace gradus::detail {

/// Calls visit(index, a, b, length) for each edge of the mesh in index order, a = from of its first half-edge.
template <class Visit>
void for_each_edge(const TriMesh& mesh, Visit visit) {
    const Eigen::Vector3d* points = mesh.points();
    const int n = static_cast<int>(mesh.n_edges());
    for (int e = 0; e < n; ++e) {
        const int a = mesh.to_vertex_handle(OpenMesh::HalfedgeHandle(2 * e + 1)).idx();
        const int b = mesh.to_vertex_handle(OpenMesh::HalfedgeHandle(2 * e)).idx();
        visit(e, a, b, (points[a] - points[b]).norm());
    }
}

struct Arc {
    double length;
    int to;
    int edge;
};

/// Arcs of vertex v are arcs[first[v]] .. arcs[first[v + 1]], by rising edge index.
struct VertexGraph {
    std::vector<int> first;
    std::vector<Arc> arcs;

    std::span<const Arc> at(int v) const { return {arcs.data() + first[v], arcs.data() + first[v + 1]}; }
};

VertexGraph make_vertex_graph(const TriMesh& mesh);

/// @throws std::invalid_argument naming `function` if sizes do not match the vertices or one is not positive (or NaN)
void require_sizes(std::size_t vertices, std::span<const double> size, const char* function);
inline void require_sizes(const TriMesh& mesh, std::span<const double> size, const char* function) {
    require_sizes(mesh.n_vertices(), size, function);
}

/// @throws std::invalid_argument naming `function` and value unless value > above (and finite)
void require_above(double value, double above, const char* what, const char* function);

/// One flag per vertex, or empty if nothing is required.
/// @throws std::invalid_argument for an index that is no vertex, or one whose size is not set
std::vector<char> required_flags(const TriMesh& mesh, std::span<const double> size, std::span<const int> required,
                                 const char* function);

}  // namespace gradus::detail

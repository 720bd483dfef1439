#include "gradus/mesh/tri_mesh.hpp"

#include <stdexcept>
#include <string>

namespace gradus {

TriMesh make_mesh(std::span<const Eigen::Vector3d> points, std::span<const Triangle> triangles) {
    TriMesh mesh;
    mesh.reserve(points.size(), points.size() + triangles.size(), triangles.size());
    for (const Eigen::Vector3d& p : points) mesh.add_vertex(p);
    const int n = static_cast<int>(points.size());
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const auto& [a, b, c] = triangles[t];
        const bool valid = a >= 0 && b >= 0 && c >= 0 && a < n && b < n && c < n && a != b && b != c && c != a;
        if (!valid) throw std::invalid_argument("make_mesh: triangle " + std::to_string(t) + " has a bad or repeated vertex index");
        // Tested before add_face, which prints to stderr when it refuses.
        for (const auto& [from, to] : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}}) {
            const auto from_vertex = mesh.vertex_handle(from), to_vertex = mesh.vertex_handle(to);
            const auto edge = mesh.find_halfedge(from_vertex, to_vertex);
            if (edge.is_valid() && !mesh.is_boundary(edge))
                throw std::invalid_argument("make_mesh: triangle " + std::to_string(t) + " makes edge " + std::to_string(from) + "-" +
                                            std::to_string(to) + " non-manifold or wrongly oriented");
            if (!mesh.is_boundary(from_vertex))
                throw std::invalid_argument("make_mesh: triangle " + std::to_string(t) + " makes vertex " + std::to_string(from) + " non-manifold");
        }
        if (!mesh.add_face(mesh.vertex_handle(a), mesh.vertex_handle(b), mesh.vertex_handle(c)).is_valid())
            throw std::invalid_argument("make_mesh: triangle " + std::to_string(t) + " makes a vertex non-manifold");
    }
    return mesh;
}

std::vector<Triangle> triangles_of(const TriMesh& mesh) {
    std::vector<Triangle> triangles(mesh.n_faces());
    for (const auto face : mesh.faces()) {
        int k = 0;
        for (const auto vertex : face.vertices()) triangles[face.idx()][k++] = vertex.idx();
    }
    return triangles;
}

std::span<const Eigen::Vector3d> points_of(const TriMesh& mesh) { return {mesh.points(), mesh.n_vertices()}; }

}  // namespace gradus

#include "gradus/mesh/tri_mesh.hpp"

#include "gradus/mesh/connectivity.hpp"

#include <stdexcept>

namespace gradus {

TriMesh make_mesh(std::span<const Eigen::Vector3d> points, std::span<const Triangle> triangles) {
    // Checked before add_face, which prints to stderr when it refuses.
    const Connectivity check(static_cast<int>(points.size()), triangles);
    TriMesh mesh;
    mesh.reserve(points.size(), points.size() + triangles.size(), triangles.size());
    for (const Eigen::Vector3d& p : points) mesh.add_vertex(p);
    for (const auto& [a, b, c] : triangles)
        if (!mesh.add_face(mesh.vertex_handle(a), mesh.vertex_handle(b), mesh.vertex_handle(c)).is_valid())
            throw std::logic_error("make_mesh: OpenMesh refuses a manifold triangle");
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

#include "gradus/mesh/tri_mesh.hpp"

#include "gradus/mesh/connectivity.hpp"

namespace gradus {

// Fills the kernel from checked connectivity: several times faster than add_face, which searches for every edge.
TriMesh make_mesh(std::span<const Eigen::Vector3d> points, std::span<const Triangle> triangles) {
    const Connectivity connectivity(static_cast<int>(points.size()), triangles);
    const int num_halfedges = 3 * connectivity.num_triangles();
    TriMesh mesh;
    mesh.reserve(points.size(), points.size() + triangles.size(), triangles.size());
    for (const Eigen::Vector3d& p : points) mesh.add_vertex(p);

    std::vector<OpenMesh::HalfedgeHandle> handle(num_halfedges);
    for (int h = 0; h < num_halfedges; ++h) {
        const int twin = connectivity.twin(h);
        if (twin >= 0 && twin < h)
            handle[h] = mesh.opposite_halfedge_handle(handle[twin]);
        else
            handle[h] =
                mesh.new_edge(mesh.vertex_handle(connectivity.origin(h)), mesh.vertex_handle(connectivity.target(h)));
    }
    std::vector<OpenMesh::HalfedgeHandle> border_from(points.size());  // the border half-edge that leaves a vertex
    for (int h = 0; h < num_halfedges; h += 3) {
        const auto face = mesh.new_face();
        // OpenMesh starts to count corners where this half-edge ends.
        mesh.set_halfedge_handle(face, handle[h + 2]);
        for (int e = h; e < h + 3; ++e) {
            mesh.set_face_handle(handle[e], face);
            mesh.set_next_halfedge_handle(handle[e], handle[Connectivity::next(e)]);
            mesh.set_halfedge_handle(mesh.vertex_handle(connectivity.origin(e)), handle[e]);
            if (connectivity.twin(e) < 0)
                border_from[connectivity.target(e)] = mesh.opposite_halfedge_handle(handle[e]);
        }
    }
    for (std::size_t v = 0; v < points.size(); ++v) {
        if (!border_from[v].is_valid()) continue;
        mesh.set_next_halfedge_handle(border_from[v], border_from[mesh.to_vertex_handle(border_from[v]).idx()]);
        mesh.set_halfedge_handle(mesh.vertex_handle(static_cast<unsigned>(v)), border_from[v]);
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

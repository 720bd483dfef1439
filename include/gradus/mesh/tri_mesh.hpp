/// The triangle mesh that gradus passes around: an OpenMesh kernel with points in double precision.
#pragma once

// The kernel must come before EigenVectorT.
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
// (kept apart so that formatting does not reorder the two)
#include <OpenMesh/Core/Geometry/EigenVectorT.hh>

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

namespace gradus {

struct TriMeshTraits : OpenMesh::DefaultTraits {
    using Point = Eigen::Vector3d;
    using Normal = Eigen::Vector3d;
};

using TriMesh = OpenMesh::TriMesh_ArrayKernelT<TriMeshTraits>;

/// Vertex indices of a triangle, counter-clockwise seen from the outside.
using Triangle = std::array<int, 3>;

/// Builds a mesh whose vertices and faces have the indices of `points` and `triangles`.
/// @throws std::invalid_argument naming the first triangle with a bad or repeated index, else an edge or a vertex that
/// is
///         not manifold or not consistently oriented
TriMesh make_mesh(std::span<const Eigen::Vector3d> points, std::span<const Triangle> triangles);

/// Vertex indices of each face, in face order; corner 0 is the one the face was added with.
std::vector<Triangle> triangles_of(const TriMesh& mesh);

/// Points in vertex order.
std::span<const Eigen::Vector3d> points_of(const TriMesh& mesh);

}  // namespace gradus

/// Indexed triangles as a file holds them, before anything is known of their topology.
#pragma once

#include <string>
#include <vector>

#include "gradus/mesh/tri_mesh.hpp"

namespace gradus {

/// Where a vertex lies on a parametric surface: a patch of the model and parameters in its domain.
struct SurfacePoint {
    int patch = -1;
    Eigen::Vector2d uv{0, 0};
};

/// What a mesh of the same surface must keep as it is, by index. A triangle keeps its edges and vertices, an edge its
/// vertices.
struct RequiredElements {
    std::vector<int> vertices = {};              ///< stay vertices, where they are
    std::vector<std::array<int, 2>> edges = {};  ///< stay edges between the same two points
    std::vector<int> triangles = {};             ///< stay triangles of the same three points

    bool empty() const { return vertices.empty() && edges.empty() && triangles.empty(); }
    bool operator==(const RequiredElements&) const = default;
};

/// Triangles of a file with what came along. Polygons are split into fans by the readers.
struct TriangleSoup {
    std::vector<Eigen::Vector3d> points;
    std::vector<Triangle> triangles;
    std::vector<int> labels = {};  ///< one per triangle (Medit reference, patch), or empty

    /// Parameters of a vertex on a patch; a vertex on a shared curve has one entry per patch. May be empty.
    struct Parameters {
        int vertex;
        SurfacePoint at;
    };
    std::vector<Parameters> parameters = {};

    std::vector<std::array<int, 2>> edges = {};  ///< feature edges, or empty
    std::vector<int> edge_labels = {};  ///< one per feature edge (Medit reference, marker of a segment), or empty
    std::vector<int> corners = {};      ///< vertices that are feature corners, or empty
    RequiredElements required = {};     ///< what remeshing does not touch
    int dimension = 3;                  ///< 2: of the plane, z is 0
};

/// Of the box around the corners of its triangles; 0 without any.
double diagonal_of(const TriangleSoup& soup);

/// Numbers that ride along on the points or the triangles of a soup.
struct Field {
    std::string name;
    int components = 1;               ///< numbers per point or triangle, >= 1
    std::vector<double> values = {};  ///< components of the first, of the second ...; not-a-number where there is none
    bool integer = false;             ///< the file says so; what is not one is written as a real number
};

/// A soup with its fields. The pieces of a split polygon have its values each.
struct MeshData {
    TriangleSoup soup;
    std::vector<Field> point_fields = {}, cell_fields = {};
};

}  // namespace gradus

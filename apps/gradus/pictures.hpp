/// Pictures of a mesh: the whole of it, what it was made for, and enlargements where sizes change most.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "gradus/io/image.hpp"
#include "gradus/io/picture.hpp"
#include "gradus/remesh/surface_mesh.hpp"

namespace gradus::app {

struct Picture {
    std::string name;  ///< of the file, without extension
    std::string title;
    Image image;
};

/// Cameras that look where the sizes of a mesh differ most over a short way, from where nothing stands before them; on
/// different parts of the mesh, or far apart on one.
std::vector<Camera> enlargements(const SurfaceMesh& mesh, int count);

/// The mesh, its feature edges heavy.
Image draw(const SurfaceMesh& mesh, const Camera& camera = {});

/// A size map: triangles with a size at each vertex.
struct SizedTriangles {
    std::span<const Eigen::Vector3d> points;
    std::span<const Triangle> triangles;
    std::span<const double> sizes;
};
enum class Quantity { Size, Shock };
/// Coloured by size, or by the H-shock of the sizes, on a logarithmic scale.
Image draw(const SizedTriangles& map, Quantity quantity, const std::optional<Range>& range = {});

/// Whole, sizes, two enlargements; with the input, where that is a triangulation, the same of it before: whole, and the
/// enlargements.
std::vector<Picture> pictures_of(const SurfaceMesh& mesh, const std::optional<DrawnMesh>& input = {});

}  // namespace gradus::app

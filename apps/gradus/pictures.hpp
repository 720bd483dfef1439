/// Pictures of a mesh: the whole of it, what it was made for, and enlargements where sizes change most.
#pragma once

#include <string>
#include <vector>

#include "gradus/io/image.hpp"
#include "gradus/io/picture.hpp"
#include "gradus/remesh/surface_mesh.hpp"

namespace gradus::app {

struct Picture {
    std::string name;   ///< of the file, without extension
    std::string title;
    Image image;
};

/// Cameras that look where the sizes of a mesh differ most over a short way, from where nothing stands before them; on different parts of
/// the mesh, or far apart on one.
std::vector<Camera> enlargements(const SurfaceMesh& mesh, int count);

enum class Show {
    Edges,  ///< the mesh
    Size,   ///< coloured by size
    Shock   ///< coloured by the H-shock of the sizes
};
Image draw(const SurfaceMesh& mesh, const Camera& camera, Show show, const std::optional<Range>& range = {});

/// H-shocks of the sizes at the vertices of a mesh.
std::vector<double> shocks_of(const SurfaceMesh& mesh);

/// Whole, sizes, two enlargements.
std::vector<Picture> pictures_of(const SurfaceMesh& mesh);

}  // namespace gradus::app

/// Meshes of a surface as files.
#pragma once

#include <string>
#include <vector>

#include "gradus/control/control_space.hpp"
#include "gradus/quality/report.hpp"
#include "gradus/remesh/surface_mesh.hpp"

namespace gradus::app {

/// Labels are patches, from 1; vertices come with their parameters; feature edges.
TriangleSoup soup_of(const SurfaceMesh& mesh);

/// Writes a mesh in the format of the extension. `.vtu` has the fields size, shock, minimal_radius, curvature (at
/// vertices), quality (area-length) and patch (from 1).
/// @param labels  of the patches; none: they are numbered from 1
void write_surface_mesh(const std::string& path, const SurfaceModel& model, const SurfaceMesh& mesh,
                        std::span<const int> labels = {});

/// The same for a mesh of a triangulation, whose patches are labels where it has any; `.vtu` without curvature. With
/// fields where the format holds some.
void write_surface_mesh(const std::string& path, const SurfaceMesh& mesh, bool labelled,
                        const std::vector<Field>& point_fields, const std::vector<Field>& cell_fields);

/// Everything there is to measure. @param control  size map the mesh was made for
MeshReport measure_surface_mesh(const SurfaceModel& model, const SurfaceMesh& mesh, const ControlSpace& control);

/// Worst and mean area-length, for a line of text.
struct Shape {
    double worst = 1, mean = 0;
};
Shape shape_of(const SurfaceMesh& mesh);
/// Its elements short of the limits, against its own features and sizes.
OffenderReport offenders_of(const SurfaceMesh& mesh);

}  // namespace gradus::app

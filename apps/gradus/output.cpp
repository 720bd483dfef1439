#include "output.hpp"

#include <algorithm>

#include "files.hpp"
#include "gradus/curvature/principal.hpp"
#include "gradus/gradation/measures.hpp"
#include "gradus/io/mesh_files.hpp"
#include "gradus/io/vtu.hpp"
#include "gradus/quality/shape.hpp"

namespace gradus::app {

namespace {

std::vector<double> qualities_of(const SurfaceMesh& mesh) {
    std::vector<double> quality;
    for (const Triangle& t : mesh.triangles)
        quality.push_back(area_length(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]));
    return quality;
}

void write_fields(const std::string& path, const SurfaceModel& model, const SurfaceMesh& mesh) {
    const std::vector<double> shock = vertex_shocks(make_mesh(mesh.points, mesh.triangles), mesh.sizes),
                              quality = qualities_of(mesh);
    std::vector<double> radius, curvature, patch(mesh.patches.begin(), mesh.patches.end());
    for (const SurfacePoint& at : mesh.places) {
        radius.push_back(minimal_radius(model.patch(at.patch), at.uv));
        curvature.push_back(1 / radius.back());
    }
    for (double& p : patch) ++p;
    write_vtu(
        path, mesh.points, mesh.triangles,
        {{"size", 1, mesh.sizes}, {"shock", 1, shock}, {"minimal_radius", 1, radius}, {"curvature", 1, curvature}},
        {{"quality", 1, quality}, {"patch", 1, patch}});
}

}  // namespace

TriangleSoup soup_of(const SurfaceMesh& mesh) {
    TriangleSoup soup;
    soup.points = mesh.points;
    soup.triangles = mesh.triangles;
    for (const int patch : mesh.patches) soup.labels.push_back(patch + 1);
    for (std::size_t v = 0; v < mesh.places.size(); ++v)
        soup.parameters.push_back({static_cast<int>(v), mesh.places[v]});
    soup.edges = mesh.features;
    return soup;
}

void write_surface_mesh(const std::string& path, const SurfaceModel& model, const SurfaceMesh& mesh,
                        std::span<const int> labels) {
    if (extension_of(path) == ".vtu")
        write_fields(path, model, mesh);
    else {
        TriangleSoup soup = soup_of(mesh);
        if (!labels.empty()) {
            for (std::size_t t = 0; t < mesh.patches.size(); ++t) soup.labels[t] = labels[mesh.patches[t]];
            // A file with places on patches has patches as labels.
            soup.parameters.clear();
        }
        write_mesh(path, soup);
    }
}

void write_surface_mesh(const std::string& path, const SurfaceMesh& mesh, bool labelled,
                        const std::vector<Field>& point_fields, const std::vector<Field>& cell_fields) {
    MeshData data{{mesh.points, mesh.triangles}};
    data.soup.dimension = mesh.dimension;
    if (labelled) data.soup.labels = mesh.patches;
    const bool with_own = extension_of(path) == ".vtu";
    if (with_own) {
        data.point_fields = {{"size", 1, mesh.sizes},
                             {"shock", 1, vertex_shocks(make_mesh(mesh.points, mesh.triangles), mesh.sizes)}};
        data.cell_fields = {{"quality", 1, qualities_of(mesh)}};
    } else {
        data.soup.edges = mesh.features;
        data.soup.edge_labels = mesh.feature_labels;
        data.soup.required = mesh.required;
    }
    if (holds_fields(path)) {
        data.point_fields.insert(data.point_fields.end(), point_fields.begin(), point_fields.end());
        data.cell_fields.insert(data.cell_fields.end(), cell_fields.begin(), cell_fields.end());
    }
    write_mesh_data(path, data);
}

MeshReport measure_surface_mesh(const SurfaceModel& model, const SurfaceMesh& mesh, const ControlSpace& control) {
    std::vector<int> cells;
    for (const SurfacePoint& at : mesh.places) cells.push_back(control.locate(at));
    const KnownFeatures features{.edges = mesh.features};
    MeasureOptions options;
    options.sizes = mesh.sizes;
    options.features = &features;
    options.size = [&](const Eigen::Vector3d& p, int& cell) { return control.size(p, cell); };
    options.size_hints = cells;
    options.model = &model;
    options.places = mesh.places;
    options.patches = mesh.patches;
    return measure({mesh.points, mesh.triangles}, options);
}

OffenderReport offenders_of(const SurfaceMesh& mesh) {
    const KnownFeatures features{.edges = mesh.features};
    return find_offenders({mesh.points, mesh.triangles},
                          {.sizes = mesh.sizes, .features = &features, .required = &mesh.required});
}

Shape shape_of(const SurfaceMesh& mesh) {
    Shape shape;
    for (const Triangle& t : mesh.triangles) {
        const double q = area_length(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]);
        shape.worst = std::min(shape.worst, q);
        shape.mean += q / static_cast<double>(mesh.triangles.size());
    }
    return shape;
}

}  // namespace gradus::app

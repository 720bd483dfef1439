#include "output.hpp"

#include <algorithm>

#include "files.hpp"
#include "gradus/curvature/principal.hpp"
#include "gradus/gradation/measures.hpp"
#include "gradus/io/mesh_files.hpp"
#include "gradus/quality/shape.hpp"

namespace gradus::app {

namespace {

std::vector<double> qualities_of(const SurfaceMesh& mesh) {
    std::vector<double> quality;
    for (const Triangle& t : mesh.triangles)
        quality.push_back(area_length(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]));
    return quality;
}

// What `.vtu` shows of every mesh.
MeshData with_own_fields(const SurfaceMesh& mesh) {
    MeshData data{{.points = mesh.points, .triangles = mesh.triangles}};
    data.point_fields = {{"size", 1, mesh.sizes},
                         {"shock", 1, vertex_shocks(make_mesh(mesh.points, mesh.triangles), mesh.sizes)}};
    data.cell_fields = {{"quality", 1, qualities_of(mesh)}};
    return data;
}

void add_curvature(const SurfaceModel& model, const SurfaceMesh& mesh, MeshData& data) {
    std::vector<double> radius, curvature, patch;
    for (const SurfacePoint& at : mesh.places) {
        radius.push_back(minimal_radius(model.patch(at.patch), at.uv));
        curvature.push_back(1 / radius.back());
    }
    for (const int p : mesh.patches) patch.push_back(p + 1);
    data.point_fields.push_back({"minimal_radius", 1, std::move(radius)});
    data.point_fields.push_back({"curvature", 1, std::move(curvature)});
    data.cell_fields.push_back({"patch", 1, std::move(patch)});
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
    const bool is_vtu = extension_of(path) == ".vtu";
    MeshData data = is_vtu ? with_own_fields(mesh) : MeshData{};
    data.soup = soup_of(mesh);
    if (!labels.empty()) {
        for (std::size_t t = 0; t < mesh.patches.size(); ++t) data.soup.labels[t] = labels[mesh.patches[t]];
        // A file with places on patches has patches as labels.
        data.soup.parameters.clear();
    }
    if (is_vtu) add_curvature(model, mesh, data);
    // Patches are no labels in .ply, which few readers take them from.
    labels.empty() && !is_vtu ? write_mesh(path, data.soup) : write_mesh_data(path, data);
}

void write_surface_mesh(const std::string& path, const SurfaceMesh& mesh, bool labelled,
                        const std::vector<Field>& point_fields, const std::vector<Field>& cell_fields) {
    MeshData data = extension_of(path) == ".vtu" ? with_own_fields(mesh)
                                                 : MeshData{{.points = mesh.points, .triangles = mesh.triangles}};
    data.soup.dimension = mesh.dimension;
    if (labelled) data.soup.labels = mesh.patches;
    data.soup.edges = mesh.features;
    data.soup.edge_labels = mesh.feature_labels;
    data.soup.required = mesh.required;
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

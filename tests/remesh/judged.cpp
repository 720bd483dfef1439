#include "remesh/judged.hpp"

#include "gradus/surface/locate.hpp"

#include <algorithm>
#include <numbers>
#include <set>

namespace gradus::testing {

namespace {

/// True where the place lies on a curve of its patch that is a feature.
bool on_feature(const SurfaceModel& model, const SurfacePoint& at) {
    const auto border = model.border_at(at, 1e-15);
    return std::any_of(border.begin(), border.end(), [&](const auto& on) { return is_feature(model, on.use.curve); });
}

bool has_place_on_feature(const SurfaceModel& model, const SurfacePoint& at) {
    const auto places = places_of(model, at);
    return std::any_of(places.begin(), places.end(),
                       [&](const SurfacePoint& place) { return on_feature(model, place); });
}

/// Direction in which a curve leaves one of its ends.
Eigen::Vector3d leaving(const SurfaceModel& model, int curve, bool from_end) {
    const auto point = [&](double t) { return model.position(model.on_curve(curve, 0, t)); };
    return (from_end ? Eigen::Vector3d(point(1 - 1e-6) - point(1)) : Eigen::Vector3d(point(1e-6) - point(0)))
        .normalized();
}

/// Vertices where feature curves end or meet, other than two that continue each other.
std::vector<int> corners_of(const SurfaceModel& model) {
    std::vector<std::vector<Eigen::Vector3d>> directions(model.vertices().size());
    for (int c = 0; c < static_cast<int>(model.curves().size()); ++c)
        if (is_feature(model, c))
            for (const bool end : {false, true})
                directions[model.curves()[c].ends[end]].push_back(leaving(model, c, end));
    std::vector<int> corners;
    for (int v = 0; v < static_cast<int>(directions.size()); ++v) {
        const auto& d = directions[v];
        if (d.empty() || (d.size() == 2 && d[0].dot(d[1]) < -0.95)) continue;
        corners.push_back(v);
    }
    return corners;
}

Eigen::Vector3d unit_normal(const SurfaceMesh& mesh, int t) {
    const Triangle& v = mesh.triangles[t];
    return (mesh.points[v[1]] - mesh.points[v[0]]).cross(mesh.points[v[2]] - mesh.points[v[0]]).normalized();
}

}  // namespace

bool is_feature(const SurfaceModel& model, int curve) {
    const CurveKind kind = model.curves()[curve].kind;
    return kind == CurveKind::Boundary || kind == CurveKind::Crease;
}

Judged judge(const models::Kind& kind, const SurfaceModel& model, RemeshResult result) {
    Judged judged;
    judged.mesh = std::move(result.mesh);
    judged.statistics = std::move(result.statistics);
    const SurfaceMesh& mesh = judged.mesh;
    const MeshView view{mesh.points, mesh.triangles};
    judged.report =
        measure(view, {.sizes = mesh.sizes, .model = &model, .places = mesh.places, .patches = mesh.patches});
    for (const Triangle& t : mesh.triangles)
        judged.area += (mesh.points[t[1]] - mesh.points[t[0]]).cross(mesh.points[t[2]] - mesh.points[t[0]]).norm() / 2;
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
        judged.misplaced += mesh.points[v] != model.position(mesh.places[v]);
        if (kind.off_surface) judged.off_surface = std::max(judged.off_surface, kind.off_surface(mesh.points[v]));
    }

    std::set<std::array<int, 2>> features;
    for (const auto& [a, b] : mesh.features) {
        features.insert({std::min(a, b), std::max(a, b)});
        judged.feature_length += (mesh.points[a] - mesh.points[b]).norm();
        for (const int v : {a, b}) judged.stray_features += !has_place_on_feature(model, mesh.places[v]);
    }
    const MeshEdges edges = edges_of(view);
    for (int e = 0; e < edges.size(); ++e) {
        if (features.count(edges.ends[e])) continue;
        const auto uses = edges.uses_of(e);
        if (uses.size() != 2)
            ++judged.missing_boundary;
        else {
            const double cosine = unit_normal(mesh, uses[0] / 3).dot(unit_normal(mesh, uses[1] / 3));
            judged.turned = std::max(judged.turned, std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi);
        }
    }
    const auto key = [](const Eigen::Vector3d& p) { return std::array{p.x(), p.y(), p.z()}; };
    std::set<std::array<double, 3>> points;
    for (const Eigen::Vector3d& p : mesh.points) points.insert(key(p));
    for (int c = 0; c < static_cast<int>(model.curves().size()); ++c)
        if (is_feature(model, c)) judged.curve_length += model.curves()[c].length;
    for (const int v : corners_of(model)) judged.missing_corners += !points.count(key(model.vertices()[v].point));
    return judged;
}

Judged remesh_and_judge(const models::Kind& kind, const SurfaceModel& model, const SizedBackground& sized,
                        const RemeshOptions& options) {
    return judge(kind, model, remesh(model, ControlSpace(sized.background, sized.sizes), options));
}

}  // namespace gradus::testing

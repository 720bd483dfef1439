#include "gradus/quality/distance.hpp"

#include "gradus/surface/locate.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace gradus {

namespace {

/// The places of each vertex on every patch that has it.
class VertexPlaces {
  public:
    VertexPlaces(const SurfaceModel& model, const PlacedMesh& placed)
        : places_(placed.places), shared_index_(placed.places.size(), -1) {
        if (placed.places.size() != placed.mesh.points.size())
            throw std::invalid_argument("measure_distance: " + std::to_string(placed.places.size()) + " places for " +
                                        std::to_string(placed.mesh.points.size()) + " vertices");
        if (!placed.patches.empty() && placed.patches.size() != placed.mesh.triangles.size())
            throw std::invalid_argument("measure_distance: " + std::to_string(placed.patches.size()) + " patches for " +
                                        std::to_string(placed.mesh.triangles.size()) + " triangles");
        used_.assign(places_.size(), 0);
        for (const Triangle& t : placed.mesh.triangles)
            for (const int v : t) used_[v] = 1;
        for (std::size_t v = 0; v < places_.size(); ++v) {
            if (!used_[v]) continue;
            if (places_[v].patch < 0 || places_[v].patch >= model.num_patches())
                throw std::invalid_argument("measure_distance: vertex " + std::to_string(v) + " is on patch " +
                                            std::to_string(places_[v].patch));
            std::vector<SurfacePoint> all = places_of(model, places_[v]);
            int along = 0;
            if (all.size() == 1 && !on_pole(model, places_[v], along)) continue;
            shared_index_[v] = static_cast<int>(shared_.size());
            shared_.push_back(std::move(all));
        }
    }

    bool used(int vertex) const { return used_[vertex]; }
    /// True for the vertices that lie on a side of a patch shared with another one, or on a pole.
    bool shared(int vertex) const { return shared_index_[vertex] >= 0; }
    const SurfacePoint& own(int vertex) const { return places_[vertex]; }
    std::span<const SurfacePoint> all(int vertex) const {
        if (!shared(vertex)) return places_.subspan(vertex, 1);
        return shared_[shared_index_[vertex]];
    }
    bool has(int vertex, int patch) const {
        const std::span<const SurfacePoint> list = all(vertex);
        return std::any_of(list.begin(), list.end(), [&](const SurfacePoint& at) { return at.patch == patch; });
    }
    /// Patches that have all of the vertices, in the order of the places of the first.
    std::vector<int> common_patches(std::span<const int> vertices) const {
        std::vector<int> patches;
        for (const SurfacePoint& at : all(vertices[0])) {
            const bool everywhere =
                std::all_of(vertices.begin(), vertices.end(), [&](int v) { return has(v, at.patch); });
            if (everywhere && std::find(patches.begin(), patches.end(), at.patch) == patches.end())
                patches.push_back(at.patch);
        }
        return patches;
    }

  private:
    std::span<const SurfacePoint> places_;
    std::vector<char> used_;
    std::vector<int> shared_index_;
    std::vector<std::vector<SurfacePoint>> shared_;
};

/// Mean of the parameters of some vertices on a patch that has them all. On a seam each takes the side where the others
/// are; on a pole the parameter without meaning is that of the others.
Eigen::Vector2d mean_parameters(const SurfaceModel& model, const VertexPlaces& places, std::span<const int> vertices,
                                int patch) {
    std::vector<std::vector<SurfacePoint>> choices;
    for (const int v : vertices) {
        std::vector<SurfacePoint>& list = choices.emplace_back();
        for (const SurfacePoint& at : places.all(v))
            if (at.patch == patch) list.push_back(at);
    }
    std::size_t reference = 0;
    for (std::size_t i = 0; i < choices.size(); ++i)
        if (choices[i].size() < choices[reference].size()) reference = i;
    const Eigen::Vector2d near = choices[reference][0].uv;

    Eigen::Vector2d sum(0, 0), count(0, 0);
    for (const std::vector<SurfacePoint>& list : choices) {
        const SurfacePoint& at =
            *std::min_element(list.begin(), list.end(), [&](const SurfacePoint& a, const SurfacePoint& b) {
                return (a.uv - near).squaredNorm() < (b.uv - near).squaredNorm();
            });
        int meaningless = -1;
        on_pole(model, at, meaningless);
        for (int k = 0; k < 2; ++k) {
            if (k == meaningless) continue;
            sum[k] += at.uv[k];
            count[k] += 1;
        }
    }
    for (int k = 0; k < 2; ++k) sum[k] = count[k] > 0 ? sum[k] / count[k] : near[k];
    return sum;
}

/// Distance of the mean of some vertices of the mesh to the surface.
double distance_of_mean(const SurfaceModel& model, const PlacedMesh& placed, const VertexPlaces& places,
                        std::span<const int> vertices) {
    Eigen::Vector3d point(0, 0, 0);
    for (const int v : vertices) point += placed.mesh.points[v];
    point /= static_cast<double>(vertices.size());

    const int patch = places.own(vertices[0]).patch;
    const bool inside = std::all_of(vertices.begin(), vertices.end(),
                                    [&](int v) { return !places.shared(v) && places.own(v).patch == patch; });
    double best = std::numeric_limits<double>::infinity();
    if (inside) {
        Eigen::Vector2d mean(0, 0);
        for (const int v : vertices) mean += places.own(v).uv;
        best = project(model, point, {patch, mean / static_cast<double>(vertices.size())}).distance;
    } else {
        for (const int common : places.common_patches(vertices))
            best = std::min(best,
                            project(model, point, {common, mean_parameters(model, places, vertices, common)}).distance);
    }
    // No common patch, or a foot so far off that the search must have gone astray: descend from the corners.
    constexpr double kAstray = .25;
    double extent = 0;
    for (const int v : vertices) extent = std::max(extent, (placed.mesh.points[v] - point).norm());
    if (best <= kAstray * extent) return best;
    for (const int v : vertices)
        for (const SurfacePoint& at : places.all(v)) best = std::min(best, project(model, point, at).distance);
    return best;
}

constexpr double kDegrees = 180 / std::numbers::pi;

double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return kDegrees * std::atan2(a.cross(b).norm(), a.dot(b));
}

/// Outward normals of the surface at vertices, computed once where a vertex is inside a patch.
class VertexNormals {
  public:
    VertexNormals(const SurfaceModel& model, const VertexPlaces& places, std::size_t num_vertices)
        : model_(model), places_(places), inside_(num_vertices) {
        for (std::size_t i = 0; i < num_vertices; ++i) {
            const int v = static_cast<int>(i);
            if (places.used(v) && !places.shared(v)) inside_[i] = model.normal(places.own(v));
        }
    }

    /// Angle to the nearest normal that the vertex has on one of the patches; on any patch if it is on none of them.
    double angle(int vertex, const Eigen::Vector3d& normal, std::span<const int> patches) const {
        if (!places_.shared(vertex)) return angle_between(normal, inside_[vertex]);
        const auto wanted = [&](const SurfacePoint& at) {
            return std::find(patches.begin(), patches.end(), at.patch) != patches.end();
        };
        const std::span<const SurfacePoint> all = places_.all(vertex);
        const bool any = std::none_of(all.begin(), all.end(), wanted);
        double smallest = 180;
        for (const SurfacePoint& at : all)
            if (any || wanted(at)) smallest = std::min(smallest, angle_between(normal, model_.normal(at)));
        return smallest;
    }

  private:
    const SurfaceModel& model_;
    const VertexPlaces& places_;
    std::vector<Eigen::Vector3d> inside_;
};

}  // namespace

DistanceReport measure_distance(const SurfaceModel& model, const PlacedMesh& placed, const MeshEdges& edges,
                                const DistanceOptions& options) {
    const VertexPlaces places(model, placed);
    DistanceReport report;
    report.diagonal = model.diagonal();
    std::vector<double> at_vertices, at_midpoints, at_centroids;
    Worst vertices(options.worst), midpoints(options.worst), centroids(options.worst);
    const auto record = [&](std::vector<double>& values, Worst& worst, int index, double distance) {
        values.push_back(distance / report.diagonal);
        worst.add(index, values.back());
    };
    for (int v = 0; v < static_cast<int>(placed.mesh.points.size()); ++v)
        if (places.used(v))
            record(at_vertices, vertices, v, (placed.mesh.points[v] - model.position(places.own(v))).norm());
    for (int e = 0; e < edges.size(); ++e)
        record(at_midpoints, midpoints, e, distance_of_mean(model, placed, places, edges.ends[e]));
    for (int t = 0; t < static_cast<int>(placed.mesh.triangles.size()); ++t)
        record(at_centroids, centroids, t, distance_of_mean(model, placed, places, placed.mesh.triangles[t]));
    report.vertices = summarise(std::move(at_vertices));
    report.midpoints = summarise(std::move(at_midpoints));
    report.centroids = summarise(std::move(at_centroids));
    report.worst_vertices = vertices.sorted();
    report.worst_edges = by_ends(edges, midpoints.sorted());
    report.worst_triangles = centroids.sorted();
    return report;
}

NormalReport measure_normals(const SurfaceModel& model, const PlacedMesh& placed, const DistanceOptions& options) {
    const VertexPlaces places(model, placed);
    const VertexNormals normals(model, places, placed.mesh.points.size());
    NormalReport report;
    std::vector<double> largest;
    Worst worst(options.worst);
    for (std::size_t t = 0; t < placed.mesh.triangles.size(); ++t) {
        const Triangle& corners = placed.mesh.triangles[t];
        const auto& [a, b, c] = corners;
        const Eigen::Vector3d normal =
            (placed.mesh.points[b] - placed.mesh.points[a]).cross(placed.mesh.points[c] - placed.mesh.points[a]);
        if (!(normal.norm() > 0)) {
            ++report.without_normal;
            continue;
        }
        const std::vector<int> patches =
            placed.patches.empty() ? places.common_patches(corners) : std::vector<int>{placed.patches[t]};
        double angle = 0;
        for (const int v : corners) angle = std::max(angle, normals.angle(v, normal, patches));
        report.over_45 += angle > 45;
        report.over_60 += angle > 60;
        largest.push_back(angle);
        worst.add(static_cast<int>(t), angle);
    }
    report.angle = summarise(std::move(largest));
    report.worst = worst.sorted();
    return report;
}

}  // namespace gradus

#include "gradus/quality/reference.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <string>

namespace gradus {

namespace {

using Eigen::Vector3d;

constexpr double kPrecision = 0.01;  // of the largest distance
constexpr double kSamePlace = 1e-6;  // of the diagonal: what a file in single precision does not tell apart
constexpr std::size_t kGrain = 256;
constexpr double kDegrees = 180 / std::numbers::pi;

constexpr double kLargestCoordinate = 1e100;  // beyond it squares of squared distances are no numbers

const MeshView& checked(const MeshView& surface, const char* what) {
    if (surface.triangles.empty()) throw std::invalid_argument(std::string("Reference: ") + what + " has no triangles");
    for (std::size_t t = 0; t < surface.triangles.size(); ++t)
        for (const int v : surface.triangles[t]) {
            const bool known = v >= 0 && static_cast<std::size_t>(v) < surface.points.size();
            if (!known || !surface.points[v].allFinite())
                throw std::invalid_argument(std::string("Reference: triangle ") + std::to_string(t) + " of " + what +
                                            " has vertex " + std::to_string(v) +
                                            (known ? ", which is not finite" : ", which there is not"));
            if (surface.points[v].cwiseAbs().maxCoeff() > kLargestCoordinate)
                throw std::invalid_argument(std::string("Reference: vertex ") + std::to_string(v) + " of " + what +
                                            " is beyond 1e100");
        }
    return surface;
}

double diagonal_of(const MeshView& surface) {
    Eigen::AlignedBox3d box;
    for (const Triangle& t : surface.triangles)
        for (const int v : t) box.extend(surface.points[v]);
    return box.diagonal().norm();
}

Vector3d normal_of(const MeshView& surface, const Triangle& t) {
    return (surface.points[t[1]] - surface.points[t[0]])
        .cross(surface.points[t[2]] - surface.points[t[0]])
        .stableNormalized();
}

std::vector<Vector3d> normals_of(const MeshView& surface) {
    std::vector<Vector3d> normals;
    for (const Triangle& t : surface.triangles) normals.push_back(normal_of(surface, t));
    return normals;
}

std::vector<int> all_of(const MeshView& surface) {
    std::vector<int> all(surface.triangles.size());
    std::iota(all.begin(), all.end(), 0);
    return all;
}

std::optional<ClosestTriangle> facing_of(const MeshView& surface, const std::vector<Vector3d>& normals) {
    std::vector<int> chosen = all_of(surface);
    std::erase_if(chosen, [&](int t) { return normals[t].isZero(0); });
    if (chosen.empty()) return std::nullopt;
    return ClosestTriangle(surface.points, surface.triangles, std::move(chosen));
}

// Calls use(i, near) in parallel; it returns a triangle near the next one.
template <class Use>
void for_each_of(std::size_t count, const Use& use) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, kGrain), [&](const auto& range) {
        int near = -1;
        for (std::size_t i = range.begin(); i < range.end(); ++i) near = use(i, near);
    });
}

}  // namespace

std::vector<TopologyComparison> compare(const TopologyReport& mesh, const TopologyReport& reference) {
    const auto number = [](std::size_t n) { return static_cast<long long>(n); };
    return {{"components", number(mesh.components), number(reference.components)},
            {"boundary loops", number(mesh.boundary_loops), number(reference.boundary_loops)},
            {"Euler characteristic", mesh.euler, reference.euler},
            {"genus", mesh.genus, reference.genus}};
}

Reference::Reference(const MeshView& surface)
    : surface_(checked(surface, "the reference")),
      diagonal_(diagonal_of(surface)),
      normals_(normals_of(surface)),
      facing_(facing_of(surface, normals_)),
      target_(surface) {}

ReferenceReport Reference::measure(const MeshView& mesh) const {
    const DistanceTarget back(checked(mesh, "the mesh"));
    ReferenceReport report;
    report.hausdorff.diagonal = diagonal_;
    report.hausdorff.from_mesh = target_.measure_from(mesh, {.precision = kPrecision});
    report.hausdorff.from_reference = back.measure_from(surface_, {.precision = kPrecision});
    report.topology = measure_topology(surface_, edges_of(surface_));
    return report;
}

DistanceReport Reference::measure_distance(const MeshView& mesh, const MeshEdges& edges,
                                           const DistanceOptions& options) const {
    checked(mesh, "the mesh");
    std::vector<int> used;
    for (const Triangle& t : mesh.triangles) used.insert(used.end(), t.begin(), t.end());
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());

    Worst vertices(options.worst), midpoints(options.worst), centroids(options.worst);
    const auto distances = [&](std::size_t count, const auto& point, const auto& index, Worst& worst) {
        std::vector<double> values(count);
        for_each_of(count, [&](std::size_t i, int near) {
            const auto hit = target_.closest(point(i), near);
            values[i] = diagonal_ > 0 ? hit.distance / diagonal_ : hit.distance;
            return hit.triangle;
        });
        for (std::size_t i = 0; i < count; ++i) worst.add(index(i), values[i]);
        return summarise(std::move(values));
    };
    const auto& p = mesh.points;
    const auto same = [](std::size_t i) { return static_cast<int>(i); };
    DistanceReport report;
    report.diagonal = diagonal_;
    report.vertices = distances(
        used.size(), [&](std::size_t i) { return p[used[i]]; }, [&](std::size_t i) { return used[i]; }, vertices);
    report.midpoints = distances(
        edges.ends.size(), [&](std::size_t e) { return Vector3d((p[edges.ends[e][0]] + p[edges.ends[e][1]]) / 2); },
        same, midpoints);
    report.centroids = distances(
        mesh.triangles.size(),
        [&](std::size_t i) {
            const auto& [a, b, c] = mesh.triangles[i];
            return Vector3d((p[a] + p[b] + p[c]) / 3);
        },
        same, centroids);
    report.worst_vertices = vertices.sorted();
    report.worst_edges = by_ends(edges, midpoints.sorted());
    report.worst_triangles = centroids.sorted();
    return report;
}

NormalReport Reference::measure_normals(const MeshView& mesh, const DistanceOptions& options) const {
    checked(mesh, "the mesh");
    constexpr double kNone = -1;
    NormalReport report;
    std::vector<double> angles(mesh.triangles.size(), kNone);
    if (facing_)
        for_each_of(mesh.triangles.size(), [&](std::size_t i, int near) {
            const Triangle& corners = mesh.triangles[i];
            const Vector3d normal = normal_of(mesh, corners);
            if (normal.isZero(0)) return near;
            const auto lean = [&](int facet) {
                return std::atan2(normals_[facet].cross(normal).norm(), normals_[facet].dot(normal));
            };
            const auto least_lean = [&](const std::vector<int>& facets) {
                return *std::min_element(facets.begin(), facets.end(), [&](int a, int b) { return lean(a) < lean(b); });
            };
            const auto at = [&](const Vector3d& p) {
                const auto hit = facing_->closest(p, near);
                near = hit.triangle;
                return facing_->within(p, hit.distance + kSamePlace * diagonal_);
            };
            const auto faces = [&](int facet) { return normals_[facet].dot(normal) >= 0; };
            const Vector3d centroid = (mesh.points[corners[0]] + mesh.points[corners[1]] + mesh.points[corners[2]]) / 3;
            int under = least_lean(at(centroid));
            if (!faces(under)) {
                double closest = std::numeric_limits<double>::infinity();
                int instead = -1, corners_facing = 0;
                for (const int v : corners) {
                    const int facet = least_lean(at(mesh.points[v]));
                    const auto& [a, b, c] = surface_.triangles[facet];
                    const double distance =
                        (closest_point(centroid, surface_.points[a], surface_.points[b], surface_.points[c]) - centroid)
                            .norm();
                    corners_facing += faces(facet);
                    if (distance < closest) closest = distance, instead = facet;
                }
                if (corners_facing == 3) under = instead;
            }
            angles[i] = kDegrees * lean(under);
            return near;
        });
    Worst worst(options.worst);
    for (std::size_t t = 0; t < angles.size(); ++t) {
        report.without_normal += angles[t] == kNone;
        report.over_45 += angles[t] > 45;
        report.over_60 += angles[t] > 60;
        if (angles[t] != kNone) worst.add(static_cast<int>(t), angles[t]);
    }
    std::erase(angles, kNone);
    report.angle = summarise(std::move(angles));
    report.worst = worst.sorted();
    return report;
}

}  // namespace gradus

#include "quadrilaterals.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>

#include "gradus/io/picture.hpp"
#include "session.hpp"

namespace gradus::app {

namespace {

Eigen::Vector3d normal_of(const std::array<Eigen::Vector3d, 4>& p) {
    return (p[2] - p[0]).cross(p[3] - p[1]).stableNormalized();
}

}  // namespace

QuadReport measure_quads(const QuadMesh& mesh) {
    QuadReport report;
    report.vertices = mesh.points.size();
    report.quads = mesh.quads.size();
    report.triangles = mesh.triangles.size();
    std::vector<int> elements(mesh.points.size()), borders(mesh.points.size());
    std::map<std::pair<int, int>, int> sides;
    const auto count = [&](const auto& v) {
        for (std::size_t k = 0; k < v.size(); ++k) {
            ++elements[v[k]];
            ++sides[std::minmax(v[k], v[(k + 1) % v.size()])];
        }
    };
    for (const auto& v : mesh.quads) {
        count(v);
        std::array<Eigen::Vector3d, 4> p;
        for (int k = 0; k < 4; ++k) p[k] = mesh.points[v[k]];
        const Eigen::Vector3d n = normal_of(p);
        const double quality =
            mesh.metrics.empty()
                ? quad_quality(p, n)
                : quad_quality(p, {mesh.metrics[v[0]], mesh.metrics[v[1]], mesh.metrics[v[2]], mesh.metrics[v[3]]}, n);
        report.worst = std::min(report.worst, quality);
        report.mean += quality / static_cast<double>(mesh.quads.size());
        report.not_convex += quality <= 0;
    }
    for (const auto& v : mesh.triangles) count(v);
    for (const auto& [side, uses] : sides)
        if (uses == 1) borders[side.first] = borders[side.second] = 1;
    for (std::size_t v = 0; v < elements.size(); ++v)
        if (!borders[v]) ++report.valences[elements[v]];
    return report;
}

std::string text_of(const QuadReport& report) {
    std::string valences;
    std::size_t inside = 0;
    for (const auto& [valence, count] : report.valences) inside += count;
    for (const auto& [valence, count] : report.valences)
        valences += fmt::format("{}{}: {:.1f} %", valences.empty() ? "" : ", ", valence,
                                100.0 * static_cast<double>(count) / static_cast<double>(inside));
    return fmt::format(
        "mesh: {} quadrilaterals, {} triangles ({:.2f} % quadrilaterals), {} vertices; corners worst {:.3f}, mean "
        "{:.4f}, {} not convex\nvalences inside: {}\n",
        grouped(report.quads), grouped(report.triangles), 100 * report.share(), grouped(report.vertices), report.worst,
        report.mean, grouped(report.not_convex), valences);
}

Json json_of(const QuadReport& report) {
    Json valences = Json::object();
    for (const auto& [valence, count] : report.valences) valences[std::to_string(valence)] = count;
    return {{"vertices", report.vertices},     {"quads", report.quads}, {"triangles", report.triangles},
            {"share", report.share()},         {"worst", report.worst}, {"mean", report.mean},
            {"not_convex", report.not_convex}, {"valences", valences}};
}

Image draw_quads(const QuadMesh& mesh, const Eigen::Vector2d& middle, double width) {
    // Two triangles for each, whose common edge is not shown.
    std::vector<Triangle> triangles;
    std::vector<std::uint8_t> shown;
    for (const auto& v : mesh.quads) {
        triangles.push_back({v[0], v[1], v[2]});
        triangles.push_back({v[0], v[2], v[3]});
        shown.insert(shown.end(), {0b011, 0b110});
    }
    for (const Triangle& v : mesh.triangles) {
        triangles.push_back(v);
        shown.push_back(0b111);
    }
    Camera camera;
    if (mesh.dimension == 2) camera.direction = {0, 0, 1}, camera.up = {0, 1, 0};
    if (width > 0) {
        camera.target = Eigen::Vector3d(middle.x(), middle.y(), 0);
        camera.width = width;
    }
    const bool is_flat = mesh.dimension == 2;
    return render({.points = mesh.points, .triangles = triangles, .features = mesh.edges, .shown_edges = shown}, camera,
                  {.width = is_flat ? 1000 : 1600,
                   .height = 1000,
                   .shading = is_flat ? Shading::None : Shading::Smooth,
                   .edge_width = 0.8,
                   .feature_width = 1.6});
}

}  // namespace gradus::app

#include "gradus/gradation/measures.hpp"

#include "vertex_graph.hpp"

namespace gradus {

namespace {

template <class Measure>
std::vector<double> vertex_maxima(const TriMesh& mesh, double least, Measure measure) {
    std::vector<double> largest(mesh.n_vertices(), least);
    detail::for_each_edge(mesh, [&](int, int a, int b, double L) {
        const double m = measure(a, b, L);
        largest[a] = std::max(largest[a], m);
        largest[b] = std::max(largest[b], m);
    });
    return largest;
}

double quantile(std::vector<double>& values, double share) {
    if (values.empty()) return 0;
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

}  // namespace

Eigen::Vector3d size_gradient(const std::array<Eigen::Vector3d, 3>& corners, const std::array<double, 3>& sizes) {
    if (sizes[0] == sizes[1] && sizes[0] == sizes[2]) return Eigen::Vector3d::Zero();
    const Eigen::Vector3d ab = corners[1] - corners[0], ac = corners[2] - corners[0];
    const Eigen::Vector3d normal = ab.cross(ac);
    const double area2 = normal.squaredNorm();
    if (area2 == 0) return Eigen::Vector3d::Zero();
    if (std::isinf(sizes[0] + sizes[1] + sizes[2]))
        return Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
    return ((sizes[1] - sizes[0]) * ac.cross(normal) + (sizes[2] - sizes[0]) * normal.cross(ab)) / area2;
}

std::vector<double> vertex_variations(const TriMesh& mesh, std::span<const double> size) {
    detail::require_sizes(mesh, size, "vertex_variations");
    return vertex_maxima(mesh, 0, [&](int a, int b, double L) { return h_variation(L, size[a], size[b]); });
}

std::vector<double> vertex_shocks(const TriMesh& mesh, std::span<const double> size) {
    detail::require_sizes(mesh, size, "vertex_shocks");
    return vertex_maxima(mesh, 1, [&](int a, int b, double L) { return h_shock(L, size[a], size[b]); });
}

std::vector<Eigen::Vector3d> size_gradients(const TriMesh& mesh, std::span<const double> size) {
    detail::require_sizes(mesh, size, "size_gradients");
    const std::span<const Eigen::Vector3d> p = points_of(mesh);
    std::vector<Eigen::Vector3d> gradients;
    gradients.reserve(mesh.n_faces());
    for (const auto& [a, b, c] : triangles_of(mesh))
        gradients.push_back(size_gradient({p[a], p[b], p[c]}, {size[a], size[b], size[c]}));
    return gradients;
}

int count_coarse_edges(const TriMesh& mesh, double shock, std::span<const double> size) {
    detail::require_sizes(mesh, size, "count_coarse_edges");
    detail::require_above(shock, 1, "H-shock bound", "count_coarse_edges");
    const double log_beta = std::log(shock);
    int coarse = 0;
    detail::for_each_edge(
        mesh, [&](int, int a, int b, double L) { coarse += L * log_beta > kCoarseEdge * std::min(size[a], size[b]); });
    return coarse;
}

GradationReport measure_gradation(const TriMesh& mesh, std::span<const double> size) {
    detail::require_sizes(mesh, size, "measure_gradation");
    GradationReport report;
    std::vector<double> values(mesh.n_edges());
    detail::for_each_edge(mesh, [&](int e, int a, int b, double L) {
        const double variation = h_variation(L, size[a], size[b]);
        values[e] = h_shock(L, size[a], size[b]);
        if (variation > report.variation_max) {
            report.variation_max = variation;
            report.variation_edge = {std::min(a, b), std::max(a, b)};
        }
        if (values[e] > report.shock_max) {
            report.shock_max = values[e];
            report.shock_edge = {std::min(a, b), std::max(a, b)};
        }
    });
    if (!values.empty()) report.shock_p999 = quantile(values, .999);

    values.clear();
    for (const Eigen::Vector3d& gradient : size_gradients(mesh, size)) {
        values.push_back(gradient.norm());
        if (values.back() > report.gradient_max) {
            report.gradient_max = values.back();
            report.gradient_triangle = static_cast<int>(values.size()) - 1;
        }
    }
    report.gradient_p999 = quantile(values, .999);
    return report;
}

}  // namespace gradus

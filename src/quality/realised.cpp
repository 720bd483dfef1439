#include "gradus/quality/realised.hpp"

#include "gradus/control/metric.hpp"
#include "gradus/quality/shape.hpp"

namespace gradus {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double ratio(double larger, double smaller) { return smaller > 0 ? larger / smaller : kInfinity; }

/// H-shock of an edge of length L; sizes may be zero, unlike those of a map.
double realised_shock(double L, double h_p, double h_q) {
    const auto [small, large] = std::minmax(h_p, h_q);
    if (small == large) return 1;
    if (small == 0 || L == 0) return kInfinity;
    return std::exp(std::log1p((large - small) / small) / metric_length(L, small, large));
}

double realised_variation(double L, double h_p, double h_q) { return h_p == h_q ? 0 : ratio(std::abs(h_q - h_p), L); }

/// Compares the triangles on either side of each edge that has two.
void measure_neighbours(const MeshView& mesh, const MeshEdges& edges, const std::vector<double>& lengths,
                        RealisedGradation& report) {
    std::vector<double> areas(mesh.triangles.size());
    for (std::size_t t = 0; t < areas.size(); ++t) {
        const auto& [a, b, c] = mesh.triangles[t];
        areas[t] = (mesh.points[b] - mesh.points[a]).cross(mesh.points[c] - mesh.points[a]).norm() / 2;
    }
    std::vector<double> edge_ratios, area_ratios;
    edge_ratios.reserve(edges.ends.size());
    area_ratios.reserve(edges.ends.size());
    for (int e = 0; e < edges.size(); ++e) {
        if (edges.num_uses(e) != 2) continue;
        const int s = edges.uses_of(e)[0] / 3, t = edges.uses_of(e)[1] / 3;
        double shortest = kInfinity, longest = 0;
        for (const int triangle : {s, t})
            for (int k = 0; k < 3; ++k) {
                const double length = lengths[edges.edge_of[3 * triangle + k]];
                shortest = std::min(shortest, length);
                longest = std::max(longest, length);
            }
        edge_ratios.push_back(ratio(longest, shortest));
        area_ratios.push_back(ratio(std::max(areas[s], areas[t]), std::min(areas[s], areas[t])));
    }
    report.neighbour_edges = summarise(std::move(edge_ratios));
    report.neighbour_areas = summarise(std::move(area_ratios));
}

/// Mean length of the edges at each vertex.
std::vector<double> mean_at_vertices(const MeshView& mesh, const MeshEdges& edges, const std::vector<double>& lengths) {
    std::vector<double> sum(mesh.points.size(), 0);
    for (int e = 0; e < edges.size(); ++e)
        for (const int v : edges.ends[e]) sum[v] += lengths[e];
    const std::vector<int> count = valences(mesh, edges);
    // 0 / 0: not a number where there is no edge.
    for (std::size_t v = 0; v < sum.size(); ++v) sum[v] /= count[v];
    return sum;
}

}  // namespace

std::vector<double> realised_sizes(const MeshView& mesh, const MeshEdges& edges) {
    return mean_at_vertices(mesh, edges, edge_lengths(mesh, edges));
}

RealisedGradation measure_realised_gradation(const MeshView& mesh, const MeshEdges& edges,
                                             const RealisedOptions& options) {
    RealisedGradation report;
    const std::vector<double> lengths = edge_lengths(mesh, edges);
    std::vector<double> sizes = mean_at_vertices(mesh, edges, lengths);
    std::vector<double> shocks(edges.size()), variations(edges.size());
    Worst worst(options.worst);
    for (int e = 0; e < edges.size(); ++e) {
        const auto& [a, b] = edges.ends[e];
        shocks[e] = realised_shock(lengths[e], sizes[a], sizes[b]);
        variations[e] = realised_variation(lengths[e], sizes[a], sizes[b]);
        worst.add(e, shocks[e]);
    }
    report.worst = by_ends(edges, worst.sorted());
    report.shock = summarise(std::move(shocks));
    report.variation = summarise(std::move(variations));
    report.size = summarise(std::move(sizes));
    measure_neighbours(mesh, edges, lengths, report);
    return report;
}

}  // namespace gradus

#include "gradus/quality/edges.hpp"

#include "gradus/control/metric.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace gradus {

namespace {

struct GaussPoint {
    double t, weight;  // on [0, 1]
};

/// Five-point Gauss-Legendre rule, exact for polynomials of degree 9.
std::array<GaussPoint, 5> gauss_points() {
    const double inner = std::sqrt(5 - 2 * std::sqrt(10. / 7)) / 3, outer = std::sqrt(5 + 2 * std::sqrt(10. / 7)) / 3;
    const double inner_weight = (322 + 13 * std::sqrt(70.)) / 900, outer_weight = (322 - 13 * std::sqrt(70.)) / 900;
    return {{{(1 - outer) / 2, outer_weight / 2},
             {(1 - inner) / 2, inner_weight / 2},
             {.5, 64. / 225},
             {(1 + inner) / 2, inner_weight / 2},
             {(1 + outer) / 2, outer_weight / 2}}};
}

double checked_size(double h) {
    if (!(h > 0)) throw std::invalid_argument("metric_lengths: size " + std::to_string(h) + " is not positive");
    return h;
}

double euclidean_length(const MeshView& mesh, const std::array<int, 2>& ends) {
    return (mesh.points[ends[1]] - mesh.points[ends[0]]).stableNorm();
}

}  // namespace

std::vector<double> metric_lengths(const MeshView& mesh, const MeshEdges& edges, std::span<const double> sizes) {
    if (sizes.size() != mesh.points.size())
        throw std::invalid_argument("metric_lengths: " + std::to_string(sizes.size()) + " sizes for " +
                                    std::to_string(mesh.points.size()) + " vertices");
    std::vector<double> lengths(edges.size());
    for (int e = 0; e < edges.size(); ++e) {
        const auto& [a, b] = edges.ends[e];
        lengths[e] =
            metric_length(euclidean_length(mesh, edges.ends[e]), checked_size(sizes[a]), checked_size(sizes[b]));
    }
    return lengths;
}

std::vector<double> metric_lengths(const MeshView& mesh, const MeshEdges& edges, const SizeQuery& size,
                                   std::span<const int> hints) {
    const std::array<GaussPoint, 5> rule = gauss_points();
    std::vector<double> lengths(edges.size());
    int hint = -1;
    for (int e = 0; e < edges.size(); ++e) {
        const Eigen::Vector3d& p = mesh.points[edges.ends[e][0]];
        const Eigen::Vector3d along = mesh.points[edges.ends[e][1]] - p;
        if (!hints.empty()) hint = hints[edges.ends[e][0]];
        double inverse_size = 0;
        for (const auto& [t, weight] : rule) inverse_size += weight / checked_size(size(p + t * along, hint));
        lengths[e] = along.stableNorm() * inverse_size;
    }
    return lengths;
}

EdgeReport measure_edges(const MeshEdges& edges, std::span<const double> lengths, const EdgeOptions& options) {
    EdgeReport report;
    report.length = summarise({lengths.begin(), lengths.end()});
    if (lengths.empty()) return report;
    Worst worst(options.worst);
    double lost = 0;  // sum of min(l, 1/l) - 1
    for (int e = 0; e < edges.size(); ++e) {
        const double l = lengths[e];
        report.num_short += l < 1 / std::numbers::sqrt2;
        report.num_long += l > std::numbers::sqrt2;
        lost += (l <= 1 ? l : 1 / l) - 1;
        report.log2_histogram.add(std::log2(l));
        worst.add(e, std::max(l, 1 / l));
    }
    const double n = static_cast<double>(lengths.size());
    report.short_share = static_cast<double>(report.num_short) / n;
    report.long_share = static_cast<double>(report.num_long) / n;
    report.unit_share = static_cast<double>(lengths.size() - report.num_short - report.num_long) / n;
    report.efficiency = std::exp(lost / n);
    for (const Offender& edge : worst.sorted()) report.worst.push_back({edges.ends[edge.index], lengths[edge.index]});
    return report;
}

}  // namespace gradus

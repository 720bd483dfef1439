#include "gradus/gradation/grade.hpp"

#include "gradus/gradation/gradient.hpp"
#include "vertex_graph.hpp"

#include <stdexcept>
#include <tuple>

namespace gradus {

namespace {

constexpr double kEdgeTolerance = 1e-9;
constexpr double kTriangleTolerance = 1e-6;

void require_options(const GradationOptions& options) {
    if (!options.shock && !options.variation)
        throw std::invalid_argument("grade: neither a shock nor a variation is given");
    if (options.shock) detail::require_above(*options.shock, 1, "H-shock bound", "grade");
    if (options.variation) detail::require_above(*options.variation, 0, "H-variation bound", "grade");
    if (options.method == GradationMethod::Paper && !options.required.empty())
        throw std::invalid_argument("grade: the paper's method knows no required sizes");
}

/// The strongest demand at each vertex.
void keep_strongest(std::vector<RequiredConflict>& conflicts) {
    std::stable_sort(conflicts.begin(), conflicts.end(), [](const auto& p, const auto& q) {
        return std::tie(p.vertex, p.needed) < std::tie(q.vertex, q.needed);
    });
    const auto same_vertex = [](const auto& p, const auto& q) { return p.vertex == q.vertex; };
    conflicts.erase(std::unique(conflicts.begin(), conflicts.end(), same_vertex), conflicts.end());
}

void by_edges(const TriMesh& mesh, std::span<double> size, const GradationOptions& options, GradationResult& result) {
    const bool both = options.shock && options.variation;
    const auto run = [&](EdgeReduction reduction) {
        result.conflicts.insert(result.conflicts.end(), reduction.conflicts.begin(), reduction.conflicts.end());
        keep_strongest(result.conflicts);
        if (!both) result.certificate = std::move(reduction.certificate);
        return reduction.lowered;
    };
    // Each bound can undo the other only by lowering, and a vertex lowered by one is tight against a neighbour; a few
    // rounds do.
    for (int round = 0; round < 100; ++round) {
        int lowered = 0;
        if (options.variation) lowered += run(limit_h_variation(mesh, *options.variation, size, options.required));
        if (options.shock) lowered += run(limit_h_shock(mesh, *options.shock, size, options.required));
        if (!both || lowered == 0) return;
    }
    result.converged = false;
}

void by_paper(const TriMesh& mesh, std::span<double> size, const GradationOptions& options, GradationResult& result) {
    if (options.variation) result.converged = paper_h_variation(mesh, *options.variation, size).converged;
    if (options.shock) result.converged = paper_h_shock(mesh, *options.shock, size).converged && result.converged;
}

bool edges_met(const GradationReport& report, const GradationOptions& options) {
    return (!options.shock || report.shock_max <= *options.shock * (1 + kEdgeTolerance)) &&
           (!options.variation || report.variation_max <= *options.variation * (1 + kEdgeTolerance));
}

bool is_met(const GradationResult& result, const GradationOptions& options) {
    switch (options.method) {
        case GradationMethod::Full:
            return edges_met(result.after, options) &&
                   result.after.gradient_max <= result.gradient_bound * (1 + kTriangleTolerance);
        case GradationMethod::Gradient:
            return result.converged;
        case GradationMethod::Exact:
        case GradationMethod::Paper:
            break;
    }
    return edges_met(result.after, options);
}

}  // namespace

double gradient_bound(const GradationOptions& options) {
    require_options(options);
    const double by_shock = options.shock ? std::log(*options.shock) : std::numeric_limits<double>::infinity();
    return std::min(by_shock, options.variation.value_or(by_shock));
}

void measure_graded(const TriMesh& mesh, std::span<const double> size, const GradationOptions& options,
                    GradationResult& result) {
    result.gradient_bound = gradient_bound(options);
    result.after = measure_gradation(mesh, size);
    result.steep_triangles = 0;
    for (const Eigen::Vector3d& g : size_gradients(mesh, size))
        result.steep_triangles += g.norm() > result.gradient_bound * (1 + 1e-9);
    if (options.shock) result.coarse_edges = count_coarse_edges(mesh, *options.shock, size);
    result.met = is_met(result, options);
}

GradationResult grade(const TriMesh& mesh, std::span<double> size, const GradationOptions& options) {
    GradationResult result;
    result.gradient_bound = gradient_bound(options);
    result.before = measure_gradation(mesh, size);
    const std::vector<double> input(size.begin(), size.end());

    switch (options.method) {
        case GradationMethod::Full:
            // A gradient bound on triangles holds on their edges too; edges first because that is fast, and names
            // conflicts.
            result.conflicts = limit_h_variation(mesh, result.gradient_bound, size, options.required).conflicts;
            result.converged = limit_gradient(mesh, result.gradient_bound, size, options.required).converged;
            break;
        case GradationMethod::Exact:
            by_edges(mesh, size, options, result);
            break;
        case GradationMethod::Gradient:
            result.converged = march_gradient(mesh, result.gradient_bound, size, options.required).converged;
            break;
        case GradationMethod::Paper:
            by_paper(mesh, size, options, result);
            break;
    }

    for (std::size_t v = 0; v < size.size(); ++v) {
        if (!(size[v] < input[v])) continue;
        ++result.lowered;
        result.largest_factor = std::max(result.largest_factor, input[v] / size[v]);
    }
    measure_graded(mesh, size, options, result);
    return result;
}

}  // namespace gradus

#include "gradus/remesh/adapt_planar.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "vertex.hpp"

namespace gradus {

namespace {

constexpr int kPatience = 2;  // iterations that bring nothing, after which the loop ends
// Backgrounds are refined for the corrected map, whose edges are to be no longer than this in it, until few are cut.
constexpr double kLongestCorrected = 0.7, kFewCuts = 0.02;
constexpr int kMostRefinements = 4;
constexpr double kBetter = 0.002;  // of the share of unit edges

struct Bounded {
    double shock_before = 1, shock = 1;
    bool met = true, changed = false;
};

template <class M>
TriMesh mesh_of(const SampledBackground<M>& background) {
    std::vector<Triangle> triangles;
    for (int t = 0; t < background.mesh.num_triangles(); ++t) triangles.push_back(background.mesh.triangle(t));
    return make_mesh(background.points, triangles);
}

// Corrects the sizes of a background.
Bounded bound(const SampledBackground<Size>& background, std::vector<double>& sizes,
              const PlanarAdaptOptions& options) {
    const TriMesh mesh = mesh_of(background);
    if (!options.gradation) {
        const GradationReport report = measure_gradation(mesh, sizes);
        return {report.shock_max, report.shock_max};
    }
    const GradationResult result = grade(mesh, sizes, *options.gradation);
    return {result.before.shock_max, result.after.shock_max, result.met, result.lowered > 0};
}

Bounded bound(const SampledBackground<SizeTensor>& background, std::vector<Tensor>& sizes,
              const PlanarAdaptOptions& options) {
    const TriMesh mesh = mesh_of(background);
    std::vector<Tensor> metrics;
    for (const Tensor& h : sizes) metrics.push_back(metric_of(h));
    if (!options.tensor_gradation) {
        const GradationReport report = measure_gradation(mesh, metrics);
        return {report.shock_max, report.shock_max};
    }
    const TensorGradationResult result = grade(mesh, metrics, *options.tensor_gradation);
    for (std::size_t v = 0; v < metrics.size(); ++v) sizes[v] = size_tensor(metrics[v]);
    return {result.before.shock_max, result.after.shock_max, result.met, result.lowered > 0};
}

template <class M>
std::vector<VertexOf<M>> sized_vertices(std::span<const Eigen::Vector3d> points,
                                        std::span<const typename M::Value> sizes) {
    std::vector<VertexOf<M>> vertices(points.size());
    for (std::size_t v = 0; v < points.size(); ++v) {
        vertices[v].p = points[v];
        vertices[v].n = Eigen::Vector3d::UnitZ();
        take_size(vertices[v], sizes[v]);
    }
    return vertices;
}

template <class M>
class Loop {
  public:
    Loop(const Triangulation& domain, const SizeFunction<M>& wanted, const PlanarAdaptOptions& options)
        : wanted_(wanted), options_(options), mesher_(domain) {}

    PlanarAdaptResult<M> run() {
        Map map = sample();
        double best = -1;
        int in_vain = 0;
        while (static_cast<int>(result_.iterations.size()) < options_.max_iterations) {
            if (options_.progress) options_.progress(static_cast<int>(result_.iterations.size()) + 1);
            Map next = iterate(std::move(map));
            const PlanarAdaptIteration& last = result_.iterations.back();
            const double share = std::min(last.own.unit_share, last.wanted.not_long);
            result_.converged = share >= options_.unit_share;
            in_vain = share > best + kBetter ? 0 : in_vain + 1;
            best = std::max(best, share);
            if (result_.converged || in_vain == kPatience) break;
            map = std::move(next);
        }
        result_.mesh = mesher_.soup();
        return std::move(result_);
    }

  private:
    struct Map {
        SampledBackground<M> background;
        Bounded bounded;
        std::vector<typename M::Value> wanted;  // its sizes before they were corrected
    };

    // The sizes wanted on the mesh there is, refined where it does not show them, and corrected.
    Map sample() {
        Map map{sampled_background<M>(mesher_.points(), mesher_.connectivity(), wanted_, options_.sampling), {}, {}};
        for (int round = 1;; ++round) {
            auto sizes = map.background.sizes;
            map.bounded = bound(map.background, sizes, options_);
            const int before = map.background.mesh.num_triangles();
            const int cuts = map.bounded.changed && round < kMostRefinements
                                 ? cut_long_edges<M>(map.background, wanted_, sizes, kLongestCorrected,
                                                     options_.sampling.max_triangles)
                                 : 0;
            if (cuts <= kFewCuts * before) {
                if (cuts > 0) {
                    sizes = map.background.sizes;
                    map.bounded = bound(map.background, sizes, options_);
                }
                map.wanted = std::exchange(map.background.sizes, std::move(sizes));
                break;
            }
        }
        result_.graded = result_.graded && map.bounded.met;
        return map;
    }

    MetricFit fit_to(std::span<const typename M::Value> of_background) const {
        return measure_fit<M>(mesher_.points(), mesher_.connectivity(), of_background.first(mesher_.points().size()));
    }

    // Meshes by a map. @returns the one sampled on the mesh
    Map iterate(Map map) {
        const auto start = std::chrono::steady_clock::now();
        PlanarAdaptIteration iteration;
        iteration.background_vertices = static_cast<int>(map.background.points.size());
        iteration.shock_before = map.bounded.shock_before;
        iteration.shock = map.bounded.shock;
        result_.statistics = mesher_.mesh(map.background, options_.remesh);
        iteration.predicted_triangles = result_.statistics.predicted_triangles;
        iteration.triangles = mesher_.connectivity().num_triangles();
        result_.background = std::move(map.background);
        result_.wanted = std::move(map.wanted);
        result_.sizes = mesher_.sizes();
        iteration.own = measure_fit<M>(mesher_.points(), mesher_.connectivity(), result_.sizes);
        Map next = sample();
        iteration.wanted = fit_to(next.wanted);
        iteration.next = fit_to(next.background.sizes);
        iteration.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        result_.iterations.push_back(iteration);
        return next;
    }

    const SizeFunction<M>& wanted_;
    const PlanarAdaptOptions& options_;
    PlanarMesher<M> mesher_;
    PlanarAdaptResult<M> result_;
};

}  // namespace

template <class M>
MetricFit measure_fit(std::span<const Eigen::Vector3d> points, const Connectivity& mesh,
                      std::span<const typename M::Value> sizes) {
    const std::vector<VertexOf<M>> vertices = sized_vertices<M>(points, sizes);
    MetricFit fit;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const auto [a, b, c] = mesh.triangle(t);
        const double quality = triangle_quality(vertices[a], vertices[b], vertices[c]);
        fit.worst = std::min(fit.worst, quality);
        fit.mean += quality / mesh.num_triangles();
    }
    long edges = 0, unit = 0, long_ones = 0;
    fit.shortest = std::numeric_limits<double>::infinity();
    for (int h = 0; h < 3 * mesh.num_triangles(); ++h) {
        if (mesh.twin(h) > h) continue;
        const double length = length_between(vertices[mesh.origin(h)], vertices[mesh.target(h)]);
        ++edges;
        unit += length >= 1 / std::numbers::sqrt2 && length <= std::numbers::sqrt2;
        long_ones += length > std::numbers::sqrt2;
        fit.shortest = std::min(fit.shortest, length);
        fit.longest = std::max(fit.longest, length);
    }
    fit.unit_share = static_cast<double>(unit) / static_cast<double>(std::max(edges, 1L));
    fit.not_long = 1 - static_cast<double>(long_ones) / static_cast<double>(std::max(edges, 1L));
    return fit;
}

template <class M>
PlanarAdaptResult<M> adapt_planar(const Triangulation& domain, const SizeFunction<M>& wanted,
                                  const PlanarAdaptOptions& options) {
    return Loop<M>(domain, wanted, options).run();
}

template MetricFit measure_fit<Size>(std::span<const Eigen::Vector3d>, const Connectivity&, std::span<const double>);
template MetricFit measure_fit<SizeTensor>(std::span<const Eigen::Vector3d>, const Connectivity&,
                                           std::span<const Tensor>);
template PlanarAdaptResult<Size> adapt_planar(const Triangulation&, const SizeFunction<Size>&,
                                              const PlanarAdaptOptions&);
template PlanarAdaptResult<SizeTensor> adapt_planar(const Triangulation&, const SizeFunction<SizeTensor>&,
                                                    const PlanarAdaptOptions&);

}  // namespace gradus

#include "gradus/gradation/anisotropic.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <stdexcept>
#include <tuple>

#include "gradus/gradation/isotropic.hpp"
#include "vertex_graph.hpp"

namespace gradus {

namespace {

using Eigen::Vector3d;

constexpr double kResidual = 1e-9;  // up to which a bound counts as met
constexpr double kChange = 1e-13;   // smaller relative changes are rounding
// The same of intersections, which are by eigenvalues; and of those of Physical, whose chains shrink on and on.
constexpr double kChangeOfBalls = 1e-11, kChangeOfPhysical = 1e-3;
constexpr long kVisitsPerVertex = 1000;
constexpr int kMostSweeps = 1000;

// How large a size may be at distance L from a size h.
class Bound {
  public:
    explicit Bound(const TensorGradationOptions& options) : shock_(options.shock), variation_(options.variation) {
        if (!shock_ && !variation_) throw std::invalid_argument("grade: no bound is given");
        if (shock_) detail::require_above(*shock_, 1, "H-shock bound", "grade");
        if (variation_) detail::require_above(*variation_, 0, "H-variation bound", "grade");
    }

    double limit(double h, double L) const {
        double limit = std::numeric_limits<double>::infinity();
        if (variation_) limit = h + *variation_ * L;
        // Where edges are coarse for it the limit of a shock falls as h grows; the least that it comes to, of all h
        // from this one on, rises always.
        if (shock_) limit = std::min(limit, shock_limit(std::max(h, L * std::log(*shock_) / kCoarseEdge), L, *shock_));
        return limit;
    }
    // Per length, in all directions.
    double slope() const {
        const double infinite = std::numeric_limits<double>::infinity();
        return std::min(variation_.value_or(infinite), shock_ ? std::log(*shock_) : infinite);
    }
    // By the paper: the size of the larger end, from that and the smaller one.
    double paper_limit(double small, double large, double L) const {
        double limit = large;
        if (variation_) limit = std::min(limit, small + *variation_ * L);
        if (shock_) {
            const double excess = log_h_shock(L, small, large) - std::log(*shock_);
            if (excess > 1e-12 * std::log(*shock_))
                limit = std::min(limit, large * std::exp(-excess * metric_length(L, small, large)));
        }
        return limit;
    }

  private:
    std::optional<double> shock_, variation_;
};

// The mesh as gradation sees it.
struct Graph {
    std::span<const Vector3d> points;
    detail::VertexGraph arcs;
    std::vector<Vector3d> normals;  // of vertices; empty in the plane

    explicit Graph(const TriMesh& mesh) : points(points_of(mesh)), arcs(detail::make_vertex_graph(mesh)) {
        const bool is_flat = std::all_of(points.begin(), points.end(), [](const Vector3d& p) { return p.z() == 0; });
        if (is_flat) return;
        normals.assign(points.size(), Vector3d::Zero());
        for (const auto& [a, b, c] : triangles_of(mesh)) {
            const Vector3d n = (points[b] - points[a]).cross(points[c] - points[a]);
            for (const int v : {a, b, c}) normals[v] += n;
        }
        for (Vector3d& n : normals) n = n.squaredNorm() > 0 ? n.stableNormalized() : Vector3d::UnitZ().eval();
    }
    int size() const { return static_cast<int>(points.size()); }
    bool comes_before(int v, int w) const {
        const Vector3d &p = points[v], &q = points[w];
        return std::tuple(p.x(), p.y(), p.z(), v) < std::tuple(q.x(), q.y(), q.z(), w);
    }
};

double directional_size(const Tensor& metric, const Vector3d& e) { return size_along(metric, e); }

// h of the area that a metric asks for, whatever its plane.
double mean_size(const Tensor& metric) { return std::pow(determinant(metric), -1.0 / 6); }

// Vertices by rising size, of equal sizes by coordinates.
class WorkList {
  public:
    explicit WorkList(const Graph& graph) : later_{&graph}, queue_(later_) {}
    void push(int v, double size) { queue_.push({size, v}); }
    bool empty() const { return queue_.empty(); }
    std::pair<double, int> pop() {
        const auto top = queue_.top();
        queue_.pop();
        return top;
    }

  private:
    struct Later {
        const Graph* graph;
        bool operator()(const std::pair<double, int>& a, const std::pair<double, int>& b) const {
            if (a.first != b.first) return a.first > b.first;
            return a.second != b.second && graph->comes_before(b.second, a.second);
        }
    };
    Later later_;
    std::priority_queue<std::pair<double, int>, std::vector<std::pair<double, int>>, Later> queue_;
};

// --- scaling ---

// The factor that the end w of an edge may keep, from its neighbour v.
double allowed_factor(const Graph& graph, const Bound& bound, std::span<const Tensor> input, int v, double factor_v,
                      int w, double L) {
    if (!(L > 0)) return 1;
    const Vector3d e = graph.points[w] - graph.points[v];
    return bound.limit(factor_v * directional_size(input[v], e), L) / directional_size(input[w], e);
}

std::vector<double> settle_factors(const Graph& graph, const Bound& bound, std::span<const Tensor> input,
                                   TensorGradationResult& result) {
    const int n = graph.size();
    std::vector<double> factor(n, 1), size(n);
    result.parent.assign(n, -1);
    WorkList list(graph);
    for (int v = 0; v < n; ++v) list.push(v, size[v] = mean_size(input[v]));
    while (!list.empty()) {
        const auto [key, v] = list.pop();
        if (key != factor[v] * size[v]) continue;  // it was lowered since
        if (++result.visits > kVisitsPerVertex * n) {
            result.converged = false;
            break;
        }
        for (const detail::Arc& arc : graph.arcs.at(v)) {
            const double allowed = allowed_factor(graph, bound, input, v, factor[v], arc.to, arc.length);
            if (!(allowed < factor[arc.to] * (1 - kChange))) continue;
            factor[arc.to] = allowed;
            result.parent[arc.to] = v;
            list.push(arc.to, factor[arc.to] * size[arc.to]);
        }
    }
    return factor;
}

void scale_by(std::span<const double> factor, std::span<Tensor> metrics, TensorGradationResult& result) {
    for (std::size_t v = 0; v < factor.size(); ++v) {
        if (factor[v] == 1) continue;
        ++result.lowered;
        result.largest_factor = std::max(result.largest_factor, 1 / factor[v]);
        metrics[v] = (1 / (factor[v] * factor[v])) * metrics[v];
    }
}

void scale_by_paper(const Graph& graph, const Bound& bound, std::span<Tensor> metrics, TensorGradationResult& result) {
    std::vector<double> factor(metrics.size(), 1);
    const std::vector<Tensor> input(metrics.begin(), metrics.end());
    bool any = true;
    for (; any && result.visits < kMostSweeps; ++result.visits) {
        any = false;
        for (int v = 0; v < graph.size(); ++v)
            for (const detail::Arc& arc : graph.arcs.at(v)) {
                if (arc.to < v || !(arc.length > 0)) continue;
                const Vector3d e = graph.points[arc.to] - graph.points[v];
                const double at_v = factor[v] * directional_size(input[v], e),
                             at_w = factor[arc.to] * directional_size(input[arc.to], e);
                const double small = std::min(at_v, at_w), large = std::max(at_v, at_w);
                const double limit = bound.paper_limit(small, large, arc.length);
                if (!(limit < large * (1 - kChange))) continue;
                factor[at_v > at_w ? v : arc.to] *= limit / large;
                any = true;
            }
    }
    result.converged = !any;
    scale_by(factor, metrics, result);
}

double excess_of_sizes(const Graph& graph, const Bound& bound, std::span<const Tensor> metrics) {
    double most = 0;
    for (int v = 0; v < graph.size(); ++v)
        for (const detail::Arc& arc : graph.arcs.at(v)) {
            if (!(arc.length > 0)) continue;
            const Vector3d e = graph.points[arc.to] - graph.points[v];
            const double small = directional_size(metrics[v], e), large = directional_size(metrics[arc.to], e);
            if (large > small) most = std::max(most, large / bound.limit(small, arc.length) - 1);
        }
    return most;
}

// --- intersections ---

// The metric of v as it may be at w.
Tensor grown(const Graph& graph, const TensorGradationOptions& options, double slope, const Tensor& metric, int v,
             int w) {
    const Vector3d e = graph.points[w] - graph.points[v];
    const double L = e.norm();
    const double by_metric = 1 + slope * std::sqrt(squared_in(metric, e));
    Tensor larger = metric;
    if (options.method == TensorGradationMethod::Metric) {
        larger = (1 / (by_metric * by_metric)) * metric;
    } else {
        const double t = options.method == TensorGradationMethod::Mixed ? options.mixing : 1;
        Axes axes = axes_of(metric);
        Vector3d h;
        for (int k = 0; k < 3; ++k) {
            const double growth = std::pow(1 + slope * std::sqrt(axes.values[k]) * L, t) * std::pow(by_metric, 1 - t);
            h[k] = growth / std::sqrt(axes.values[k]);
        }
        larger = metric_along(axes.directions, h);
    }
    return graph.normals.empty() ? larger : transported(larger, graph.normals[v], graph.normals[w]);
}

void intersect_all(const Graph& graph, const TensorGradationOptions& options, double slope, std::span<Tensor> metrics,
                   TensorGradationResult& result) {
    const int n = graph.size();
    const double change = options.method == TensorGradationMethod::Physical ? kChangeOfPhysical : kChangeOfBalls;
    std::vector<double> size(n);
    WorkList list(graph);
    for (int v = 0; v < n; ++v) list.push(v, size[v] = mean_size(metrics[v]));
    std::vector<char> changed(n);
    while (!list.empty()) {
        const auto [key, v] = list.pop();
        if (key != size[v]) continue;
        if (++result.visits > kVisitsPerVertex * n) {
            result.converged = false;
            break;
        }
        for (const detail::Arc& arc : graph.arcs.at(v)) {
            const Tensor bound = grown(graph, options, slope, metrics[v], v, arc.to);
            Tensor& metric = metrics[arc.to];
            if (!(largest_ratio(metric, bound) > 1 + change)) continue;
            metric = intersection(metric, bound);
            changed[arc.to] = 1;
            list.push(arc.to, size[arc.to] = mean_size(metric));
        }
    }
    result.lowered = static_cast<int>(std::count(changed.begin(), changed.end(), 1));
}

double excess_of_balls(const Graph& graph, const TensorGradationOptions& options, double slope,
                       std::span<const Tensor> metrics) {
    double most = 0;
    for (int v = 0; v < graph.size(); ++v)
        for (const detail::Arc& arc : graph.arcs.at(v))
            most =
                std::max(most, largest_ratio(metrics[arc.to], grown(graph, options, slope, metrics[v], v, arc.to)) - 1);
    return most;
}

void require_metrics(const TriMesh& mesh, std::span<const Tensor> metrics) {
    if (metrics.size() != mesh.n_vertices())
        throw std::invalid_argument("grade: " + std::to_string(metrics.size()) + " metrics for " +
                                    std::to_string(mesh.n_vertices()) + " vertices");
    for (std::size_t v = 0; v < metrics.size(); ++v)
        if (!is_positive_definite(metrics[v]))
            throw std::invalid_argument("grade: the metric at vertex " + std::to_string(v) +
                                        " is not positive definite");
}

double residual_of(TensorGradationMethod method) {
    return method == TensorGradationMethod::Physical ? kChangeOfPhysical : kResidual;
}

// Where edges are coarse the limit that scaling keeps to is below what the bound itself allows.
double excess_of_measures(const GradationReport& report, const TensorGradationOptions& options) {
    double excess = 0;
    if (options.shock) excess = std::max(excess, report.shock_max / *options.shock - 1);
    if (options.variation) excess = std::max(excess, report.variation_max / *options.variation - 1);
    return excess;
}

}  // namespace

double h_variation(const Vector3d& e, const Tensor& metric_p, const Tensor& metric_q) {
    return h_variation(e.norm(), size_along(metric_p, e), size_along(metric_q, e));
}

double log_h_shock(const Vector3d& e, const Tensor& metric_p, const Tensor& metric_q) {
    return log_h_shock(e.norm(), size_along(metric_p, e), size_along(metric_q, e));
}

GradationReport measure_gradation(const TriMesh& mesh, std::span<const Tensor> metrics) {
    require_metrics(mesh, metrics);
    GradationReport report;
    const auto points = points_of(mesh);
    std::vector<double> shocks;
    detail::for_each_edge(mesh, [&](int, int a, int b, double L) {
        if (!(L > 0)) return;
        const Vector3d e = points[b] - points[a];
        const double variation = h_variation(e, metrics[a], metrics[b]);
        shocks.push_back(std::exp(log_h_shock(e, metrics[a], metrics[b])));
        if (variation > report.variation_max) {
            report.variation_max = variation;
            report.variation_edge = {std::min(a, b), std::max(a, b)};
        }
        if (shocks.back() > report.shock_max) {
            report.shock_max = shocks.back();
            report.shock_edge = {std::min(a, b), std::max(a, b)};
        }
    });
    if (shocks.empty()) return report;
    const auto at = shocks.begin() + static_cast<std::ptrdiff_t>(.999 * static_cast<double>(shocks.size() - 1));
    std::nth_element(shocks.begin(), at, shocks.end());
    report.shock_p999 = *at;
    return report;
}

TensorGradationResult grade(const TriMesh& mesh, std::span<Tensor> metrics, const TensorGradationOptions& options) {
    const Bound bound(options);
    if (!(options.mixing >= 0 && options.mixing <= 1))
        throw std::invalid_argument("grade: the mixing is " + std::to_string(options.mixing) + ", not in [0, 1]");
    require_metrics(mesh, metrics);
    const Graph graph(mesh);
    TensorGradationResult result;
    result.before = measure_gradation(mesh, metrics);
    if (options.method == TensorGradationMethod::Shape) {
        scale_by(settle_factors(graph, bound, metrics, result), metrics, result);
    } else if (options.method == TensorGradationMethod::Paper) {
        scale_by_paper(graph, bound, metrics, result);
    } else {
        const std::vector<Tensor> input(metrics.begin(), metrics.end());
        intersect_all(graph, options, bound.slope(), metrics, result);
        for (std::size_t v = 0; v < input.size(); ++v)
            result.largest_factor = std::max(result.largest_factor, largest_ratio(input[v], metrics[v]));
    }
    result.after = measure_gradation(mesh, metrics);
    if (options.method == TensorGradationMethod::Shape)
        result.residual = excess_of_sizes(graph, bound, metrics);
    else if (options.method == TensorGradationMethod::Paper)
        result.residual = excess_of_measures(result.after, options);
    else
        result.residual = excess_of_balls(graph, options, bound.slope(), metrics);
    result.met = result.residual <= residual_of(options.method);
    return result;
}

namespace {

// The factor by which a metric is the input scaled; nothing where it is no multiple of it.
std::optional<double> factor_between(const Tensor& input, const Tensor& result) {
    const double factor = std::pow(determinant(input) / determinant(result), 1.0 / 6);
    for (int k = 0; k < 6; ++k)
        if (std::abs(result.v[k] * factor * factor - input.v[k]) > 1e-10 * (input.v[0] + input.v[2] + input.v[5]))
            return std::nullopt;
    return factor;
}

std::string at_vertex(std::size_t v) { return "vertex " + std::to_string(v); }

}  // namespace

std::optional<std::string> check_shape_certificate(const TriMesh& mesh, const TensorGradationOptions& options,
                                                   std::span<const Tensor> input, std::span<const Tensor> result,
                                                   std::span<const int> parent) {
    const Bound bound(options);
    const Graph graph(mesh);
    const std::size_t n = graph.points.size();
    if (input.size() != n || result.size() != n || parent.size() != n)
        return "metrics or parents do not match the vertices";
    for (int v = 0; v < graph.size(); ++v)
        for (const detail::Arc& arc : graph.arcs.at(v)) {
            if (!(arc.length > 0)) continue;
            const Vector3d e = graph.points[arc.to] - graph.points[v];
            if (size_along(result[arc.to], e) > bound.limit(size_along(result[v], e), arc.length) * (1 + kResidual))
                return "the bound fails on edge " + std::to_string(v) + "-" + std::to_string(arc.to);
        }
    // By how much of its parent's an excess of a vertex may be.
    std::vector<double> share(n, 0);
    for (std::size_t v = 0; v < n; ++v) {
        const std::optional<double> factor = factor_between(input[v], result[v]);
        if (!factor || *factor > 1 + kResidual) return at_vertex(v) + " is no smaller multiple of its input";
        const int p = parent[v];
        if (p < 0) {
            if (*factor < 1 - kResidual) return at_vertex(v) + " changed without a parent";
            continue;
        }
        if (p >= graph.size() ||
            !mesh.find_halfedge(mesh.vertex_handle(p), mesh.vertex_handle(static_cast<int>(v))).is_valid())
            return "the parent of " + at_vertex(v) + " is no neighbour";
        const Vector3d e = graph.points[v] - graph.points[p];
        const double h = size_along(result[v], e), limit = bound.limit(size_along(result[p], e), e.norm());
        if (std::abs(h - limit) > kResidual * limit) return at_vertex(v) + " is not tight against its parent";
        share[v] = size_along(input[p], e) / size_along(input[v], e);
    }
    // A circle of parents holds itself up unless an excess shrinks on the way around it.
    std::vector<char> state(n, 0);  // 1: on the path that is followed, 2: proved
    for (int start = 0; start < graph.size(); ++start) {
        std::vector<int> path;
        int v = start;
        for (; v >= 0 && state[v] == 0; v = parent[v]) state[v] = 1, path.push_back(v);
        if (v >= 0 && state[v] == 1) {
            double around = 1;
            for (auto i = path.rbegin();; ++i) {
                around *= share[*i];
                if (*i == v) break;
            }
            if (!(around < 1)) return at_vertex(v) + " leans on itself";
        }
        for (const int w : path) state[w] = 2;
    }
    return std::nullopt;
}

std::optional<std::string> check_intersection_certificate(const TriMesh& mesh, const TensorGradationOptions& options,
                                                          std::span<const Tensor> input,
                                                          std::span<const Tensor> result) {
    const Bound bound(options);
    const Graph graph(mesh);
    if (input.size() != graph.points.size() || result.size() != graph.points.size())
        return "metrics do not match the vertices";
    for (int v = 0; v < graph.size(); ++v) {
        if (largest_ratio(result[v], input[v]) > 1 + kResidual) return at_vertex(v) + " is not inside its input";
        for (const detail::Arc& arc : graph.arcs.at(v))
            if (largest_ratio(result[arc.to], grown(graph, options, bound.slope(), result[v], v, arc.to)) >
                1 + residual_of(options.method))
                return "the bound fails on edge " + std::to_string(v) + "-" + std::to_string(arc.to);
    }
    return std::nullopt;
}

}  // namespace gradus

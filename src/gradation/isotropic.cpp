#include "gradus/gradation/isotropic.hpp"

#include "gradus/gradation/measures.hpp"
#include "monotone_queue.hpp"
#include "vertex_graph.hpp"

#include <bit>
#include <cstdint>
#include <tuple>

namespace gradus {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double next_below(double h) { return std::bit_cast<double>(std::bit_cast<std::uint64_t>(h) - 1); }

/// h + step rounded down, so that the step that was taken is never larger than the one allowed.
double add_down(double h, double step) {
    const double sum = h + step;
    return sum - h > step ? next_below(sum) : sum;
}

/// r - 1 for the ratio r = e^u of two sizes whose H-shock over an edge is beta: u^2 / (1 - e^-u) = x. [eq. 20]
double growth(double x) {
    // Beyond, e^u overflows.
    if (x > 5e5) return kInfinity;
    if (x <= 0) return 0;
    // From ln(1 + x), close below the root of F = u^2 - x (1 - e^-u), Halley's steps converge cubically; far out the
    // root tends to sqrt(x).
    double u = std::max(std::log1p(x), std::sqrt(x) * (x > 16));
    for (int i = 0; i < 20; ++i) {
        const double decay = std::expm1(-u);
        const double F = u * u + x * decay, F1 = 2 * u - x * (1 + decay), F2 = 2 + x * (1 + decay);
        const double step = 2 * F * F1 / (2 * F1 * F1 - F * F2);
        u -= step;
        if (std::abs(step) <= 1e-6 * u) break;  // the next step would be below rounding
    }
    return std::expm1(u);
}

/// How far a settled size h lets a neighbour at distance L rise. `at_least` is a cheap lower bound of `limit`.
struct VariationLaw {
    double bound;
    double at_least(double h, double L) const { return h + bound * L; }
    double limit(double h, double L) const { return add_down(h, bound * L); }
};

struct ShockLaw {
    double log_beta;
    double at_least(double h, double L) const { return h + log_beta * L; }
    double limit(double h, double L) const { return add_down(h, h * growth(L * log_beta / h)); }
};

/// What the search keeps of a vertex, together because it is used together (most of the time is spent waiting for
/// memory).
struct Label {
    double size;
    int parent;
    int first_arc;
};

std::vector<Label> make_labels(const detail::VertexGraph& graph, std::span<const double> size) {
    std::vector<Label> labels;
    labels.reserve(size.size() + 1);
    for (std::size_t v = 0; v < size.size(); ++v) labels.push_back({size[v], -1, graph.first[v]});
    labels.push_back({kInfinity, -1, graph.first.back()});
    return labels;
}

/// Queues the vertices from which some neighbour must be lowered; no other vertex has any effect while it keeps its
/// size.
template <class Law>
detail::MonotoneQueue queue_sources(const std::vector<Label>& labels, const std::vector<detail::Arc>& arcs,
                                    const Law& law) {
    std::vector<int> sources;
    double low = kInfinity, high = 0;
    bool unset = false;
    const int n = static_cast<int>(labels.size()) - 1;
    for (int v = 0; v < n; ++v) {
        const double h = labels[v].size;
        if (std::isinf(h)) {
            unset = true;
            continue;
        }
        high = std::max(high, h);
        for (int k = labels[v].first_arc; k < labels[v + 1].first_arc; ++k)
            if (labels[arcs[k].to].size > law.at_least(h, arcs[k].length)) {
                sources.push_back(v);
                low = std::min(low, h);
                break;
            }
    }
    if (sources.empty()) return {1, 1, 0};
    // How far unset sizes will rise is not known; a guess only costs time.
    if (unset) high = std::max(high, low * 65536);
    detail::MonotoneQueue queue(low, high, labels.size());
    for (const int v : sources) queue.push(labels[v].size, v);
    return queue;
}

/// Asks the memory for what the vertices that come next will need. (Always inline: g++ 12 takes a function that only
/// fetches for one without effect, and drops its calls.)
[[gnu::always_inline]] inline void prefetch(const detail::MonotoneQueue& queue, const std::vector<Label>& labels,
                                            const std::vector<detail::Arc>& arcs) {
    if (const int v = queue.ahead(12); v >= 0) __builtin_prefetch(&labels[v]);
    if (const int v = queue.ahead(8); v >= 0) {
        const detail::Arc* arc = arcs.data() + labels[v].first_arc;
        __builtin_prefetch(arc);
        __builtin_prefetch(arc + 4);
    }
    if (const int v = queue.ahead(4); v >= 0)
        for (int k = labels[v].first_arc; k < labels[v + 1].first_arc; ++k) __builtin_prefetch(&labels[arcs[k].to]);
}

/// Of all demands on required sizes keeps the strongest at each vertex, and finds out where it comes from.
void sort_conflicts(std::vector<RequiredConflict>& conflicts, const std::vector<int>& parent) {
    std::sort(conflicts.begin(), conflicts.end(), [](const RequiredConflict& p, const RequiredConflict& q) {
        return std::tie(p.vertex, p.needed, p.neighbour) < std::tie(q.vertex, q.needed, q.neighbour);
    });
    const auto same_vertex = [](const RequiredConflict& p, const RequiredConflict& q) { return p.vertex == q.vertex; };
    conflicts.erase(std::unique(conflicts.begin(), conflicts.end(), same_vertex), conflicts.end());
    for (RequiredConflict& conflict : conflicts) {
        conflict.origin = conflict.neighbour;
        while (parent[conflict.origin] >= 0) conflict.origin = parent[conflict.origin];
    }
}

template <class Law>
EdgeReduction settle(const TriMesh& mesh, const Law& law, std::span<double> size, const std::vector<char>& required) {
    const detail::VertexGraph graph = detail::make_vertex_graph(mesh);
    const std::vector<detail::Arc>& arcs = graph.arcs;
    std::vector<Label> labels = make_labels(graph, size);
    detail::MonotoneQueue queue = queue_sources(labels, arcs, law);
    EdgeReduction result;
    double h;
    int v;
    while (queue.pop(h, v)) {
        prefetch(queue, labels, arcs);
        // Sizes spread from small to large, so a popped vertex is final (Dijkstra); older, larger labels of it are
        // void.
        if (h != labels[v].size) continue;
        if (labels[v].parent >= 0) result.certificate.order.push_back(v);
        for (int k = labels[v].first_arc; k < labels[v + 1].first_arc; ++k) {
            Label& other = labels[arcs[k].to];
            if (other.size <= law.at_least(h, arcs[k].length)) continue;
            const double limit = law.limit(h, arcs[k].length);
            if (other.size <= limit) continue;
            if (!required.empty() && required[arcs[k].to]) {
                result.conflicts.push_back({arcs[k].to, v, -1, other.size, limit});
                continue;
            }
            other.size = limit;
            other.parent = v;
            queue.push(limit, arcs[k].to);
        }
    }

    result.lowered = static_cast<int>(result.certificate.order.size());
    result.certificate.parent.resize(size.size());
    for (std::size_t w = 0; w < size.size(); ++w) {
        result.certificate.parent[w] = labels[w].parent;
        if (!(labels[w].size < size[w])) continue;
        result.largest_factor = std::max(result.largest_factor, size[w] / labels[w].size);
        size[w] = labels[w].size;
    }
    sort_conflicts(result.conflicts, result.certificate.parent);
    return result;
}

template <class Law, class Measure>
std::optional<std::string> check_certificate(const TriMesh& mesh, const Law& law, Measure excess,
                                             std::span<const double> input, std::span<const double> result,
                                             const Certificate& certificate, const std::vector<char>& required) {
    const std::size_t n = mesh.n_vertices();
    if (input.size() != n || result.size() != n || certificate.parent.size() != n)
        return "sizes or parents do not match the vertices";
    for (std::size_t v = 0; v < n; ++v) {
        if (!(result[v] > 0)) return "the size at vertex " + std::to_string(v) + " is not positive";
        if (certificate.parent[v] < 0 && result[v] != input[v])
            return "vertex " + std::to_string(v) + " changed without a parent";
        if (!(result[v] <= input[v])) return "vertex " + std::to_string(v) + " is above its input";
    }

    std::optional<std::string> fault;
    detail::for_each_edge(mesh, [&](int, int a, int b, double L) {
        const int large = result[a] > result[b] ? a : b;
        if (fault || (!required.empty() && required[large]) || excess(L, result[a], result[b]) <= 0) return;
        fault = "the bound fails on edge " + std::to_string(a) + "-" + std::to_string(b);
    });
    if (fault) return fault;

    // A vertex may lean on its parent only once the parent has settled: no circle of vertices holds itself up.
    std::vector<char> settled(n);
    for (std::size_t v = 0; v < n; ++v) settled[v] = certificate.parent[v] < 0;
    for (const int v : certificate.order) {
        const int p = v >= 0 && v < static_cast<int>(n) ? certificate.parent[v] : -1;
        if (p < 0 || p >= static_cast<int>(n))
            return "the order names vertex " + std::to_string(v) + ", which has no parent";
        if (!settled[p]) return "vertex " + std::to_string(v) + " settled before its parent";
        if (!mesh.find_halfedge(mesh.vertex_handle(p), mesh.vertex_handle(v)).is_valid())
            return "the parent of vertex " + std::to_string(v) + " is no neighbour";
        const double limit = law.limit(result[p], (points_of(mesh)[p] - points_of(mesh)[v]).norm());
        // The limit of a size is evaluated to a few units in the last place.
        if (std::abs(result[v] - limit) > 1e-14 * limit)
            return "vertex " + std::to_string(v) + " is not tight against its parent";
        settled[v] = 1;
    }
    for (std::size_t v = 0; v < n; ++v)
        if (!settled[v]) return "vertex " + std::to_string(v) + " never settled";
    return std::nullopt;
}

/// Sweeps over edges as long as something changes. `corrected` returns the size the larger end should have.
template <class Corrected>
PaperReduction iterate(const TriMesh& mesh, std::span<double> size, int max_sweeps, Corrected corrected) {
    const detail::VertexGraph graph = detail::make_vertex_graph(mesh);
    struct Edge {
        int a, b;
        double length;
    };
    std::vector<Edge> edges;
    edges.reserve(mesh.n_edges());
    detail::for_each_edge(mesh, [&](int, int a, int b, double L) { edges.push_back({a, b, L}); });

    std::vector<int> current(edges.size()), next;
    for (std::size_t e = 0; e < edges.size(); ++e) current[e] = static_cast<int>(e);
    std::vector<char> listed(edges.size(), 0), changed(size.size(), 0);
    PaperReduction result;
    while (!current.empty() && result.sweeps < max_sweeps) {
        ++result.sweeps;
        for (const int e : current) {
            const int large = size[edges[e].a] > size[edges[e].b] ? edges[e].a : edges[e].b;
            const double h = corrected(edges[e].length, size[edges[e].a + edges[e].b - large], size[large]);
            if (!(h < size[large])) continue;
            size[large] = h;
            changed[large] = 1;
            for (const detail::Arc& arc : graph.at(large)) {
                if (listed[arc.edge]) continue;
                listed[arc.edge] = 1;
                next.push_back(arc.edge);
            }
        }
        // Index order again, so that the result is a function of the mesh alone.
        std::sort(next.begin(), next.end());
        for (const int e : next) listed[e] = 0;
        current.swap(next);
        next.clear();
    }
    result.converged = current.empty();
    result.lowered = static_cast<int>(std::count(changed.begin(), changed.end(), 1));
    return result;
}

/// What measured bounds may exceed the asked ones by: rounding.
constexpr double kRounding = 1e-12;

}  // namespace

double shock_limit(double h, double L, double beta) { return ShockLaw{std::log(beta)}.limit(h, L); }

EdgeReduction limit_h_variation(const TriMesh& mesh, double bound, std::span<double> size,
                                std::span<const int> required) {
    detail::require_above(bound, 0, "H-variation bound", "limit_h_variation");
    detail::require_sizes(mesh, size, "limit_h_variation");
    return settle(mesh, VariationLaw{bound}, size, detail::required_flags(mesh, size, required, "limit_h_variation"));
}

EdgeReduction limit_h_shock(const TriMesh& mesh, double beta, std::span<double> size, std::span<const int> required) {
    detail::require_above(beta, 1, "H-shock bound", "limit_h_shock");
    detail::require_sizes(mesh, size, "limit_h_shock");
    EdgeReduction result =
        settle(mesh, ShockLaw{std::log(beta)}, size, detail::required_flags(mesh, size, required, "limit_h_shock"));
    result.coarse_edges = count_coarse_edges(mesh, beta, size);
    return result;
}

std::optional<std::string> check_variation_certificate(const TriMesh& mesh, double bound, std::span<const double> input,
                                                       std::span<const double> result, const Certificate& certificate,
                                                       std::span<const int> required) {
    const auto excess = [&](double L, double p, double q) { return h_variation(L, p, q) - bound * (1 + kRounding); };
    return check_certificate(mesh, VariationLaw{bound}, excess, input, result, certificate,
                             detail::required_flags(mesh, input, required, "check_variation_certificate"));
}

std::optional<std::string> check_shock_certificate(const TriMesh& mesh, double beta, std::span<const double> input,
                                                   std::span<const double> result, const Certificate& certificate,
                                                   std::span<const int> required) {
    const auto excess = [&](double L, double p, double q) { return h_shock(L, p, q) - beta * (1 + kRounding); };
    return check_certificate(mesh, ShockLaw{std::log(beta)}, excess, input, result, certificate,
                             detail::required_flags(mesh, input, required, "check_shock_certificate"));
}

PaperReduction paper_h_variation(const TriMesh& mesh, double bound, std::span<double> size, int max_sweeps) {
    detail::require_above(bound, 0, "H-variation bound", "paper_h_variation");
    detail::require_above(max_sweeps, 0, "largest number of sweeps", "paper_h_variation");
    detail::require_sizes(mesh, size, "paper_h_variation");
    return iterate(mesh, size, max_sweeps, [&](double L, double small, double) { return small + bound * L; });
}

PaperReduction paper_h_shock(const TriMesh& mesh, double beta, std::span<double> size, int max_sweeps) {
    detail::require_above(beta, 1, "H-shock bound", "paper_h_shock");
    detail::require_above(max_sweeps, 0, "largest number of sweeps", "paper_h_shock");
    detail::require_sizes(mesh, size, "paper_h_shock");
    const double log_beta = std::log(beta);
    return iterate(mesh, size, max_sweeps, [&](double L, double small, double large) {
        if (log_h_shock(L, small, large) <= log_beta * (1 + kRounding)) return large;
        // eta h(Q) = (beta / c)^l h(Q) is beta^l h(P), which is also right where h(Q) is not set (l = 0).
        return small * std::exp(log_beta * metric_length(L, small, large));
    });
}

}  // namespace gradus

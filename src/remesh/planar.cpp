#include "gradus/remesh/planar.hpp"

#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "gradus/mesh/closest.hpp"
#include "optimise.hpp"

namespace gradus {

using Eigen::Vector3d;

PlanarSupport::PlanarSupport(std::span<const Vector3d> points, const Features& features)
    : points_(points.begin(), points.end()), curve_of_(points.size(), {-1, 0.0}) {
    for (const FeatureChain& chain : features.chains) {
        Curve curve{{points[chain.vertex(0)]}, {0.0}, chain.closed};
        for (int i = 0; i <= chain.num_edges(); ++i) {
            const int v = chain.vertex(i);
            if (i > 0) {
                curve.length.push_back(curve.end() + (points[v] - curve.points.back()).norm());
                curve.points.push_back(points[v]);
            }
            if (!features.corner[v] && (i < chain.num_edges() || !chain.closed))
                curve_of_[v] = {static_cast<int>(curves_.size()), curve.end()};
        }
        curves_.push_back(std::move(curve));
    }
}

int PlanarSupport::Curve::edge_at(double t) const {
    const auto after = std::upper_bound(length.begin(), length.end(), t) - length.begin();
    return static_cast<int>(std::clamp<std::ptrdiff_t>(after - 1, 0, std::ssize(length) - 2));
}

Foot PlanarSupport::on_curve(int curve, double t, int cell) const {
    const Curve& c = curves_[curve];
    if (c.closed) t -= c.end() * std::floor(t / c.end());
    const int i = c.edge_at(t);
    const double length = c.length[i + 1] - c.length[i], s = length > 0 ? (t - c.length[i]) / length : 0;
    return {{{}, curve, t, cell}, (1 - s) * c.points[i] + s * c.points[i + 1], Vector3d::UnitZ()};
}

std::optional<Foot> PlanarSupport::move(const Place& from, const Vector3d&, const Vector3d& target) const {
    return Foot{{{}, -1, 0, from.cell}, target, Vector3d::UnitZ()};
}

std::optional<Foot> PlanarSupport::slide(const Place& from, const Vector3d& target) const {
    const Curve& c = curves_[from.curve];
    double t = from.t;
    for (int step = 0; step < 2; ++step) {
        const int i = c.edge_at(t);
        const Vector3d along = (c.points[i + 1] - c.points[i]).stableNormalized();
        t += along.dot(target - on_curve(from.curve, t, 0).point);
        if (c.closed) t -= c.end() * std::floor(t / c.end());
        if (!c.closed && !(t > 0 && t < c.end())) return std::nullopt;
    }
    return on_curve(from.curve, t, from.cell);
}

Foot PlanarSupport::middle(int chain, const Foot& a, const Foot& b) const {
    const Curve& c = curves_[chain];
    const bool a_inside = a.place.curve == chain, b_inside = b.place.curve == chain;
    // An end of an open chain; where the chain returns to its start, the end that is nearer along it.
    const auto end_near = [&](const Foot& corner, double other) {
        const Vector3d &first = c.points.front(), &last = c.points.back();
        if (first == last) return other > c.end() / 2 ? c.end() : 0.0;
        return (corner.point - first).squaredNorm() < (corner.point - last).squaredNorm() ? 0.0 : c.end();
    };
    double ta = a_inside ? a.place.t : 0, tb = b_inside ? b.place.t : 0;
    if (!a_inside) ta = end_near(a, tb);
    if (!b_inside) tb = end_near(b, ta);
    if (!a_inside && !b_inside && ta == tb) tb = c.end() - ta;
    if (c.closed && tb - ta > c.end() / 2) tb -= c.end();
    if (c.closed && ta - tb > c.end() / 2) ta -= c.end();
    return on_curve(chain, (ta + tb) / 2, a.place.cell);
}

Foot PlanarSupport::at_vertex(int vertex) const {
    const auto [curve, t] = curve_of_[vertex];
    return {{{}, curve, t, 0}, points_[vertex], Vector3d::UnitZ()};
}

namespace {

constexpr int kFewestPasses = 2, kMostPasses = 4;  // that bring the number of triangles near what is expected
constexpr double kFirstFactor = 0.95;              // of sizes
constexpr double kMore = 1.03;  // triangles than expected: where sizes change fast smaller elements are better shaped
constexpr double kCloseCount = 0.02;

// The label of each triangle: that of the domain under the largest triangle of its region, as feature edges bound it.
std::vector<int> labels_of(const Triangulation& domain, std::span<const Vector3d> points, const Connectivity& mesh) {
    const TriangleSoup& soup = domain.soup();
    if (soup.labels.empty()) return {};
    const ClosestTriangle closest(soup.points, soup.triangles);
    std::vector<int> labels(mesh.num_triangles()), region;
    std::vector<char> done(mesh.num_triangles());
    const auto area = [&](int t) {
        const auto [a, b, c] = mesh.triangle(t);
        return (points[b] - points[a]).cross(points[c] - points[a]).z();
    };
    for (int first = 0; first < mesh.num_triangles(); ++first) {
        if (done[first]) continue;
        done[first] = 1;
        region.assign(1, first);
        for (std::size_t i = 0; i < region.size(); ++i)
            for (int h = 3 * region[i], end = h + 3; h < end; ++h) {
                const int twin = mesh.twin(h);
                if (twin < 0 || mesh.tag(h) >= 0 || done[twin / 3]) continue;
                done[twin / 3] = 1;
                region.push_back(twin / 3);
            }
        const int largest =
            *std::max_element(region.begin(), region.end(), [&](int s, int t) { return area(s) < area(t); });
        const auto [a, b, c] = mesh.triangle(largest);
        const int label = soup.labels[closest.closest((points[a] + points[b] + points[c]) / 3).triangle];
        for (const int t : region) labels[t] = label;
    }
    return labels;
}

template <class M>
Foot foot_of(const VertexOf<M>& v) {
    return {v.place, v.p, v.n};
}

// A field whose sizes are all multiplied.
template <class M>
class ScaledField final : public MetricField<M> {
  public:
    ScaledField(const MetricField<M>& field, double factor) : field_(field), factor_(factor) {}
    typename M::Value size(const Vector3d& p, int& hint) const override { return factor_ * field_.size(p, hint); }

  private:
    const MetricField<M>& field_;
    double factor_;
};

}  // namespace

template <class M>
struct PlanarMesher<M>::State {
    explicit State(const Triangulation& of) : domain(of), support(of.soup().points, of.features()) {}
    const Triangulation& domain;
    PlanarSupport support;
    std::vector<VertexOf<M>> vertices;
};

template <class M>
PlanarMesher<M>::~PlanarMesher() = default;
template <class M>
PlanarMesher<M>::PlanarMesher(PlanarMesher&&) noexcept = default;

template <class M>
PlanarMesher<M>::PlanarMesher(const Triangulation& domain)
    : points_(domain.soup().points), mesh_(domain.mesh()), state_(std::make_unique<State>(domain)) {
    if (std::any_of(points_.begin(), points_.end(), [](const Vector3d& p) { return p.z() != 0; }))
        throw std::invalid_argument("PlanarMesher: the domain is not in the plane z = 0");
    const Frozen& frozen = domain.frozen();
    for (int h = 0; h < static_cast<int>(frozen.half_edge.size()); ++h)
        if (frozen.half_edge[h] && mesh_.twin(h) < h) mesh_.set_tag(h, frozen_tag(mesh_.tag(h)));
    for (int v = 0; v < mesh_.num_vertices(); ++v) {
        VertexOf<M> x;
        const Foot foot = state_->support.at_vertex(v);
        x.p = foot.point;
        x.n = foot.normal;
        x.place = foot.place;
        x.place.vertex = v;
        if (domain.features().corner[v] || frozen.has_vertex(v)) x.bound = Bound::Fixed;
        if (x.bound != Bound::Fixed && x.place.curve >= 0) x.bound = Bound::Curve;
        if (domain.features().corner[v]) x.lean = kAnyNormal;
        state_->vertices.push_back(x);
    }
}

template <class M>
void PlanarMesher<M>::take_cuts(const SampledBackground<M>& background) {
    std::vector<VertexOf<M>>& vertices = state_->vertices;
    // In the order in which they came the ends of a cut edge are there before its middle.
    for (const auto& [ends, tag] : background.cuts) {
        const int v = static_cast<int>(vertices.size());
        VertexOf<M> x;
        x.n = Vector3d::UnitZ();
        x.p = background.points[v];
        if (tag >= 0) {
            const Foot foot = state_->support.middle(tag, foot_of(vertices[ends[0]]), foot_of(vertices[ends[1]]));
            x.p = foot.point;
            x.place = foot.place;
            x.bound = Bound::Curve;
        }
        vertices.push_back(x);
    }
    mesh_ = background.mesh;
}

template <class M>
RemeshStatistics PlanarMesher<M>::mesh(const SampledBackground<M>& background, const RemeshOptions& options) {
    RemeshStatistics statistics;
    const InterpolatedField<M> wanted(background.points, background.mesh, background.sizes);
    statistics.predicted_triangles = check_estimate(wanted, options);
    StageClock clock(statistics.seconds);
    take_cuts(background);
    for (std::size_t v = 0; v < state_->vertices.size(); ++v)
        state_->vertices[v].place.cell = mesh_.outgoing(static_cast<int>(v)) / 3;
    // Unit edges make fewer triangles than the map asks for where sizes grow; smaller sizes make up for it. A mesh that
    // begins with a good one gets better.
    double factor = kFirstFactor;
    for (int pass = 1; pass <= kMostPasses; ++pass) {
        mesh_for(ScaledField<M>(wanted, factor), {.fast = options.fast, .goal = options.goal, .given = pass == 1},
                 statistics, clock);
        const double share = mesh_.num_triangles() / (kMore * statistics.predicted_triangles);
        if (options.fast || (pass >= kFewestPasses && std::abs(share - 1) < kCloseCount)) break;
        factor *= std::sqrt(share);
    }
    points_.clear();
    sizes_.clear();
    for (VertexOf<M>& v : state_->vertices) {
        points_.push_back(v.p);
        sizes_.push_back(wanted.size(v.p, v.place.cell));
    }
    clock.done("export");
    return statistics;
}

template <class M>
void PlanarMesher<M>::mesh_for(const MetricField<M>& field, const OptimiseOptions& options,
                               RemeshStatistics& statistics, StageClock& clock) {
    std::vector<VertexOf<M>> vertices = std::move(state_->vertices);
    for (VertexOf<M>& v : vertices) take_size(v, field.size(v.p, v.place.cell));
    EditorOf<M> editor(state_->support, field, std::move(vertices), std::move(mesh_));
    statistics.generated_triangles = editor.mesh().num_live_triangles();
    clock.done("assembly");
    take_report(optimise(editor, options, clock), statistics);
    state_->vertices = editor.vertices();
    mesh_ = editor.mesh();
}

template <class M>
TriangleSoup PlanarMesher<M>::soup() const {
    TriangleSoup soup;
    soup.points = points_;
    soup.labels = labels_of(state_->domain, points_, mesh_);
    soup.dimension = 2;
    for (int t = 0; t < mesh_.num_triangles(); ++t) {
        soup.triangles.push_back(mesh_.triangle(t));
        for (int h = 3 * t; h < 3 * t + 3; ++h) {
            const int chain = thawed_tag(mesh_.tag(h));
            if (chain < 0 || mesh_.twin(h) >= h) continue;
            soup.edges.push_back({mesh_.origin(h), mesh_.target(h)});
            soup.edge_labels.push_back(state_->domain.features().chains[chain].label);
        }
    }
    if (std::all_of(soup.edge_labels.begin(), soup.edge_labels.end(), [](int label) { return label == 0; }))
        soup.edge_labels.clear();
    for (int v = 0; v < mesh_.num_vertices(); ++v)
        if (state_->vertices[v].lean == kAnyNormal) soup.corners.push_back(v);
    soup.required = required();
    return soup;
}

template <class M>
RequiredElements PlanarMesher<M>::required() const {
    const TriangleSoup& domain = state_->domain.soup();
    RequiredElements found = domain.required;
    if (found.empty()) return found;
    std::vector<int> number(domain.points.size(), -1);
    for (int v = 0; v < mesh_.num_vertices(); ++v)
        if (state_->vertices[v].bound == Bound::Fixed) number[state_->vertices[v].place.vertex] = v;
    for (int& v : found.vertices) v = number[v];
    for (auto& [a, b] : found.edges) a = number[a], b = number[b];
    for (int& t : found.triangles) {
        const Triangle& corners = domain.triangles[t];
        int h = mesh_.find_edge(number[corners[0]], number[corners[1]]);
        if (h >= 0 && mesh_.apex(h) != number[corners[2]]) h = mesh_.twin(h);
        if (h < 0)
            throw std::logic_error("PlanarMesher: required triangle " + std::to_string(t) + " is not in the mesh");
        t = h / 3;
    }
    return found;
}

template class PlanarMesher<Size>;
template class PlanarMesher<SizeTensor>;

}  // namespace gradus

#include "gradus/plane/delaunay.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

#include "constrained_triangulation.hpp"

namespace gradus {
namespace {

using Eigen::Vector2d;
using planar::kOutside;
using planar::next;
using planar::previous;
using planar::Tri;

// Triangles that need no further point: circumradius below 1.5 times that of the unit triangle (beyond it the ideal
// point over a side is .7 away from the opposite corner), and no long edge. Rows that spread get a new point early:
// left until edges reach sqrt(2), a whole row would do so at once.
constexpr double kDoneRadius2 = 0.75;
constexpr double kDoneEdge = 1.25;
// A candidate nearer than this to a vertex is refused. Above 1/sqrt(2), as rows that crowd shed points early and one by
// one.
constexpr double kCloseFront = 0.8;
constexpr double kMovable = 0.65;  // a refused candidate nearer than this to a vertex is not worth moving
// The same for the middle of a long edge, where a short edge is the lesser evil.
constexpr double kCloseSplit = 0.55;
constexpr double kMovableSplit = 0.3;
constexpr double kLongEdge = 1.4142135623730951;
constexpr double kCollapsed = 1e-3;  // a segment this short in the metric is a point (a pole) drawn as a segment
constexpr int kWalkBound = 10000;
constexpr int kSplitSweeps = 40;
constexpr int kFlipsPerEdge = 10;

/// Symmetric metric [a b; b c].
struct Metric {
    double a = 0, b = 0, c = 0;
    double squared(const Vector2d& d) const { return a * d.x() * d.x() + 2 * b * d.x() * d.y() + c * d.y() * d.y(); }
    double length(const Vector2d& d) const { return std::sqrt(std::max(0.0, squared(d))); }
    double determinant() const { return a * c - b * b; }
};

Metric mean(const Metric& m, const Metric& n) { return {(m.a + n.a) / 2, (m.b + n.b) / 2, (m.c + n.c) / 2}; }

struct Node {
    Vector2d p;
    Metric m;
    int hint = -1;
    int pole = -1;  ///< the collapsed side it lies on, or -1
};

double cross2(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Length of a way along which the speed changes from s to t: between the logarithmic mean (sizes that grow
/// geometrically) and the arithmetic one (the way to a pole).
double mean_length(double s, double t) { return (s + t + std::sqrt(s * t)) / 3; }

/// Circumradius squared of a triangle with these sides.
double circumradius2(double x, double y, double z) {
    const double area16 = (x + y + z) * (y + z - x) * (z + x - y) * (x + y - z);
    return area16 > 0 ? x * x * y * y * z * z / area16 : 1e300;
}

/// Powers of two that bring the mean metric near the identity: a scaling that is exact, so that signs found in the
/// scaled plane hold in the caller's.
Vector2d unit_scale(const std::vector<Eigen::Matrix2d>& metrics) {
    Vector2d sum(0, 0);
    for (const Eigen::Matrix2d& m : metrics) sum += Vector2d(std::sqrt(m(0, 0)), std::sqrt(m(1, 1)));
    const auto power = [&](double s, double other) {
        const double value = s > 0 ? s : other > 0 ? other : 1.0;
        return std::ldexp(1.0, static_cast<int>(std::lround(std::log2(value / static_cast<double>(metrics.size())))));
    };
    return {power(sum.x(), sum.y()), power(sum.y(), sum.x())};
}

class Generator {
  public:
    Generator(const PlanarDomain& domain, const PlaneMetric& metric, const DelaunayOptions& options);
    PlanarMesh run();

  private:
    /// Whose metric decides on a flip: the mean of the four corners, or each of them (for triangles the metric varies
    /// much on).
    enum class Vote { Mean, Unanimous };
    struct FrontEdge {
        int triangle, a, b;
    };
    struct LongEdge {
        double length;
        int triangle, a, b;
    };
    struct Candidate {
        Vector2d p;
        Metric m;
        int hint = -1;
        int triangle = kOutside;
    };

    void read_domain();
    void mark_poles();
    void advance();
    void split_long_edges();
    std::vector<LongEdge> long_edges(const std::vector<int>& of) const;
    std::vector<int> all_triangles() const;
    int split_sweep(const std::vector<int>& triangles);
    void flip_all(Vote vote);
    bool wants_flip(int t, int k, Vote vote) const;
    void flip(int t, int k);
    PlanarMesh result() const;

    Metric ask(const Vector2d& p, int& hint) const;
    Vector2d toward(const Node& node, const Vector2d& p, const Metric& m) const;
    double length(const Node& s, const Node& t) const;
    double length(const Node& s, const Vector2d& p, const Metric& m) const;
    double length(int i, int j) const { return length(nodes_[i], nodes_[j]); }

    void push(int t, int k, int level);
    bool pop(FrontEdge& edge, int& level);
    void push_first_front();
    bool find_ideal(const FrontEdge& edge, Candidate& candidate);
    bool locate(Candidate& candidate);
    bool insert(const Candidate& candidate, double close, int level);
    bool settle(Candidate& candidate, double least);
    bool open_cavity(const Candidate& candidate);
    bool is_clear(const Candidate& candidate, double close);
    void judge_fan(int level);
    bool is_done(double x, double y, double z) const;

    auto point_of() const {
        return [this](int i) -> const Vector2d& { return nodes_[i].p; };
    }

    const PlanarDomain& domain_;
    const PlaneMetric& field_;
    const DelaunayOptions& options_;
    Vector2d scale_{1, 1};
    std::vector<Node> nodes_;
    std::vector<Tri> triangles_;
    std::vector<std::vector<std::array<int, 2>>> poles_;  // segments of each collapsed side
    std::vector<std::vector<FrontEdge>> front_;           // by level
    std::vector<std::size_t> front_head_;
    int lowest_ = 0;
    planar::Cavity cavity_;
    std::vector<int> fan_;
    std::vector<double> spokes_;
    bool splitting_ = false;
    std::vector<int> made_;  // triangles made since the last sweep of splits
    DelaunayStatistics statistics_;
};

Generator::Generator(const PlanarDomain& domain, const PlaneMetric& metric, const DelaunayOptions& options)
    : domain_(domain), field_(metric), options_(options) {
    if (!(options.target > 0))
        throw std::invalid_argument("mesh_domain: target must be positive, not " + std::to_string(options.target));
    if (!domain.hints.empty() && domain.hints.size() != domain.points.size())
        throw std::invalid_argument("mesh_domain: hints must be one per point");
    if (domain.points.size() > options.max_points) throw std::length_error("mesh_domain: more points than max_points");
    read_domain();
}

Eigen::Matrix2d checked(const Eigen::Matrix2d& m, const Vector2d& uv) {
    if (m.allFinite() && m(0, 0) >= 0 && m(1, 1) >= 0) return m;
    throw std::invalid_argument("mesh_domain: the metric at (" + std::to_string(uv.x()) + ", " +
                                std::to_string(uv.y()) + ") is not finite or not positive");
}

void Generator::read_domain() {
    const std::size_t n = domain_.points.size();
    std::vector<Eigen::Matrix2d> metrics(n);
    nodes_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
        if (!domain_.hints.empty()) nodes_[i].hint = domain_.hints[i];
        metrics[i] =
            checked(field_(domain_.points[i], nodes_[i].hint), domain_.points[i]) / (options_.target * options_.target);
    }
    if (n > 0) scale_ = unit_scale(metrics);
    for (std::size_t i = 0; i < n; ++i) {
        const Eigen::Matrix2d& m = metrics[i];
        nodes_[i].p = domain_.points[i].cwiseProduct(scale_);
        nodes_[i].m = {m(0, 0) / (scale_.x() * scale_.x()), (m(0, 1) + m(1, 0)) / 2 / (scale_.x() * scale_.y()),
                       m(1, 1) / (scale_.y() * scale_.y())};
    }
    std::vector<Vector2d> points(n);
    for (std::size_t i = 0; i < n; ++i) points[i] = nodes_[i].p;
    triangles_ = planar::triangulate_loops(points, domain_.segments);
    mark_poles();
}

/// Segments of length 0 that hang together are one pole, unless so many of them do that they are just a very fine
/// boundary.
void Generator::mark_poles() {
    std::vector<double> extent;
    const auto join = [&](int from, int to) {
        for (const auto& [i, j] : poles_[from]) nodes_[i].pole = nodes_[j].pole = to;
        poles_[to].insert(poles_[to].end(), poles_[from].begin(), poles_[from].end());
        poles_[from].clear();
        extent[to] += extent[from];
    };
    for (const auto& [a, b] : domain_.segments) {
        const Vector2d d = nodes_[b].p - nodes_[a].p;
        const double l = mean_length(nodes_[a].m.length(d), nodes_[b].m.length(d));
        if (l > kCollapsed) continue;
        const int at_a = nodes_[a].pole, at_b = nodes_[b].pole;
        const int pole = at_a >= 0 ? at_a : at_b >= 0 ? at_b : static_cast<int>(poles_.size());
        if (pole == static_cast<int>(poles_.size())) {
            poles_.emplace_back();
            extent.push_back(0);
        }
        if (at_a >= 0 && at_b >= 0 && at_a != at_b) join(at_b, pole);
        poles_[pole].push_back({a, b});
        extent[pole] += l;
        nodes_[a].pole = nodes_[b].pole = pole;
    }
    for (std::size_t pole = 0; pole < poles_.size(); ++pole)
        if (extent[pole] > 10 * kCollapsed)
            for (const auto& [i, j] : poles_[pole]) nodes_[i].pole = nodes_[j].pole = -1;
}

Metric Generator::ask(const Vector2d& p, int& hint) const {
    const Vector2d uv = p.cwiseQuotient(scale_);
    const Eigen::Matrix2d m = checked(field_(uv, hint), uv);
    const double t = 1 / (options_.target * options_.target);
    return {t * m(0, 0) / (scale_.x() * scale_.x()), t * (m(0, 1) + m(1, 0)) / 2 / (scale_.x() * scale_.y()),
            t * m(1, 1) / (scale_.y() * scale_.y())};
}

/// Where a node stands seen from p: a pole is a whole segment of the plane, so it is met at the point of it nearest to
/// p.
Vector2d Generator::toward(const Node& node, const Vector2d& p, const Metric& m) const {
    if (node.pole < 0) return node.p;
    Vector2d best = node.p;
    double best2 = m.squared(p - best);
    for (const auto& [i, j] : poles_[node.pole]) {
        const Vector2d s = nodes_[i].p, d = nodes_[j].p - s, r = p - s;
        const double dd = m.squared(d);
        const double along = m.a * d.x() * r.x() + m.b * (d.x() * r.y() + d.y() * r.x()) + m.c * d.y() * r.y();
        const Vector2d foot = s + (dd > 0 ? std::clamp(along / dd, 0.0, 1.0) : 0.0) * d;
        const double foot2 = m.squared(p - foot);
        if (foot2 < best2) {
            best = foot;
            best2 = foot2;
        }
    }
    return best;
}

double Generator::length(const Node& s, const Vector2d& p, const Metric& m) const {
    const Vector2d d = p - toward(s, p, m);
    return mean_length(s.m.length(d), m.length(d));
}

double Generator::length(const Node& s, const Node& t) const {
    if (s.pole < 0 && t.pole < 0) {
        const Vector2d d = t.p - s.p;
        return mean_length(s.m.length(d), t.m.length(d));
    }
    if (s.pole >= 0 && s.pole == t.pole) return 0;
    const Vector2d q = toward(t, s.p, s.m);
    return length(s, q, t.m);
}

bool Generator::is_done(double x, double y, double z) const {
    return x < kDoneEdge && y < kDoneEdge && z < kDoneEdge && circumradius2(x, y, z) < kDoneRadius2;
}

/// Notes the side k of triangle t, not done, as an edge of the front.
void Generator::push(int t, int k, int level) {
    if (level >= static_cast<int>(front_.size())) {
        front_.resize(level + 1);
        front_head_.resize(level + 1, 0);
    }
    front_[level].push_back({t, triangles_[t].v[next(k)], triangles_[t].v[previous(k)]});
    lowest_ = std::min(lowest_, level);
}

/// The oldest edge of the lowest level: rows are completed one after the other. Edges whose triangle has gone are
/// skipped.
bool Generator::pop(FrontEdge& edge, int& level) {
    while (lowest_ < static_cast<int>(front_.size())) {
        std::vector<FrontEdge>& row = front_[lowest_];
        std::size_t& head = front_head_[lowest_];
        if (head == row.size()) {
            row = {};
            head = 0;
            ++lowest_;
            continue;
        }
        edge = row[head++];
        level = lowest_;
        const Tri& tri = triangles_[edge.triangle];
        const int k = planar::corner_of(tri, edge.a);
        if (tri.level < 0 && tri.v[k] == edge.a && tri.v[next(k)] == edge.b) return true;
    }
    return false;
}

void Generator::push_first_front() {
    for (Tri& t : triangles_)
        t.level = is_done(length(t.v[0], t.v[1]), length(t.v[1], t.v[2]), length(t.v[2], t.v[0])) ? 0 : -1;
    for (int t = 0; t < static_cast<int>(triangles_.size()); ++t)
        for (int k = 0; k < 3; ++k) {
            const int n = triangles_[t].n[k];
            if (triangles_[t].level < 0 && (n == kOutside || triangles_[n].level >= 0)) push(t, k, 0);
        }
}

bool Generator::locate(Candidate& candidate) {
    const planar::Location at = planar::walk_to(triangles_, point_of(), candidate.triangle, candidate.p, kWalkBound);
    if (at.outcome == planar::Walk::Lost) ++statistics_.lost_walks;
    candidate.triangle = at.triangle;
    return at.outcome == planar::Walk::Found;
}

/// The point that makes an equilateral triangle with a front edge, in the metric as it is on the way there.
bool Generator::find_ideal(const FrontEdge& edge, Candidate& candidate) {
    const Node &a = nodes_[edge.a], &b = nodes_[edge.b];
    const Vector2d pa = toward(a, b.p, b.m), pb = toward(b, a.p, a.m);
    // The metric of a pole knows nothing across the approach: the other end speaks for both.
    const Metric m = a.pole >= 0 ? b.m : b.pole >= 0 ? a.m : mean(a.m, b.m);
    const double l = length(a, b);
    const Vector2d e = pb - pa;
    const double e2 = m.squared(e), det = m.determinant();
    if (l < kCollapsed || !(e2 > 0) || !(det > 0)) return false;
    // Orthogonal to e in the metric, to its left, of length 1.
    const Vector2d normal = Vector2d(-(m.b * e.x() + m.c * e.y()), m.a * e.x() + m.b * e.y()) / std::sqrt(det * e2);
    const Vector2d tangent = e / std::sqrt(e2);
    const double height = std::sqrt(std::max(1 - l * l / 4, 0.25));
    double s = height, t = 0;
    candidate.triangle = edge.triangle;
    candidate.hint = a.hint;
    constexpr int kSteps = 4;
    constexpr double kEnough = 0.01;
    for (int step = 0; step < kSteps; ++step) {
        candidate.p = (pa + pb) / 2 + s * normal + t * tangent;
        if (!locate(candidate)) return false;
        candidate.m = ask(candidate.p, candidate.hint);
        const double la = length(a, candidate.p, candidate.m), lb = length(b, candidate.p, candidate.m);
        // Coordinates of the apex of the flat triangle with sides l, la, lb.
        const double x = (la * la - lb * lb) / (2 * l);
        const double y = std::sqrt(std::max(la * la - (x + l / 2) * (x + l / 2), 0.01));
        if (std::abs(x) < kEnough && std::abs(y - height) < kEnough) break;
        s *= std::clamp(height / y, 0.4, 2.5);
        t -= std::clamp(x, -0.5, 0.5);
    }
    return true;
}

/// Collects what the candidate replaces: the triangles whose circumcircle in the metric at the candidate holds it.
bool Generator::open_cavity(const Candidate& candidate) {
    const auto in_conflict = [&](int t) {
        const auto& v = triangles_[t].v;
        Vector2d d[3];
        bool seen_from_pole = false;
        for (int k = 0; k < 3; ++k) {
            const Node& node = nodes_[v[k]];
            seen_from_pole |= node.pole >= 0;
            d[k] = toward(node, candidate.p, candidate.m) - candidate.p;
        }
        if (seen_from_pole && !(cross2(d[1] - d[0], d[2] - d[0]) > 0))
            for (int k = 0; k < 3; ++k) d[k] = nodes_[v[k]].p - candidate.p;
        const Metric& m = candidate.m;
        return m.squared(d[0]) * cross2(d[1], d[2]) + m.squared(d[1]) * cross2(d[2], d[0]) +
                   m.squared(d[2]) * cross2(d[0], d[1]) >
               0;
    };
    return planar::grow_cavity(triangles_, point_of(), in_conflict, candidate.triangle, candidate.p, cavity_);
}

/// True if no vertex is closer to the candidate than `close`. Measures the spokes on the way. The nearest vertex is on
/// the rim of the cavity in a Delaunay triangulation; where the triangulation is far from that, the search goes on
/// beyond the rim edges that pass the candidate at less than the distance.
bool Generator::is_clear(const Candidate& candidate, double close) {
    const auto passes_near = [&](int i, int j) {
        const Vector2d a = nodes_[i].p - candidate.p, b = nodes_[j].p - candidate.p;
        const double area = cross2(a, b);
        return candidate.m.determinant() * area * area < close * close * candidate.m.squared(b - a);
    };
    spokes_.clear();
    for (const planar::RimEdge& e : cavity_.rim) {
        spokes_.push_back(length(nodes_[e.a], candidate.p, candidate.m));
        if (spokes_.back() < close) return false;
    }
    cavity_.stack.clear();
    for (const planar::RimEdge& e : cavity_.rim)
        if (e.outer != kOutside && passes_near(e.a, e.b)) cavity_.stack.push_back({e.outer, e.outer_side});
    constexpr int kBound = 100;
    for (int step = 0; step < kBound && !cavity_.stack.empty(); ++step) {
        const auto [t, k] = cavity_.stack.back();
        cavity_.stack.pop_back();
        const Tri& tri = triangles_[t];
        if (length(nodes_[tri.v[k]], candidate.p, candidate.m) < close) return false;
        for (const int side : {next(k), previous(k)}) {
            const int beyond = tri.n[side];
            if (beyond != kOutside && passes_near(tri.v[next(side)], tri.v[previous(side)]))
                cavity_.stack.push_back({beyond, planar::side_of(triangles_[beyond], t)});
        }
    }
    return true;
}

bool Generator::insert(const Candidate& candidate, double close, int level) {
    if (!open_cavity(candidate)) return false;
    if (!is_clear(candidate, close)) return false;
    if (nodes_.size() >= options_.max_points)
        throw std::length_error("mesh_domain: more than " + std::to_string(options_.max_points) + " points");
    planar::fill_cavity(triangles_, static_cast<int>(nodes_.size()), cavity_, fan_);
    nodes_.push_back({candidate.p, candidate.m, candidate.hint, -1});
    judge_fan(level);
    if (splitting_) made_.insert(made_.end(), fan_.begin(), fan_.end());
    return true;
}

/// Finds which of the new triangles are done, and with it where the front now stands.
void Generator::judge_fan(int level) {
    const std::size_t n = fan_.size();
    for (std::size_t i = 0; i < n; ++i) {
        const planar::RimEdge& e = cavity_.rim[i];
        if (is_done(spokes_[i], spokes_[i + 1 == n ? 0 : i + 1], length(e.a, e.b))) triangles_[fan_[i]].level = level;
    }
    for (std::size_t i = 0; i < n; ++i) {
        const int t = fan_[i];
        const bool done = triangles_[t].level >= 0;
        for (int k = 0; k < 3; ++k) {
            const int other = triangles_[t].n[k];
            if (other == kOutside) {
                if (!done) push(t, k, 0);
            } else if (const bool other_done = triangles_[other].level >= 0; !done && other_done) {
                push(t, k, triangles_[other].level);
            } else if (done && !other_done && k == 0) {
                push(other, planar::side_of(triangles_[other], t), level);
            }
        }
    }
}

/// Moves a refused candidate half way out of the unit discs of the vertices that crowd it: where two sides of the front
/// meet at an angle, to the bisector. @returns false if one of them is nearer than `least`
bool Generator::settle(Candidate& candidate, double least) {
    if (!open_cavity(candidate)) return false;
    Vector2d push(0, 0);
    for (const planar::RimEdge& e : cavity_.rim) {
        const double l = length(nodes_[e.a], candidate.p, candidate.m);
        if (l < least) return false;
        if (l < 1) push += 0.5 * (1 - l) / l * (candidate.p - toward(nodes_[e.a], candidate.p, candidate.m));
    }
    candidate.p += push;
    if (!locate(candidate)) return false;
    candidate.m = ask(candidate.p, candidate.hint);
    return true;
}

void Generator::advance() {
    FrontEdge edge;
    int level = 0;
    Candidate candidate;
    while (pop(edge, level)) {
        bool inserted = false;
        if (find_ideal(edge, candidate)) {
            inserted = insert(candidate, kCloseFront, level + 1);
            if (!inserted && settle(candidate, kMovable)) inserted = insert(candidate, kCloseFront, level + 1);
        }
        ++(inserted ? statistics_.front_points : statistics_.refused);
    }
}

/// Inner edges above sqrt(2) of the given triangles, seen from the triangle of the lower index where both are given.
std::vector<Generator::LongEdge> Generator::long_edges(const std::vector<int>& of) const {
    std::vector<LongEdge> edges;
    for (const int t : of)
        for (int k = 0; k < 3; ++k) {
            const int other = triangles_[t].n[k];
            if (other == kOutside || (other < t && std::binary_search(of.begin(), of.end(), other))) continue;
            const int a = triangles_[t].v[next(k)], b = triangles_[t].v[previous(k)];
            const double l = length(a, b);
            if (l > kLongEdge) edges.push_back({l, t, a, b});
        }
    return edges;
}

std::vector<int> Generator::all_triangles() const {
    std::vector<int> all(triangles_.size());
    std::iota(all.begin(), all.end(), 0);
    return all;
}

/// Fronts that meet leave gaps too narrow for an ideal point; edges across them are halved.
int Generator::split_sweep(const std::vector<int>& triangles) {
    std::vector<LongEdge> edges = long_edges(triangles);
    std::sort(edges.begin(), edges.end(), [](const LongEdge& x, const LongEdge& y) {
        return x.length != y.length       ? x.length > y.length
               : x.triangle != y.triangle ? x.triangle < y.triangle
                                          : x.a < y.a;
    });
    int inserted = 0;
    for (const LongEdge& e : edges) {
        const Tri& tri = triangles_[e.triangle];
        const int k = planar::corner_of(tri, e.a);
        if (tri.v[k] != e.a || tri.v[next(k)] != e.b) continue;
        const Node &a = nodes_[e.a], &b = nodes_[e.b];
        // Half way in the metric, taken as linear along the edge in size.
        const Vector2d pa = toward(a, b.p, b.m), pb = toward(b, pa, a.m), d = pb - pa;
        const double sa = a.m.length(d), sb = b.m.length(d);
        const double half =
            sa + sb > 0 && a.pole < 0 && b.pole < 0 ? std::sqrt(sb) / (std::sqrt(sa) + std::sqrt(sb)) : 0.5;
        Candidate candidate{.p = pa + std::clamp(half, 0.2, 0.8) * d, .m = {}, .hint = a.hint, .triangle = e.triangle};
        if (!locate(candidate)) continue;
        candidate.m = ask(candidate.p, candidate.hint);
        if (insert(candidate, kCloseSplit, 0) ||
            (settle(candidate, kMovableSplit) && insert(candidate, kCloseSplit, 0)))
            ++inserted;
    }
    return inserted;
}

void Generator::split_long_edges() {
    splitting_ = true;
    std::vector<int> triangles = all_triangles();
    for (int sweep = 0; sweep < kSplitSweeps; ++sweep) {
        made_.clear();
        const int inserted = split_sweep(triangles);
        statistics_.split_points += inserted;
        if (inserted == 0) return;
        advance();
        // What was refused stays refused until the triangles there change.
        std::sort(made_.begin(), made_.end());
        made_.erase(std::unique(made_.begin(), made_.end()), made_.end());
        triangles = made_;
    }
    statistics_.splits_bounded = true;
}

PlanarMesh Generator::result() const {
    PlanarMesh mesh;
    mesh.points.reserve(nodes_.size());
    mesh.hints.reserve(nodes_.size());
    for (const Node& node : nodes_) {
        mesh.points.push_back(node.p.cwiseQuotient(scale_));
        mesh.hints.push_back(node.hint);
    }
    mesh.triangles.reserve(triangles_.size());
    std::vector<char> used(nodes_.size(), 0);
    for (const Tri& t : triangles_) {
        mesh.triangles.push_back(t.v);
        for (const int i : t.v) used[i] = 1;
    }
    mesh.statistics = statistics_;
    mesh.statistics.long_edges = static_cast<int>(long_edges(all_triangles()).size());
    mesh.statistics.unused_points = static_cast<int>(std::count(used.begin(), used.end(), 0));
    return mesh;
}

/// True if the edge opposite corner k of t is not Delaunay in the metric of the corners, and can be flipped.
bool Generator::wants_flip(int t, int k, Vote vote) const {
    const Tri& tri = triangles_[t];
    if (tri.n[k] == kOutside) return false;
    const Tri& other = triangles_[tri.n[k]];
    // Quadrilateral apex, a, opposite, b; the edge is a b.
    const std::array<int, 4> v{tri.v[k], tri.v[next(k)], other.v[planar::side_of(other, t)], tri.v[previous(k)]};
    Metric m;
    Vector2d centre(0, 0);
    int plain = 0;
    bool pole = false;
    for (const int i : v) {
        const Node& node = nodes_[i];
        pole |= node.pole >= 0;
        if (node.pole >= 0) continue;
        m = {m.a + node.m.a, m.b + node.m.b, m.c + node.m.c};
        centre += node.p;
        ++plain;
    }
    if (plain == 0) return false;
    std::array<Vector2d, 4> q;
    for (int i = 0; i < 4; ++i) q[i] = pole ? toward(nodes_[v[i]], centre / plain, m) : nodes_[v[i]].p;
    if (pole && !(cross2(q[1] - q[0], q[3] - q[0]) > 0 && cross2(q[3] - q[2], q[1] - q[2]) > 0))
        for (int i = 0; i < 4; ++i) q[i] = nodes_[v[i]].p;
    const Vector2d a = q[0] - q[2], b = q[1] - q[2], c = q[3] - q[2];
    const auto in_circle = [&](const Metric& metric) {
        const double aa = metric.squared(a) * cross2(b, c), bb = metric.squared(b) * cross2(c, a),
                     cc = metric.squared(c) * cross2(a, b);
        constexpr double kRounding = 1e-12;  // a tie is left as it is, or rounding could flip for ever
        return aa + bb + cc > kRounding * (std::abs(aa) + std::abs(bb) + std::abs(cc));
    };
    if (vote == Vote::Mean && !in_circle(m)) return false;
    if (vote == Vote::Unanimous)
        for (const int i : v)
            if (nodes_[i].pole < 0 && !in_circle(nodes_[i].m)) return false;
    return orient2d(nodes_[v[0]].p, nodes_[v[1]].p, nodes_[v[2]].p) > 0 &&
           orient2d(nodes_[v[0]].p, nodes_[v[2]].p, nodes_[v[3]].p) > 0;
}

/// Turns edge a b of triangles (apex, a, b) and (opposite, b, a) into the edge apex - opposite; t keeps a, its
/// neighbour b.
void Generator::flip(int t, int k) {
    const int u = triangles_[t].n[k];
    Tri &tri = triangles_[t], &other = triangles_[u];
    const int j = planar::side_of(other, t);
    const int apex = tri.v[k], a = tri.v[next(k)], b = tri.v[previous(k)], opposite = other.v[j];
    const int beyond_b = tri.n[next(k)], beyond_a = tri.n[previous(k)];    // across b apex, apex a
    const int under_a = other.n[next(j)], under_b = other.n[previous(j)];  // across a opposite, opposite b
    if (beyond_b != kOutside) triangles_[beyond_b].n[planar::side_of(triangles_[beyond_b], t)] = u;
    if (under_a != kOutside) triangles_[under_a].n[planar::side_of(triangles_[under_a], u)] = t;
    tri.v = {apex, a, opposite};
    tri.n = {under_a, u, beyond_a};
    other.v = {apex, opposite, b};
    other.n = {under_b, beyond_b, t};
}

/// Makes the triangulation Delaunay in the metric, as far as a metric that varies allows. [Lawson 1977]
void Generator::flip_all(Vote vote) {
    const long bound = kFlipsPerEdge * 3L * static_cast<long>(triangles_.size());
    long flips = 0;
    std::vector<int> stack;
    for (int first = 0; first < static_cast<int>(triangles_.size()); ++first) {
        stack.assign(1, first);
        while (!stack.empty()) {
            const int t = stack.back();
            stack.pop_back();
            for (int k = 0; k < 3; ++k) {
                if (!wants_flip(t, k, vote)) continue;
                if (flips == bound) {
                    statistics_.flips_bounded = true;
                    statistics_.flips += static_cast<int>(flips);
                    return;
                }
                ++flips;
                const int u = triangles_[t].n[k];
                flip(t, k);
                stack.push_back(u);
                stack.push_back(t);
                break;
            }
        }
    }
    statistics_.flips += static_cast<int>(flips);
}

PlanarMesh Generator::run() {
    flip_all(Vote::Unanimous);
    push_first_front();
    advance();
    flip_all(Vote::Mean);
    split_long_edges();
    flip_all(Vote::Mean);
    return result();
}

}  // namespace

PlanarMesh mesh_domain(const PlanarDomain& domain, const PlaneMetric& metric, const DelaunayOptions& options) {
    return Generator(domain, metric, options).run();
}

}  // namespace gradus

#include "editor.hpp"

#include "derivatives.hpp"
#include "gradus/control/metric.hpp"
#include "gradus/surface/unit_normal.hpp"

#include <Eigen/Geometry>
#include <array>
#include <limits>
#include <numbers>

namespace gradus {

namespace {

constexpr int kMostSpokes = 40;       // vertices of higher valence are left to flips first
constexpr double kStillMoves = 2e-3;  // moves below this fraction of the size are not worth making
constexpr int kPairRounds = 4;
constexpr double kPush = 0.4;  // of an edge
constexpr int kMendRounds = 3;
constexpr std::size_t kMostWays = 40;  // to mend a fault, that the guard is asked for
constexpr double kBadlyMended =
    1e5;  // energy around, where it was not more before: that of a triangle of a quality of .25
constexpr double kOpposed =
    0.2;  // cosine of the angle between normals: the ends of an edge may be on the two walls of a crevice
constexpr double kDeep = 0.5;  // over the size
constexpr double kLongestBridge2 =
    1;  // of the halves, squared, over the edge that is split, where its ends are on the walls of a crevice
constexpr double kLongestHalf2 = 0.72;       // squared, over the edge that is split
constexpr double kFarthestMiddle2 = 0.3;     // the same on a feature curve, which may be half a circle
constexpr double kLongestByCollapse = 1.85;  // in the metric
constexpr double kAboutAsLong =
    1.05;  // over what it was: edges that are too long anyway, as those across a row of needles
constexpr double kBadEnergy =
    1.13;  // of a triangle (a quality of about .89) that is worth a search without derivatives
constexpr double kWorseByHalving = 1.6;  // energy over that of the whole: a needle's halves are up to 1.5 times as bad
constexpr float kSharpCrease = 0.67f;  // lean of creases, to which triangles agree that turn by 84 degrees from what is
                                       // the other way around: 96 degrees
constexpr double kLegalEnergy =
    12;  // a triangle above this is degenerate or folded: no operation may make one that is worse than what was

// Normal, as long as twice the area.
template <class M>
Eigen::Vector3d area_vector(const VertexOf<M>& a, const VertexOf<M>& b, const VertexOf<M>& c) {
    return (b.p - a.p).cross(c.p - a.p);
}

// Corners and sharp creases do not know on which side the surface is: between three of their vertices, beside a notch,
// a triangle may be outside.
template <class M>
bool may_be_outside(const VertexOf<M>& a, const VertexOf<M>& b, const VertexOf<M>& c) {
    return a.lean < kSharpCrease && b.lean < kSharpCrease && c.lean < kSharpCrease;
}

// What an operation may make of the triangles that it replaces: none that is degenerate or folded, unless one of those
// was worse.
template <class M>
class Legality {
  public:
    using Vertex = VertexOf<M>;
    explicit Legality(double size_weight = kSizeWeight) : size_weight_(size_weight) {}

    // A triangle that goes.
    void had(const Vertex& a, const Vertex& b, const Vertex& c) {
        const double energy = triangle_energy(a, b, c, size_weight_);
        energy_ = std::max(energy_, energy);
        if (energy > kLegalEnergy) fold_ = std::max(fold_, fold_of(a, b, c));
    }
    // @param instead_of  normal of what the triangle that comes is in the place of, of any length
    // @param worse       by how much its energy may be above that of those that went
    bool allows(const Vertex& a, const Vertex& b, const Vertex& c, const Eigen::Vector3d& instead_of,
                double worse = 1) const {
        const double energy = triangle_energy(a, b, c, size_weight_);
        if (may_be_outside(a, b, c) && !(area_vector(a, b, c).dot(instead_of) > 0)) return false;
        // Needles have a large energy too, which is no leave to fold.
        return energy <= worse * energy_ && (energy <= kLegalEnergy || fold_of(a, b, c) <= fold_);
    }

  private:
    static double fold_of(const Vertex& a, const Vertex& b, const Vertex& c) {
        return fold_penalty(least_agreement(a, b, c, area_vector(a, b, c).stableNormalized()));
    }
    double size_weight_;
    double energy_ = kLegalEnergy;
    double fold_ = 0;  // of needles: they turn no farther than goes unpunished
};

int penalty(int valence, bool boundary) {
    const int off = valence - (boundary ? 4 : 6);
    return off * off;
}

}  // namespace

template <class M>
double EditorOf<M>::energy(int t) const {
    const Triangle v = mesh_.triangle(t);
    return triangle_energy(vertices_[v[0]], vertices_[v[1]], vertices_[v[2]]);
}

template <class M>
double EditorOf<M>::quality(int t) const {
    const Triangle v = mesh_.triangle(t);
    return triangle_quality(vertices_[v[0]], vertices_[v[1]], vertices_[v[2]]);
}

template <class M>
double EditorOf<M>::unit_area(int t) const {
    const Triangle v = mesh_.triangle(t);
    const Vertex &a = vertices_[v[0]], &b = vertices_[v[1]], &c = vertices_[v[2]];
    return (b.p - a.p).cross(c.p - a.p).norm() * (2 / 1.7320508075688772) / (a.g * b.g * c.g);
}

template <class M>
double EditorOf<M>::length(int h) const {
    return length_between(vertices_[mesh_.origin(h)], vertices_[mesh_.target(h)]);
}

template <class M>
double EditorOf<M>::fan_ratio(int v) const {
    double shortest2 = std::numeric_limits<double>::infinity(), longest2 = 0;
    mesh_.for_each_edge(v, [&](int, int other) {
        const double length2 = squared_at(vertices_[v], vertices_[other].p - vertices_[v].p);
        shortest2 = std::min(shortest2, length2);
        longest2 = std::max(longest2, length2);
    });
    return shortest2 > 0 ? std::sqrt(longest2 / shortest2) : std::numeric_limits<double>::infinity();
}

template <class M>
bool EditorOf<M>::holds_now_and_then() {
    constexpr int kSeldom = 256;
    if (++unchecked_ < std::max(kSeldom, mesh_.num_triangles())) return true;
    unchecked_ = 0;
    return holds();
}

template <class M>
bool EditorOf<M>::holds() const {
    if (static_cast<int>(vertices_.size()) != mesh_.num_vertices() || !mesh_.check().empty()) return false;
    for (int v = 0; v < mesh_.num_vertices(); ++v)
        if (mesh_.is_live_vertex(v) && !is_sound(vertices_[v])) return false;
    for (int h = 0; h < 3 * mesh_.num_triangles(); ++h) {
        if (!mesh_.is_live_triangle(h / 3) || !is_frozen(h)) continue;
        for (const int v : {mesh_.origin(h), mesh_.target(h)})
            if (vertices_[v].bound != Bound::Fixed) return false;
    }
    return true;
}

template <class M>
void EditorOf<M>::set_vertex(int v, const Vertex& x) {
    GRADUS_ASSERT(v >= 0 && v < static_cast<int>(vertices_.size()) && is_sound(x));
    if (recording_) recording_->saved.emplace_back(v, vertices_[v]);
    vertices_[v] = x;
}

template <class M>
double EditorOf<M>::ring_energy(int v, const Vertex& x, Aim aim) const {
    double sum = 0;
    mesh_.for_each_outgoing(v, [&](int h) {
        sum += weighted(triangle_energy(x, vertices_[mesh_.target(h)], vertices_[mesh_.apex(h)]), aim);
    });
    if (x.bound == Bound::Curve)
        for_each_on_curve(v, [&](int other) { sum += weighted(edge_energy(x, vertices_[other]), aim); });
    return sum;
}

template <class M>
bool EditorOf<M>::turns_over(int v, const Vertex& moved) const {
    bool any = false;
    if (moved.lean < kSharpCrease)
        mesh_.for_each_outgoing(v, [&](int h) {
            const Vertex &a = vertices_[mesh_.target(h)], &b = vertices_[mesh_.apex(h)];
            any = any ||
                  (may_be_outside(moved, a, b) && !(area_vector(moved, a, b).dot(area_vector(vertices_[v], a, b)) > 0));
        });
    return any;
}

namespace {

// Towards the least energy; down its slope where it is not convex.
std::array<double, 2> newton_step(const Derivatives& d, Bound bound) {
    if (bound == Bound::Curve) return {-d.gx / d.hxx, 0};
    const double trace = d.hxx + d.hyy;
    const double det = d.hxx * d.hyy - d.hxy * d.hxy;
    if (det > 1e-3 * trace * trace && trace > 0)
        return {-(d.hyy * d.gx - d.hxy * d.gy) / det, -(d.hxx * d.gy - d.hxy * d.gx) / det};
    const double steep = std::max(std::abs(trace), 1e-300);
    return {-d.gx / steep, -d.gy / steep};
}

}  // namespace

template <class M>
Eigen::Vector3d EditorOf<M>::axis_at(int v) const {
    const Vertex& x = vertices_[v];
    if (x.bound != Bound::Curve) return any_tangent(x.n);
    Eigen::Vector3d u = Eigen::Vector3d::Zero();
    for_each_on_curve(v, [&](int other) {
        const Eigen::Vector3d d = vertices_[other].p - x.p;
        u += u.dot(d) < 0 ? Eigen::Vector3d(-d) : d;
    });
    return u.squaredNorm() > 0 ? u.normalized() : u;
}

template <class M>
double EditorOf<M>::relax(int v, Aim aim) {
    ++moves_;
    const Vertex& x = vertices_[v];
    if (x.bound == Bound::Fixed || mesh_.valence(v) > kMostSpokes) return 0;
    const Eigen::Vector3d axis = axis_at(v);
    if (!(axis.squaredNorm() > 0)) return 0;
    const TangentAxes axes = tangent_axes(x, axis);
    Derivatives d;
    double shortest2 = std::numeric_limits<double>::infinity();
    mesh_.for_each_outgoing(v, [&](int h) {
        const Vertex &a = vertices_[mesh_.target(h)], &b = vertices_[mesh_.apex(h)];
        shortest2 = std::min({shortest2, squared_at(x, a.p - x.p), squared_at(x, b.p - x.p)});
        add_triangle(x, a, b, axes, aim, d);
    });
    if (x.bound == Bound::Curve)
        for_each_on_curve(v, [&](int other) { add_edge(x, vertices_[other], axes.u, aim, d); });
    if (x.bound == Bound::Curve && !(d.hxx > 0)) return 0;
    auto [sx, sy] = newton_step(d, x.bound);
    double step = std::sqrt(sx * sx + sy * sy);
    const double longest = 0.5 * std::sqrt(shortest2);
    if (step > longest) {
        sx *= longest / step;
        sy *= longest / step;
        step = longest;
    }
    const auto moved_by = [&](double along_u, double along_w) -> std::optional<Vertex> {
        const Eigen::Vector3d target = x.p + along_u * axes.u + along_w * axes.v;
        const std::optional<Foot> foot =
            x.bound == Bound::Curve ? support_.slide(x.place, target) : support_.move(x.place, x.p, target);
        if (!foot) return std::nullopt;
        Vertex moved = x;
        stand(moved, *foot, support_, field_);
        return moved;
    };
    for (int halving = 0; halving < 3 && step > kStillMoves * x.h; ++halving, sx /= 3, sy /= 3, step /= 3) {
        const std::optional<Vertex> moved = moved_by(sx, sy);
        if (!moved || ring_energy(v, *moved, aim) >= d.value || turns_over(v, *moved)) continue;
        const double part = step / moved->h;
        set_vertex(v, *moved);
        return part;
    }
    const bool stuck = d.folded || (aim == Aim::Worst && d.worst > kBadEnergy);
    if (!stuck || x.bound != Bound::Free) return 0;
    // Where the surface bends within one edge the penalty rules: the best of a few directions.
    double least = d.value;
    std::optional<Vertex> best;
    for (const double reach : {0.2 * x.h, 0.05 * x.h})
        for (int i = 0; i < 8; ++i) {
            constexpr double kDiagonal = std::numbers::sqrt2 / 2;
            constexpr double kCos[8] = {1, kDiagonal, 0, -kDiagonal, -1, -kDiagonal, 0, kDiagonal};
            const std::optional<Vertex> moved = moved_by(reach * kCos[i], reach * kCos[(i + 6) % 8]);
            if (!moved) continue;
            const double energy = ring_energy(v, *moved, aim);
            if (energy < least) least = energy, best = moved;
        }
    if (!best) return 0;
    const double part = std::sqrt(squared_at(*best, best->p - x.p)) / best->h;
    set_vertex(v, *best);
    return part;
}

template <class M>
double EditorOf<M>::centre(int v, int a, int b) {
    const Vertex& x = vertices_[v];
    const double to_a = length_between(x, vertices_[a]), to_b = length_between(x, vertices_[b]);
    const Eigen::Vector3d step = to_a > to_b ? (to_a - to_b) / (2 * to_a) * (vertices_[a].p - x.p)
                                             : (to_b - to_a) / (2 * to_b) * (vertices_[b].p - x.p);
    const double part = std::sqrt(squared_at(x, step)) / x.h;
    if (!(part > kStillMoves)) return 0;
    const std::optional<Foot> foot = support_.slide(x.place, x.p + step);
    if (!foot) return 0;
    Vertex moved = x;
    stand(moved, *foot, support_, field_);
    Legality<M> legality(0);
    mesh_.for_each_outgoing(v, [&](int h) { legality.had(x, vertices_[mesh_.target(h)], vertices_[mesh_.apex(h)]); });
    bool legal = true;
    mesh_.for_each_outgoing(v, [&](int h) {
        const Vertex &c = vertices_[mesh_.target(h)], &d = vertices_[mesh_.apex(h)];
        legal = legal && legality.allows(moved, c, d, area_vector(x, c, d));
    });
    if (!legal) return 0;
    set_vertex(v, moved);
    return part;
}

template <class M>
int EditorOf<M>::valence_penalty(int v, int by) const {
    return vertices_[v].lean == kAnyNormal ? 0 : penalty(mesh_.valence(v) + by, mesh_.is_boundary_vertex(v));
}

template <class M>
int EditorOf<M>::least_valence(int v) const {
    if (mesh_.is_boundary_vertex(v)) return vertices_[v].bound == Bound::Fixed ? 2 : 3;
    return vertices_[v].lean == kAnyNormal ? 3 : 4;
}

template <class M>
int EditorOf<M>::flip_gain(int h) const {
    const int g = mesh_.twin(h);
    const auto change = [&](int v, int by) { return valence_penalty(v, 0) - valence_penalty(v, by); };
    return change(mesh_.origin(h), -1) + change(mesh_.target(h), -1) + change(mesh_.apex(h), 1) +
           change(mesh_.apex(g), 1);
}

template <class M>
int EditorOf<M>::collapse_gain(int h) const {
    const int v = mesh_.origin(h), w = mesh_.target(h), g = mesh_.twin(h);
    const auto of = [&](int x, int by) { return valence_penalty(x, by); };
    const int shared = g < 0 ? 1 : 2;
    int gain = of(v, 0) + of(w, 0) - of(w, mesh_.valence(v) - 2 - shared);
    gain += of(mesh_.apex(h), 0) - of(mesh_.apex(h), -1);
    if (g >= 0) gain += of(mesh_.apex(g), 0) - of(mesh_.apex(g), -1);
    return gain;
}

template <class M>
bool EditorOf<M>::can_flip(int h) const {
    const int g = mesh_.twin(h);
    if (g < 0 || mesh_.tag(h) >= 0) return false;
    const auto spare = [&](int v) { return mesh_.valence(v) > least_valence(v); };
    return spare(mesh_.origin(h)) && spare(mesh_.target(h)) && mesh_.find_edge(mesh_.apex(h), mesh_.apex(g)) < 0;
}

template <class M>
double EditorOf<M>::flip_height(int h) const {
    const Vertex &v = vertices_[mesh_.origin(h)], &w = vertices_[mesh_.target(h)], &c = vertices_[mesh_.apex(h)],
                 &d = vertices_[mesh_.apex(mesh_.twin(h))];
    const Eigen::Vector3d n = (w.p - v.p).cross(d.p - c.p);
    const double length = n.norm();
    return length > 0 ? std::abs((c.p - v.p).dot(n)) / (length * std::min({v.h, w.h, c.h, d.h}))
                      : std::numeric_limits<double>::infinity();
}

template <class M>
double EditorOf<M>::flip_rise(int h, double enough) const {
    const int g = mesh_.twin(h);
    const Vertex &v = vertices_[mesh_.origin(h)], &w = vertices_[mesh_.target(h)], &c = vertices_[mesh_.apex(h)],
                 &d = vertices_[mesh_.apex(g)];
    const double before = triangle_energy(v, w, c) + triangle_energy(w, v, d);
    // No triangle has less than 1.
    if (2 - before >= enough) return 2 - before;
    return triangle_energy(v, d, c) + triangle_energy(d, w, c) - before;
}

template <class M>
bool EditorOf<M>::bridges(const Vertex& a, const Vertex& b) const {
    if (a.n.dot(b.n) > kOpposed) return false;
    const std::optional<Foot> foot = support_.between(a.place, b.place, (a.n + b.n).stableNormalized());
    return foot && (foot->point - (a.p + b.p) / 2).norm() > kDeep * std::min(a.h, b.h);
}

template <class M>
bool EditorOf<M>::flip(int h) {
    const int g = mesh_.twin(h);
    const Vertex &v = vertices_[mesh_.origin(h)], &w = vertices_[mesh_.target(h)], &c = vertices_[mesh_.apex(h)],
                 &d = vertices_[mesh_.apex(g)];
    Legality<M> legality;
    legality.had(v, w, c);
    legality.had(w, v, d);
    const Eigen::Vector3d both = area_vector(v, w, c) + area_vector(w, v, d);
    if (!legality.allows(v, d, c, both) || !legality.allows(d, w, c, both) || bridges(c, d)) return false;
    mesh_.flip(h);
    GRADUS_ASSERT(holds_now_and_then());
    return true;
}

template <class M>
bool EditorOf<M>::can_collapse(int h) const {
    const Vertex& v = vertices_[mesh_.origin(h)];
    if (v.bound == Bound::Fixed) return false;
    if (v.bound == Bound::Curve && mesh_.tag(h) != support_.chain_of(v.place.curve)) return false;
    if (!mesh_.can_collapse(h)) return false;
    const int g = mesh_.twin(h);
    const auto left = [&](int x) { return mesh_.valence(x) > least_valence(x); };
    if (!left(mesh_.apex(h)) || (g >= 0 && !left(mesh_.apex(g)))) return false;
    // The two edges that become one on either side must not both be features.
    const auto clash = [&](int side) {
        return mesh_.tag(Connectivity::next(side)) >= 0 && mesh_.tag(Connectivity::prev(side)) >= 0;
    };
    return !clash(h) && !(g >= 0 && clash(g));
}

template <class M>
bool EditorOf<M>::collapse(int h, double longest_on_curve) {
    const int v = mesh_.origin(h), g = mesh_.twin(h);
    const Vertex& w = vertices_[mesh_.target(h)];
    bool legal = true;
    // The energy knows areas, not lengths: those of a curve's pieces stay unit, and others come out not much too long.
    mesh_.for_each_edge(v, [&](int edge, int other) {
        if (!legal || other == mesh_.target(h)) return;
        const bool on_curve = vertices_[v].bound == Bound::Curve && mesh_.tag(edge) >= 0;
        const double most = on_curve ? longest_on_curve : kLongestByCollapse;
        const Vertex &x = vertices_[other], &from = vertices_[v];
        if (lengths_at_ends(x, w)[1] > most && length_between(x, w) > most &&
            (on_curve || std::sqrt(squared_at(x, x.p - w.p)) > kAboutAsLong * std::sqrt(squared_at(x, x.p - from.p))))
            legal = false;
    });
    if (!legal) return false;
    Legality<M> legality;
    mesh_.for_each_outgoing(
        v, [&](int e) { legality.had(vertices_[v], vertices_[mesh_.target(e)], vertices_[mesh_.apex(e)]); });
    mesh_.for_each_outgoing(v, [&](int e) {
        const Vertex &a = vertices_[mesh_.target(e)], &b = vertices_[mesh_.apex(e)];
        const bool vanishes = e == h || (g >= 0 && e == Connectivity::next(g));
        legal = legal && (vanishes || legality.allows(w, a, b, area_vector(vertices_[v], a, b)));
    });
    if (!legal) return false;
    mesh_.for_each_outgoing(v, [&](int e) { legal = legal && !bridges(w, vertices_[mesh_.target(e)]); });
    if (!legal) return false;
    mesh_.collapse(h);
    GRADUS_ASSERT(holds_now_and_then());
    return true;
}

template <class M>
int EditorOf<M>::split(int h) {
    if (is_frozen(h)) return -1;
    const int chain = mesh_.tag(h);
    const Vertex &va = vertices_[mesh_.origin(h)], &vb = vertices_[mesh_.target(h)];
    Vertex m;
    if (chain >= 0) {
        const auto foot = [&](const Vertex& v) {
            // A vertex of another chain ends this one. Frozen ones may be inside.
            const bool inside = v.place.curve >= 0 && support_.chain_of(v.place.curve) == chain;
            return Foot{{v.place.at, inside ? v.place.curve : -1, v.place.t, v.place.cell}, v.p, v.n};
        };
        stand(m, support_.middle(chain, foot(va), foot(vb)), support_, field_);
        m.bound = Bound::Curve;
        // Where a short curve returns to its start, its middle may be that of the other way round.
        if ((m.p - (va.p + vb.p) / 2).squaredNorm() > kFarthestMiddle2 * (va.p - vb.p).squaredNorm()) return -1;
    } else {
        const Eigen::Vector3d middle = (va.p + vb.p) / 2;
        const auto facing = [&](int side) {
            return (vb.p - va.p).cross(vertices_[mesh_.apex(side)].p - va.p).stableNormalized();
        };
        std::optional<Foot> foot = support_.between(va.place, vb.place, facing(h) - facing(mesh_.twin(h)));
        const double longest2 = foot ? kLongestBridge2 : kLongestHalf2;
        if (!foot) {
            const bool from_b = va.bound != Bound::Free && vb.bound == Bound::Free;
            const Vertex &first = from_b ? vb : va, &second = from_b ? va : vb;
            foot = support_.move(first.place, first.p, middle);
            if (!foot) foot = support_.move(second.place, second.p, middle);
            if (!foot) return -1;
        }
        // On a sharply curved part the middle of the chord may be reached on another sheet.
        if (std::max((foot->point - va.p).squaredNorm(), (foot->point - vb.p).squaredNorm()) >
            longest2 * (va.p - vb.p).squaredNorm())
            return -1;
        stand(m, *foot, support_, field_);
    }
    const int g = mesh_.twin(h);
    Legality<M> legality(0);  // where sizes are much smaller than the triangle, that is to be divided
    for (const int side : {h, g})
        if (side >= 0)
            legality.had(vertices_[mesh_.origin(side)], vertices_[mesh_.target(side)], vertices_[mesh_.apex(side)]);
    // Of a needle's halves one is worse than the whole was, until the other long side is split too.
    for (const int side : {h, g}) {
        if (side < 0) continue;
        const Vertex &a = vertices_[mesh_.origin(side)], &b = vertices_[mesh_.target(side)],
                     &c = vertices_[mesh_.apex(side)];
        const Eigen::Vector3d whole = area_vector(a, b, c);
        if (!legality.allows(a, m, c, whole, kWorseByHalving) || !legality.allows(m, b, c, whole, kWorseByHalving))
            return -1;
    }
    const int v = mesh_.split(h);
    if (v >= static_cast<int>(vertices_.size())) vertices_.resize(v + 1);
    stamp_.resize(mesh_.num_triangles(), 0);
    set_vertex(v, m);
    GRADUS_ASSERT(holds_now_and_then());
    return v;
}

template <class M>
double EditorOf<M>::energy_around(const std::vector<int>& around, Aim aim, double mean) {
    ++stamp_now_;
    double sum = 0;
    const double neutral = weighted(mean, aim);
    for (const int v : around) {
        if (!mesh_.is_live_vertex(v)) continue;
        if (aim == Aim::Worst) sum += weighted(std::min(fan_energy(fan_ratio(v)), kLegalEnergy), aim) - 1;
        mesh_.for_each_outgoing(v, [&](int h) {
            const int t = h / 3;
            if (stamp_[t] == stamp_now_) return;
            stamp_[t] = stamp_now_;
            if (is_frozen_triangle(t)) return;
            sum += weighted(energy(t), aim) - neutral;
            for (const int e : {h, Connectivity::next(h), Connectivity::prev(h)}) {
                if (mesh_.tag(e) < 0 || is_frozen(e)) continue;
                const double share = mesh_.twin(e) < 0 ? 1 : 0.5;
                sum += share * (weighted(edge_energy(vertices_[mesh_.origin(e)], vertices_[mesh_.target(e)]), aim) - 1);
            }
        });
    }
    return sum;
}

template <class M>
void EditorOf<M>::add_ring(std::vector<int>& around) const {
    const std::size_t inner = around.size();
    for (std::size_t i = 0; i < inner; ++i)
        mesh_.for_each_outgoing(around[i], [&](int h) {
            add_once(around, mesh_.target(h));
            add_once(around, mesh_.apex(h));
        });
}

template <class M>
bool EditorOf<M>::bring(int v, const Eigen::Vector3d& target) {
    Vertex x = vertices_[v];
    const std::optional<Foot> foot = x.bound == Bound::Free ? support_.move(x.place, x.p, target) : std::nullopt;
    if (!foot) return false;
    stand(x, *foot, support_, field_);
    set_vertex(v, x);
    return true;
}

template <class M>
bool EditorOf<M>::push(int h) {
    const Eigen::Vector3d &from = vertices_[mesh_.origin(h)].p, &to = vertices_[mesh_.target(h)].p;
    return bring(mesh_.origin(h), from + kPush * (to - from));
}

// The vertices of the triangles on either side of h.
template <class M>
void EditorOf<M>::list_corners(int h, std::vector<int>& around) const {
    around.assign({mesh_.origin(h), mesh_.target(h), mesh_.apex(h)});
    if (const int g = mesh_.twin(h); g >= 0) around.push_back(mesh_.apex(g));
}

// Applies the operation, recording; trial.around becomes its vertices, a new one first.
template <class M>
bool EditorOf<M>::begin(Trial& trial, Operation operation, int h) {
    list_corners(h, trial.around);
    trial.journal.clear();
    trial.saved.clear();
    mesh_.record(&trial.journal);
    recording_ = &trial;
    switch (operation) {
        case Operation::Move:
            return true;
        case Operation::Push:
            return push(h);
        case Operation::Flip:
            return flip(h);
        case Operation::Collapse:
            return collapse(h);
        case Operation::Split: {
            const int fresh = split(h);
            if (fresh >= 0) trial.around.insert(trial.around.begin(), fresh);
            return fresh >= 0;
        }
    }
    return false;
}

template <class M>
void EditorOf<M>::keep(const Trial& trial) {
    mesh_.record(nullptr);
    recording_ = nullptr;
    touched_ = trial.around;
}

template <class M>
void EditorOf<M>::roll_back(Trial& trial) {
    recording_ = nullptr;
    for (auto i = trial.saved.rbegin(); i != trial.saved.rend(); ++i) vertices_[i->first] = i->second;
    mesh_.undo(trial.journal);
    GRADUS_ASSERT(holds_now_and_then());
}

namespace {

// The energy that counts as lower.
double below(double energy) { return energy - 1e-4 * std::abs(energy) - 1e-6; }

}  // namespace

template <class M>
bool EditorOf<M>::attempt(Operation operation, int h, Aim aim, double mean, Reach reach) {
    Trial& trial = trials_[0];
    std::vector<int>& around = touched_;
    list_corners(h, around);
    if (reach == Reach::Wide) add_ring(around);
    const double enough = below(energy_around(around, aim, mean));
    bool done = begin(trial, operation, h);
    if (done) {
        if (operation == Operation::Split) around.insert(around.begin(), trial.around.front());
        // What was pushed would go straight back.
        if (operation == Operation::Push) std::rotate(around.begin(), around.begin() + 1, around.end());
        // Rounds go on while, at the pace of the last one, they may still reach what was before.
        const int rounds = reach == Reach::Wide ? 4 : 2;
        double after = 0, last = std::numeric_limits<double>::infinity();
        for (int round = 0; round < rounds; ++round) {
            for (const int v : around)
                if (mesh_.is_live_vertex(v)) relax(v, aim);
            after = energy_around(around, aim, mean);
            if (after > enough && after - enough > 2 * (rounds - round) * (last - after)) break;
            last = after;
        }
        done = after < enough && is_allowed(around);
    }
    if (done) {
        trial.around = around;
        keep(trial);
    } else {
        roll_back(trial);
    }
    return done;
}

template <class M>
bool EditorOf<M>::attempt_pair(Operation first, int h, double mean, Search search) {
    // Energy is measured two rings around, so that whatever the second operation moves is inside.
    std::vector<int> inner;
    list_corners(h, inner);
    add_ring(inner);
    std::vector<int> region = inner;
    add_ring(region);
    const double enough = below(energy_around(region, Aim::Worst, mean));
    Trial& one = trials_[0];
    if (!begin(one, first, h)) {
        roll_back(one);
        return false;
    }
    if (first == Operation::Split) inner.push_back(one.around.front()), region.push_back(one.around.front());
    for (int round = 0; round < 2; ++round)
        for (const int v : one.around)
            if (mesh_.is_live_vertex(v)) relax(v, Aim::Worst);
    recording_ = nullptr;
    mesh_.record(nullptr);

    std::vector<int> candidates;
    std::erase_if(one.around, [&](int v) { return !mesh_.is_live_vertex(v); });
    add_halfedges_around(mesh_, one.around, candidates);
    const bool improved = any_halfedge(mesh_, candidates, [&](int e, bool is_first) {
        for (const Operation second : {Operation::Flip, Operation::Collapse, Operation::Split}) {
            if (!is_first && second != Operation::Collapse) continue;
            const double l = length(e);
            const bool possible = second == Operation::Flip       ? can_flip(e)
                                  : second == Operation::Collapse ? l < 1 && can_collapse(e)
                                                                  : l > 1;
            if (!possible) continue;
            // Those that worsen valences, or the energy by much, rarely turn out well.
            const bool hopeful = second == Operation::Flip       ? flip_gain(e) >= 0 && flip_rise(e) < kHopefulRise
                                 : second == Operation::Collapse ? collapse_gain(e) >= 0
                                                                 : false;
            if (search == Search::Quick && !hopeful) continue;
            if (attempt_second(second, e, inner, region, enough, mean)) return true;
        }
        return false;
    });
    if (!improved) roll_back(one);
    return improved;
}

// @param inner  vertices that relax  @param region  those around which the energy is to be below `enough`
template <class M>
bool EditorOf<M>::attempt_second(Operation second, int h, const std::vector<int>& inner, std::vector<int>& region,
                                 double enough, double mean) {
    Trial& trial = trials_[1];
    bool done = begin(trial, second, h);
    if (done) {
        const std::size_t known = region.size();
        if (second == Operation::Split) region.push_back(trial.around.front());
        std::vector<int> around = trial.around;
        for (const int v : inner) add_once(around, v);
        std::erase_if(around, [&](int v) { return std::find(region.begin(), region.end(), v) == region.end(); });
        double last = std::numeric_limits<double>::infinity();
        for (int round = 0; round < kPairRounds; ++round) {
            for (const int v : around)
                if (mesh_.is_live_vertex(v)) relax(v, Aim::Worst);
            const double after = energy_around(region, Aim::Worst, mean);
            done = after < enough;
            if (after > enough && after - enough > 2 * (kPairRounds - round) * (last - after)) break;
            last = after;
        }
        if (done) done = is_allowed(around);
        region.resize(known);
        trial.around = around;
    }
    if (done)
        keep(trial);
    else
        roll_back(trial);
    return done;
}

// Applies a way to mend and relaxes what is around, recording; a vertex that comes is added. @returns the energy around
// that leaves
template <class M>
std::optional<double> EditorOf<M>::try_mending(const Mending& mending, const Eigen::Vector3d& fault, int rounds,
                                               std::vector<int>& around) {
    if (!begin(trials_[0], mending.operation, mending.halfedge)) return std::nullopt;
    const bool comes = mending.operation == Operation::Split;
    const int moved = comes ? trials_[0].around.front() : mesh_.origin(mending.halfedge);
    if (comes) around.push_back(moved);
    if (mending.to_fault && !bring(moved, fault)) return std::nullopt;
    for (int round = 0; round < rounds; ++round)
        for (const int v : around)
            if (!mending.to_fault || v != moved) relax(v, Aim::Worst);
    return energy_around(around, Aim::Worst, 1);
}

template <class M>
bool EditorOf<M>::mend(const std::vector<int>& corners, const Eigen::Vector3d& fault) {
    std::vector<int> region = corners;
    add_ring(region);
    const double most = std::max(kBadlyMended, energy_around(region, Aim::Worst, 1));
    std::vector<std::pair<double, Mending>> ways;
    const auto offer = [&](const Mending& way) {
        std::vector<int> around = region;
        if (const auto energy = try_mending(way, fault, 1, around); energy && *energy < most)
            ways.emplace_back(*energy, way);
        roll_back(trials_[0]);
    };
    for (const int v : corners) {
        std::vector<int> edges;
        mesh_.for_each_edge(v, [&](int h, int other) {
            if (v < other && std::find(corners.begin(), corners.end(), other) != corners.end()) edges.push_back(h);
        });
        offer({Operation::Move, mesh_.outgoing(v), true});
        for (const int h : edges) {
            if (can_flip(h) && flip_rise(h) < kHopefulRise) offer({Operation::Flip, h, false});
            for (const bool to_fault : {false, true}) offer({Operation::Split, h, to_fault});
        }
    }
    std::stable_sort(ways.begin(), ways.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    if (ways.size() > kMostWays) ways.resize(kMostWays);
    for (const auto& [energy, way] : ways) {
        std::vector<int> around = region;
        if (try_mending(way, fault, kMendRounds, around) && is_allowed(around)) {
            trials_[0].around = around;
            keep(trials_[0]);
            return true;
        }
        roll_back(trials_[0]);
    }
    return false;
}

template <class M>
void EditorOf<M>::renumber() {
    const Connectivity::Numbering numbering = mesh_.breadth_first();
    std::vector<Vertex> vertices;
    vertices.reserve(numbering.vertices.size());
    for (const int v : numbering.vertices) vertices.push_back(vertices_[v]);
    vertices_ = std::move(vertices);
    mesh_ = mesh_.renumbered(numbering);
    stamp_.assign(mesh_.num_triangles(), 0);
    stamp_now_ = 0;
}

template class EditorOf<Size>;
template class EditorOf<SizeTensor>;

}  // namespace gradus

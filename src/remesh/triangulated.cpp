#include "gradus/remesh/triangulated.hpp"

#include "gradus/mesh/frozen.hpp"
#include "gradus/quality/offenders.hpp"
#include "optimise.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>

namespace gradus {

namespace {

using Eigen::Vector3d;

constexpr double kNear2 = 1e-2;  // squared: a tenth of the way is near enough
constexpr int kMostSteps = 3;
constexpr double kLongestSection = 4;  // between two places, over their distance
constexpr double kOnSide = 1e-12;  // weights of a corner below this are rounding: a place is on the side opposite to it
constexpr double kInside = 0.02;   // least weight of a corner, off the sides of a facet
constexpr double kAside2 = 1e-6, kInLine2 = 1e-2;   // squared, over the distance of two places
constexpr double kNearFold = 0.25;                  // over the size
constexpr int kMostNear = 64;                       // triangles
constexpr int kKept = 4096;                         // patches
constexpr double kBroken = 0.3;                     // quality of elements that no mesh should have
constexpr double kUnsplit = 2.5;                    // metric length of edges that were to be split
constexpr double kAround = 3;                       // sizes
constexpr double kSamePlace = 0.25;                 // sizes: what was broken and moved is broken as before
constexpr int kMostAttempts = 4;                    // to lower sizes, and to polish
constexpr double kWider = 3;                        // each time
constexpr int kMostRetries = 6, kMostFailures = 4;  // of places where elements are bad
constexpr int kMostPartings = 8;                    // of sheets that are in contact
constexpr double kSmaller = 0.75;                   // factor of the sizes there, each time one led to nothing better
constexpr std::size_t kMostBadPlaces = 100;
constexpr double kAroundBad = 8;  // sizes: how far from there it is polished again
// Quality sought for the worst triangles of meshes that are checked, and when they are good: better ones cost more than
// they are worth.
constexpr double kGoalOnTheWay = 0.75, kGoalOfPolish = 0.82;
// Faults that are mended one by one, over the triangles or in all: where there are more, lower sizes cost less and
// leave better shapes.
constexpr double kFewFaults = 0.001, kFewFaultsInAll = 8;
constexpr int kMostMendings = 8;           // in a row
constexpr std::size_t kLargestFault = 24;  // triangles: where there are more no single operation will do
constexpr double kChanged = 0.005;         // of a size: edges stay unit where it changes by less

// Coordinates (b, c) of the point at s from the origin of half-edge h, in its triangle.
Eigen::Vector2d on_halfedge(int h, double s) {
    std::array<double, 3> w{0, 0, 0};
    w[h % 3] = 1 - s;
    w[(h + 1) % 3] = s;
    return {w[1], w[2]};
}

// Weights of the corners of its triangle.
std::array<double, 3> weights_of(const Place& place) {
    const Eigen::Vector2d& uv = place.at.uv;
    return {1 - uv.x() - uv.y(), uv.x(), uv.y()};
}

}  // namespace

TriangleSupport::TriangleSupport(const SmoothSupport& surface, const Features& features)
    : surface_(surface), features_(features), kept_(kKept), curve_of_(surface.mesh().num_vertices(), {-1, 0.0}) {
    const auto points = surface.points();
    for (const FeatureChain& chain : features.chains) {
        Curve curve{{0.0}, {}, chain.closed};
        for (int i = 0; i < chain.num_edges(); ++i) {
            const int a = chain.vertex(i), b = chain.vertex(i + 1);
            if (!features.corner[a]) curve_of_[a] = {static_cast<int>(curves_.size()), curve.end()};
            curve.halfedges.push_back(surface.mesh().find_edge(a, b));
            curve.length.push_back(curve.end() + (points[b] - points[a]).norm());
        }
        curves_.push_back(std::move(curve));
    }
}

// Where the surface folds within much less than the size its normal is that between the sides of the fold.
void TriangleSupport::spread_normals(Foot& foot, double reach) const {
    const Connectivity& mesh = surface_.mesh();
    const int triangle = foot.place.at.patch;
    const double reach2 = reach * reach;
    // Far from the sides of its facet, a place is far from folds.
    const auto corners = mesh.triangle(triangle);
    const std::array<Vector3d, 3> p{surface_.points()[corners[0]], surface_.points()[corners[1]],
                                    surface_.points()[corners[2]]};
    const std::array<double, 3> w = weights_of(foot.place);
    const double area2 = (p[1] - p[0]).cross(p[2] - p[0]).squaredNorm();
    bool is_near = false;
    for (int k = 0; k < 3; ++k)
        is_near = is_near || w[k] * w[k] * area2 < reach2 * (p[(k + 2) % 3] - p[(k + 1) % 3]).squaredNorm();
    if (!is_near) return;
    near_.assign({{triangle, surface_.facet_normal(triangle)}});
    list_near(foot, reach);
    if (near_.size() == 1) return;
    const auto [one, other] = farthest_apart(foot.normal);
    if (one.dot(other) < SmoothSupport::kFold) between_sides(one, other, foot);
}

// Adds to those listed the facets that are reached, without crossing a feature, across sides that are near.
void TriangleSupport::list_near(const Foot& foot, double reach) const {
    const Connectivity& mesh = surface_.mesh();
    const double reach2 = reach * reach;
    const auto is_side_near = [&](int h) {
        const Vector3d &a = surface_.points()[mesh.origin(h)], along = surface_.points()[mesh.target(h)] - a,
                       to = foot.point - a;
        const double length2 = along.squaredNorm();
        const double s = length2 > 0 ? std::clamp(along.dot(to) / length2, 0.0, 1.0) : 0;
        return (to - s * along).squaredNorm() < reach2;
    };
    const auto is_listed = [&](int t) {
        return std::any_of(near_.begin(), near_.end(), [t](const Near& near) { return near.triangle == t; });
    };
    for (std::size_t i = 0; i < near_.size() && near_.size() < kMostNear; ++i)
        for (int h = 3 * near_[i].triangle, end = h + 3; h < end; ++h) {
            const int g = mesh.twin(h);
            if (g >= 0 && mesh.tag(h) < 0 && !is_listed(g / 3) && is_side_near(h))
                near_.push_back({g / 3, surface_.facet_normal(g / 3)});
        }
}

// Of the normals listed the one farthest from a normal, and the one farthest from that.
std::pair<Vector3d, Vector3d> TriangleSupport::farthest_apart(const Vector3d& normal) const {
    const auto farthest_from = [&](const Vector3d& n) {
        Vector3d farthest = n;
        double least = 1;
        for (const Near& near : near_)
            if (const double cosine = near.normal.dot(n); cosine < least && !near.normal.isZero())
                least = cosine, farthest = near.normal;
        return farthest;
    };
    const Vector3d one = farthest_from(normal);
    return {one, farthest_from(one)};
}

const GregoryPatch& TriangleSupport::patch(int triangle) const {
    Kept& kept = kept_[triangle % kKept];
    if (kept.triangle != triangle) kept = {triangle, surface_.patch(triangle)};
    return kept.patch;
}

Vector3d TriangleSupport::point_at(const Place& place) const {
    return patch(place.at.patch).point(place.at.uv.x(), place.at.uv.y());
}

Foot TriangleSupport::foot(const Place& place) const {
    const auto& [triangle, uv] = place.at;
    return foot_of({place, patch(triangle).point(uv.x(), uv.y()), patch(triangle).normal(uv.x(), uv.y())});
}

// The half-edges on the two sides of a place of a curve, with the normals there; the second is -1 at a boundary.
std::pair<int, int> TriangleSupport::sides_at(const Place& place, std::array<Vector3d, 2>& normals) const {
    // The same point of the curve as the triangle on the other side has it.
    const auto [h, s] = edge_at(place.curve, place.t);
    const int g = surface_.mesh().twin(h);
    if (g < 0) return {h, g};
    const Eigen::Vector2d here = on_halfedge(h, s), there = on_halfedge(g, 1 - s);
    normals[0] = patch(h / 3).normal(here.x(), here.y());
    normals[1] = patch(g / 3).normal(there.x(), there.y());
    return {h, g};
}

// A point of the surface and its normal, which become the foot that they are of.
Foot TriangleSupport::foot_of(Foot foot) const {
    if (foot.place.curve < 0) return foot;
    std::array<Vector3d, 2> normals;
    if (sides_at(foot.place, normals).second >= 0) between_sides(normals[0], normals[1], foot);
    return foot;
}

void TriangleSupport::settle(Foot& foot, double size) const {
    const double reach = kNearFold * size;
    if (foot.place.curve >= 0)
        spread_over_sides(foot, reach);
    else if (surface_.folds_near(foot.place.at.patch))
        spread_normals(foot, reach);
}

// The same at a crease that has folds beside it.
void TriangleSupport::spread_over_sides(Foot& foot, double reach) const {
    const auto [h, s] = edge_at(foot.place.curve, foot.place.t);
    const int twin = surface_.mesh().twin(h);
    if (twin < 0 || (!surface_.folds_near(h / 3) && !surface_.folds_near(twin / 3))) return;
    std::array<Vector3d, 2> normals;
    sides_at(foot.place, normals);
    near_.assign({{h / 3, normals[0]}, {twin / 3, normals[1]}});
    list_near(foot, reach);
    if (near_.size() == 2) return;
    const auto [a, b] = farthest_apart(foot.normal);
    if (a.dot(b) < normals[0].dot(normals[1])) between_sides(a, b, foot);
}

Foot TriangleSupport::at_vertex(int vertex, int cell) const {
    const int h = surface_.mesh().outgoing(vertex);
    const auto [curve, t] = curve_of_[vertex];
    return foot_of({{{h / 3, on_halfedge(h, 0)}, curve, t, cell},
                    surface_.points()[vertex],
                    surface_.normal_at_corner(h / 3, h % 3)});
}

std::optional<Foot> TriangleSupport::move(const Place& from, const Vector3d& point, const Vector3d& target) const {
    const Connectivity& mesh = surface_.mesh();
    // From a vertex or a feature the way may begin on any side: the one that leads closest.
    const int triangle = from.at.patch;
    const std::array<double, 3> w = weights_of(from);
    // The surface is off its facets at the target about as it is here.
    Vector3d aim = target + (on_facet(triangle, w) - point);
    SmoothSupport::Foot best = surface_.walk(triangle, aim);
    const auto try_from = [&](int start) {
        if (const auto foot = surface_.walk(start, aim); foot.distance2 < best.distance2) best = foot;
    };
    for (int k = 0; k < 3; ++k) {
        const int side = 3 * triangle + (k + 1) % 3;
        if (w[k] >= 1 - kOnSide)
            mesh.for_each_outgoing(mesh.origin(3 * triangle + k), [&](int h) { try_from(h / 3); });
        else if (w[k] <= kOnSide && mesh.tag(side) >= 0 && mesh.twin(side) >= 0)
            try_from(mesh.twin(side) / 3);
    }
    if (best.barred) return std::nullopt;
    const auto foot_at = [&](const SmoothSupport::Foot& at) {
        const GregoryPatch& patch = this->patch(at.triangle);
        return Foot{{{at.triangle, {at.b, at.c}}, -1, 0, from.cell}, patch.point(at.b, at.c), patch.normal(at.b, at.c)};
    };
    Foot foot = foot_at(best);
    const double goal2 = (target - point).squaredNorm();
    for (int step = 0; step < kMostSteps; ++step) {
        const Vector3d miss = (target - foot.point) - foot.normal.dot(target - foot.point) * foot.normal;
        if (miss.squaredNorm() <= kNear2 * goal2) break;
        aim += miss;
        const auto next = surface_.walk(best.triangle, aim);
        if (next.barred) break;
        best = next;
        foot = foot_at(best);
    }
    return foot;
}

// Calls use(triangle, weights of its corners) for the triangles that hold a place: several where it is on an edge or at
// a vertex.
template <class Use>
void TriangleSupport::for_each_holder(const Place& place, const Use& use) const {
    using Weights = std::array<double, 3>;
    const Connectivity& mesh = surface_.mesh();
    const int triangle = place.at.patch;
    const Weights w = weights_of(place);
    for (int k = 0; k < 3; ++k) {
        if (w[k] < 1 - kOnSide) continue;
        mesh.for_each_outgoing(mesh.origin(3 * triangle + k), [&](int h) {
            Weights at{0, 0, 0};
            at[h % 3] = 1;
            use(h / 3, at);
        });
        return;
    }
    use(triangle, w);
    for (int k = 0; k < 3; ++k) {
        const int side = 3 * triangle + (k + 1) % 3, g = mesh.twin(side);
        if (w[k] > kOnSide || g < 0) continue;
        Weights at{0, 0, 0};
        at[g % 3] = w[(k + 2) % 3];
        at[Connectivity::next(g) % 3] = w[(k + 1) % 3];
        use(g / 3, at);
    }
}

Vector3d TriangleSupport::on_facet(int triangle, const std::array<double, 3>& weights) const {
    const auto points = surface_.points();
    const Triangle v = surface_.mesh().triangle(triangle);
    return weights[0] * points[v[0]] + weights[1] * points[v[1]] + weights[2] * points[v[2]];
}

// Where a plane through two places cuts the facets between them.
class TriangleSupport::Section {
  public:
    // @param up  in the plane; looked down at from there
    Section(const TriangleSupport& support, const Place& a, const Place& b, const Vector3d& up)
        : support_(support),
          mesh_(support.surface_.mesh()),
          points_(support.surface_.points()),
          from_(support.on_facet(a.at.patch, weights_of(a))),
          to_(support.on_facet(b.at.patch, weights_of(b))),
          along_(to_ - from_),
          across_(along_.cross(up)),
          most_(kLongestSection * along_.norm()) {
        support_.goals_.clear();
        support_.for_each_holder(
            b, [&](int triangle, const std::array<double, 3>&) { support_.goals_.push_back(triangle); });
    }

    bool is_goal(int triangle) const {
        const std::vector<int>& goals = support_.goals_;
        return std::find(goals.begin(), goals.end(), triangle) != goals.end();
    }
    bool is_cut(int h) const { return (height(mesh_.origin(h)) >= 0) != (height(mesh_.target(h)) >= 0); }
    Vector3d middle_of_ends() const { return (from_ + to_) / 2; }

    // Follows the section across half-edge h and on. @returns its length where it leads to the goal
    std::optional<double> follow(int h) const {
        std::vector<Part>& section = support_.section_;
        section.clear();
        Vector3d here = from_;
        // No triangle is crossed twice.
        for (double length = 0; length <= most_ && std::ssize(section) < mesh_.num_triangles();) {
            const Vector3d next = on_edge(h);
            if (section.empty() && (next - from_).dot(along_) <= 0) return std::nullopt;
            length += (next - here).norm();
            section.push_back({h / 3, here});
            here = next;
            const int g = mesh_.twin(h);
            if (mesh_.tag(h) >= 0 || g < 0) return std::nullopt;
            if (is_goal(g / 3)) {
                section.push_back({g / 3, here});
                length += (to_ - here).norm();
                return length <= most_ ? std::optional(length) : std::nullopt;
            }
            h = is_cut(Connectivity::next(g)) ? Connectivity::next(g) : Connectivity::prev(g);
        }
        return std::nullopt;
    }

    // The point half way along the section that was followed last, and its triangle.
    std::pair<int, Vector3d> half_way(double length) const {
        const std::vector<Part>& section = support_.section_;
        double left = length / 2;
        Vector3d end = to_;
        auto part = section.rbegin();
        for (; part + 1 != section.rend() && (end - part->begin).norm() < left; ++part) {
            left -= (end - part->begin).norm();
            end = part->begin;
        }
        const double l = (end - part->begin).norm();
        return {part->triangle, l > 0 ? Vector3d(end + std::min(1.0, left / l) * (part->begin - end)) : end};
    }

  private:
    double height(int v) const { return across_.dot(points_[v] - from_); }
    // Where an edge that the plane cuts is cut.
    Vector3d on_edge(int h) const {
        const double s0 = height(mesh_.origin(h)), s1 = height(mesh_.target(h)), s = s0 / (s0 - s1);
        return (1 - s) * points_[mesh_.origin(h)] + s * points_[mesh_.target(h)];
    }

    const TriangleSupport& support_;
    const Connectivity& mesh_;
    std::span<const Vector3d> points_;
    Vector3d from_, to_, along_, across_;
    double most_;
};

std::optional<Foot> TriangleSupport::between(const Place& a, const Place& b, const Vector3d& up) const {
    const Section section(*this, a, b, up);
    // Of the sections that reach the goal the one that looks up where it is half way.
    double best = 0;
    std::optional<Place> middle;
    const auto offer = [&](int triangle, const Vector3d& p) {
        const double looks_up = surface_.facet_normal(triangle).dot(up);
        if (!(looks_up > best)) return;
        best = looks_up;
        const auto closest = surface_.within(triangle, p);
        middle = {{triangle, {closest.b, closest.c}}, -1, 0, a.cell};
    };
    for_each_holder(a, [&](int first, const std::array<double, 3>& w) {
        if (section.is_goal(first)) return offer(first, section.middle_of_ends());
        for (int k = 0; k < 3; ++k) {
            const int h = 3 * first + (k + 1) % 3;
            if (w[k] <= kOnSide || !section.is_cut(h)) continue;
            if (const auto length = section.follow(h)) {
                const auto [triangle, p] = section.half_way(*length);
                offer(triangle, p);
            }
        }
    });
    if (!middle) return std::nullopt;
    return in_line(foot(*middle), a, b);
}

// Inside a flat facet the halves are to be in line, though the surface over it is not that of the facet: beside needles
// there is no room.
Foot TriangleSupport::in_line(const Foot& half, const Place& a, const Place& b) const {
    const std::array<double, 3> w = weights_of(half.place);
    if (*std::min_element(w.begin(), w.end()) < kInside) return half;
    const Vector3d along = on_facet(b.at.patch, weights_of(b)) - on_facet(a.at.patch, weights_of(a));
    const Vector3d chord_middle = (point_at(a) + point_at(b)) / 2, off = chord_middle - half.point,
                   aside = off - off.dot(half.normal) * half.normal;
    const double length2 = along.squaredNorm();
    if (aside.squaredNorm() < kAside2 * length2 || off.squaredNorm() > kInLine2 * length2) return half;
    return move(half.place, half.point, chord_middle).value_or(half);
}

// The half-edge under a place of a curve, and how far along it.
std::pair<int, double> TriangleSupport::edge_at(int curve, double t) const {
    const Curve& c = curves_[curve];
    const auto edges = static_cast<int>(c.halfedges.size());
    const int i = std::clamp(
        static_cast<int>(std::upper_bound(c.length.begin(), c.length.end(), t) - c.length.begin()) - 1, 0, edges - 1);
    const double length = c.length[i + 1] - c.length[i];
    const double s = length > 0 ? std::clamp((t - c.length[i]) / length, 0.0, 1.0) : 0;
    const int h = c.halfedges[i];
    return {h, surface_.mesh().origin(h) == features_.chains[curve].vertex(i) ? s : 1 - s};
}

Place TriangleSupport::on_curve(int curve, double t, int cell) const {
    const Curve& c = curves_[curve];
    if (c.closed) t -= c.end() * std::floor(t / c.end());
    const auto [h, s] = edge_at(curve, t);
    return {{h / 3, on_halfedge(h, s)}, curve, t, cell};
}

std::optional<Foot> TriangleSupport::slide(const Place& from, const Vector3d& target) const {
    const Curve& c = curves_[from.curve];
    Place place = from;
    for (int step = 0; step < 2; ++step) {
        const auto i = std::clamp<std::ptrdiff_t>(
            std::upper_bound(c.length.begin(), c.length.end(), place.t) - c.length.begin() - 1, 0,
            std::ssize(c.halfedges) - 1);
        const FeatureChain& chain = features_.chains[from.curve];
        const auto points = surface_.points();
        const Vector3d along =
            (points[chain.vertex(static_cast<int>(i) + 1)] - points[chain.vertex(static_cast<int>(i))])
                .stableNormalized();
        const double t = place.t + along.dot(target - point_at(place));
        if (!c.closed && !(t > 0 && t < c.end())) return std::nullopt;
        place = on_curve(from.curve, t, from.cell);
    }
    return foot(place);
}

Foot TriangleSupport::middle(int chain, const Foot& a, const Foot& b) const {
    const Curve& c = curves_[chain];
    const auto points = surface_.points();
    const FeatureChain& of = features_.chains[chain];
    const auto inside = [&](const Foot& f) { return f.place.curve == chain; };
    // An end of an open chain; where the chain returns to its start, the end that is nearer along it.
    const auto end_near = [&](const Foot& corner, double other) {
        if (of.vertices.front() == of.vertices.back()) return other > c.end() / 2 ? c.end() : 0.0;
        const Vector3d &first = points[of.vertices.front()], &last = points[of.vertices.back()];
        return (corner.point - first).squaredNorm() < (corner.point - last).squaredNorm() ? 0.0 : c.end();
    };
    double ta = inside(a) ? a.place.t : 0, tb = inside(b) ? b.place.t : 0;
    if (!inside(a)) ta = end_near(a, tb);
    if (!inside(b)) tb = end_near(b, ta);
    if (!inside(a) && !inside(b) && ta == tb) tb = c.end() - ta;
    if (c.closed && tb - ta > c.end() / 2) tb -= c.end();
    if (c.closed && ta - tb > c.end() / 2) ta -= c.end();
    return foot(on_curve(chain, (ta + tb) / 2, a.place.cell));
}

namespace {

// @param order  vertices of the triangulation
std::vector<Vertex> place_vertices(const TriangulatedSurface& surface, const TriangleSupport& support,
                                   const ControlSpace& control, const Frozen& frozen, std::span<const int> cells,
                                   std::span<const int> order) {
    const Connectivity& mesh = surface.support.mesh();
    std::vector<Vertex> vertices(order.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        const int v = order[i];
        Vertex& x = vertices[i];
        stand(x, support.at_vertex(v, cells[v]), support, control);
        x.p = surface.support.points()[v];
        if (surface.features.corner[v] || frozen.has_vertex(v))
            x.bound = Bound::Fixed;
        else if (x.place.curve >= 0)
            x.bound = Bound::Curve;
        if (!surface.features.corner[v]) continue;
        int sides = 0;
        mesh.for_each_outgoing(v, [&](int h) { sides += mesh.tag(h) >= 0; });
        if (sides != 1) x.lean = kAnyNormal;
    }
    return vertices;
}

Connectivity with_frozen_edges(Connectivity mesh, const Frozen& frozen) {
    for (int h = 0; h < static_cast<int>(frozen.half_edge.size()); ++h)
        if (frozen.half_edge[h] && mesh.twin(h) < h) mesh.set_tag(h, frozen_tag(mesh.tag(h)));
    return mesh;
}

// Of the triangulation's own mesh.
std::unique_ptr<Editor> first_editor(const TriangulatedSurface& surface, const TriangleSupport& support,
                                     const ControlSpace& control, const Frozen& frozen, std::span<const int> cells) {
    const Connectivity::Numbering numbering = surface.support.mesh().breadth_first();
    Connectivity mesh = with_frozen_edges(surface.support.mesh(), frozen).renumbered(numbering);
    return std::make_unique<Editor>(support, control,
                                    place_vertices(surface, support, control, frozen, cells, numbering.vertices),
                                    std::move(mesh));
}

std::vector<Vertex> with_sizes(const Connectivity& mesh, std::vector<Vertex> vertices, std::span<const double> sizes) {
    for (std::size_t v = 0; v < vertices.size(); ++v) {
        take_size(vertices[v], sizes[v]);
        vertices[v].place.cell = mesh.outgoing(static_cast<int>(v)) / 3;
    }
    return vertices;
}

// Vertices whose size changed by enough to matter, and those around them.
std::vector<char> changed(const Editor& editor, std::span<const double> before, std::span<const double> now) {
    std::vector<char> active(before.size());
    for (std::size_t v = 0; v < before.size(); ++v) active[v] = std::abs(now[v] - before[v]) > kChanged * before[v];
    std::vector<char> wider = active;
    for (int h = 0; h < 3 * editor.mesh().num_triangles(); ++h)
        if (active[editor.mesh().origin(h)]) wider[editor.mesh().target(h)] = wider[editor.mesh().apex(h)] = 1;
    return wider;
}

// Places where the mesh is none that could be the last: elements that are very bad, and edges that were to be split and
// could not be.
struct BrokenPlace {
    Vector3d at;
    double size;
};
std::vector<BrokenPlace> broken_places(const Editor& editor) {
    const Connectivity& mesh = editor.mesh();
    std::vector<BrokenPlace> places;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        if (!mesh.is_live_triangle(t) || editor.is_frozen_triangle(t)) continue;
        bool broken = editor.quality(t) < kBroken;
        for (int h = 3 * t; h < 3 * t + 3; ++h)
            broken =
                broken || (!editor.is_frozen(h) && editor.longest_length(h) > kUnsplit && editor.length(h) > kUnsplit);
        const Triangle v = mesh.triangle(t);
        if (broken)
            places.push_back(
                {(editor.vertex(v[0]).p + editor.vertex(v[1]).p + editor.vertex(v[2]).p) / 3, editor.vertex(v[0]).h});
    }
    return places;
}

// Required elements in the numbers of the result: fixed vertices are where they were, exactly at a corner of a
// triangle.
RequiredElements find_required(const TriangulatedSurface& surface, const Editor& editor) {
    RequiredElements found;
    if (!surface.required) return found;
    const Connectivity &mesh = editor.mesh(), &given = surface.support.mesh();
    std::vector<int> number(given.num_vertices(), -1);
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        if (editor.vertex(v).bound != Bound::Fixed) continue;
        const auto& [triangle, uv] = editor.vertex(v).place.at;
        number[given.origin(3 * triangle + (uv.x() == 1 ? 1 : uv.y() == 1 ? 2 : 0))] = v;
    }
    const auto half_edge = [&](int a, int b) {
        const int h = number[a] >= 0 && number[b] >= 0 ? mesh.find_edge(number[a], number[b]) : -1;
        if (h < 0)
            throw std::logic_error("remesh: required edge " + std::to_string(a) + "-" + std::to_string(b) +
                                   " is not in the mesh");
        return h;
    };
    for (const int v : surface.required->vertices) found.vertices.push_back(number[v]);
    for (const auto& [a, b] : surface.required->edges) {
        half_edge(a, b);
        found.edges.push_back({number[a], number[b]});
    }
    for (const int t : surface.required->triangles) {
        const auto [a, b, c] = given.triangle(t);
        int h = half_edge(a, b);
        if (mesh.apex(h) != number[c]) h = mesh.twin(h);
        if (h < 0 || mesh.apex(h) != number[c])
            throw std::logic_error("remesh: required triangle " + std::to_string(t) + " is not in the mesh");
        found.triangles.push_back(h / 3);
    }
    return found;
}

SurfaceMesh export_mesh(const TriangulatedSurface& surface, const Support& support, const Editor& editor) {
    SurfaceMesh result;
    const Connectivity& mesh = editor.mesh();
    for (const Vertex& v : editor.vertices()) {
        result.points.push_back(v.p);
        result.places.push_back(v.place.at);
        result.sizes.push_back(v.h);
    }
    const auto label_under = [&](const Triangle& t) {
        if (surface.labels.empty()) return 0;
        const Vertex &a = editor.vertex(t[0]), &b = editor.vertex(t[1]), &c = editor.vertex(t[2]);
        for (const Vertex* v : {&a, &b, &c})
            if (v->bound == Bound::Free) return surface.labels[v->place.at.patch];
        const auto foot = support.move(a.place, a.p, (a.p + b.p + c.p) / 3);
        return surface.labels[foot ? foot->place.at.patch : a.place.at.patch];
    };
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        result.triangles.push_back(mesh.triangle(t));
        result.patches.push_back(label_under(result.triangles.back()));
        for (int h = 3 * t; h < 3 * t + 3; ++h) {
            const int chain = thawed_tag(mesh.tag(h));
            if (chain < 0 || mesh.twin(h) >= h) continue;
            result.features.push_back({mesh.origin(h), mesh.target(h)});
            result.feature_labels.push_back(surface.features.chains[chain].label);
        }
    }
    if (std::all_of(result.feature_labels.begin(), result.feature_labels.end(), [](int label) { return label == 0; }))
        result.feature_labels.clear();
    result.required = find_required(surface, editor);
    return result;
}

// The triangles at some vertices, and those that touch them.
MeshPart part_around(const Editor& editor, std::span<const int> vertices) {
    const Connectivity& mesh = editor.mesh();
    MeshPart part;
    std::vector<int> triangles, corners;
    const auto add_triangles_at = [&](int v) { mesh.for_each_outgoing(v, [&](int h) { add_once(triangles, h / 3); }); };
    const auto list_corners = [&] {
        for (const int t : triangles)
            for (const int v : mesh.triangle(t)) add_once(corners, v);
    };
    for (const int v : vertices)
        if (mesh.is_live_vertex(v)) add_triangles_at(v);
    part.changed = static_cast<int>(triangles.size());
    list_corners();
    for (std::size_t i = 0, inner = corners.size(); i < inner; ++i) add_triangles_at(corners[i]);
    list_corners();
    for (const int v : corners) {
        part.points.push_back(editor.vertex(v).p);
        part.places.push_back(editor.vertex(v).place.at);
    }
    for (const int t : triangles) {
        Triangle numbers = mesh.triangle(t);
        for (int& v : numbers) v = static_cast<int>(std::find(corners.begin(), corners.end(), v) - corners.begin());
        part.triangles.push_back(numbers);
    }
    return part;
}

// Elements that are short of what good ones keep, without a cause, or faults; no points where they are all over.
struct BadPlaces {
    std::vector<Vector3d> points;
    std::size_t elements = 0;
};
BadPlaces bad_places(const SurfaceMesh& mesh) {
    const KnownFeatures features{.edges = mesh.features};
    const OffenderOptions options{
        .sizes = mesh.sizes, .features = &features, .required = &mesh.required, .most = kMostBadPlaces + 1};
    const OffenderReport report = find_offenders({mesh.points, mesh.triangles}, options);
    BadPlaces places;
    for (const OffenderGroup& group : report.groups) {
        // Where the surface turns sharply smaller elements may follow it.
        if (group.cause.kind != OffenderCause::Kind::None && group.cause.kind != OffenderCause::Kind::SharpTurn)
            continue;
        places.points.push_back(group.point);
        places.elements += group.quality.count + group.angle.count + group.edge_ratio.count;
    }
    if (places.points.size() > kMostBadPlaces) places.points.clear();
    return places;
}

BadPlaces places_of(std::span<const MeshFault> faults) {
    BadPlaces places{{}, faults.size()};
    if (faults.size() <= kMostBadPlaces)
        for (const MeshFault& fault : faults) places.points.push_back(fault.point);
    return places;
}

bool is_as_good(std::span<const MeshFault> a, std::span<const MeshFault> b) {
    const auto worst = [](std::span<const MeshFault> faults) {
        double distance = 0;
        for (const MeshFault& fault : faults) distance = std::max(distance, fault.distance);
        return distance;
    };
    return a.size() <= b.size() && worst(a) <= worst(b);
}

bool is_better(std::span<const MeshFault> a, std::span<const MeshFault> b) {
    return is_as_good(a, b) && !is_as_good(b, a);
}

// Mends the faults of a mesh one by one, as far as that can be done. @returns whether anything was done
bool mend(Editor& editor, const SurfaceMesh& mesh, std::span<const MeshFault> faults, MeshChecks& checks) {
    bool any = false;
    for (const MeshFault& fault : faults) {
        if (fault.triangles.size() > kLargestFault) continue;
        const auto allows = [&](const Editor& now, std::span<const int> around) {
            MeshPart part = part_around(now, around);
            part.fault = fault.point;
            return checks.allows(part);
        };
        std::vector<int> corners;
        for (const int t : fault.triangles)
            for (const int v : mesh.triangles[t]) add_once(corners, v);
        if (allows(editor, corners)) continue;  // mended with another
        editor.set_guard(allows);
        any = editor.mend(corners, fault.point) || any;
    }
    editor.set_guard({});
    if (any) editor.renumber();
    return any;
}

}  // namespace

bool is_around(const Vector3d& p, double size, std::span<const Vector3d> places) {
    return std::any_of(places.begin(), places.end(),
                       [&](const Vector3d& q) { return (q - p).norm() < kAround * size; });
}

namespace {

// One mesh on its way to the result.
class Remesher {
  public:
    Remesher(const TriangulatedSurface& surface, const ControlSpace& control, std::span<const int> cells,
             const RemeshOptions& options, MeshChecks* checks)
        : surface_(surface), options_(options), checks_(checks), clock_(result_.statistics.seconds) {
        expect(control);
        support_ = std::make_unique<TriangleSupport>(surface.support, surface.features);
        control_ = &control;
        const Frozen frozen = surface.required
                                  ? frozen_elements(surface.support.points(), surface.support.mesh(), *surface.required)
                                  : Frozen{};
        editor_ = first_editor(surface, *support_, control, frozen, cells);
        result_.statistics.generated_triangles = editor_->mesh().num_live_triangles();
        clock_.done("assembly");
    }

    RemeshResult run() {
        if (has_limit()) make_drafts();
        make_finals();
        if (has_limit() && !options_.fast) {
            polish_last({});
            if (!faults_.empty()) try_again();
        }
        if (checks_ && !options_.fast && faults_.empty()) try_again();
        if (checks_) part_contacts();
        return std::move(result_);
    }

  private:
    bool has_limit() const { return checks_ && checks_->has_limit(); }
    double goal_of(double with_limit) const {
        return has_limit() ? std::min(with_limit, options_.goal) : options_.goal;
    }

    void expect(const ControlSpace& control) {
        result_.statistics.predicted_triangles = check_estimate(control, options_);
    }

    void optimise_for(MeshStage stage, std::vector<char> active) {
        const bool fast = stage == MeshStage::Draft || options_.fast;
        const double goal = goal_of(kGoalOnTheWay);
        take_report(
            optimise(*editor_,
                     {.fast = fast, .goal = goal, .given = given_, .fitted = fitted_, .active = std::move(active)},
                     clock_),
            result_.statistics);
        given_ = false;
        fitted_ = stage == MeshStage::Draft;
    }

    void take_mesh() { result_.mesh = export_mesh(surface_, *support_, *editor_); }

    // Starts from a mesh, that of the result, with other sizes at its vertices.
    void start_from(const Connectivity& mesh, const std::vector<Vertex>& vertices, std::span<const double> sizes) {
        auto finer = std::make_unique<ControlSpace>(result_.mesh.points, mesh, sizes);
        editor_ = std::make_unique<Editor>(*support_, *finer, with_sizes(mesh, vertices, sizes), mesh);
        own_ = std::move(finer);
        control_ = own_.get();
        clock_.done("assembly");
    }

    std::optional<std::vector<double>> sizes_after(MeshStage stage) {
        auto sizes = checks_->sizes_after(result_.mesh, stage, in_vain_);
        clock_.done("check");
        return sizes;
    }

    // Drafts until one is good enough.
    void make_drafts() {
        optimise_for(MeshStage::Draft, {});
        take_mesh();
        while (const auto sizes = sizes_after(MeshStage::Draft)) {
            start_from(editor_->mesh(), editor_->vertices(), *sizes);
            expect(*own_);
            optimise_for(MeshStage::Draft, changed(*editor_, result_.mesh.sizes, *sizes));
            take_mesh();
        }
        // Sizes at its own vertices, or at those of the draft before it, do from here on.
        if (!own_) start_from(editor_->mesh(), editor_->vertices(), checks_->sizes_of_draft(result_.mesh));
    }

    // The whole schedule, and again where sizes are to be lower.
    void make_finals() {
        optimise_for(MeshStage::Final, {});
        take_mesh();
        if (has_limit()) refine_while_at_fault();
    }

    void refine_while_at_fault() {
        while (true) {
            faults_ = check_and_mend(editor_, result_.mesh);
            auto sizes = sizes_after(MeshStage::Final);
            if (!sizes) return;
            refine(std::move(*sizes));
            take_mesh();
        }
    }

    // Lowers sizes, but not where that breaks the mesh, unless it is mended at as many other places or may break.
    void refine(std::vector<double> sizes, bool may_break = false) {
        const Connectivity mesh = editor_->mesh();
        const std::vector<Vertex> vertices = editor_->vertices();
        const std::vector<BrokenPlace> broken_before = broken_places(*editor_);
        const auto known_before = in_vain_.size();
        double reach = 1;
        for (int attempt = 1; attempt <= kMostAttempts; ++attempt) {
            start_from(mesh, vertices, sizes);
            expect(*own_);
            optimise_for(MeshStage::Final, changed(*editor_, result_.mesh.sizes, sizes));
            const auto known = in_vain_.size();
            const std::vector<BrokenPlace> broken_now = broken_places(*editor_);
            if (may_break || broken_now.size() <= broken_before.size()) return;
            for (const BrokenPlace& broken : broken_now) {
                const auto is_same = [&](const BrokenPlace& before) {
                    return (before.at - broken.at).norm() < kSamePlace * broken.size;
                };
                if (std::none_of(broken_before.begin(), broken_before.end(), is_same)) in_vain_.push_back(broken.at);
            }
            if (in_vain_.size() == known) return;
            // Back to what it was there; if that is not enough, ever farther around, and in the end everywhere.
            const auto in_vain_now = std::span(in_vain_).subspan(known_before);
            for (std::size_t v = 0; v < vertices.size(); ++v)
                if (attempt + 1 == kMostAttempts || is_around(vertices[v].p, reach * vertices[v].h, in_vain_now))
                    sizes[v] = result_.mesh.sizes[v];
            reach *= kWider;
        }
    }

    // Checks a mesh, and mends its faults one by one where they are few, as long as that makes it better. @returns
    // those that are left
    std::vector<MeshFault> check_and_mend(std::unique_ptr<Editor>& editor, SurfaceMesh& mesh) {
        std::vector<MeshFault> faults = checks_->faults_of(mesh);
        clock_.done("check");
        const double few = std::max(kFewFaultsInAll, kFewFaults * static_cast<double>(mesh.triangles.size()));
        for (int mendings = 0; !faults.empty() && static_cast<double>(faults.size()) <= few && mendings < kMostMendings;
             ++mendings) {
            auto mender = std::make_unique<Editor>(*support_, *control_, editor->vertices(), editor->mesh());
            const bool any = mend(*mender, mesh, faults, *checks_);
            clock_.done("mending");
            if (!any) break;
            SurfaceMesh mended = export_mesh(surface_, *support_, *mender);
            std::vector<MeshFault> left = checks_->faults_of(mended);
            const bool better = is_better(left, faults);
            if (!better) checks_->faults_of(mesh);
            clock_.done("check");
            if (!better) break;
            editor = std::move(mender);
            mesh = std::move(mended);
            faults = std::move(left);
        }
        return faults;
    }

    // Improves what is not as good as it could be, without losing what was reached. @param around  places to do that
    // at; empty: everywhere
    void polish_last(std::span<const Vector3d> around) {
        std::vector<char> active;
        if (!around.empty())
            for (const Vertex& v : editor_->vertices())
                active.push_back(std::any_of(around.begin(), around.end(),
                                             [&](const Vector3d& p) { return (p - v.p).norm() < kAroundBad * v.h; }));
        std::vector<Vector3d> barred;
        for (int attempt = 1; attempt <= kMostAttempts; ++attempt) {
            auto polisher = std::make_unique<Editor>(*support_, *control_, editor_->vertices(), editor_->mesh());
            polisher->set_guard([&](const Editor& now, std::span<const int> vertices) {
                return std::none_of(vertices.begin(), vertices.end(),
                                    [&](int v) { return is_around(now.vertex(v).p, now.vertex(v).h, barred); }) &&
                       checks_->allows(part_around(now, vertices));
            });
            const OptimiseReport report = polish(*polisher, goal_of(kGoalOfPolish), active, clock_);
            polisher->set_guard({});
            SurfaceMesh polished = export_mesh(surface_, *support_, *polisher);
            const std::vector<MeshFault> left = check_and_mend(polisher, polished);
            if (is_as_good(left, faults_)) {
                take_report(report, result_.statistics);
                editor_ = std::move(polisher);
                result_.mesh = std::move(polished);
                faults_ = left;
                return;
            }
            for (const MeshFault& fault : left) barred.push_back(fault.point);
        }
        checks_->faults_of(result_.mesh);
        clock_.done("check");
    }

    // What is gone back to where a change led to nothing better.
    struct State {
        Connectivity connectivity;
        std::vector<Vertex> vertices;
        SurfaceMesh mesh;
        RemeshStatistics statistics;
        std::vector<MeshFault> faults;
    };
    State state() const { return {editor_->mesh(), editor_->vertices(), result_.mesh, result_.statistics, faults_}; }

    void restore(State state) {
        checks_->take_back();
        state.statistics.seconds = std::move(result_.statistics.seconds);
        result_.statistics = std::move(state.statistics);
        result_.mesh = std::move(state.mesh);
        faults_ = std::move(state.faults);
        start_from(state.connectivity, state.vertices, result_.mesh.sizes);
        checks_->faults_of(result_.mesh);
        clock_.done("check");
    }

    // Makes the mesh anew, with smaller sizes, around its faults or, where it has none, around elements that fall short
    // though nothing forces them to.
    void try_again() {
        double factor = kSmaller;
        for (int attempt = 1, failures = 0; attempt <= kMostRetries && failures < kMostFailures; ++attempt) {
            const std::vector<MeshFault> faults = faults_;
            const BadPlaces before = faults.empty() ? bad_places(result_.mesh) : places_of(faults);
            if (before.points.empty()) return;
            const auto sizes = checks_->sizes_below(result_.mesh, before.points, factor);
            if (!sizes) return;
            const State earlier = state();
            try {
                // What is broken on the way to a mesh without faults may be mended later.
                refine(*sizes, !faults.empty());
                take_mesh();
                refine_while_at_fault();
                polish_last(before.points);
                if (faults.empty() ? is_as_good(faults_, faults) && bad_places(result_.mesh).elements < before.elements
                                   : is_better(faults_, faults))
                    continue;
            } catch (const std::length_error&) {
                // More triangles than there may be: then the mesh stays what it was.
            }
            restore(earlier);
            ++failures;
            factor *= kSmaller;
        }
    }

    // Smaller elements keep sheets apart that larger ones cut into each other.
    void part_contacts() {
        std::vector<Vector3d> contacts = checks_->contacts_of(result_.mesh);
        for (int attempt = 1; attempt <= kMostPartings && !contacts.empty(); ++attempt) {
            clock_.done("check");
            const auto sizes = checks_->sizes_below(result_.mesh, contacts, kSmaller);
            if (!sizes) return;
            const State before = state();
            bool better = false;
            try {
                refine(*sizes, true);
                take_mesh();
                if (has_limit()) refine_while_at_fault();
                if (!options_.fast) polish_last(contacts);
                const std::vector<Vector3d> left = checks_->contacts_of(result_.mesh);
                better = left.size() <= contacts.size() && is_as_good(faults_, before.faults);
                if (better) contacts = left;
            } catch (const std::length_error&) {
                // More triangles than there may be.
            }
            if (better) continue;
            restore(before);
            checks_->contacts_of(result_.mesh);
            return;
        }
    }

    const TriangulatedSurface& surface_;
    const RemeshOptions& options_;
    MeshChecks* checks_;
    RemeshResult result_;
    StageClock clock_;
    const ControlSpace* control_ = nullptr;  // of the editor
    std::unique_ptr<ControlSpace> own_;      // sizes at the vertices of the last mesh that was begun from
    std::unique_ptr<TriangleSupport> support_;
    std::unique_ptr<Editor> editor_;
    bool given_ = true, fitted_ = false;  // see OptimiseOptions
    std::vector<MeshFault> faults_;       // of the last mesh
    std::vector<Vector3d> in_vain_;       // places where lower sizes broke it
};

}  // namespace

RemeshResult remesh(const TriangulatedSurface& surface, const ControlSpace& control, std::span<const int> cells,
                    const RemeshOptions& options, MeshChecks* checks) {
    const Connectivity& mesh = surface.support.mesh();
    if (std::ssize(cells) < mesh.num_vertices())
        throw std::invalid_argument("remesh: " + std::to_string(cells.size()) + " cells for " +
                                    std::to_string(mesh.num_vertices()) + " vertices");
    if (!surface.labels.empty() && std::ssize(surface.labels) != mesh.num_triangles())
        throw std::invalid_argument("remesh: " + std::to_string(surface.labels.size()) + " labels for " +
                                    std::to_string(mesh.num_triangles()) + " triangles");
    return Remesher(surface, control, cells, options, checks).run();
}

}  // namespace gradus

#include "gradus/control/clearance.hpp"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <mutex>
#include <numbers>
#include <optional>
#include <queue>
#include <unordered_map>

#include "gradus/mesh/closest.hpp"

namespace gradus {

namespace {

using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kFacing =
    3.732;  // 1 / tan 15 degrees: way along features over distance, from which they face each other
constexpr double kNarrow = std::numbers::pi / 6;  // angle of corners whose sides face each other
constexpr double kStraight = 1.2;    // way over distance, up to which sides of a corner run straight from it
constexpr double kSamePlace = 0.05;  // from one another over the clearance
constexpr double kSeen = 0.5;        // cosine of the angles within which sheets see each other
constexpr double kDetour = 1.4;      // way along the surface over distance, up to which a place is a neighbour

// Shortest ways from some vertices along edges, found as far as they are asked for.
class Ways {
  public:
    void begin(std::size_t vertices) {
        if (stamps_.size() != vertices) stamps_.assign(vertices, 0), lengths_.resize(vertices), now_ = 0;
        ++now_;
        heap_ = {};
    }
    void reach(int v, double length) {
        if (length >= at(v)) return;
        stamps_[v] = now_;
        lengths_[v] = length;
        heap_.emplace(length, v);
    }
    /// Afterwards all lengths up to `limit` are final, and others are longer. @param from  calls its argument with
    /// neighbour and edge length
    template <class From>
    void advance(double limit, const From& from) {
        while (!heap_.empty() && heap_.top().first <= limit) {
            const auto [length, v] = heap_.top();
            heap_.pop();
            if (length > at(v)) continue;
            from(v, [&, base = length](int w, double edge) { reach(w, base + edge); });
        }
    }
    double at(int v) const { return stamps_[v] == now_ ? lengths_[v] : kInfinity; }

  private:
    using Entry = std::pair<double, int>;
    std::vector<int> stamps_;
    std::vector<double> lengths_;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> heap_;
    int now_ = 0;
};

// What a growing ball holds of the face about its middle.
class Ball {
  public:
    Ball(std::span<const Vector3d> points, const Connectivity& mesh)
        : points_(points), mesh_(mesh), seen_(mesh.num_triangles(), 0) {}

    /// Calls meet(h, q, radius) as the ball grows to hold the place q of a feature half-edge h, until it returns true.
    template <class Meet>
    void grow(const Vector3d& middle, std::span<const int> triangles, double most, const Meet& meet) {
        ++now_;
        heap_ = {};
        middle_ = middle;
        most_ = most;
        for (const int t : triangles) enter(t, 0);
        while (!heap_.empty()) {
            const auto [radius, h] = heap_.top();
            heap_.pop();
            if (mesh_.tag(h) >= 0) {
                if (meet(h, nearest(h), radius)) return;
            } else if (mesh_.twin(h) != Connectivity::kNone) {
                enter(mesh_.twin(h) / 3, radius);
            }
        }
    }

  private:
    Vector3d nearest(int h) const {
        const Vector3d &a = points_[mesh_.origin(h)], &b = points_[mesh_.target(h)];
        return closest_point(middle_, a, b, b);
    }
    void enter(int t, double radius) {
        if (seen_[t] == now_) return;
        seen_[t] = now_;
        for (int h = 3 * t; h < 3 * t + 3; ++h)
            if (const double r = std::max(radius, (nearest(h) - middle_).norm()); r <= most_) heap_.emplace(r, h);
    }

    using Entry = std::pair<double, int>;
    std::span<const Vector3d> points_;
    const Connectivity& mesh_;
    std::vector<int> seen_;  // triangles entered when now_ was this
    int now_ = 0;
    Vector3d middle_ = Vector3d::Zero();
    double most_ = 0;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> heap_;
};

}  // namespace

struct ClearanceFinder::Parts {
    explicit Parts(const Triangulation& triangulation)
        : surface(triangulation),
          points(surface.soup().points),
          mesh(surface.mesh()),
          wedges(surface.wedges()),
          first(points.size() + 1, 0) {
        for (int h = 0; h < 3 * mesh.num_triangles(); ++h)
            if (mesh.tag(h) >= 0 && mesh.twin(h) < h)
                segments.push_back({mesh.origin(h), mesh.target(h), mesh.target(h)});
        for (const Triangle& s : segments) ++first[s[0] + 1], ++first[s[1] + 1];
        for (std::size_t v = 0; v < points.size(); ++v) first[v + 1] += first[v];
        arcs.resize(first.back());
        std::vector<int> next(first.begin(), first.end() - 1);
        for (const Triangle& s : segments) {
            const double length = (points[s[1]] - points[s[0]]).norm();
            arcs[next[s[0]]++] = {s[1], length};
            arcs[next[s[1]]++] = {s[0], length};
        }
        if (segments.empty()) return;
        for (int v = 0; v < mesh.num_vertices(); ++v)
            if (is_tip(v)) tips.push_back(v);
        std::vector<int> all(segments.size());
        for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
        near_features.emplace(points, segments, std::move(all));
    }

    bool on_feature(const SidedPlace& place) const {
        if (place.wedge >= 0) return first[wedges.vertex[place.wedge]] < first[wedges.vertex[place.wedge] + 1];
        return place.half_edge >= 0 && mesh.tag(place.half_edge) >= 0;
    }

    // Whether two features leave a vertex with a narrow angle between them.
    bool is_tip(int v) const {
        bool narrow = false;
        if (first[v + 1] - first[v] < 2) return false;
        for (const SidedPlace& side : sides_of_vertex(surface, v)) {
            double angle = 0;
            wedges.for_each(mesh, side.wedge, [&](int h) {
                const Vector3d a = points[mesh.target(h)] - points[v], b = points[mesh.apex(h)] - points[v];
                angle += std::atan2(a.cross(b).norm(), a.dot(b));
            });
            narrow = narrow || angle < kNarrow;
        }
        return narrow;
    }

    std::vector<int> triangles_at(const SidedPlace& place) const {
        if (place.wedge < 0) return {place.triangle};
        std::vector<int> result;
        wedges.for_each(mesh, place.wedge, [&](int h) { result.push_back(h / 3); });
        return result;
    }

    // A place of feature half-edge h, on its side.
    SidedPlace beside(int h, const Vector3d& q) const {
        SidedPlace place{q, h / 3, h};
        if (q == points[mesh.origin(h)]) place.wedge = wedges.of_corner[h];
        if (q == points[mesh.target(h)]) place.wedge = wedges.of_corner[Connectivity::next(h)];
        return place;
    }

    // Across the face, from a place on a feature.
    Clearance across(const SidedPlace& place, double reach, double tip) const {
        const Vector3d& p = place.point;
        std::vector<int> near_tips;
        std::copy_if(tips.begin(), tips.end(), std::back_inserter(near_tips),
                     [&](int v) { return (points[v] - p).norm() < tip; });
        Ways& ways = along_features.local();
        ways.begin(points.size());
        if (place.wedge >= 0) {
            ways.reach(wedges.vertex[place.wedge], 0);
        } else {
            for (const int v : {mesh.origin(place.half_edge), mesh.target(place.half_edge)})
                ways.reach(v, (points[v] - p).norm());
        }
        const auto from = [&](int v, const auto& to) {
            for (int i = first[v]; i < first[v + 1]; ++i) to(arcs[i].first, arcs[i].second);
        };
        const auto same_edge = [&](int h) {
            return place.wedge < 0 && (h == place.half_edge || h == mesh.twin(place.half_edge));
        };
        Clearance result;
        balls.local().grow(p, triangles_at(place), reach, [&](int h, const Vector3d& q, double radius) {
            if (same_edge(h)) return false;
            const int a = mesh.origin(h), b = mesh.target(h);
            const auto is_longer = [&](double length) {
                ways.advance(length, from);
                return std::min(ways.at(a) + (q - points[a]).norm(), ways.at(b) + (q - points[b]).norm()) > length;
            };
            if (!is_longer(kFacing * radius)) return false;
            const auto joins = [&](int v) {
                return !is_longer(kStraight * ((points[v] - p).norm() + (points[v] - q).norm()));
            };
            if (std::any_of(near_tips.begin(), near_tips.end(), joins)) return false;
            result = {radius, h / 3, q};
            return true;
        });
        return result;
    }

    // That of the nearer end of its edge, if from so far away both are the same place. Fine rims have many places asked
    // for between two ends.
    std::optional<Clearance> across_from_end(const SidedPlace& place, double reach, double tip) const {
        const int a = mesh.origin(place.half_edge), b = mesh.target(place.half_edge);
        const double to_a = (points[a] - place.point).norm(), to_b = (points[b] - place.point).norm(),
                     off = std::min(to_a, to_b);
        const int v = to_a <= to_b ? a : b;
        if (off > kSamePlace * reach || first[v + 1] - first[v] != 2) return {};
        const SidedPlace end = beside(place.half_edge, points[v]);
        FromEnd& known = from_ends.local()[end.wedge];
        if (known.reach != reach || known.tip != tip) known = {reach, tip, across(end, reach, tip)};
        if (off > kSamePlace * std::min(known.clearance.distance, reach)) return {};
        return known.clearance;
    }

    Clearance feature(const SidedPlace& place, double reach, double tip) const {
        if (segments.empty()) return {};
        if (on_feature(place)) return across(place, reach, tip);
        if (near_features->closest(place.point).distance > reach) return {};
        std::optional<SidedPlace> nearest;
        double distance = 0;
        balls.local().grow(place.point, triangles_at(place), reach, [&](int h, const Vector3d& q, double radius) {
            nearest = beside(h, q);
            distance = radius;
            return true;
        });
        if (!nearest) return {};
        const std::optional<Clearance> at_end = across_from_end(*nearest, reach, tip);
        const Clearance there = at_end ? *at_end : across(*nearest, reach, tip);
        return distance <= there.distance ? there : Clearance{};
    }

    // Of the smooth surface, at a place of a triangle.
    Vector3d normal_at(int t, const Vector3d& p) const {
        const Triangle v = mesh.triangle(t);
        const Vector3d &a = points[v[0]], &b = points[v[1]], &c = points[v[2]];
        const Vector3d facet = (b - a).cross(c - a);
        const double weight[3] = {(c - b).cross(p - b).dot(facet), (a - c).cross(p - c).dot(facet),
                                  (b - a).cross(p - a).dot(facet)};
        Vector3d sum = Vector3d::Zero();
        for (int k = 0; k < 3; ++k) sum += std::max(weight[k], 0.0) * normal_of_wedge(wedges.of_corner[3 * t + k]);
        return sum.squaredNorm() > 0 ? sum.stableNormalized() : facet.stableNormalized();
    }
    // Not so where noise folds the facets over.
    bool is_unfolded(int t) const {
        const auto normal = [&](int k) -> const Vector3d& { return normal_of_wedge(wedges.of_corner[3 * t + k]); };
        return normal(0).dot(normal(1)) >= kSeen && normal(1).dot(normal(2)) >= kSeen &&
               normal(2).dot(normal(0)) >= kSeen;
    }
    const Vector3d& normal_of_wedge(int wedge) const { return surface.curvature()[wedge].normal; }

    Clearance sheet(const SidedPlace& place, double reach) const {
        std::call_once(facets_made, [&] { facets.emplace(points, surface.soup().triangles); });
        const Vector3d& p = place.point;
        for (const int t : triangles_at(place))
            if (!is_unfolded(t)) return {};
        const Vector3d normal = place.wedge >= 0 ? normal_of_wedge(place.wedge) : normal_at(place.triangle, p);
        Ways& ways = along_edges.local();
        ways.begin(points.size());
        for (const int v : mesh.triangle(place.triangle)) ways.reach(v, (points[v] - p).norm());
        const auto from = [&](int v, const auto& to) {
            mesh.for_each_outgoing(v, [&](int h) {
                for (const int w : {mesh.target(h), mesh.apex(h)}) to(w, (points[w] - points[v]).norm());
            });
        };
        const auto faces = [&](int t, const Vector3d& q) {
            const double distance = (q - p).norm();
            const Vector3d there = normal_at(t, q);
            if (t == place.triangle || there.dot(normal) > -kSeen || std::abs(there.dot(q - p)) < kSeen * distance)
                return false;
            if (!is_unfolded(t)) return false;
            ways.advance(kDetour * distance, from);
            double way = kInfinity;
            for (const int v : mesh.triangle(t)) way = std::min(way, ways.at(v) + (q - points[v]).norm());
            return way > kDetour * distance;
        };
        const ClosestTriangle::Hit hit = facets->closest_in_cone({p, normal, kSeen}, reach, faces);
        if (hit.triangle < 0) return {};
        const Triangle& v = surface.soup().triangles[hit.triangle];
        return {hit.distance, hit.triangle, closest_point(p, points[v[0]], points[v[1]], points[v[2]])};
    }

    const Triangulation& surface;
    std::span<const Vector3d> points;
    const Connectivity& mesh;
    const Wedges& wedges;
    std::vector<Triangle> segments;  // feature edges
    std::vector<int> first;          // of the arcs of each vertex
    std::vector<std::pair<int, double>> arcs;
    std::vector<int> tips;
    std::optional<ClosestTriangle> near_features;
    mutable std::once_flag facets_made;
    mutable std::optional<ClosestTriangle> facets;
    mutable tbb::enumerable_thread_specific<Ways> along_features, along_edges;
    // What was found last for a wedge: threads ask for the same, and find it each for themselves.
    struct FromEnd {
        double reach = -1, tip = -1;
        Clearance clearance;
    };
    mutable tbb::enumerable_thread_specific<std::unordered_map<int, FromEnd>> from_ends;
    mutable tbb::enumerable_thread_specific<Ball> balls{[this] { return Ball(points, mesh); }};
};

ClearanceFinder::ClearanceFinder(const Triangulation& surface) : parts_(std::make_unique<Parts>(surface)) {}
ClearanceFinder::~ClearanceFinder() = default;

Clearance ClearanceFinder::feature(const SidedPlace& place, double reach, double tip) const {
    return parts_->feature(place, reach, tip);
}
Clearance ClearanceFinder::sheet(const SidedPlace& place, double reach) const { return parts_->sheet(place, reach); }

std::vector<SidedPlace> sides_of_vertex(const Triangulation& surface, int v) {
    std::vector<SidedPlace> sides;
    const Connectivity& mesh = surface.mesh();
    if (!mesh.is_live_vertex(v)) return sides;
    int last = -1;
    mesh.for_each_outgoing(v, [&](int h) {
        const int wedge = surface.wedges().of_corner[h];
        if (wedge == last || (!sides.empty() && sides.front().wedge == wedge)) return;
        sides.push_back({surface.soup().points[v], h / 3, -1, wedge});
        last = wedge;
    });
    return sides;
}

std::vector<SidedPlace> sides_of_edge(const Triangulation& surface, int h, const Vector3d& point) {
    std::vector<SidedPlace> sides{{point, h / 3, h}};
    if (const int g = surface.mesh().twin(h); g >= 0 && surface.mesh().tag(h) >= 0) sides.push_back({point, g / 3, g});
    return sides;
}

namespace {

template <class Find>
std::vector<double> at_vertices(const Triangulation& surface, const Find& find) {
    const ClearanceFinder finder(surface);
    std::vector<double> result(surface.soup().points.size(), kInfinity);
    tbb::parallel_for(tbb::blocked_range<int>(0, static_cast<int>(result.size()), 64), [&](const auto& range) {
        for (int v = range.begin(); v < range.end(); ++v)
            for (const SidedPlace& side : sides_of_vertex(surface, v))
                result[v] = std::min(result[v], find(finder, side).distance);
    });
    return result;
}

}  // namespace

std::vector<double> feature_clearance(const Triangulation& surface, double reach) {
    return at_vertices(
        surface, [=](const ClearanceFinder& finder, const SidedPlace& side) { return finder.feature(side, reach); });
}

std::vector<double> sheet_clearance(const Triangulation& surface, double reach) {
    return at_vertices(
        surface, [=](const ClearanceFinder& finder, const SidedPlace& side) { return finder.sheet(side, reach); });
}

}  // namespace gradus

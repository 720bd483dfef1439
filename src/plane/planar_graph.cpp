#include "gradus/plane/planar_graph.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>

#include "constrained_triangulation.hpp"
#include "gradus/mesh/edge.hpp"
#include "gradus/plane/predicates.hpp"

namespace gradus {
namespace {

using Edge = std::array<int, 2>;
using planar::kOutside;

constexpr int kNone = -1;
constexpr double kLargestCoordinate = 1e40;  // of which the signs of areas are exact
// Circumradius over the shortest side of a triangle that is well shaped. [Ruppert 1995]
constexpr double kWellShaped = 1.4142135623730951;

std::string text_of(const Eigen::Vector2d& p) {
    std::ostringstream text;
    text << '(' << p.x() << ", " << p.y() << ')';
    return text.str();
}

/// The biconnected components of a graph: of each segment the one it is in. [Hopcroft, Tarjan 1973]
class Outlines {
  public:
    Outlines(int num_points, std::span<const Edge> segments)
        : segments_(segments), of_(segments.size(), kNone), number_(num_points, 0), low_(num_points, 0) {
        at_.resize(num_points);
        for (int s = 0; s < static_cast<int>(segments.size()); ++s)
            for (const int v : segments[s]) at_[v].push_back(s);
        for (int v = 0; v < num_points; ++v)
            if (number_[v] == 0) search(v);
    }
    int count() const { return count_; }
    int of(int segment) const { return of_[segment]; }

  private:
    struct Visit {
        int vertex, by;        // the segment it was reached by
        std::size_t next = 0;  // of the segments at it
    };

    // Depth first, with a stack of our own: outlines are long.
    void search(int root) {
        std::vector<Visit> way{{root, kNone}};
        number_[root] = low_[root] = ++numbered_;
        while (!way.empty()) {
            Visit& visit = way.back();
            if (visit.next == at_[visit.vertex].size()) {
                leave(way);
                continue;
            }
            const int v = visit.vertex, s = at_[v][visit.next++];
            if (s == visit.by) continue;
            const int w = segments_[s][segments_[s][0] == v];
            if (number_[w] == 0) {
                open_.push_back(s);
                number_[w] = low_[w] = ++numbered_;
                way.push_back({w, s});
            } else if (number_[w] < number_[v]) {
                open_.push_back(s);
                low_[v] = std::min(low_[v], number_[w]);
            }
        }
    }

    void leave(std::vector<Visit>& way) {
        const Visit done = way.back();
        way.pop_back();
        if (way.empty()) return;
        const int parent = way.back().vertex;
        low_[parent] = std::min(low_[parent], low_[done.vertex]);
        if (low_[done.vertex] < number_[parent]) return;
        // Nothing below reaches above the parent: what is open since it was left is one outline.
        for (int s = kNone; s != done.by;) {
            s = open_.back();
            open_.pop_back();
            of_[s] = count_;
        }
        ++count_;
    }

    std::span<const Edge> segments_;
    std::vector<std::vector<int>> at_;  // segments at a point
    std::vector<int> of_, number_, low_, open_;
    int numbered_ = 0, count_ = 0;
};

/// Points inside a triangulation that make its triangles well shaped as far as the segments let them: circumcentres of
/// badly shaped ones, or on the way there where a segment is between or near. [Ruppert 1995; Ungor 2004] Segments stay
/// whole. It ends, as no two
/// points come nearer to each other than those that were there.
class Refinement {
  public:
    /// @param region  of each triangle, kept up to date; those below 0 stay as they are
    Refinement(std::vector<planar::Tri>& triangles, std::vector<Eigen::Vector2d>& points, std::vector<int>& region)
        : triangles_(triangles), points_(points), region_(region) {}

    void run() {
        for (int t = 0; t < static_cast<int>(triangles_.size()); ++t) waiting_.push_back({t, triangles_[t].v});
        for (std::size_t i = 0; i < waiting_.size(); ++i) {
            const auto [t, corners] = waiting_[i];
            if (region_[t] < 0 || triangles_[t].v != corners) continue;
            const auto bad = bad_shape(corners);
            if (!bad) continue;
            // On the way from the shortest side to the circumcentre, which may be out of sight.
            const double nearest = bad->shortest / bad->way.norm();
            for (double part = 1; part >= nearest && !insert(t, bad->side + part * bad->way); part /= 2) continue;
        }
    }

  private:
    struct Waiting {
        int triangle;
        std::array<int, 3> corners;  // to know whether it is still there
    };

    struct BadShape {
        double shortest;            // side
        Eigen::Vector2d side, way;  // its middle, and from there to the circumcentre
    };
    std::optional<BadShape> bad_shape(const std::array<int, 3>& v) const {
        const Eigen::Vector2d &a = points_[v[0]], ab = points_[v[1]] - a, ac = points_[v[2]] - a;
        const double cross = ab.x() * ac.y() - ab.y() * ac.x();
        const Eigen::Vector2d centre = (Eigen::Vector2d(ac.y(), -ac.x()) * ab.squaredNorm() +
                                        Eigen::Vector2d(-ab.y(), ab.x()) * ac.squaredNorm()) /
                                       (2 * cross);
        const std::array<std::pair<double, Eigen::Vector2d>, 3> sides{
            {{ab.norm(), ab / 2}, {ac.norm(), ac / 2}, {(ac - ab).norm(), (ab + ac) / 2}}};
        const auto& [shortest, middle] = *std::min_element(
            sides.begin(), sides.end(), [](const auto& one, const auto& other) { return one.first < other.first; });
        if (!centre.allFinite() || centre.norm() <= kWellShaped * shortest) return std::nullopt;
        return BadShape{shortest, a + middle, centre - middle};
    }

    // The triangle that holds p, if no segment lies between.
    std::optional<int> seen_from(int t, const Eigen::Vector2d& p) const {
        constexpr int kMostSteps = 10'000;
        for (int step = 0; step < kMostSteps; ++step) {
            const planar::Tri& tri = triangles_[t];
            int through = kNone;
            for (int i = 0, k = step % 3; i < 3 && through == kNone; ++i, k = planar::next(k))
                if (orient2d(points_[tri.v[planar::next(k)]], points_[tri.v[planar::previous(k)]], p) < 0) through = k;
            if (through == kNone) return t;
            if (tri.is_fixed(through) || tri.n[through] == kOutside) return std::nullopt;
            t = tri.n[through];
        }
        return std::nullopt;
    }

    // Nearer to a segment than half the way to the next point.
    bool is_near_segment(const Eigen::Vector2d& p) const {
        double next2 = std::numeric_limits<double>::infinity();
        for (const planar::RimEdge& e : cavity_.rim) next2 = std::min(next2, (points_[e.a] - p).squaredNorm());
        return std::any_of(cavity_.rim.begin(), cavity_.rim.end(), [&](const planar::RimEdge& e) {
            if (!e.fixed) return false;
            const Eigen::Vector2d segment = points_[e.b] - points_[e.a], to = p - points_[e.a];
            const double along = to.dot(segment), length2 = segment.squaredNorm();
            return along > 0 && along < length2 && 4 * (to - along / length2 * segment).squaredNorm() < next2;
        });
    }

    bool insert(int seen, const Eigen::Vector2d& p) {
        const std::optional<int> start = seen_from(seen, p);
        if (!start) return false;
        const auto at = [&](int v) { return points_[v]; };
        const auto in_conflict = [&](int t) {
            const auto& v = triangles_[t].v;
            return incircle(at(v[0]), at(v[1]), at(v[2]), p) > 0;
        };
        if (!planar::grow_cavity(triangles_, at, in_conflict, *start, p, cavity_) || is_near_segment(p)) return false;
        const int of = region_[*start];
        planar::fill_cavity(triangles_, static_cast<int>(points_.size()), cavity_, fan_);
        points_.push_back(p);
        region_.resize(triangles_.size());
        for (const int t : fan_) {
            region_[t] = of;
            waiting_.push_back({t, triangles_[t].v});
        }
        return true;
    }

    std::vector<planar::Tri>& triangles_;
    std::vector<Eigen::Vector2d>& points_;
    std::vector<int>& region_;
    std::vector<Waiting> waiting_;
    planar::Cavity cavity_;
    std::vector<int> fan_;
};

/// The faces into which the segments cut the plane, and which of them are the domain.
class Faces {
  public:
    explicit Faces(const PlanarGraph& graph)
        : graph_(graph),
          arrangement_(planar::triangulate_segments(graph.points, graph.segments, graph.first_number)),
          of_(triangles().size(), kNone) {
        for (int s = 0; s < static_cast<int>(graph.segments.size()); ++s)
            segment_at_[edge_between(graph.segments[s][0], graph.segments[s][1])] = s;
        for (int t = 0; t < static_cast<int>(triangles().size()); ++t)
            if (of_[t] == kNone) fill(t);
        inside_.assign(sides_.size(), 0);
        outer_ = of_[arrangement_.outer];
        if (graph.holes)
            enclose_but_holes();
        else
            alternate();
        check_inside();
        name_regions();
    }

    // Adds points so that triangles of the domain are well shaped.
    void refine() {
        std::vector<int> region(of_.size(), kNone);
        for (std::size_t t = 0; t < region.size(); ++t)
            if (inside_[of_[t]]) region[t] = of_[t];
        added_ = arrangement_.points;
        Refinement(arrangement_.triangles, added_, region).run();
        of_ = std::move(region);
        added_.erase(added_.begin(), added_.begin() + std::ssize(arrangement_.points));
    }

    TriangleSoup soup() const {
        TriangleSoup soup;
        soup.dimension = 2;
        for (const auto* points : {&graph_.points, &added_})
            for (const Eigen::Vector2d& p : *points) soup.points.emplace_back(p.x(), p.y(), 0);
        std::vector<char> in_segment(graph_.points.size(), 0), used(graph_.points.size(), 0);
        // The corners of the box are numbered between the points and those that were added.
        const int n = static_cast<int>(graph_.points.size());
        const int box = static_cast<int>(arrangement_.points.size()) - n;
        for (int t = 0; t < static_cast<int>(triangles().size()); ++t) {
            if (of_[t] == kNone || !inside_[of_[t]]) continue;
            Triangle corners = triangles()[t].v;
            for (int& v : corners) v < n ? used[v] = 1 : v -= box;
            soup.triangles.push_back(corners);
            if (has_labels_) soup.labels.push_back(labels_[of_[t]]);
        }
        for (std::size_t s = 0; s < graph_.segments.size(); ++s) {
            if (!is_of_domain_[s]) continue;
            soup.edges.push_back(graph_.segments[s]);
            if (!graph_.labels.empty()) soup.edge_labels.push_back(graph_.labels[s]);
        }
        soup.corners = graph_.corners;
        soup.required = graph_.required;
        for (const Edge& e : graph_.segments) in_segment[e[0]] = in_segment[e[1]] = 1;
        std::vector<char> required(graph_.points.size(), 0);
        for (const int v : soup.required.vertices) required[v] = 1;
        for (int v = 0; v < static_cast<int>(used.size()); ++v)
            if (used[v] && !in_segment[v] && !required[v]) soup.required.vertices.push_back(v);
        return soup;
    }

  private:
    struct FaceSide {
        int segment, beyond;  // face across it
    };

    const std::vector<planar::Tri>& triangles() const { return arrangement_.triangles; }
    [[noreturn]] static void refuse(const std::string& what) { throw std::invalid_argument(what); }
    std::string name(int segment) const {
        const auto& [a, b] = graph_.segments[segment];
        return "segment " + std::to_string(a + graph_.first_number) + "-" + std::to_string(b + graph_.first_number) +
               " at " + text_of(graph_.points[a]);
    }

    void fill(int first) {
        const int face = static_cast<int>(sides_.size());
        sides_.emplace_back();
        std::vector<int> waiting{first};
        of_[first] = face;
        while (!waiting.empty()) {
            const int t = waiting.back();
            waiting.pop_back();
            const planar::Tri& tri = triangles()[t];
            for (int k = 0; k < 3; ++k) {
                if (tri.is_fixed(k)) {
                    const int segment =
                        segment_at_.at(edge_between(tri.v[planar::next(k)], tri.v[planar::previous(k)]));
                    sides_[face].push_back({segment, tri.n[k]});
                } else if (tri.n[k] != kOutside && of_[tri.n[k]] == kNone) {
                    of_[tri.n[k]] = face;
                    waiting.push_back(tri.n[k]);
                }
            }
        }
    }
    int beyond(const FaceSide& side) const { return of_[side.beyond]; }

    // From the outside inwards: behind each outline that is met lie faces of the other kind. An outline has one face
    // outside of it.
    void alternate() {
        const Outlines outlines(static_cast<int>(graph_.points.size()), graph_.segments);
        std::vector<std::vector<FaceSide>> sides(outlines.count());
        for (const auto& of_face : sides_)
            for (const FaceSide& side : of_face) sides[outlines.of(side.segment)].push_back(side);
        std::vector<char> met(outlines.count(), 0), seen(sides_.size(), 0);
        std::vector<int> waiting{outer_};
        seen[outer_] = 1;
        for (std::size_t i = 0; i < waiting.size(); ++i) {
            const int face = waiting[i];
            for (const FaceSide& own : sides_[face]) {
                const int outline = outlines.of(own.segment);
                if (met[outline]) continue;
                met[outline] = 1;
                for (const FaceSide& side : sides[outline]) {
                    const int other = beyond(side);
                    if (seen[other]) continue;
                    seen[other] = 1;
                    inside_[other] = !inside_[face];
                    waiting.push_back(other);
                }
            }
        }
    }

    void enclose_but_holes() {
        std::fill(inside_.begin(), inside_.end(), 1);
        inside_[outer_] = 0;
        for (const Eigen::Vector2d& hole : *graph_.holes) {
            const int face = face_at(hole);
            if (face == outer_) refuse("the hole at " + text_of(hole) + " is in no region");
            inside_[face] = 0;
        }
    }

    int face_at(const Eigen::Vector2d& p) const {
        const auto at = [&](int v) { return graph_.points[v]; };
        const int n = static_cast<int>(graph_.points.size());
        for (int t = 0; t < static_cast<int>(triangles().size()); ++t) {
            const auto& v = triangles()[t].v;
            if (std::max({v[0], v[1], v[2]}) >= n) continue;
            if (orient2d(at(v[0]), at(v[1]), p) >= 0 && orient2d(at(v[1]), at(v[2]), p) >= 0 &&
                orient2d(at(v[2]), at(v[0]), p) >= 0)
                return of_[t];
        }
        return outer_;
    }

    // Something is enclosed, and every segment is of it; with holes that are listed, what is between them is not.
    void check_inside() {
        if (std::find(inside_.begin(), inside_.end(), 1) == inside_.end()) {
            std::vector<int> degree(graph_.points.size(), 0);
            for (const Edge& e : graph_.segments) ++degree[e[0]], ++degree[e[1]];
            const auto end = std::find(degree.begin(), degree.end(), 1) - degree.begin();
            if (graph_.holes && end == std::ssize(degree))
                refuse("nothing is left of the domain: there is a hole in each region");
            refuse("the segments enclose nothing: the outline is open at point " +
                   std::to_string(end + graph_.first_number) + " at " +
                   text_of(graph_.points[static_cast<std::size_t>(end)]));
        }
        is_of_domain_.assign(graph_.segments.size(), 0);
        for (int face = 0; face < static_cast<int>(sides_.size()); ++face)
            if (inside_[face])
                for (const FaceSide& side : sides_[face]) is_of_domain_[side.segment] = 1;
        const auto outside = std::find(is_of_domain_.begin(), is_of_domain_.end(), 0);
        if (!graph_.holes && outside != is_of_domain_.end())
            refuse(name(static_cast<int>(outside - is_of_domain_.begin())) +
                   " is not in the domain: it bounds no region and lies in none");
    }

    void name_regions() {
        labels_.assign(sides_.size(), 0);
        has_labels_ = !graph_.regions.empty();
        std::vector<char> named(sides_.size(), 0);
        for (const PlanarGraph::Region& region : graph_.regions) {
            const int face = face_at(region.point);
            if (!inside_[face]) refuse("the region at " + text_of(region.point) + " is in none of the domain");
            if (named[face] && labels_[face] != region.label)
                refuse("the region at " + text_of(region.point) + " has two labels, " + std::to_string(labels_[face]) +
                       " and " + std::to_string(region.label));
            named[face] = 1;
            labels_[face] = region.label;
        }
        if (has_labels_) return;
        std::vector<std::pair<int, int>> by_first_segment;
        for (int face = 0; face < static_cast<int>(sides_.size()); ++face) {
            if (!inside_[face]) continue;
            int first = std::numeric_limits<int>::max();
            for (const FaceSide& side : sides_[face]) first = std::min(first, side.segment);
            by_first_segment.emplace_back(first, face);
        }
        std::sort(by_first_segment.begin(), by_first_segment.end());
        has_labels_ = by_first_segment.size() > 1;
        for (std::size_t i = 0; i < by_first_segment.size(); ++i)
            labels_[by_first_segment[i].second] = static_cast<int>(i) + 1;
    }

    const PlanarGraph& graph_;
    planar::Arrangement arrangement_;
    std::vector<Eigen::Vector2d> added_;  // points, by refine
    std::map<Edge, int> segment_at_;
    std::vector<int> of_;                       // face of each triangle
    std::vector<std::vector<FaceSide>> sides_;  // of each face
    std::vector<char> inside_, is_of_domain_;   // faces, segments
    std::vector<int> labels_;
    bool has_labels_ = false;
    int outer_ = 0;
};

// Regions that meet in a point only get a vertex each there.
void part_touching(TriangleSoup& soup) {
    const int n = static_cast<int>(soup.points.size()), m = static_cast<int>(soup.triangles.size());
    std::map<Edge, int> one;      // a triangle at each edge
    std::vector<int> way(3 * m);  // corners at one vertex that hang together, as trees
    std::iota(way.begin(), way.end(), 0);
    const auto root = [&](int corner) {
        while (way[corner] != corner) corner = way[corner] = way[way[corner]];
        return corner;
    };
    const std::vector<Triangle> triangles = soup.triangles;
    const auto corner_at = [&](int t, int v) {
        return 3 * t + static_cast<int>(std::find(triangles[t].begin(), triangles[t].end(), v) - triangles[t].begin());
    };
    for (int t = 0; t < m; ++t)
        for (int k = 0; k < 3; ++k) {
            const int a = soup.triangles[t][k], b = soup.triangles[t][(k + 1) % 3];
            const auto [known, is_new] = one.emplace(edge_between(a, b), t);
            if (is_new) continue;
            for (const int v : {a, b}) way[root(corner_at(t, v))] = root(corner_at(known->second, v));
        }
    std::vector<int> fan(n, kNone);          // of each vertex the first
    std::map<int, int> copy;                 // of a further fan the vertex
    std::vector<std::array<int, 2>> copies;  // and of which it is a copy
    for (int corner = 0; corner < 3 * m; ++corner) {
        const int v = soup.triangles[corner / 3][corner % 3], of = root(corner);
        if (fan[v] == kNone) fan[v] = of;
        if (fan[v] == of || copy.count(of)) continue;
        copy[of] = static_cast<int>(soup.points.size());
        copies.push_back({copy[of], v});
        soup.points.push_back(soup.points[v]);
    }
    if (copies.empty()) return;
    for (std::vector<Edge>* edges : {&soup.edges, &soup.required.edges})
        for (Edge& edge : *edges) {
            const auto at = one.find(edge_between(edge[0], edge[1]));
            if (at == one.end()) continue;
            for (int& v : edge)
                if (const auto to = copy.find(root(corner_at(at->second, v))); to != copy.end()) v = to->second;
        }
    for (int corner = 0; corner < 3 * m; ++corner)
        if (const auto to = copy.find(root(corner)); to != copy.end())
            soup.triangles[corner / 3][corner % 3] = to->second;
    for (std::vector<int>* list : {&soup.corners, &soup.required.vertices})
        for (const auto& [c, v] : copies)
            if (std::find(list->begin(), list->end(), v) != list->end()) list->push_back(c);
}

}  // namespace

TriangleSoup triangulate(const PlanarGraph& graph, InnerPoints inner) {
    if (!graph.labels.empty() && graph.labels.size() != graph.segments.size())
        throw std::invalid_argument("triangulate: " + std::to_string(graph.labels.size()) + " labels for " +
                                    std::to_string(graph.segments.size()) + " segments");
    for (std::size_t i = 0; i < graph.points.size(); ++i)
        if (graph.points[i].cwiseAbs().maxCoeff() > kLargestCoordinate)
            throw std::invalid_argument("point " + std::to_string(i + graph.first_number) + " at " +
                                        text_of(graph.points[i]) + " is too far away");
    Faces faces(graph);
    if (inner == InnerPoints::Added) faces.refine();
    TriangleSoup soup = faces.soup();
    part_touching(soup);
    return soup;
}

}  // namespace gradus

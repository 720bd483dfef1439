#include "constrained_triangulation.hpp"

#include <algorithm>
#include <bit>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>

namespace gradus::planar {

void fill_cavity(std::vector<Tri>& triangles, int vertex, const Cavity& cavity, std::vector<int>& fan) {
    const int m = static_cast<int>(cavity.rim.size()), reused = static_cast<int>(cavity.removed.size());
    fan.resize(m);
    for (int i = 0; i < m; ++i)
        fan[i] = i < reused ? cavity.removed[i] : static_cast<int>(triangles.size()) + i - reused;
    triangles.resize(triangles.size() + std::max(0, m - reused));
    for (int i = 0; i < m; ++i) {
        const RimEdge& e = cavity.rim[i];
        Tri& tri = triangles[fan[i]];
        tri.v = {vertex, e.a, e.b};
        tri.n = {e.outer, fan[i + 1 == m ? 0 : i + 1], fan[i == 0 ? m - 1 : i - 1]};
        tri.level = -1;
        tri.fixed = e.fixed ? 1 : 0;
        if (e.outer != kOutside) triangles[e.outer].n[e.outer_side] = fan[i];
    }
}

namespace {

using Points = std::span<const Eigen::Vector2d>;
using Segments = std::span<const std::array<int, 2>>;

// Numbers of points as a file counts them.
struct Names {
    Points points;
    int first;  ///< of the first point

    std::string operator()(int point) const { return std::to_string(point + first); }
    std::string operator()(const std::array<int, 2>& segment) const {
        return (*this)(segment[0]) + "-" + (*this)(segment[1]);
    }
    std::string place(const Eigen::Vector2d& p) const {
        std::ostringstream text;
        text << " at (" << p.x() << ", " << p.y() << ")";
        return text.str();
    }
    std::string placed(int point) const { return "point " + (*this)(point) + place(points[point]); }
};

[[noreturn]] void refuse(const std::string& what) { throw std::invalid_argument(what); }

void check_segments(Points points, Segments segments, const Names& name) {
    const int n = static_cast<int>(points.size());
    for (const auto& s : segments)
        if (s[0] < 0 || s[1] < 0 || s[0] >= n || s[1] >= n || s[0] == s[1])
            refuse("segment " + name(s) + " has a bad or repeated index");
    if (segments.empty()) refuse("no segments");
    for (int i = 0; i < n; ++i)
        if (!points[i].allFinite()) refuse("point " + name(i) + " is not finite");
    std::vector<std::array<int, 2>> sorted(segments.begin(), segments.end());
    for (auto& s : sorted) std::sort(s.begin(), s.end());
    std::sort(sorted.begin(), sorted.end());
    const auto repeated = std::adjacent_find(sorted.begin(), sorted.end());
    if (repeated != sorted.end()) refuse("segment " + name(*repeated) + " is repeated");
}

void check_closed(Points points, Segments segments, const Names& name) {
    std::vector<int> degree(points.size(), 0);
    for (const auto& s : segments)
        for (const int i : s) ++degree[i];
    for (int i = 0; i < static_cast<int>(points.size()); ++i)
        if (degree[i] % 2 != 0) refuse("the loop is open at " + name.placed(i));
}

class Builder {
  public:
    Builder(Points points, Segments segments, const Names& names)
        : name_(names), points_(points.begin(), points.end()), num_points_(static_cast<int>(points.size())) {
        add_box();
        insert_points();
        for (const auto& s : segments) recover(s);
    }

    std::vector<Tri> inside() const;
    /// All triangles, and one at the border of the box.
    Arrangement take() { return {std::move(points_), std::move(triangles_), triangle_of_[num_points_]}; }

  private:
    const Eigen::Vector2d& at(int vertex) const { return points_[vertex]; }
    auto point_of() const {
        return [this](int vertex) -> const Eigen::Vector2d& { return points_[vertex]; };
    }

    void add_box();
    void insert_points();
    void insert(int vertex, int start);
    void recover(const std::array<int, 2>& segment);
    void carve(int a, int b, int first);
    int fill_chain(const std::vector<int>& chain, int from, int to, std::vector<int>& slots);
    void link(const std::vector<int>& made, std::vector<RimEdge>& rim);
    void fix(int t, int k);
    [[noreturn]] void refuse_crossing(const std::array<int, 2>& segment, const std::array<int, 2>& other) const;

    const Names& name_;
    std::vector<Eigen::Vector2d> points_;
    int num_points_;
    std::vector<Tri> triangles_;
    std::vector<int> triangle_of_;  // one triangle at each vertex
    Cavity cavity_;
    std::vector<int> fan_;
};

/// Two triangles around everything. What lies between box and loops is cut away later, so their shape has no influence.
void Builder::add_box() {
    Eigen::Vector2d low = points_[0], high = points_[0];
    for (const Eigen::Vector2d& p : points_) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
    }
    const Eigen::Vector2d margin = Eigen::Vector2d::Constant((high - low).maxCoeff());
    if (!(margin.x() > 0)) refuse("all points coincide");
    low -= margin;
    high += margin;
    const int n = num_points_;
    for (const Eigen::Vector2d& p : {low, Eigen::Vector2d(high.x(), low.y()), high, Eigen::Vector2d(low.x(), high.y())})
        points_.push_back(p);
    triangles_.resize(2);
    triangles_[0] = {.v = {n, n + 1, n + 2}, .n = {kOutside, 1, kOutside}};
    triangles_[1] = {.v = {n, n + 2, n + 3}, .n = {kOutside, kOutside, 0}};
    triangle_of_.assign(points_.size(), 0);
    triangle_of_[n + 3] = 1;
}

/// Every 2^k-th point first, then those half way between, and so on: points of a loop come in order, so the walk from
/// the neighbour of the level before is short, and the triangulation never becomes a fan of needles.
void Builder::insert_points() {
    insert(0, 0);
    for (int stride = static_cast<int>(std::bit_floor(static_cast<unsigned>(num_points_))); stride > 0; stride /= 2)
        for (long i = stride; i < num_points_; i += 2L * stride) insert(static_cast<int>(i), triangle_of_[i - stride]);
}

void Builder::insert(int vertex, int start) {
    const Eigen::Vector2d p = at(vertex);
    // A walk in a Delaunay triangulation never enters a triangle twice.
    const Location found = walk_to(triangles_, point_of(), start, p, static_cast<int>(triangles_.size()) + 1);
    const auto in_conflict = [&](int t) {
        const auto& v = triangles_[t].v;
        return incircle(at(v[0]), at(v[1]), at(v[2]), p) > 0;
    };
    if (found.outcome != Walk::Found || !grow_cavity(triangles_, point_of(), in_conflict, found.triangle, p, cavity_)) {
        const auto& v = triangles_[found.triangle].v;
        const auto same = std::find_if(v.begin(), v.end(), [&](int other) { return at(other) == p; });
        refuse(name_.placed(vertex) + " coincides with " + (same != v.end() ? "point " + name_(*same) : "another"));
    }
    fill_cavity(triangles_, vertex, cavity_, fan_);
    for (std::size_t i = 0; i < fan_.size(); ++i) triangle_of_[cavity_.rim[i].a] = fan_[i];
    triangle_of_[vertex] = fan_[0];
}

/// Marks a side as a segment, from both sides.
void Builder::fix(int t, int k) {
    triangles_[t].fixed |= static_cast<std::uint8_t>(1 << k);
    const int other = triangles_[t].n[k];
    triangles_[other].fixed |= static_cast<std::uint8_t>(1 << side_of(triangles_[other], t));
}

/// Turns around the first end until the segment is met as an edge, or as the way into a triangle's opposite side.
void Builder::recover(const std::array<int, 2>& segment) {
    const auto [a, b] = segment;
    const int first = triangle_of_[a];
    int t = first;
    do {  // all points lie inside the box, so the triangles around `a` close
        const Tri& tri = triangles_[t];
        const int k = corner_of(tri, a);
        const int right = tri.v[next(k)], left = tri.v[previous(k)];
        if (right == b) return fix(t, previous(k));
        const int side = orient2d(at(a), at(right), at(b));
        if (side == 0 && (at(right) - at(a)).dot(at(b) - at(a)) > 0)
            refuse("segment " + name_(segment) + " touches " + name_.placed(right));
        if (side > 0 && left != b && orient2d(at(a), at(left), at(b)) < 0) return carve(a, b, t);
        t = tri.n[next(k)];
    } while (t != first);
    refuse("segment " + name_(segment) + " cannot be placed");
}

void Builder::refuse_crossing(const std::array<int, 2>& segment, const std::array<int, 2>& other) const {
    const Eigen::Vector2d &a = at(segment[0]), d = at(segment[1]) - a, &c = at(other[0]), e = at(other[1]) - c,
                          off = c - a;
    const double along = (off.x() * e.y() - off.y() * e.x()) / (d.x() * e.y() - d.y() * e.x());
    refuse("segment " + name_(segment) + " crosses " + name_(other) + name_.place(a + along * d));
}

/// Replaces the triangles that the segment a b crosses by triangulations of the two polygons on its sides. [Anglada
/// 1997]
void Builder::carve(int a, int b, int first) {
    std::vector<int> removed{first}, left{a}, right{a};
    std::vector<RimEdge> rim;
    const auto keep = [&](int t, int k) {
        const Tri& tri = triangles_[t];
        const int outer = tri.n[k];
        rim.push_back({tri.v[next(k)], tri.v[previous(k)], outer, outer == kOutside ? 0 : side_of(triangles_[outer], t),
                       tri.is_fixed(k)});
    };
    int t = first, k = corner_of(triangles_[t], a);
    keep(t, next(k));
    keep(t, previous(k));
    right.push_back(triangles_[t].v[next(k)]);
    left.push_back(triangles_[t].v[previous(k)]);
    for (;;) {
        // The segment leaves t through its side k, from right.back() to left.back().
        if (triangles_[t].is_fixed(k)) refuse_crossing({a, b}, {right.back(), left.back()});
        const int beyond = triangles_[t].n[k];
        const int j = side_of(triangles_[beyond], t);
        const int apex = triangles_[beyond].v[j];
        removed.push_back(beyond);
        t = beyond;
        if (apex == b) {
            keep(t, next(j));
            keep(t, previous(j));
            break;
        }
        const int side = orient2d(at(a), at(b), at(apex));
        if (side == 0) refuse("segment " + name_({a, b}) + " touches " + name_.placed(apex));
        // Corners of `beyond`: apex, then left.back(), then right.back().
        if (side > 0) {
            keep(t, previous(j));  // apex to left.back()
            left.push_back(apex);
            k = next(j);  // right.back() to apex
        } else {
            keep(t, next(j));
            right.push_back(apex);
            k = previous(j);
        }
    }
    left.push_back(b);
    right.push_back(b);
    std::reverse(left.begin(), left.end());  // the polygon left of a b, counter-clockwise, starts at b

    std::vector<int> slots = removed;
    const int size = static_cast<int>(removed.size());
    const int below = fill_chain(right, 0, static_cast<int>(right.size()) - 1, slots);
    const int above = fill_chain(left, 0, static_cast<int>(left.size()) - 1, slots);
    if (!slots.empty() || below == kOutside || above == kOutside || size != static_cast<int>(removed.size()))
        refuse("segment " + name_({a, b}) + " cannot be placed");
    link(removed, rim);
    for (int i = 0; i < 3; ++i)
        if (triangles_[below].v[next(i)] == b && triangles_[below].v[previous(i)] == a) fix(below, i);
}

/// Triangulates the polygon chain[from..to], closed by its base from `to` to `from`, into free slots: first the
/// triangle on the base whose circle is empty, then both sides of it. @returns the triangle at the base, or kOutside
/// for a chain of one edge
int Builder::fill_chain(const std::vector<int>& chain, int from, int to, std::vector<int>& slots) {
    int result = kOutside;
    std::vector<std::array<int, 2>> open{{from, to}};
    while (!open.empty()) {
        const auto [i, j] = open.back();
        open.pop_back();
        if (j - i < 2) continue;
        int c = i + 1;
        for (int k = i + 2; k < j; ++k)
            if (incircle(at(chain[j]), at(chain[i]), at(chain[c]), at(chain[k])) > 0) c = k;
        if (slots.empty()) return kOutside;
        const int t = slots.back();
        slots.pop_back();
        triangles_[t] = {.v = {chain[j], chain[i], chain[c]}};
        if (result == kOutside) result = t;
        open.push_back({i, c});
        open.push_back({c, j});
    }
    return result;
}

/// Joins new triangles to each other and to what lies around them. An edge that stood on the rim from both sides
/// (a dangling edge inside the carved region) joins two new triangles.
void Builder::link(const std::vector<int>& made, std::vector<RimEdge>& rim) {
    std::map<std::array<int, 2>, std::array<int, 2>> sides;  // directed edge -> triangle, side
    for (const int t : made)
        for (int k = 0; k < 3; ++k) {
            const Tri& tri = triangles_[t];
            sides[{tri.v[next(k)], tri.v[previous(k)]}] = {t, k};
            triangle_of_[tri.v[k]] = t;
        }
    for (const auto& [edge, side] : sides) {
        const auto twin = sides.find({edge[1], edge[0]});
        if (twin != sides.end()) triangles_[side[0]].n[side[1]] = twin->second[0];
    }
    for (const RimEdge& e : rim) {
        const auto& [t, k] = sides.at({e.a, e.b});
        if (e.fixed) triangles_[t].fixed |= static_cast<std::uint8_t>(1 << k);
        if (sides.count({e.b, e.a}) != 0) continue;
        triangles_[t].n[k] = e.outer;
        if (e.outer != kOutside) triangles_[e.outer].n[e.outer_side] = t;
    }
}

/// Parity spreads from the box: it changes across each segment. Returns the triangles of odd parity, renumbered.
std::vector<Tri> Builder::inside() const {
    std::vector<int> parity(triangles_.size(), -1), stack;
    const int seed = triangle_of_[num_points_];
    parity[seed] = 0;
    stack.push_back(seed);
    while (!stack.empty()) {
        const int t = stack.back();
        stack.pop_back();
        for (int k = 0; k < 3; ++k) {
            const int other = triangles_[t].n[k];
            if (other == kOutside || parity[other] >= 0) continue;
            parity[other] = triangles_[t].is_fixed(k) ? 1 - parity[t] : parity[t];
            stack.push_back(other);
        }
    }
    std::vector<int> renumbered(triangles_.size(), kOutside);
    int count = 0;
    for (std::size_t t = 0; t < triangles_.size(); ++t)
        if (parity[t] == 1) renumbered[t] = count++;
    std::vector<Tri> result;
    result.reserve(count);
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
        if (parity[t] != 1) continue;
        Tri tri = triangles_[t];
        for (int k = 0; k < 3; ++k)
            tri.n[k] = tri.is_fixed(k) || tri.n[k] == kOutside ? kOutside : renumbered[tri.n[k]];
        tri.fixed = 0;  // said by kOutside from here on, and flips would have to carry it along
        result.push_back(tri);
    }
    return result;
}

}  // namespace

std::vector<Tri> triangulate_loops(Points points, Segments segments) {
    const Names names{points, 0};
    check_segments(points, segments, names);
    check_closed(points, segments, names);
    return Builder(points, segments, names).inside();
}

Arrangement triangulate_segments(Points points, Segments segments, int first_number) {
    const Names names{points, first_number};
    check_segments(points, segments, names);
    return Builder(points, segments, names).take();
}

}  // namespace gradus::planar

/// Triangles of the plane with neighbours: walking, cavities, and the constrained Delaunay triangulation of closed
/// loops. Every decision of topology rests on exact signs.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "gradus/plane/predicates.hpp"

namespace gradus::planar {

constexpr int kOutside = -1;

struct Tri {
    std::array<int, 3> v;                                ///< counter-clockwise
    std::array<int, 3> n{kOutside, kOutside, kOutside};  ///< n[k] lies across the edge v[k+1] v[k+2]
    int level = -1;                                      ///< free for the user
    std::uint8_t fixed =
        0;  ///< bit k: the edge opposite v[k] is a segment with triangles on both sides (while building)

    bool is_fixed(int k) const { return (fixed >> k) & 1; }
};

constexpr int next(int k) { return k == 2 ? 0 : k + 1; }
constexpr int previous(int k) { return k == 0 ? 2 : k - 1; }

inline int side_of(const Tri& t, int neighbour) { return t.n[0] == neighbour ? 0 : t.n[1] == neighbour ? 1 : 2; }
inline int corner_of(const Tri& t, int vertex) { return t.v[0] == vertex ? 0 : t.v[1] == vertex ? 1 : 2; }

/// Edge a b of the rim of a cavity, counter-clockwise, with what lies beyond it.
struct RimEdge {
    int a, b;
    int outer;       ///< triangle beyond, or kOutside
    int outer_side;  ///< which of its sides
    bool fixed;
};

/// Triangles that a new point replaces: star-shaped seen from it.
struct Cavity {
    std::vector<RimEdge> rim;
    std::vector<int> removed;
    std::vector<std::array<int, 2>> stack;  // scratch: triangle, side
};

enum class Walk { Found, Blocked, Lost };

struct Location {
    Walk outcome = Walk::Lost;
    int triangle = kOutside;
};

/// Walks from triangle `start` to the one that holds p. Blocked: the way leads through the boundary. Lost: more than
/// `bound` steps, which can happen only in triangulations that are not Delaunay.
template <class PointOf>
Location walk_to(const std::vector<Tri>& triangles, const PointOf& point_of, int start, const Eigen::Vector2d& p,
                 int bound) {
    int t = start, from = kOutside;
    for (int step = 0; step < bound; ++step) {
        const Tri& tri = triangles[t];
        int through = kOutside;
        bool blocked = false;
        // The first side looked at turns with the steps, which breaks cycles.
        for (int i = 0, k = step % 3; i < 3 && through == kOutside; ++i, k = next(k)) {
            if (from != kOutside && tri.n[k] == from) continue;
            if (orient2d(point_of(tri.v[next(k)]), point_of(tri.v[previous(k)]), p) >= 0) continue;
            if (tri.n[k] == kOutside)
                blocked = true;
            else
                through = tri.n[k];
        }
        if (through == kOutside) return {blocked ? Walk::Blocked : Walk::Found, t};
        from = t;
        t = through;
    }
    return {Walk::Lost, t};
}

/// Collects the triangles in conflict with p, starting from the one that holds p, as far as the whole stays star-shaped
/// (exactly).
/// @returns false if p lies on a fixed edge or on a vertex
template <class PointOf, class Conflict>
bool grow_cavity(const std::vector<Tri>& triangles, const PointOf& point_of, const Conflict& in_conflict, int start,
                 const Eigen::Vector2d& p, Cavity& cavity) {
    cavity.rim.clear();
    cavity.removed.assign(1, start);
    cavity.stack.clear();
    int forced = kOutside;  // side of the first triangle that holds p: its neighbour must go as well
    for (int k = 2; k >= 0; --k) {
        const Tri& tri = triangles[start];
        cavity.stack.push_back({start, k});
        if (orient2d(point_of(tri.v[next(k)]), point_of(tri.v[previous(k)]), p) > 0) continue;
        if (forced != kOutside || tri.n[k] == kOutside || tri.is_fixed(k)) return false;
        forced = k;
    }
    while (!cavity.stack.empty()) {
        const auto [t, k] = cavity.stack.back();
        cavity.stack.pop_back();
        const Tri& tri = triangles[t];
        const int a = tri.v[next(k)], b = tri.v[previous(k)], beyond = tri.n[k];
        int j = 0;
        if (beyond != kOutside) {
            const Tri& outer = triangles[beyond];
            j = side_of(outer, t);
            const bool is_forced = t == start && k == forced;
            // The cavity grows by replacing rim edge a b by a z and z b: both must face p, or it would not stay
            // star-shaped.
            const int z = outer.v[j];
            if (is_forced || (!tri.is_fixed(k) && in_conflict(beyond) && orient2d(point_of(a), point_of(z), p) > 0 &&
                              orient2d(point_of(z), point_of(b), p) > 0)) {
                cavity.removed.push_back(beyond);
                cavity.stack.push_back({beyond, previous(j)});  // edge z b
                cavity.stack.push_back(
                    {beyond, next(j)});  // edge a z: looked at first, so that the rim comes out in order
                continue;
            }
        }
        cavity.rim.push_back({a, b, beyond, j, tri.is_fixed(k)});
    }
    return true;
}

/// Replaces a cavity by the fan of triangles (vertex, a, b) over its rim; their indices come out in `fan`, in order of
/// the rim.
void fill_cavity(std::vector<Tri>& triangles, int vertex, const Cavity& cavity, std::vector<int>& fan);

/// Constrained Delaunay triangulation of the region inside closed loops (even-odd). In the result the segments are
/// exactly the sides with n == kOutside.
/// @throws std::invalid_argument naming points or segments: repeated points, open loops, repeated, crossing or touching
/// segments
std::vector<Tri> triangulate_loops(std::span<const Eigen::Vector2d> points,
                                   std::span<const std::array<int, 2>> segments);

/// A constrained Delaunay triangulation of a box around all points, whose corners are numbered after these.
struct Arrangement {
    std::vector<Eigen::Vector2d> points;  ///< with the corners of the box behind them
    std::vector<Tri> triangles;           ///< is_fixed() where the segments are
    int outer;                            ///< a triangle at the border of the box
};

/// Points that belong to no segment become vertices, too.
/// @param first_number  what messages call the first point
/// @throws std::invalid_argument as above, but for open loops
Arrangement triangulate_segments(std::span<const Eigen::Vector2d> points, std::span<const std::array<int, 2>> segments,
                                 int first_number = 0);

}  // namespace gradus::planar

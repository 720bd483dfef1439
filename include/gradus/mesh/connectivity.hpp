/// Compact triangle connectivity for the local operations: half-edges by number, three per triangle.
///
/// Half-edge 3t + k runs from corner k of triangle t to corner (k + 1) mod 3. Its twin is the opposite half-edge of the
/// neighbouring triangle, or -1 on the boundary. Each half-edge carries a tag, the same on both halves of an edge.
/// Triangles and vertices that were removed are skipped by is_live and recycled by later splits.
#pragma once

#include "gradus/mesh/tri_mesh.hpp"

#include <span>
#include <vector>

namespace gradus {

class Connectivity {
  public:
    static constexpr int kNone = -1;

    Connectivity() = default;
    /// @throws std::invalid_argument for a bad index, an edge of more than two triangles or with two of the same
    /// direction, or a
    ///         vertex whose triangles form more than one fan
    Connectivity(int num_vertices, std::span<const Triangle> triangles);

    /// Other numbers for what is not removed.
    struct Numbering {
        std::vector<int> vertices, triangles;  ///< the present numbers, in the new order
        std::vector<int> new_number;           ///< of each vertex, or kNone
    };
    /// Keeps what is next to each other together: breadth first, each component from its first vertex; triangles by
    /// their first vertex.
    Numbering breadth_first() const;
    /// The same mesh with other numbers, without what is removed. @pre of this mesh, with all that is not removed
    Connectivity renumbered(const Numbering& numbering) const;

    int num_triangles() const { return static_cast<int>(origin_.size() / 3); }  ///< including removed ones
    int num_vertices() const { return static_cast<int>(outgoing_.size()); }     ///< including removed ones
    int num_live_triangles() const { return num_triangles() - static_cast<int>(free_triangles_.size()); }
    bool is_live_triangle(int t) const { return origin_[3 * t] != kNone; }
    bool is_live_vertex(int v) const { return outgoing_[v] != kNone; }

    static int next(int h) { return h % 3 == 2 ? h - 2 : h + 1; }
    static int prev(int h) { return h % 3 == 0 ? h + 2 : h - 1; }
    int twin(int h) const { return twin_[h]; }
    int origin(int h) const { return origin_[h]; }
    int target(int h) const { return origin_[next(h)]; }
    int apex(int h) const { return origin_[prev(h)]; }
    int tag(int h) const { return tag_[h]; }
    void set_tag(int h, int tag) {
        tag_[h] = tag;
        if (twin_[h] != kNone) tag_[twin_[h]] = tag;
    }
    Triangle triangle(int t) const { return {origin_[3 * t], origin_[3 * t + 1], origin_[3 * t + 2]}; }

    /// An outgoing half-edge of v; the one on the boundary (without twin) where there is one.
    int outgoing(int v) const { return outgoing_[v]; }
    bool is_boundary_vertex(int v) const { return twin_[outgoing_[v]] == kNone; }
    int valence(int v) const { return valence_[v]; }  ///< number of edges
    /// The next outgoing half-edge of the same vertex, counter-clockwise; kNone past the last on a boundary.
    int rotate(int h) const { return twin_[prev(h)]; }
    /// Calls f(h) for the outgoing half-edges h of v, one per triangle, counter-clockwise.
    template <class F>
    void for_each_outgoing(int v, F&& f) const {
        const int first = outgoing_[v];
        int h = first;
        do {
            const int following = rotate(h);
            f(h);
            h = following;
        } while (h != kNone && h != first);
    }
    /// Calls f(half-edge, other end) for the edges at v, also the one of a boundary that only comes in; none where v is
    /// in no triangle.
    template <class F>
    void for_each_edge(int v, F&& f) const {
        if (!is_live_vertex(v)) return;
        for_each_outgoing(v, [&](int h) {
            f(h, target(h));
            const int last = prev(h);
            if (twin(last) < 0) f(last, origin(last));
        });
    }
    /// Half-edge from a to b or, on a boundary, the one from b to a; kNone where they are not joined.
    int find_edge(int a, int b) const;

    /// Turns the edge of h inside its two triangles. @pre it has two triangles and its opposite vertices are not joined
    void flip(int h);
    /// Puts vertex m (new) on the edge of h: one triangle becomes two, on each side. @returns m; half-edge h then ends
    /// in m
    int split(int h);
    /// Moves the origin of h into its target; its triangles vanish. @pre can_collapse(h)
    void collapse(int h);
    /// Topology alone: the link condition, no vertex left with fewer than three edges, boundaries stay simple.
    bool can_collapse(int h) const;

    /// Everything the operations change, so that they can be undone.
    struct Journal {
        struct TriangleState {
            int triangle;
            std::array<int, 3> origin, twin, tag;
        };
        struct VertexState {
            int vertex, outgoing, valence;
        };
        struct Recycling {
            int number;
            bool freed;  ///< else allocated
        };
        std::vector<TriangleState> triangles;
        std::vector<VertexState> vertices;
        std::vector<Recycling> recycled_triangles, recycled_vertices;  ///< in the order of events
        void clear();
    };
    /// Records into `journal` (may be null to stop recording).
    void record(Journal* journal) { journal_ = journal; }
    /// Restores the state at the time recording began; recording stops. Numbers that were new then are free now, and
    /// are given out again in the same order. @pre what was done since is in this journal, or undone
    void undo(Journal& journal);

    /// The invariants of this class, for tests and assertions, whatever state it is in. @returns an empty string or the
    /// first fault found
    std::string check() const;

  private:
    void link(int h, int g) {
        if (h != kNone) twin_[h] = g;
        if (g != kNone) twin_[g] = h;
    }
    void touch(int t);
    void touch_vertex(int v);
    void set_outgoing(int v, int h);
    int new_triangle();
    int new_vertex();

    std::vector<int> origin_, twin_, tag_;
    std::vector<int> outgoing_, valence_;
    std::vector<int> free_triangles_, free_vertices_;
    Journal* journal_ = nullptr;
};

}  // namespace gradus

// The mesh under local operations: connectivity, vertices that know their place on the surface, and the energy they
// lower.
#pragma once

#include "gradus/mesh/connectivity.hpp"
#include "gradus/mesh/frozen.hpp"

#include "../assert.hpp"
#include "vertex.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

namespace gradus {

// Energy of a triangle: 1 / (area-length quality), plus a term that is 0 where its area is the one asked for, plus a
// penalty where it turns away from the surface. 1 for the ideal triangle. [remeshing notes; shape term: Bank & Smith
// 1997]
inline constexpr double kSizeWeight = 0.1;
inline constexpr double kFoldCosine = 0.56;  // triangles may turn this far (56 degrees) from the surface unpunished
inline constexpr double kFoldWeight = 60;

// The size term by m, area over the area asked for: (m + 1/m) / 2 - 1, continued by its tangent below kTiny, so that a
// surface much smaller than its sizes is still meshed by shape.
inline constexpr double kTiny = 1.0 / 16;
struct SizeTerm {
    double value, slope, curvature;
};
inline SizeTerm size_term(double m) {
    if (m >= kTiny) {
        const double i = 1 / m;
        return {(m + i) / 2 - 1, (1 - i * i) / 2, i * i * i};
    }
    constexpr double value = (kTiny + 1 / kTiny) / 2 - 1, slope = (1 - 1 / (kTiny * kTiny)) / 2;
    return {value + slope * (m - kTiny), slope, 0};
}

inline double fold_penalty(double cosine) {
    return cosine < kFoldCosine ? kFoldWeight * (kFoldCosine - cosine) * (kFoldCosine - cosine) : 0;
}

// Cosine of the angle by which a triangle turns from the surface, at the corner where it is largest. @param facing  its
// unit normal
template <class M>
double least_agreement(const VertexOf<M>& a, const VertexOf<M>& b, const VertexOf<M>& c,
                       const Eigen::Vector3d& facing) {
    return std::min({agreement(a, facing), agreement(b, facing), agreement(c, facing)});
}

// Penalty of a triangle with the normal n, as long as twice the area.
template <class M>
double turn_penalty(const VertexOf<M>& a, const VertexOf<M>& b, const VertexOf<M>& c, const Eigen::Vector3d& n,
                    double twice_area) {
    // Agreements are no less than the cosines with the vertices' normals, and most triangles do not turn that far.
    if (std::min({n.dot(a.n), n.dot(b.n), n.dot(c.n)}) >= kFoldCosine * twice_area) return 0;
    return fold_penalty(least_agreement(a, b, c, n / twice_area));
}

// @param size_weight  0 for the shape alone
template <class M>
double triangle_energy(const VertexOf<M>& a, const VertexOf<M>& b, const VertexOf<M>& c,
                       double size_weight = kSizeWeight) {
    const Eigen::Vector3d e1 = b.p - a.p, e2 = c.p - a.p;
    const Eigen::Vector3d n(e1.y() * e2.z() - e1.z() * e2.y(), e1.z() * e2.x() - e1.x() * e2.z(),
                            e1.x() * e2.y() - e1.y() * e2.x());
    const double twice_area = std::sqrt(n.squaredNorm());
    if (!(twice_area > 0)) return 1e30;
    const auto shape = mean_shape(a, b, c);
    const double lengths = shape.squared(e1) + shape.squared(e2) + shape.squared(e2 - e1);
    const double m = twice_area * (2 / 1.7320508075688772) / (a.g * b.g * c.g);
    return lengths / (2 * 1.7320508075688772 * twice_area) + size_weight * size_term(m).value +
           turn_penalty(a, b, c, n, twice_area);
}

// Energy of a fan, for the aim at the worst: edges at a vertex are not to differ by much.
inline constexpr double kUnevenFan = 2, kFanWeight = 1;
inline double fan_energy(double ratio) { return ratio > kUnevenFan ? 1 + kFanWeight * (ratio - kUnevenFan) : 1; }

// Energy of an edge of a feature curve, whose length no triangle asks for: 1 where it is the one asked for.
inline constexpr double kLengthWeight = 0.1;
template <class M>
double edge_energy(const VertexOf<M>& a, const VertexOf<M>& b) {
    return 1 + kLengthWeight * size_term(squared_length(a, b)).value;
}

// High powers make the worst triangle rule.
enum class Aim { Mean, Worst };
inline double weighted(double energy, Aim aim) {
    if (aim == Aim::Mean) return energy;
    const double e2 = energy * energy, e4 = e2 * e2;
    return e4 * e4;
}

inline void add_once(std::vector<int>& list, int item) {
    if (std::find(list.begin(), list.end(), item) == list.end()) list.push_back(item);
}

// Adds the half-edges that leave some vertices, and those opposite to them in their triangles, that are not in the list
// yet.
template <class Vertices>
void add_halfedges_around(const Connectivity& mesh, const Vertices& vertices, std::vector<int>& halfedges) {
    for (const int v : vertices)
        mesh.for_each_outgoing(v, [&](int h) {
            add_once(halfedges, h);
            add_once(halfedges, Connectivity::next(h));
        });
}

// Calls use(half-edge, whether it is the first of its edge) for each in a list, until that returns true. @returns
// whether it did
template <class Use>
bool any_halfedge(const Connectivity& mesh, const std::vector<int>& halfedges, const Use& use) {
    for (auto at = halfedges.begin(); at != halfedges.end(); ++at)
        if (use(*at, std::find(halfedges.begin(), at, mesh.twin(*at)) == at)) return true;
    return false;
}

enum class Operation {
    Move,
    Push,  // the origin of the edge goes some way along it before anything relaxes
    Flip,
    Collapse,
    Split
};
enum class Reach { Near, Wide };        // the vertices of the operation relax, or their neighbours too
enum class Search { Quick, Thorough };  // second operations that look promising, or all
// Rise of the energy by a flip, before anything moves, up to which it may turn out well once the neighbours have moved
// too.
inline constexpr double kHopefulRise = 1.6;

template <class M>
class EditorOf {
  public:
    using Vertex = VertexOf<M>;

    EditorOf(const Support& support, const MetricField<M>& field, std::vector<Vertex> vertices, Connectivity mesh)
        : support_(support),
          field_(field),
          vertices_(std::move(vertices)),
          mesh_(std::move(mesh)),
          stamp_(mesh_.num_triangles(), 0) {
        GRADUS_ASSERT(holds());
    }

    const Connectivity& mesh() const { return mesh_; }
    const Vertex& vertex(int v) const { return vertices_[v]; }
    const std::vector<Vertex>& vertices() const { return vertices_; }

    double energy(int t) const;
    double quality(int t) const;
    double unit_area(int t) const;                                          // over the area asked for
    double length(int h) const;                                             // in the metric
    double longest_length(int h) const { return bound_length<true>(h); }    // at least length(h), and cheap
    double shortest_length(int h) const { return bound_length<false>(h); }  // at most

    // Moves v to lower the energy of its triangles by a Newton step, cut back until it does.
    // Returns the distance moved over the size (0 when it stayed).
    double relax(int v, Aim aim = Aim::Mean);

    // Moves a vertex of a feature curve half way, in the metric, between two of its neighbours, unless a triangle would
    // degenerate or fold. Returns the same.
    double centre(int v, int a, int b);

    // Calls of relax so far: a measure of the work done that is the same on every machine.
    long moves() const { return moves_; }

    // Valence penalty: sum of squared distances from six (inside) or four (boundary).
    int flip_gain(int h) const;  // > 0 when the flip lowers the penalty
    int collapse_gain(int h) const;

    bool is_frozen(int h) const { return is_frozen_tag(mesh_.tag(h)); }
    bool is_frozen_triangle(int t) const { return is_frozen(3 * t) && is_frozen(3 * t + 1) && is_frozen(3 * t + 2); }
    bool can_flip(int h) const;
    bool can_collapse(int h) const;
    // Applies a legal operation without judging the shapes; false if the surface or a fold bars it.
    bool flip(int h);
    // @param longest_on_curve  metric length up to which an edge of a feature curve may come
    bool collapse(int h, double longest_on_curve = std::numbers::sqrt2);
    int split(int h);  // the new vertex, or -1

    // By how much the energy of the two triangles of h would rise; where that is `enough` or more, something between
    // the two.
    double flip_rise(int h, double enough = std::numeric_limits<double>::infinity()) const;
    double flip_height(int h) const;  // distance between the edges before and after, over the size
    // Longest over shortest edge at a vertex.
    double fan_ratio(int v) const;

    // Says whether triangles may stay as they are now: those around these vertices.
    using Guard = std::function<bool(const EditorOf&, std::span<const int> vertices)>;
    void set_guard(Guard guard) { guard_ = std::move(guard); }

    // Applies the operation, relaxes what is around, keeps it only if the energy fell, counting a triangle more or less
    // at `mean`, and if the guard lets it.
    using Operation = gradus::Operation;
    using Reach = gradus::Reach;
    using Search = gradus::Search;
    bool attempt(Operation operation, int h, Aim aim, double mean, Reach reach = Reach::Near);
    // The same for two operations in a row, the second on any edge around: a way out where each alone makes things
    // worse.
    bool attempt_pair(Operation first, int h, double mean, Search search);
    // Flips or splits an edge between some vertices, or brings one of them or one that comes near a fault: the first
    // way that the guard lets pass of the dozen that leave the best shapes, judged before all around has settled.
    // @returns whether there is one
    bool mend(const std::vector<int>& corners, const Eigen::Vector3d& fault);
    // Vertices around the last operation that was kept.
    const std::vector<int>& touched() const { return touched_; }

    // New numbers in an order that keeps neighbours together; removed entries vanish.
    void renumber();

  private:
    template <bool longest>
    double bound_length(int h) const {
        return lengths_at_ends(vertices_[mesh_.origin(h)], vertices_[mesh_.target(h)])[longest];
    }
    // Whether an edge between two vertices would leave a crevice of the surface out.
    bool bridges(const Vertex& a, const Vertex& b) const;
    double ring_energy(int v, const Vertex& x, Aim aim) const;
    // First axis of the tangent plane; on a curve along it, from one neighbour to the other, zero where they are one.
    Eigen::Vector3d axis_at(int v) const;
    // Whether moving a vertex of a sharp crease puts a triangle beside it outside the surface.
    bool turns_over(int v, const Vertex& moved) const;
    // Calls use(other) for each edge of a feature curve at v.
    template <class Use>
    void for_each_on_curve(int v, const Use& use) const {
        mesh_.for_each_edge(v, [&](int edge, int other) {
            if (mesh_.tag(edge) >= 0) use(other);
        });
    }
    double energy_around(const std::vector<int>& around, Aim aim, double mean);
    struct Mending {
        Operation operation;
        int halfedge;
        bool to_fault;  // the vertex that comes by a split, or the origin of the half-edge, goes there
    };
    std::optional<double> try_mending(const Mending& mending, const Eigen::Vector3d& fault, int rounds,
                                      std::vector<int>& around);
    // Moves a free vertex to the surface near a point. @returns whether it went
    bool bring(int v, const Eigen::Vector3d& target);
    bool push(int h);
    void set_vertex(int v, const Vertex& x);
    void list_corners(int h, std::vector<int>& around) const;
    void add_ring(std::vector<int>& around) const;
    // Whether all that operations rely on holds, asked now and then: looking costs as much as the operations since.
    bool holds_now_and_then();
    bool holds() const;

    const Support& support_;
    const MetricField<M>& field_;
    std::vector<Vertex> vertices_;
    Connectivity mesh_;
    std::vector<int> stamp_;
    int stamp_now_ = 0;
    long moves_ = 0;
    int unchecked_ = 0;  // operations since that was looked at
    // What one operation and the moves after it changed; a second one may begin inside the first.
    struct Trial {
        Connectivity::Journal journal;
        std::vector<std::pair<int, Vertex>> saved;
        std::vector<int> around;  // vertices that relax
    };
    bool begin(Trial& trial, Operation operation, int h);
    bool attempt_second(Operation second, int h, const std::vector<int>& inner, std::vector<int>& region, double enough,
                        double mean);
    void keep(const Trial& trial);
    void roll_back(Trial& trial);

    int valence_penalty(
        int v, int by) const;  // with some edges more; none at corners, where angles are what the surface makes them
    int least_valence(int v)
        const;  // corners need no more than a triangle at boundaries, and three where the surface comes to a point
    bool is_allowed(std::span<const int> vertices) const { return !guard_ || guard_(*this, vertices); }

    Guard guard_;
    Trial trials_[2];
    Trial* recording_ = nullptr;
    std::vector<int> touched_;
};

extern template class EditorOf<Size>;
extern template class EditorOf<SizeTensor>;
using Editor = EditorOf<Size>;

}  // namespace gradus

#include "gradus/quality/topology.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "../mesh/disjoint_sets.hpp"

namespace gradus {

namespace {

/// Walks through the fan of triangles around a vertex.
class Fan {
  public:
    Fan(const MeshView& mesh, const MeshEdges& edges) : mesh_(mesh), edges_(edges) {}

    struct End {
        int edge = -1;  ///< where the walk stopped: an edge without exactly two triangles, or the edge it began with
        int triangles = 0;  ///< triangles passed
    };

    /// Turns around `vertex` from `edge` into `triangle`, which has both.
    End walk(int vertex, int edge, int triangle) const {
        End end{edge, 0};
        do {
            end.edge = other_edge(vertex, end.edge, triangle);
            ++end.triangles;
            if (edges_.num_uses(end.edge) != 2) break;
            const std::span<const int> uses = edges_.uses_of(end.edge);
            triangle = uses[0] / 3 == triangle ? uses[1] / 3 : uses[0] / 3;
        } while (end.edge != edge);
        return end;
    }

  private:
    /// The other edge of the triangle at the vertex.
    int other_edge(int vertex, int edge, int triangle) const {
        const Triangle& t = mesh_.triangles[triangle];
        const int k = t[0] == vertex ? 0 : t[1] == vertex ? 1 : 2;
        const int out = edges_.edge_of[3 * triangle + k], in = edges_.edge_of[3 * triangle + (k + 2) % 3];
        return out == edge ? in : out;
    }

    const MeshView& mesh_;
    const MeshEdges& edges_;
};

void count_edges(const MeshView& mesh, const MeshEdges& edges, TopologyReport& report) {
    const auto forward = [&](int use) {
        return mesh.triangles[use / 3][use % 3] < mesh.triangles[use / 3][(use % 3 + 1) % 3];
    };
    report.edges = edges.ends.size();
    for (int e = 0; e < edges.size(); ++e) {
        const std::span<const int> uses = edges.uses_of(e);
        report.boundary_edges += uses.size() == 1;
        report.nonmanifold_edges += uses.size() > 2;
        report.misoriented_edges += uses.size() == 2 && forward(uses[0]) == forward(uses[1]);
    }
}

std::size_t count_boundary_loops(const MeshView& mesh, const MeshEdges& edges) {
    const Fan fan(mesh, edges);
    DisjointSets chains(edges.ends.size());
    for (int e = 0; e < edges.size(); ++e) {
        if (edges.num_uses(e) != 1) continue;
        // Around either end the fan leads to the next edge of the boundary.
        for (const int v : edges.ends[e]) {
            const int next = fan.walk(v, e, edges.uses_of(e)[0] / 3).edge;
            if (edges.num_uses(next) == 1) chains.unite(e, next);
        }
    }
    std::size_t loops = 0;
    for (int e = 0; e < edges.size(); ++e) loops += edges.num_uses(e) == 1 && chains.find(e) == e;
    return loops;
}

/// Vertices, components, and vertices whose triangles are not one fan.
void count_vertices(const MeshView& mesh, const MeshEdges& edges, TopologyReport& report) {
    const std::size_t n = mesh.points.size();
    std::vector<int> triangles_at(n, 0), start(n, -1), borders(n, 0);
    for (std::size_t use = 0; use < edges.edge_of.size(); ++use) {
        if (edges.edge_of[use] < 0) continue;
        const int v = mesh.triangles[use / 3][use % 3];
        ++triangles_at[v];
        start[v] = static_cast<int>(use);
    }
    DisjointSets pieces(n);
    for (int e = 0; e < edges.size(); ++e) {
        const auto& [a, b] = edges.ends[e];
        pieces.unite(a, b);
        if (edges.num_uses(e) != 2) ++borders[a], ++borders[b];
    }
    const Fan fan(mesh, edges);
    for (std::size_t i = 0; i < n; ++i) {
        const int v = static_cast<int>(i);
        if (triangles_at[v] == 0) {
            ++report.unused_vertices;
            continue;
        }
        ++report.vertices;
        report.components += pieces.find(v) == v;
        // An open fan ends in two border edges, so more of them, or one closed walk that misses a triangle, is more
        // than one fan.
        const int edge = edges.edge_of[start[v]];
        const bool one_fan =
            borders[v] == 0 ? fan.walk(v, edge, start[v] / 3).triangles == triangles_at[v] : borders[v] == 2;
        if (!one_fan) {
            ++report.nonmanifold_vertices;
        } else if (borders[v] == 2) {
            // One open fan, but a closed one may touch it: count the triangles on both sides of the starting edge.
            const auto walk_both = [&] {
                const Fan::End ahead = fan.walk(v, edge, start[v] / 3);
                if (edges.num_uses(edge) != 2) return ahead.triangles;
                const std::span<const int> uses = edges.uses_of(edge);
                return ahead.triangles + fan.walk(v, edge, uses[0] == start[v] ? uses[1] / 3 : uses[0] / 3).triangles;
            };
            report.nonmanifold_vertices += walk_both() != triangles_at[v];
        }
    }
}

/// Cell of a point on a grid of 1e-12 of the extent.
using Cell = std::array<std::int64_t, 3>;

std::size_t hash_of(const Cell& cell) {
    std::uint64_t h = 0;
    for (const std::int64_t x : cell) {
        h = (h ^ static_cast<std::uint64_t>(x)) * 0x9e3779b97f4a7c15ULL;
        h ^= h >> 29;
    }
    return static_cast<std::size_t>(h);
}

void count_positions(const MeshView& mesh, TopologyReport& report) {
    constexpr double kResolution = 1e-12;  // a few hundred times the rounding of coordinates
    const double infinity = std::numeric_limits<double>::infinity();
    Eigen::Vector3d low = Eigen::Vector3d::Constant(infinity), high = -low;
    for (const Eigen::Vector3d& p : mesh.points) {
        if (!p.allFinite()) {
            ++report.bad_points;
            continue;
        }
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
    }
    if (report.bad_points == mesh.points.size()) return;
    const double extent = (high - low).maxCoeff();
    const double scale = extent > 0 ? 1 / (kResolution * extent) : 0;

    // Open addressing: a table of cells, at most half full.
    std::size_t slots = 16;
    while (slots < 2 * mesh.points.size()) slots *= 2;
    std::vector<Cell> table(slots);
    std::vector<char> taken(slots, 0);
    for (const Eigen::Vector3d& p : mesh.points) {
        if (!p.allFinite()) continue;
        const Eigen::Vector3d q = (p - low) * scale;
        const Cell cell{std::llround(q[0]), std::llround(q[1]), std::llround(q[2])};
        std::size_t slot = hash_of(cell) & (slots - 1);
        while (taken[slot] && table[slot] != cell) slot = (slot + 1) & (slots - 1);
        report.duplicate_positions += taken[slot];
        taken[slot] = 1;
        table[slot] = cell;
    }
}

}  // namespace

TopologyReport measure_topology(const MeshView& mesh, const MeshEdges& edges) {
    TopologyReport report;
    report.triangles = mesh.triangles.size();
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) report.repeated_corners += edges.edge_of[3 * t] < 0;
    count_edges(mesh, edges, report);
    count_vertices(mesh, edges, report);
    report.boundary_loops = count_boundary_loops(mesh, edges);
    count_positions(mesh, report);
    report.euler = static_cast<long long>(report.vertices) - static_cast<long long>(report.edges) +
                   static_cast<long long>(report.triangles - report.repeated_corners);
    if (report.oriented_manifold())
        report.genus = (2 * static_cast<long long>(report.components) - static_cast<long long>(report.boundary_loops) -
                        report.euler) /
                       2;
    return report;
}

}  // namespace gradus

#include "gradus/mesh/diagnose.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <tuple>

#include "disjoint_sets.hpp"
#include "flat.hpp"

namespace gradus {
namespace {

/// One side of a triangle as a use of an edge.
struct EdgeUse {
    std::uint64_t edge;  ///< smaller vertex, larger vertex
    int side;            ///< 3 * sound triangle + corner where the side starts

    Diagnosis::Edge vertices() const { return {static_cast<int>(edge >> 32), static_cast<int>(edge & 0xffffffff)}; }
};

/// Sound triangles with their edge uses, sorted by edge.
struct Topology {
    std::vector<Triangle> triangles;
    std::vector<EdgeUse> uses;

    int start(int side) const { return triangles[side / 3][side % 3]; }
    /// The side as a corner of its triangle, and the corner where the side ends.
    static int next(int side) { return side % 3 == 2 ? side - 2 : side + 1; }
};

void find_bad_numbers(const TriangleSoup& soup, Diagnosis& d) {
    for (std::size_t i = 0; i < soup.points.size(); ++i)
        if (!soup.points[i].allFinite()) d.bad_numbers.add(static_cast<int>(i));
}

void find_duplicate_vertices(const TriangleSoup& soup, Diagnosis& d) {
    std::vector<int> order;
    order.reserve(soup.points.size());
    for (std::size_t i = 0; i < soup.points.size(); ++i)
        if (soup.points[i].allFinite()) order.push_back(static_cast<int>(i));
    const auto key = [&](int i) {
        const Eigen::Vector3d& p = soup.points[i];
        return std::tuple(p[0], p[1], p[2], i);
    };
    std::sort(order.begin(), order.end(), [&](int a, int b) { return key(a) < key(b); });
    std::vector<Diagnosis::Copy> copies;
    for (std::size_t first = 0, k = 1; k < order.size(); ++k) {
        if (soup.points[order[k]] == soup.points[order[first]])
            copies.push_back({order[first], order[k]});
        else
            first = k;
    }
    std::sort(copies.begin(), copies.end());
    for (const auto& copy : copies) d.duplicate_vertices.add(copy);
}

/// Sorts the triangles into faulty and sound ones.
/// @returns the sound triangles, in order, copies still among them
std::vector<int> find_faulty_triangles(const TriangleSoup& soup, Diagnosis& d) {
    const int n = static_cast<int>(soup.points.size());
    std::vector<int> sound;
    sound.reserve(soup.triangles.size());
    for (int t = 0; t < static_cast<int>(soup.triangles.size()); ++t) {
        const auto& [a, b, c] = soup.triangles[t];
        if (std::min({a, b, c}) < 0 || std::max({a, b, c}) >= n) {
            d.out_of_range.add(t);
        } else if (a == b || b == c || c == a) {
            d.repeated_index.add(t);
        } else {
            sound.push_back(t);
            const Eigen::Vector3d &p = soup.points[a], &q = soup.points[b], &r = soup.points[c];
            if (p.allFinite() && q.allFinite() && r.allFinite() && is_flat(p, q, r)) d.zero_area.add(t);
        }
    }
    return sound;
}

/// Takes the copies out of the sound triangles.
void find_duplicate_triangles(const TriangleSoup& soup, std::vector<int>& sound, Diagnosis& d) {
    std::vector<std::pair<Triangle, int>> sorted;
    sorted.reserve(sound.size());
    for (const int t : sound) {
        Triangle key = soup.triangles[t];
        std::sort(key.begin(), key.end());
        sorted.emplace_back(key, t);
    }
    std::sort(sorted.begin(), sorted.end());
    std::vector<Diagnosis::Copy> copies;
    std::vector<int> copied;
    for (std::size_t first = 0, k = 1; k < sorted.size(); ++k) {
        if (sorted[k].first == sorted[first].first) {
            copies.push_back({sorted[first].second, sorted[k].second});
            copied.push_back(sorted[k].second);
        } else {
            first = k;
        }
    }
    std::sort(copies.begin(), copies.end());
    std::sort(copied.begin(), copied.end());
    for (const auto& copy : copies) d.duplicate_triangles.add(copy);
    std::erase_if(sound, [&](int t) { return std::binary_search(copied.begin(), copied.end(), t); });
}

void find_unused_vertices(const TriangleSoup& soup, Diagnosis& d) {
    std::vector<char> used(soup.points.size(), 0);
    for (const Triangle& triangle : soup.triangles)
        for (const int vertex : triangle)
            if (vertex >= 0 && vertex < static_cast<int>(used.size())) used[vertex] = 1;
    for (std::size_t i = 0; i < used.size(); ++i)
        if (!used[i]) d.unused_vertices.add(static_cast<int>(i));
}

Topology topology_of(const TriangleSoup& soup, const std::vector<int>& sound) {
    Topology topology;
    topology.triangles.reserve(sound.size());
    for (const int t : sound) topology.triangles.push_back(soup.triangles[t]);
    topology.uses.reserve(3 * sound.size());
    for (int side = 0; side < static_cast<int>(3 * sound.size()); ++side) {
        const auto [a, b] = std::minmax({topology.start(side), topology.start(Topology::next(side))});
        topology.uses.push_back({static_cast<std::uint64_t>(a) << 32 | static_cast<std::uint64_t>(b), side});
    }
    std::sort(topology.uses.begin(), topology.uses.end(),
              [](const EdgeUse& x, const EdgeUse& y) { return x.edge != y.edge ? x.edge < y.edge : x.side < y.side; });
    return topology;
}

/// Calls visit(first use, number of uses) for every edge, in order.
template <class Visit>
void for_each_edge(const Topology& topology, Visit visit) {
    const std::vector<EdgeUse>& uses = topology.uses;
    for (std::size_t first = 0, last = 0; first < uses.size(); first = last) {
        while (last < uses.size() && uses[last].edge == uses[first].edge) ++last;
        visit(&uses[first], last - first);
    }
}

/// The corners of triangles, merged across shared edges: what stays together at a vertex is one fan.
struct Fans {
    DisjointSets corners;
    DisjointSets triangles;
};

/// Corner of the triangle of `side` at `vertex`, an end of the side.
int corner_at(const Topology& topology, int side, int vertex) {
    return topology.start(side) == vertex ? side : Topology::next(side);
}

Fans find_edge_faults(const Topology& topology, Diagnosis& d) {
    Fans fans{DisjointSets(3 * topology.triangles.size()), DisjointSets(topology.triangles.size())};
    for_each_edge(topology, [&](const EdgeUse* uses, std::size_t count) {
        ++d.num_edges;
        const Diagnosis::Edge edge = uses->vertices();
        if (count == 1) ++d.boundary_edges;
        if (count > 2) d.non_manifold_edges.add(edge);
        if (count == 2 && topology.start(uses[0].side) == topology.start(uses[1].side)) d.inconsistent_edges.add(edge);
        // Also across non-manifold edges, whose ends would all be bow ties otherwise.
        for (std::size_t k = 1; k < count; ++k) {
            fans.triangles.unite(uses[0].side / 3, uses[k].side / 3);
            for (const int vertex : edge)
                fans.corners.unite(corner_at(topology, uses[0].side, vertex),
                                   corner_at(topology, uses[k].side, vertex));
        }
    });
    return fans;
}

/// @returns the number of vertices in sound triangles
std::size_t find_bow_ties(const Topology& topology, std::size_t num_points, Fans& fans, Diagnosis& d) {
    std::vector<int> num_fans(num_points, 0);
    for (int corner = 0; corner < static_cast<int>(3 * topology.triangles.size()); ++corner)
        if (fans.corners.find(corner) == corner) ++num_fans[topology.start(corner)];
    for (std::size_t i = 0; i < num_points; ++i)
        if (num_fans[i] > 1) d.non_manifold_vertices.add(static_cast<int>(i));
    return num_points - static_cast<std::size_t>(std::count(num_fans.begin(), num_fans.end(), 0));
}

/// Boundary edges chained at the fans they bound, so that a bow tie does not join two loops.
std::size_t count_boundary_loops(const Topology& topology, Fans& fans) {
    DisjointSets loops(3 * topology.triangles.size());
    std::vector<int> on_boundary;
    for_each_edge(topology, [&](const EdgeUse* uses, std::size_t count) {
        if (count != 1) return;
        const int a = fans.corners.find(uses->side), b = fans.corners.find(Topology::next(uses->side));
        loops.unite(a, b);
        on_boundary.push_back(a);
    });
    for (int& fan : on_boundary) fan = loops.find(fan);
    std::sort(on_boundary.begin(), on_boundary.end());
    return static_cast<std::size_t>(std::unique(on_boundary.begin(), on_boundary.end()) - on_boundary.begin());
}

std::size_t count_components(const Topology& topology, Fans& fans) {
    std::size_t components = 0;
    for (int t = 0; t < static_cast<int>(topology.triangles.size()); ++t) components += fans.triangles.find(t) == t;
    return components;
}

// Text
// -----------------------------------------------------------------------------------------------------------------

std::string text_of(int index) { return std::to_string(index); }
std::string text_of(const std::array<int, 2>& pair) { return std::to_string(pair[0]) + "-" + std::to_string(pair[1]); }

template <class Item>
void describe(std::vector<std::string>& lines, const Findings<Item>& findings, const char* what) {
    if (findings.empty()) return;
    constexpr std::size_t kNamed = 5;
    std::string line = std::to_string(findings.count) + " " + what + ":";
    for (std::size_t i = 0; i < std::min(kNamed, findings.first.size()); ++i)
        line.append(" ").append(text_of(findings.first[i]));
    lines.push_back(line + (findings.count > kNamed ? " ..." : ""));
}

/// The faults that keep a soup from being a mesh, one line each.
std::vector<std::string> obstacles(const Diagnosis& d) {
    std::vector<std::string> lines;
    describe(lines, d.bad_numbers, "vertices with a coordinate that is not finite");
    describe(lines, d.out_of_range, "triangles with an index out of range");
    describe(lines, d.repeated_index, "triangles that have a vertex twice");
    describe(lines, d.duplicate_triangles, "triangles that repeat an earlier one (first-copy)");
    describe(lines, d.non_manifold_edges, "edges with three triangles or more");
    describe(lines, d.inconsistent_edges, "edges whose two triangles are oriented differently");
    describe(lines, d.non_manifold_vertices, "vertices where surfaces touch in a point only");
    return lines;
}

std::vector<std::string> blemishes(const Diagnosis& d) {
    std::vector<std::string> lines;
    describe(lines, d.zero_area, "triangles without area");
    describe(lines, d.duplicate_vertices, "vertices at the place of an earlier one (first-copy)");
    describe(lines, d.unused_vertices, "vertices in no triangle");
    return lines;
}

}  // namespace

Diagnosis diagnose(const TriangleSoup& soup) {
    Diagnosis d;
    d.num_points = soup.points.size();
    d.num_triangles = soup.triangles.size();
    find_bad_numbers(soup, d);
    find_duplicate_vertices(soup, d);
    find_unused_vertices(soup, d);
    std::vector<int> sound = find_faulty_triangles(soup, d);
    find_duplicate_triangles(soup, sound, d);

    const Topology topology = topology_of(soup, sound);
    Fans fans = find_edge_faults(topology, d);
    const std::size_t used = find_bow_ties(topology, soup.points.size(), fans, d);
    d.boundary_loops = count_boundary_loops(topology, fans);
    d.components = count_components(topology, fans);
    d.euler_characteristic = static_cast<long>(used) - static_cast<long>(d.num_edges) + static_cast<long>(sound.size());
    d.closed = !sound.empty() && d.boundary_edges == 0;
    return d;
}

bool is_manifold(const Diagnosis& d) { return obstacles(d).empty(); }

bool is_clean_manifold(const Diagnosis& d) { return is_manifold(d) && blemishes(d).empty(); }

std::string summary(const Diagnosis& d) {
    std::string text = std::to_string(d.num_points) + " vertices, " + std::to_string(d.num_edges) + " edges, " +
                       std::to_string(d.num_triangles) + " triangles\n" + std::to_string(d.components) +
                       (d.components == 1 ? " component" : " components") + ", Euler characteristic " +
                       std::to_string(d.euler_characteristic) + ", " +
                       (d.closed ? std::string("closed") : std::to_string(d.boundary_loops) + " boundary loops") + "\n";
    for (const std::string& line : obstacles(d)) text += line + "\n";
    for (const std::string& line : blemishes(d)) text += line + "\n";
    return text;
}

std::string why_not_manifold(const Diagnosis& diagnosis) {
    const std::vector<std::string> reasons = obstacles(diagnosis);
    constexpr std::size_t kReasons = 3;
    std::string text;
    for (std::size_t i = 0; i < std::min(kReasons, reasons.size()); ++i)
        text.append(i > 0 ? "; " : "").append(reasons[i]);
    return text;
}

TriMesh to_mesh(const TriangleSoup& soup) {
    const std::string reasons = why_not_manifold(diagnose(soup));
    if (!reasons.empty()) throw std::invalid_argument("to_mesh: not an oriented manifold: " + reasons);
    return make_mesh(soup.points, soup.triangles);
}

}  // namespace gradus

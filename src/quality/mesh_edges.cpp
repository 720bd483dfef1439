#include "gradus/quality/mesh_edges.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace gradus {

namespace {

void check_indices(const MeshView& mesh) {
    const auto n = static_cast<int>(mesh.points.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (const int v : mesh.triangles[t])
            if (v < 0 || v >= n)
                throw std::invalid_argument("edges_of: triangle " + std::to_string(t) + " has vertex " +
                                            std::to_string(v));
}

bool has_repeated_corner(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

/// A side of a triangle, filed under its smaller vertex.
struct FiledUse {
    int larger;
    int use;
    bool operator<(const FiledUse& other) const {
        return larger != other.larger ? larger < other.larger : use < other.use;
    }
};

}  // namespace

MeshEdges edges_of(const MeshView& mesh) {
    check_indices(mesh);
    const std::size_t num_vertices = mesh.points.size(), num_triangles = mesh.triangles.size();

    // Sides go into one drawer per smaller vertex; a drawer holds about six and is sorted by itself.
    std::vector<int> drawer(num_vertices + 1, 0);
    for (const Triangle& t : mesh.triangles) {
        if (has_repeated_corner(t)) continue;
        for (int k = 0; k < 3; ++k) ++drawer[std::min(t[k], t[(k + 1) % 3]) + 1];
    }
    for (std::size_t v = 0; v < num_vertices; ++v) drawer[v + 1] += drawer[v];
    std::vector<FiledUse> filed(drawer[num_vertices]);
    {
        std::vector<int> next(drawer.begin(), drawer.end() - 1);
        for (std::size_t t = 0; t < num_triangles; ++t) {
            const Triangle& corners = mesh.triangles[t];
            if (has_repeated_corner(corners)) continue;
            for (int k = 0; k < 3; ++k) {
                const auto [a, b] = std::minmax(corners[k], corners[(k + 1) % 3]);
                filed[next[a]++] = {b, static_cast<int>(3 * t) + k};
            }
        }
    }

    MeshEdges edges;
    edges.ends.reserve(filed.size() / 2 + 1);
    edges.first_use.reserve(filed.size() / 2 + 2);
    edges.uses.resize(filed.size());
    edges.edge_of.assign(3 * num_triangles, -1);
    for (std::size_t v = 0; v < num_vertices; ++v) {
        std::sort(filed.begin() + drawer[v], filed.begin() + drawer[v + 1]);
        for (int i = drawer[v]; i < drawer[v + 1]; ++i) {
            const auto& [larger, use] = filed[i];
            if (i == drawer[v] || filed[i - 1].larger != larger) {
                edges.ends.push_back({static_cast<int>(v), larger});
                edges.first_use.push_back(i);
            }
            edges.uses[i] = use;
            edges.edge_of[use] = edges.size() - 1;
        }
    }
    edges.first_use.push_back(static_cast<int>(filed.size()));
    return edges;
}

std::vector<EdgeOffender> by_ends(const MeshEdges& edges, std::span<const Offender> offenders) {
    std::vector<EdgeOffender> named;
    for (const Offender& edge : offenders) named.push_back({edges.ends[edge.index], edge.value});
    return named;
}

}  // namespace gradus

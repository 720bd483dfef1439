#include "gradus/mesh/frozen.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "flat.hpp"

namespace gradus {

namespace {

using Points = std::span<const Eigen::Vector3d>;

// Numbers count from 0; the place tells which it is in any counting.
[[noreturn]] void refuse(const std::string& element, const Eigen::Vector3d& at, const std::string& what) {
    throw std::invalid_argument(
        fmt::format("required {} (counted from 0) at {:.6g} {:.6g} {:.6g} {}", element, at.x(), at.y(), at.z(), what));
}

void check_index(const char* what, int index, int count) {
    if (index < 0 || index >= count)
        throw std::invalid_argument(fmt::format("required {} {} (counted from 0): there are {}", what, index, count));
}

}  // namespace

Frozen frozen_elements(Points points, const Connectivity& mesh, const RequiredElements& required) {
    Frozen frozen;
    if (required.empty()) return frozen;
    frozen.vertex.assign(mesh.num_vertices(), 0);
    frozen.half_edge.assign(3 * static_cast<std::size_t>(mesh.num_triangles()), 0);
    frozen.triangle.assign(mesh.num_triangles(), 0);
    const auto freeze_edge = [&](int h) {
        frozen.half_edge[h] = 1;
        if (mesh.twin(h) >= 0) frozen.half_edge[mesh.twin(h)] = 1;
        frozen.vertex[mesh.origin(h)] = frozen.vertex[mesh.target(h)] = 1;
    };
    for (const int v : required.vertices) {
        check_index("vertex", v, mesh.num_vertices());
        if (!mesh.is_live_vertex(v)) refuse(fmt::format("vertex {}", v), points[v], "is in no triangle");
        frozen.vertex[v] = 1;
    }
    for (const auto& [a, b] : required.edges) {
        for (const int v : {a, b}) check_index("edge to vertex", v, mesh.num_vertices());
        const std::string name = fmt::format("edge {}-{}", a, b);
        const int h =
            a != b && mesh.is_live_vertex(a) && mesh.is_live_vertex(b) ? mesh.find_edge(a, b) : Connectivity::kNone;
        if (h < 0) refuse(name, points[a], "is no side of a triangle");
        if (points[a] == points[b]) refuse(name, points[a], "has no length");
        freeze_edge(h);
    }
    for (const int t : required.triangles) {
        check_index("triangle", t, mesh.num_triangles());
        const auto [a, b, c] = mesh.triangle(t);
        if (is_flat(points[a], points[b], points[c])) refuse(fmt::format("triangle {}", t), points[a], "has no area");
        frozen.triangle[t] = 1;
        for (int h = 3 * t; h < 3 * t + 3; ++h) freeze_edge(h);
    }
    return frozen;
}

std::vector<double> frozen_edge_lengths(Points points, const Connectivity& mesh, const Frozen& frozen) {
    if (frozen.empty()) return {};
    std::vector<double> sum(mesh.num_vertices(), 0);
    std::vector<int> count(mesh.num_vertices(), 0);
    for (int h = 0; h < 3 * mesh.num_triangles(); ++h) {
        if (!frozen.half_edge[h] || mesh.twin(h) > h) continue;
        const int a = mesh.origin(h), b = mesh.target(h);
        for (const int v : {a, b}) sum[v] += (points[b] - points[a]).stableNorm(), ++count[v];
    }
    for (std::size_t v = 0; v < sum.size(); ++v)
        if (count[v] > 0) sum[v] /= count[v];
    return sum;
}

}  // namespace gradus

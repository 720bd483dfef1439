#include "gradus/control/triangles_under.hpp"

#include <algorithm>
#include <limits>

#include "gradus/mesh/closest.hpp"
#include "gradus/mesh/parts.hpp"

namespace gradus {

namespace {

constexpr double kFar = 0.5;       // of the longest edge of a triangle: nothing that follows it is as far from it
constexpr int kMostSamples = 500;  // per part of the mesh: enough to tell which part of the background it follows

// The part of the background with the least sum of distances to evenly chosen vertices of a part of the mesh.
int part_under(std::span<const Eigen::Vector3d> points, const std::vector<int>& vertices,
               const std::vector<ClosestTriangle>& trees) {
    const std::size_t step = vertices.size() / kMostSamples + 1;
    int best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t tree = 0; tree < trees.size(); ++tree) {
        double sum = 0;
        for (std::size_t i = 0; i < vertices.size() && sum < least; i += step)
            if (points[vertices[i]].allFinite()) sum += trees[tree].closest(points[vertices[i]]).distance;
        if (sum < least) least = sum, best = static_cast<int>(tree);
    }
    return best;
}

}  // namespace

std::vector<int> triangles_under(const TriMesh& background, std::span<const Eigen::Vector3d> points,
                                 std::span<const Triangle> triangles) {
    const auto ground = points_of(background);
    const std::vector<Triangle> cells = triangles_of(background);
    std::vector<int> under(points.size(), 0);
    if (cells.empty()) return under;

    const std::vector<int> ground_part = connected_parts(ground.size(), cells);
    std::vector<std::vector<int>> cells_of(ground.size());
    for (std::size_t t = 0; t < cells.size(); ++t) cells_of[ground_part[cells[t][0]]].push_back(static_cast<int>(t));
    std::vector<ClosestTriangle> trees;
    for (std::vector<int>& chosen : cells_of)
        if (!chosen.empty()) trees.emplace_back(ground, cells, std::move(chosen));
    const auto reach = [&](int t) {
        const Eigen::Vector3d &a = ground[cells[t][0]], &b = ground[cells[t][1]], &c = ground[cells[t][2]];
        return kFar * std::max({(a - b).norm(), (b - c).norm(), (c - a).norm()});
    };

    const std::vector<int> part_of = connected_parts(points.size(), triangles);
    std::vector<std::vector<int>> vertices_of(points.size());
    for (std::size_t v = 0; v < points.size(); ++v) vertices_of[part_of[v]].push_back(static_cast<int>(v));
    for (const std::vector<int>& vertices : vertices_of) {
        if (vertices.empty()) continue;
        const int part = part_under(points, vertices, trees);
        for (const int v : vertices) {
            if (!points[v].allFinite()) continue;
            ClosestTriangle::Hit hit = trees[part].closest(points[v]);
            if (hit.distance > reach(hit.triangle))
                for (const ClosestTriangle& tree : trees)
                    if (const auto other = tree.closest(points[v]); other.distance < hit.distance) hit = other;
            under[v] = hit.triangle;
        }
    }
    return under;
}

}  // namespace gradus

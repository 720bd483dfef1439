#include "gradus/control/triangles_under.hpp"

#include "gradus/mesh/closest.hpp"

#include <algorithm>
#include <numeric>

namespace gradus {

namespace {

constexpr double kFar = 1e-3;      // of the extent of the background
constexpr int kMostSamples = 500;  // per part of the mesh: enough to tell which part of the background it follows

// Number of the connected part of each vertex, in order of first vertices. Vertices without triangles are parts of their own.
struct Parts {
    std::vector<int> of;
    int count = 0;
};

Parts parts_of(std::size_t vertices, std::span<const Triangle> triangles) {
    std::vector<int> up(vertices);
    std::iota(up.begin(), up.end(), 0);
    const auto root = [&](int v) {
        while (up[v] != v) v = up[v] = up[up[v]];
        return v;
    };
    for (const Triangle& t : triangles)
        for (const int k : {1, 2}) {
            const int a = root(t[0]), b = root(t[k]);
            up[std::max(a, b)] = std::min(a, b);
        }
    Parts parts{std::vector<int>(vertices), 0};
    for (std::size_t v = 0; v < vertices; ++v) {
        const int r = root(static_cast<int>(v));
        parts.of[v] = r == static_cast<int>(v) ? parts.count++ : parts.of[r];
    }
    return parts;
}

// The part of the background with the least sum of distances to evenly chosen vertices of a part of the mesh.
int part_under(std::span<const Eigen::Vector3d> points, const std::vector<int>& vertices, const std::vector<ClosestTriangle>& trees) {
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

std::vector<int> triangles_under(const TriMesh& background, std::span<const Eigen::Vector3d> points, std::span<const Triangle> triangles) {
    const auto ground = points_of(background);
    const std::vector<Triangle> cells = triangles_of(background);
    std::vector<int> under(points.size(), 0);
    if (cells.empty()) return under;

    const Parts ground_parts = parts_of(ground.size(), cells);
    std::vector<std::vector<int>> cells_of(ground_parts.count);
    for (std::size_t t = 0; t < cells.size(); ++t) cells_of[ground_parts.of[cells[t][0]]].push_back(static_cast<int>(t));
    std::vector<ClosestTriangle> trees;
    for (std::vector<int>& chosen : cells_of)
        if (!chosen.empty()) trees.emplace_back(ground, cells, std::move(chosen));
    Eigen::Vector3d low = ground.front(), high = low;
    for (const Eigen::Vector3d& p : ground) low = low.cwiseMin(p), high = high.cwiseMax(p);
    const double far = kFar * (high - low).norm();

    const Parts parts = parts_of(points.size(), triangles);
    std::vector<std::vector<int>> vertices_of(parts.count);
    for (std::size_t v = 0; v < points.size(); ++v) vertices_of[parts.of[v]].push_back(static_cast<int>(v));
    for (const std::vector<int>& vertices : vertices_of) {
        const int part = part_under(points, vertices, trees);
        for (const int v : vertices) {
            if (!points[v].allFinite()) continue;
            ClosestTriangle::Hit hit = trees[part].closest(points[v]);
            if (hit.distance > far)
                for (const ClosestTriangle& tree : trees)
                    if (const auto other = tree.closest(points[v]); other.distance < hit.distance) hit = other;
            under[v] = hit.triangle;
        }
    }
    return under;
}

}  // namespace gradus

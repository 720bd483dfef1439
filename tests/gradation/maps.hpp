/// Seeded meshes and size maps for the tests of this room.
#pragma once

#include "gradus/mesh/tri_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

namespace gradus::test {

/// The same numbers on every platform, unlike the standard distributions.
class Random {
  public:
    explicit Random(unsigned seed) : engine_(seed) {}
    double operator()(double low, double high) { return low + (high - low) * (engine_() / 4294967296.); }
    int below(int n) { return static_cast<int>(engine_() % static_cast<unsigned>(n)); }

  private:
    std::mt19937 engine_;
};

struct Tris {
    std::vector<Eigen::Vector3d> points;
    std::vector<Triangle> triangles;
    TriMesh mesh() const { return make_mesh(points, triangles); }
};

/// Grid of n x m squares of side `step`, each cut along a diagonal.
inline Tris grid(int n, int m, double step) {
    Tris t;
    for (int j = 0; j <= m; ++j)
        for (int i = 0; i <= n; ++i) t.points.emplace_back(i * step, j * step, 0);
    for (int j = 0; j < m; ++j)
        for (int i = 0; i < n; ++i) {
            const int a = j * (n + 1) + i, b = a + 1, c = b + n + 1, d = a + n + 1;
            t.triangles.push_back({a, b, c});
            t.triangles.push_back({a, c, d});
        }
    return t;
}

/// A grid with random diagonals, vertices moved by up to `shake` steps, on a bumpy surface.
inline Tris random_tris(unsigned seed, int n, int m, double shake = .3, double bump = .3) {
    Random random(seed);
    Tris t = grid(n, m, 1);
    for (Eigen::Vector3d& p : t.points) {
        p.x() += random(-shake, shake);
        p.y() += random(-shake, shake);
        p.z() = bump * random(-1, 1) + std::sin(.7 * p.x()) * std::cos(.5 * p.y());
    }
    for (std::size_t k = 0; k + 1 < t.triangles.size(); k += 2)
        if (random(0, 1) < .5) {
            const auto [a, b, c] = t.triangles[k];
            const int d = t.triangles[k + 1][2];
            t.triangles[k] = {a, b, d};
            t.triangles[k + 1] = {b, c, d};
        }
    return t;
}

/// Sizes log-uniform between two values, each vertex for itself.
inline std::vector<double> random_sizes(unsigned seed, std::size_t n, double low, double high) {
    Random random(seed);
    std::vector<double> size(n);
    for (double& h : size) h = std::exp(random(std::log(low), std::log(high)));
    return size;
}

/// A random renumbering of the vertices: new index of each.
inline std::vector<int> permutation(unsigned seed, int n) {
    Random random(seed);
    std::vector<int> to(n);
    std::iota(to.begin(), to.end(), 0);
    for (int i = n - 1; i > 0; --i) std::swap(to[i], to[random.below(i + 1)]);
    return to;
}

inline Tris renumbered(const Tris& t, const std::vector<int>& to) {
    Tris r = t;
    for (std::size_t v = 0; v < to.size(); ++v) r.points[to[v]] = t.points[v];
    for (Triangle& triangle : r.triangles)
        for (int& v : triangle) v = to[v];
    std::reverse(r.triangles.begin(), r.triangles.end());
    return r;
}

/// A strip of triangles with the vertices 0, 1, ..., n on the x-axis, `step` apart, and a far row of n + 1 more.
inline Tris strip(int n, double step, double width) {
    Tris t;
    for (int row = 0; row < 2; ++row)
        for (int i = 0; i <= n; ++i) t.points.emplace_back(i * step, row * width, 0);
    for (int i = 0; i < n; ++i) {
        t.triangles.push_back({i, i + 1, n + 2 + i});
        t.triangles.push_back({i, n + 2 + i, n + 1 + i});
    }
    return t;
}

}  // namespace gradus::test

/// Small meshes with known topology, and ways to move them about.
#pragma once

#include "gradus/quality/mesh_edges.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

namespace gradus::testing {

struct Mesh {
    std::vector<Eigen::Vector3d> points;
    std::vector<Triangle> triangles;
    MeshView view() const { return {points, triangles}; }
};

/// Grid of nu x nv quads, each two triangles, over [0, 1]^2; closed where asked by naming the first row again.
template <class Map>
Mesh grid(int nu, int nv, bool closed_u, bool closed_v, const Map& map) {
    const int columns = closed_u ? nu : nu + 1, rows = closed_v ? nv : nv + 1;
    Mesh mesh;
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i) mesh.points.push_back(map(double(i) / nu, double(j) / nv));
    const auto at = [&](int i, int j) { return (j % rows) * columns + i % columns; };
    for (int j = 0; j < nv; ++j)
        for (int i = 0; i < nu; ++i) {
            mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    return mesh;
}

inline Mesh square(int n) {
    return grid(n, n, false, false, [](double u, double v) { return Eigen::Vector3d(u, v, 0); });
}

inline Mesh torus(int n, int m) {
    return grid(n, m, true, true, [](double u, double v) {
        const double a = 2 * std::numbers::pi * u, b = 2 * std::numbers::pi * v;
        return Eigen::Vector3d((3 + std::cos(b)) * std::cos(a), (3 + std::cos(b)) * std::sin(a), std::sin(b));
    });
}

inline Mesh annulus(int n, int m) {
    return grid(n, m, true, false, [](double u, double v) {
        const double a = 2 * std::numbers::pi * u;
        return Eigen::Vector3d((1 + v) * std::cos(a), (1 + v) * std::sin(a), 0);
    });
}

inline Mesh octahedron() {
    return {{{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
            {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}, {1, 0, 5}, {2, 1, 5}, {3, 2, 5}, {0, 3, 5}}};
}

/// Both meshes side by side, not joined.
inline Mesh together(Mesh a, const Mesh& b) {
    const int n = static_cast<int>(a.points.size());
    a.points.insert(a.points.end(), b.points.begin(), b.points.end());
    for (const Triangle& t : b.triangles) a.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
    return a;
}

/// The same mesh with vertices and triangles in another order and each triangle from another corner.
/// @param place  set to the new index of each vertex, if given
inline Mesh relabelled(const Mesh& mesh, unsigned seed, std::vector<int>* place = nullptr) {
    std::mt19937 random(seed);
    std::vector<int> to(mesh.points.size());
    std::iota(to.begin(), to.end(), 0);
    std::shuffle(to.begin(), to.end(), random);
    Mesh result{std::vector<Eigen::Vector3d>(mesh.points.size()), {}};
    for (std::size_t v = 0; v < to.size(); ++v) result.points[to[v]] = mesh.points[v];
    for (const Triangle& t : mesh.triangles) {
        const int k = static_cast<int>(random() % 3);
        result.triangles.push_back({to[t[k]], to[t[(k + 1) % 3]], to[t[(k + 2) % 3]]});
    }
    std::shuffle(result.triangles.begin(), result.triangles.end(), random);
    if (place) *place = to;
    return result;
}

inline Mesh moved(Mesh mesh, double scale) {
    const Eigen::Matrix3d rotation = Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
    for (Eigen::Vector3d& p : mesh.points) p = scale * (rotation * p + Eigen::Vector3d(.3, -.2, .7));
    return mesh;
}

/// The same mesh with every point moved by up to `amount` in each coordinate.
inline Mesh shaken(Mesh mesh, double amount, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> offset(-amount, amount);
    for (Eigen::Vector3d& p : mesh.points)
        for (int k = 0; k < 3; ++k) p[k] += offset(random);
    return mesh;
}

}  // namespace gradus::testing

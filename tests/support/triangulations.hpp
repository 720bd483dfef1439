/// Triangulations of surfaces with equations: irregular on purpose, always the same.
#pragma once

#include <functional>
#include <map>

#include "gradus/mesh/soup.hpp"
#include "gradus/surface/parametric_surface.hpp"
#include "quality/meshes.hpp"

namespace gradus::triangulations {

using testing::Mesh;

inline TriangleSoup soup(const Mesh& mesh) { return {mesh.points, mesh.triangles}; }

/// What is known of a surface at its points: curvatures are positive where it bends to the inside.
struct Known {
    std::function<Eigen::Vector3d(const Eigen::Vector3d&)> project, normal;
};

inline Known sphere_known(double radius) {
    return {[=](const Eigen::Vector3d& p) { return Eigen::Vector3d(radius * p.normalized()); },
            [](const Eigen::Vector3d& p) { return p.normalized(); }};
}

inline Known torus_known(double major, double minor) {
    const auto middle = [=](const Eigen::Vector3d& p) {
        return Eigen::Vector3d(major * Eigen::Vector3d(p.x(), p.y(), 0).normalized());
    };
    return {[=](const Eigen::Vector3d& p) { return Eigen::Vector3d(middle(p) + minor * (p - middle(p)).normalized()); },
            [=](const Eigen::Vector3d& p) { return Eigen::Vector3d((p - middle(p)).normalized()); }};
}

/// Each triangle cut in four at the middles of its sides, which are projected.
inline Mesh halved(const Mesh& mesh, const Known& known) {
    Mesh fine{mesh.points, {}};
    std::map<std::array<int, 2>, int> middles;
    const auto middle = [&](int a, int b) {
        const auto [it, is_new] =
            middles.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<int>(fine.points.size()));
        if (is_new) fine.points.push_back(known.project((mesh.points[a] + mesh.points[b]) / 2));
        return it->second;
    };
    for (const Triangle& t : mesh.triangles) {
        const int a = middle(t[0], t[1]), b = middle(t[1], t[2]), c = middle(t[2], t[0]);
        for (const Triangle& s : {Triangle{t[0], a, c}, Triangle{a, t[1], b}, Triangle{c, b, t[2]}, Triangle{a, b, c}})
            fine.triangles.push_back(s);
    }
    return fine;
}

/// Every point moved along the surface by up to `share` of the mean edge in each coordinate.
inline Mesh jittered(Mesh mesh, const Known& known, double share, unsigned seed) {
    double sum = 0;
    for (const Triangle& t : mesh.triangles) sum += (mesh.points[t[1]] - mesh.points[t[0]]).norm();
    const double amount = share * sum / static_cast<double>(mesh.triangles.size());
    mesh = testing::shaken(std::move(mesh), amount, seed);
    for (Eigen::Vector3d& p : mesh.points) p = known.project(p);
    return mesh;
}

/// An octahedron halved some times and projected, then jittered; 4^n + 2 vertices.
inline Mesh sphere(int halvings, double radius = 1, double jitter = 0.12, unsigned seed = 7) {
    const Known known = sphere_known(radius);
    Mesh mesh = testing::octahedron();
    for (Eigen::Vector3d& p : mesh.points) p *= radius;
    for (Triangle& t : mesh.triangles)
        if ((mesh.points[t[1]] - mesh.points[t[0]])
                .cross(mesh.points[t[2]] - mesh.points[t[0]])
                .dot(mesh.points[t[0]]) < 0)
            std::swap(t[1], t[2]);
    for (int k = 0; k < halvings; ++k) mesh = halved(mesh, known);
    return jittered(std::move(mesh), known, jitter, seed);
}

/// n x m quads cut along diagonals chosen at random, then jittered.
inline Mesh torus(int n, int m, double major = 3, double minor = 1, double jitter = 0.12, unsigned seed = 7) {
    Mesh mesh = testing::grid(n, m, true, true, [=](double u, double v) {
        const double a = 2 * std::numbers::pi * u, b = 2 * std::numbers::pi * v;
        return Eigen::Vector3d((major + minor * std::cos(b)) * std::cos(a), (major + minor * std::cos(b)) * std::sin(a),
                               minor * std::sin(b));
    });
    std::mt19937 random(seed);
    for (std::size_t t = 0; t < mesh.triangles.size(); t += 2) {
        if (random() % 2 == 0) continue;
        const int a = mesh.triangles[t][0], b = mesh.triangles[t][1], c = mesh.triangles[t][2],
                  d = mesh.triangles[t + 1][2];
        mesh.triangles[t] = {a, b, d};
        mesh.triangles[t + 1] = {b, c, d};
    }
    return jittered(std::move(mesh), torus_known(major, minor), jitter, seed);
}

/// Vertices that lie on one another made one; which ones are used is as before.
inline Mesh welded(const Mesh& mesh) {
    Mesh result;
    std::map<std::array<long long, 3>, int> known;
    std::vector<int> to;
    for (const Eigen::Vector3d& p : mesh.points) {
        const auto [it, is_new] =
            known.try_emplace({std::llround(1e9 * p.x()), std::llround(1e9 * p.y()), std::llround(1e9 * p.z())},
                              static_cast<int>(result.points.size()));
        if (is_new) result.points.push_back(p);
        to.push_back(it->second);
    }
    for (const Triangle& t : mesh.triangles) result.triangles.push_back({to[t[0]], to[t[1]], to[t[2]]});
    return result;
}

/// The unit cube with n x n quads on each face.
inline Mesh cube(int n) {
    Mesh mesh;
    for (int axis = 0; axis < 3; ++axis)
        for (const bool far : {false, true})
            mesh = testing::together(mesh, testing::grid(n, n, false, false, [=](double u, double v) {
                                         Eigen::Vector3d p;
                                         p[axis] = far;
                                         p[(axis + 1) % 3] = far ? u : v;
                                         p[(axis + 2) % 3] = far ? v : u;
                                         return p;
                                     }));
    return welded(mesh);
}

/// Around the z axis from z = 0 to `height`: n sides, m rows, and caps of `rings` rings around a vertex in the middle.
inline Mesh capped_cylinder(int n, int m, double radius = 1, double height = 2, int rings = 1) {
    const auto at = [=](double u, double r, double z) {
        const double a = 2 * std::numbers::pi * std::fmod(u, 1.0);
        return Eigen::Vector3d(r * std::cos(a), r * std::sin(a), z);
    };
    Mesh mesh = testing::grid(n, m, true, false, [=](double u, double v) { return at(u, radius, v * height); });
    for (const bool top : {false, true}) {
        const double z = top ? height : 0;
        Mesh cap;
        for (int k = rings; k > 0; --k)
            for (int i = 0; i < n; ++i) cap.points.push_back(at(double(i) / n, radius * k / rings, z));
        cap.points.push_back({0, 0, z});
        for (int k = 0; k < rings; ++k)
            for (int i = 0; i < n; ++i) {
                const int a = k * n + i, b = k * n + (i + 1) % n;
                if (k + 1 == rings) {
                    cap.triangles.push_back({a, b, rings * n});
                    continue;
                }
                cap.triangles.push_back({a, b, b + n});
                cap.triangles.push_back({a, b + n, a + n});
            }
        if (!top)
            for (Triangle& t : cap.triangles) std::swap(t[1], t[2]);
        mesh = testing::together(mesh, cap);
    }
    return welded(mesh);
}

/// The graph of z = f(x, y) over the unit square, n x n quads whose inner vertices are jittered along x and y.
inline Mesh graph(int n, const std::function<double(double, double)>& f, double jitter = 0.12, unsigned seed = 7) {
    Mesh mesh = testing::square(n);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> offset(-jitter / n, jitter / n);
    for (Eigen::Vector3d& p : mesh.points) {
        const bool inside = p.x() > 0 && p.x() < 1 && p.y() > 0 && p.y() < 1;
        const double dx = offset(random), dy = offset(random);
        if (inside) p += Eigen::Vector3d(dx, dy, 0);
        p.z() = f(p.x(), p.y());
    }
    return mesh;
}

/// The inner part of a patch, uv in [0.1, 0.9] of its domain: n x n quads with all vertices jittered along u and v.
struct Sampled {
    Mesh mesh;
    std::vector<Eigen::Vector2d> uv;
    /// Whether vertex v lies well inside: what its neighbours tell is not cut off by the boundary.
    bool is_inner(int v) const { return uv[v].minCoeff() > 0.3 && uv[v].maxCoeff() < 0.7; }
};
inline Sampled sampled(const ParametricSurface& patch, int n, double jitter = 0.12, unsigned seed = 7) {
    Sampled result{testing::square(n), {}};
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> offset(-jitter / n, jitter / n);
    for (Eigen::Vector3d& p : result.mesh.points) {
        const double u = p.x() + offset(random), v = p.y() + offset(random);
        result.uv.push_back(Eigen::Vector2d(0.1 + 0.8 * u, 0.1 + 0.8 * v));
        p = patch.position(result.uv.back());
    }
    return result;
}

inline double mean_edge(const Mesh& mesh) {
    double sum = 0;
    for (const Triangle& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) sum += (mesh.points[t[(k + 1) % 3]] - mesh.points[t[k]]).norm();
    return sum / (3 * static_cast<double>(mesh.triangles.size()));
}

/// Every coordinate with normal noise of this deviation.
inline Mesh noisy(Mesh mesh, double deviation, unsigned seed = 3) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0, deviation);
    for (Eigen::Vector3d& p : mesh.points)
        for (int k = 0; k < 3; ++k) p[k] += noise(random);
    return mesh;
}

}  // namespace gradus::triangulations

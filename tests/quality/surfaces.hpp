/// Meshes of parametric surfaces whose vertices know their places.
#pragma once

#include "gradus/quality/distance.hpp"
#include "quality/meshes.hpp"

#include "gradus/surface/analytic.hpp"
#include "gradus/surface/glue.hpp"

#include <map>

namespace gradus::testing {

struct PlacedTriangles : Mesh {
    std::vector<SurfacePoint> places;
    std::vector<int> patches;
    PlacedMesh placed() const { return {view(), places, patches}; }
};

inline SurfaceModel model_of(std::unique_ptr<const ParametricSurface> surface) {
    std::vector<std::unique_ptr<const ParametricSurface>> patches;
    patches.push_back(std::move(surface));
    return glue(std::move(patches));
}

/// n x m quads on every patch, split into triangles with the outside counter-clockwise; vertices of a component at one
/// point are merged and keep their first place, triangles that collapse at poles are left out.
inline PlacedTriangles mesh_of(const SurfaceModel& model, int n, int m) {
    PlacedTriangles mesh;
    std::map<std::array<long long, 4>, int> known;
    const double cell = 1e-7 * model.diagonal();
    const auto vertex = [&](int patch, double s, double t) {
        const Domain domain = model.patch(patch).domain();
        const SurfacePoint at{patch, domain.min + Eigen::Vector2d(s, t).cwiseProduct(domain.max - domain.min)};
        const Eigen::Vector3d p = model.position(at);
        const std::array<long long, 4> key{model.component(patch), std::llround(p[0] / cell), std::llround(p[1] / cell),
                                           std::llround(p[2] / cell)};
        const auto [it, is_new] = known.try_emplace(key, int(mesh.points.size()));
        if (is_new) {
            mesh.points.push_back(p);
            mesh.places.push_back(at);
        }
        return it->second;
    };
    for (int patch = 0; patch < model.num_patches(); ++patch)
        for (int j = 0; j < m; ++j)
            for (int i = 0; i < n; ++i) {
                const int a = vertex(patch, double(i) / n, double(j) / m),
                          b = vertex(patch, double(i + 1) / n, double(j) / m);
                const int c = vertex(patch, double(i + 1) / n, double(j + 1) / m),
                          d = vertex(patch, double(i) / n, double(j + 1) / m);
                for (Triangle t : {Triangle{a, b, c}, Triangle{a, c, d}}) {
                    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
                    if (model.flipped(patch)) std::swap(t[1], t[2]);
                    mesh.triangles.push_back(t);
                    mesh.patches.push_back(patch);
                }
            }
    return mesh;
}

}  // namespace gradus::testing

#include "gradus/remesh/adapt.hpp"

#include "editor.hpp"
#include "gradus/control/metric.hpp"
#include "gradus/surface/locate.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

namespace gradus {

namespace {

// Share of the edges of the mesh whose length in the sizes at its vertices lies within [1/sqrt(2), sqrt(2)].
double unit_share(const SurfaceMesh& mesh, std::span<const double> sizes) {
    std::size_t unit = 0, all = 0;
    for (const Triangle& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) {
            const int a = t[k], b = t[(k + 1) % 3];
            const double l = metric_length((mesh.points[a] - mesh.points[b]).norm(), sizes[a], sizes[b]);
            // Inner edges are met twice, which changes the share by what the boundary weighs.
            ++all;
            if (l >= 1 / std::numbers::sqrt2 && l <= std::numbers::sqrt2) ++unit;
        }
    return all > 0 ? static_cast<double>(unit) / static_cast<double>(all) : 1;
}

void measure_quality(const SurfaceMesh& mesh, AdaptIteration& iteration) {
    double least = 1, sum = 0;
    for (const Triangle& t : mesh.triangles) {
        const double q = triangle_quality(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]);
        least = std::min(least, q);
        sum += q;
    }
    iteration.quality_min = least;
    iteration.quality_mean = mesh.triangles.empty() ? 0 : sum / static_cast<double>(mesh.triangles.size());
}

std::vector<double> graded(const TriMesh& mesh, std::vector<double> sizes,
                           const std::optional<GradationOptions>& gradation) {
    if (gradation) grade(mesh, sizes, *gradation);
    return sizes;
}

}  // namespace

Background background_from_mesh(const SurfaceModel& model, const SurfaceMesh& mesh) {
    Background background{make_mesh(mesh.points, mesh.triangles), mesh.patches, {}};
    background.uv.reserve(mesh.triangles.size());
    std::optional<Locator> locator;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const int p = mesh.patches[t];
        const ParametricSurface& patch = model.patch(p);
        const Eigen::Vector2d extent = patch.domain().max - patch.domain().min;
        const Triangle& corners = mesh.triangles[t];
        // The other corners follow from one that lies on the patch; without any, from the nearest point of the patch.
        const auto own = std::find_if(corners.begin(), corners.end(), [&](int v) { return mesh.places[v].patch == p; });
        const Eigen::Vector3d centre =
            (mesh.points[corners[0]] + mesh.points[corners[1]] + mesh.points[corners[2]]) / 3;
        if (own == corners.end() && !locator) locator.emplace(model);
        const Eigen::Vector2d start =
            (own != corners.end() ? project_within(model, centre, mesh.places[*own]) : locator->find_on(p, centre))
                .at.uv;
        std::array<Eigen::Vector2d, 3> uv;
        for (int k = 0; k < 3; ++k) {
            const SurfacePoint& at = mesh.places[corners[k]];
            // Across a seam the same patch has other parameters.
            const bool near = at.patch == p && ((at.uv - start).cwiseAbs().array() <= extent.array() / 2).all();
            uv[k] = near ? at.uv : project_beyond(patch, mesh.points[corners[k]], start).at.uv;
        }
        background.uv.push_back(uv);
    }
    return background;
}

AdaptResult adapt(const SurfaceModel& model, const AdaptOptions& options) {
    AdaptResult result;
    SizedBackground sized = make_background(model, options.rule, options.background);
    std::vector<double> sizes = graded(sized.background.mesh, sized.sizes, options.gradation);
    while (!result.converged && static_cast<int>(result.iterations.size()) < options.max_iterations) {
        const auto start = std::chrono::steady_clock::now();
        AdaptIteration iteration;
        if (options.progress) options.progress(static_cast<int>(result.iterations.size()) + 1);
        {
            const ControlSpace control(sized.background, sizes);
            RemeshResult remeshed = remesh(model, control, options.remesh);
            result.mesh = std::move(remeshed.mesh);
            iteration.predicted_triangles = remeshed.statistics.predicted_triangles;
        }
        iteration.background_vertices = static_cast<int>(sized.background.mesh.n_vertices());
        iteration.triangles = static_cast<int>(result.mesh.triangles.size());
        iteration.unit_share = unit_share(result.mesh, result.mesh.sizes);
        measure_quality(result.mesh, iteration);
        // The mesh becomes the background, with exact curvature at its vertices.
        sized.background = background_from_mesh(model, result.mesh);
        sized.sizes = geometric_sizes(model, sized.background, options.rule);
        sizes = graded(sized.background.mesh, sized.sizes, options.gradation);
        iteration.next_unit_share = unit_share(result.mesh, sizes);
        result.converged = iteration.next_unit_share >= options.unit_share;
        iteration.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        result.iterations.push_back(iteration);
    }
    return result;
}

}  // namespace gradus

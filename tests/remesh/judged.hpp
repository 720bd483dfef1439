/// Meshes of known models, with what is measured on them.
#pragma once

#include "gradus/control/geometric_size.hpp"
#include "gradus/gradation/grade.hpp"
#include "gradus/quality/report.hpp"
#include "gradus/remesh/parametric.hpp"
#include "support/zoo.hpp"

namespace gradus::testing {

inline SizedBackground uniform_background(const SurfaceModel& model, double h) {
    SizingRule rule;
    rule.hmin = rule.hmax = h;
    return make_background(model, rule);
}

/// Sizes that grow by `shock` from h / 10 at a spot of the first patch to at most 4 h, less where the surface is more
/// curved.
inline SizedBackground graded_background(const SurfaceModel& model, double h, double shock = 1.5) {
    const Domain d = model.patch(0).domain();
    const Eigen::Vector2d spot = d.min + Eigen::Vector2d(0.3, 0.6).cwiseProduct(d.max - d.min);
    SizedBackground sized = make_background(
        model, {.value = 0.3, .hmin = h / 10, .hmax = 4 * h, .at = {{model.position({0, spot}), h / 10}}});
    GradationOptions options;
    options.shock = shock;
    grade(sized.background.mesh, sized.sizes, options);
    return sized;
}

struct Judged {
    SurfaceMesh mesh;
    RemeshStatistics statistics;
    MeshReport report;
    double area = 0;
    double off_surface = 0;     ///< largest distance of a vertex from the equation of the surface
    int misplaced = 0;          ///< vertices that are not bitwise at their place
    int stray_features = 0;     ///< feature vertices that are not on a side of a boundary or crease curve
    int missing_corners = 0;    ///< of the model, that are no vertex
    int missing_boundary = 0;   ///< boundary edges of the mesh that are not among its features
    double feature_length = 0;  ///< of all feature edges
    double curve_length = 0;    ///< of all feature curves
    double turned = 0;  ///< largest angle of a triangle with its neighbour over an edge that is no feature, degrees

    bool right_topology(const models::Kind& kind) const {
        const TopologyReport& t = report.topology;
        return t.oriented_manifold() && t.components == std::size_t(kind.components) &&
               t.boundary_loops == std::size_t(kind.loops) && t.genus == kind.genus && t.unused_vertices == 0 &&
               t.duplicate_positions == 0 && t.bad_points == 0;
    }
};

bool is_feature(const SurfaceModel& model, int curve);
Judged judge(const models::Kind& kind, const SurfaceModel& model, RemeshResult result);
Judged remesh_and_judge(const models::Kind& kind, const SurfaceModel& model, const SizedBackground& sized,
                        const RemeshOptions& options = {});

}  // namespace gradus::testing

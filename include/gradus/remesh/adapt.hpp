/// The adaption loop: mesh, take the mesh as the new background with exact curvature at its vertices, grade, mesh
/// again, until the mesh meets the next map. [Borouchaki 1998, section 4]
#pragma once

#include "gradus/control/geometric_size.hpp"
#include "gradus/gradation/grade.hpp"
#include "gradus/remesh/parametric.hpp"

#include <functional>
#include <optional>
#include <vector>

namespace gradus {

struct AdaptOptions {
    SizingRule rule;
    std::optional<GradationOptions> gradation = {};  ///< none: sizes as they come from curvature
    BackgroundOptions background;                    ///< of the first iteration
    RemeshOptions remesh;
    int max_iterations = 10;
    double unit_share =
        0.96;  ///< the mesh meets the next map when this share of its edges lies in [1/sqrt(2), sqrt(2)] there
    std::function<void(int iteration)> progress;  ///< called before each iteration; may be empty
};

struct AdaptIteration {
    int background_vertices = 0;
    double predicted_triangles = 0;
    int triangles = 0;
    double unit_share = 0;       ///< of the edges of this mesh in the map it was made with
    double next_unit_share = 0;  ///< and in the map recomputed on it: how well the mesh meets the next map
    double quality_min = 0;      ///< area-length
    double quality_mean = 0;
    double seconds = 0;
};

struct AdaptResult {
    SurfaceMesh mesh;
    std::vector<AdaptIteration> iterations;
    bool converged = false;
};

/// @throws as make_background, grade and remesh
AdaptResult adapt(const SurfaceModel& model, const AdaptOptions& options);

/// A mesh as background: triangles keep the patch under most of them; corners that lie on another patch get parameters
/// of that patch continued beyond its side.
Background background_from_mesh(const SurfaceModel& model, const SurfaceMesh& mesh);

}  // namespace gradus

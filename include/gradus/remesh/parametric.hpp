/// Meshes a model of patches with the sizes of a control space.
#pragma once

#include "gradus/control/control_space.hpp"
#include "gradus/gradation/anisotropic.hpp"
#include "gradus/remesh/surface_mesh.hpp"
#include "gradus/surface/surface_model.hpp"

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace gradus {

struct RemeshOptions {
    bool fast = false;                  ///< a lighter schedule: shapes are smoothed, not searched for
    double goal = 0.90;                 ///< area-length quality sought for the worst triangle, in (0, 1)
    double max_triangles = 20'000'000;  ///< refuse when the size map asks for more
    int threads = 0;                    ///< 0: all; the mesh is the same for any number
};

/// What was done, and how long it took.
struct RemeshStatistics {
    double predicted_triangles = 0;  ///< integral of 1 / (sqrt(3)/4 h^2) over the surface
    int generated_triangles = 0;     ///< of the mesh in parameter space, before the optimisation
    int splits = 0, collapses = 0, flips = 0;
    int attempts = 0, kept = 0;  ///< operations tried, and those kept as they lowered the energy
    int below_goal = 0;          ///< triangles that stayed below the goal
    std::vector<std::pair<std::string, double>> seconds;  ///< per stage
};

struct RemeshResult {
    SurfaceMesh mesh;
    RemeshStatistics statistics;
};

/// Curves first, each once; then patch by patch a metric-governed Delaunay mesh in parameter space, mapped; then local
/// operations on the surface. Creases, boundaries, corners and poles are kept; smooth patch borders are not seen in the
/// mesh.
/// @throws std::length_error naming the estimate when the map asks for more than max_triangles
/// @throws std::invalid_argument for a size below 1e-9 of the coordinates there
RemeshResult remesh(const SurfaceModel& model, const ControlSpace& control, const RemeshOptions& options = {});

/// Metric wanted at a place of the surface.
using SurfaceMetric = std::function<Tensor(const SurfacePoint&)>;

/// The same with a metric: from a mesh of the control space, which is to be fine enough for the metric to be told at
/// its vertices, by local operations until edges have length 1 in the metric interpolated between those.
/// @param gradation  of the metrics there; none: as they are
RemeshResult remesh(const SurfaceModel& model, const ControlSpace& control, const SurfaceMetric& metric,
                    const std::optional<TensorGradationOptions>& gradation, const RemeshOptions& options = {});

/// Metric of equal chord errors in both principal directions: a triangle that is equilateral in it is at most `error`
/// from the surface, as far as its curvature is that at the place. h_i = sqrt(3/4) 2 sqrt(E (2 rho_i - E)).
/// @param bounds  of sizes
Tensor chord_error_metric(const SurfaceModel& model, const SurfacePoint& at, double error, const TensorBounds& bounds);

}  // namespace gradus

/// Meshes patches so that mesh and surface stay within a chord error of each other, both ways.
#pragma once

#include <optional>

#include "gradus/control/geometric_size.hpp"
#include "gradus/gradation/grade.hpp"
#include "gradus/quality/deviation.hpp"
#include "gradus/remesh/parametric.hpp"

namespace gradus {

struct PatchChordErrorOptions {
    std::optional<GradationOptions> gradation = {};  ///< that sizes have again once they were lowered
    double hmin = 0;                                 ///< sizes are lowered no farther, unit of length, >= 0
    RemeshOptions remesh = {};
    int most_facets = 20'000'000;  ///< of the triangulation that stands for the surface
};

struct PatchChordErrorResult {
    RemeshResult result;
    /// Between the mesh and the surface. Bounds are proved of a fine triangulation of the surface, and have `facets`
    /// added.
    Deviation deviation;
    /// How far that triangulation is from the surface: twice what is seen at the middles of its edges and triangles.
    double facets = 0;
    bool kept = false;  ///< both bounds are at most the chord error
    int lowerings = 0;  ///< how often sizes were lowered
};

/// Meshes with the sizes of a map, measures, lowers sizes where the distance is above the chord error, and so on until
/// it is nowhere, or sizes are at hmin.
/// @param map          graded sizes to begin with, best by rule_within; those of the mesh when it returns
/// @param chord_error  unit of length, > 0
/// @throws std::invalid_argument if it is not
/// @throws std::length_error as remesh, and where the triangulation of the surface would have too many facets
PatchChordErrorResult remesh_within(const SurfaceModel& model, SizedBackground& map, double chord_error,
                                    const PatchChordErrorOptions& options = {});

struct StretchOptions {
    std::optional<TensorGradationOptions> gradation = {};
    TensorBounds bounds = {};  ///< of sizes
    RemeshOptions remesh = {};
    int most_facets = 20'000'000;
};

/// The same with elements that are as long as the surface lets them be: by the metric of equal chord errors in both
/// principal directions (chord_error_metric), whose sizes are lowered where the distance is above the chord error.
/// @param map  sizes of a mesh that is fine enough to tell the metric at its vertices: best those of remesh_within
PatchChordErrorResult stretch_within(const SurfaceModel& model, const SizedBackground& map, double chord_error,
                                     const StretchOptions& options = {});

}  // namespace gradus

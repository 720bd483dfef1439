/// Grades the sizes of patches on a background that is refined where it is too coarse for them.
#pragma once

#include <vector>

#include "gradus/control/geometric_size.hpp"
#include "gradus/gradation/grade.hpp"

namespace gradus {

struct RefinedGradation {
    std::vector<double> sizes;  ///< graded, one per vertex of the background
    GradationResult result;
    int refinements = 0;  ///< how often the background was refined
    int cuts = 0;         ///< edges cut then
};

/// Edges that are long in the metric of the graded sizes make these smaller than the bound asks for (see
/// GradationResult::coarse_edges). They are cut, sizes at the new vertices are those of the rule, and the map is graded
/// anew, at most four times.
/// @param rule   that the sizes follow from
/// @param sized  from make_background with that rule; refined in place, its sizes stay those of the rule
/// @throws std::invalid_argument as grade does
RefinedGradation grade_refining(const SurfaceModel& model, const SizingRule& rule, const GradationOptions& options,
                                SizedBackground& sized);

}  // namespace gradus

/// From a surface to a graded size map: the stages that several commands run.
#pragma once

#include "gradus/control/geometric_size.hpp"
#include "gradus/gradation/grade.hpp"
#include "session.hpp"

namespace gradus::app {

struct GradedMap {
    std::vector<double> sizes;
    GradationResult result;
    int refinements = 0;  ///< how often the background was refined for it
    int cuts = 0;         ///< edges cut then
};

/// Background for a rule. @throws std::length_error where max_triangles stopped it
SizedBackground background_for(const SurfaceModel& model, const SizingRule& rule, Stages& stages,
                               int max_triangles = BackgroundOptions{}.max_triangles);

/// Grades the sizes of a background; where it is too coarse for them its edges are cut and its raw sizes replaced.
GradedMap grade_refining(const SurfaceModel& model, const SizingRule& rule, const GradationOptions& gradation,
                         SizedBackground& sized, Stages& stages);

}  // namespace gradus::app

#include "gradus/gradation/grade_refining.hpp"

#include <cmath>

namespace gradus {

namespace {

constexpr int kMostRefinements = 4;  // each halves the edges that need it; one or two are usual
// Of the metric length from which an edge is coarse: the graded sizes still go down a little.
constexpr double kMargin = 0.9;

}  // namespace

RefinedGradation grade_refining(const SurfaceModel& model, const SizingRule& rule, const GradationOptions& options,
                                SizedBackground& sized) {
    RefinedGradation graded;
    const auto grade_anew = [&] {
        graded.sizes = sized.sizes;
        graded.result = grade(sized.background.mesh, graded.sizes, options);
    };
    grade_anew();
    while (graded.result.coarse_edges > 0 && graded.refinements < kMostRefinements) {
        const double longest = kMargin * kCoarseEdge / std::log(*options.shock);
        const int cuts = refine_for_gradation(model, rule, longest, sized, graded.sizes);
        if (cuts == 0) break;
        ++graded.refinements;
        graded.cuts += cuts;
        grade_anew();
    }
    return graded;
}

}  // namespace gradus

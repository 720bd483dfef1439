#include "sized.hpp"

#include <cmath>
#include <stdexcept>

namespace gradus::app {

namespace {

constexpr int kMostRefinements = 4;  // each halves the edges that need it; one or two are usual
constexpr double kMargin =
    0.9;  // of the metric length from which an edge is coarse: the graded sizes still go down a little

}  // namespace

SizedBackground background_for(const SurfaceModel& model, const SizingRule& rule, Stages& stages, int max_triangles) {
    return stages.run("background", [&] {
        SizedBackground sized = make_background(
            model, rule, {.max_triangles = max_triangles, .max_unit_triangles = static_cast<double>(max_triangles)});
        if (!sized.resolved)
            throw std::length_error("the background mesh needs more than " + grouped(max_triangles) + " triangles");
        return sized;
    });
}

GradedMap grade_refining(const SurfaceModel& model, const SizingRule& rule, const GradationOptions& gradation,
                         SizedBackground& sized, Stages& stages) {
    return stages.run("gradation", [&] {
        GradedMap map{sized.sizes, {}};
        map.result = grade(sized.background.mesh, map.sizes, gradation);
        while (map.result.coarse_edges > 0 && map.refinements < kMostRefinements) {
            stages.detail(grouped(map.result.coarse_edges) + " edges are too coarse");
            const double longest = kMargin * kCoarseEdge / std::log(*gradation.shock);
            const int cuts = refine_for_gradation(model, rule, longest, sized, map.sizes);
            if (cuts == 0) break;
            ++map.refinements;
            map.cuts += cuts;
            map.sizes = sized.sizes;
            map.result = grade(sized.background.mesh, map.sizes, gradation);
        }
        return map;
    });
}

}  // namespace gradus::app

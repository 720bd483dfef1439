#include "sized.hpp"

#include <stdexcept>

namespace gradus::app {

SizedBackground background_for(const SurfaceModel& model, const SizingRule& rule, Stages& stages, int max_triangles) {
    return stages.run("background", [&] {
        SizedBackground sized = make_background(
            model, rule, {.max_triangles = max_triangles, .max_unit_triangles = static_cast<double>(max_triangles)});
        if (!sized.resolved)
            throw std::length_error("the background mesh needs more than " + grouped(max_triangles) + " triangles");
        return sized;
    });
}

}  // namespace gradus::app

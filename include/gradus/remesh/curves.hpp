/// Cuts the curves of a model into pieces of unit length in the size map.
#pragma once

#include "gradus/control/control_space.hpp"
#include "gradus/surface/surface_model.hpp"

#include <vector>

namespace gradus {

/// For each curve its parameters t in [0, 1], increasing, from 0 to 1, so that the integral of ds / h is the same over
/// each piece and as near to 1 as a whole number of pieces allows; poles have none. [George & Borouchaki 1998, ch. 7]
/// Curves that form a loop are cut often enough for it to be a polygon.
std::vector<std::vector<double>> discretise_curves(const SurfaceModel& model, const ControlSpace& control);

}  // namespace gradus

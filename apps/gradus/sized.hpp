/// Backgrounds that commands make.
#pragma once

#include "gradus/control/geometric_size.hpp"
#include "session.hpp"

namespace gradus::app {

/// Background for a rule. @throws std::length_error where max_triangles stopped it
SizedBackground background_for(const SurfaceModel& model, const SizingRule& rule, Stages& stages,
                               int max_triangles = BackgroundOptions{}.max_triangles);

}  // namespace gradus::app

/// What commands print for people.
#pragma once

#include <string>

#include "gradus/gradation/grade.hpp"
#include "gradus/surface/surface_model.hpp"
#include "session.hpp"

namespace gradus::app {

/// "teapot.bpt: 32 patches in 4 components, diagonal 8.204"
std::string text_of(const std::string& path, const SurfaceModel& model);

/// An H-shock; those beyond a thousand are told as such.
std::string shock_text(double shock);
/// Measures before and after, with the bounds, and what happened. @param vertices  of the background
std::string text_of(const GradationOptions& options, const GradationResult& result, std::size_t vertices);

/// "2.31 s: background 1.20; meshing 1.01", without what took no time
std::string text_of(const std::vector<StageTime>& stages);

}  // namespace gradus::app

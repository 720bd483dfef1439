/// Every kind of model, with what is known of it in closed form.
#pragma once

#include "support/models.hpp"

#include <string>
#include <vector>

namespace gradus::models {

struct Kind {
    std::string name{};
    std::function<SurfaceModel()> make{};
    double area = 0;    ///< of the surface
    double size = 0.1;  ///< a uniform size that gives several hundred triangles
    int components = 1, loops = 0, genus = 0;
    int creases = 0;  ///< curves that are creases
    /// Distance from the surface, where it has an equation.
    std::function<double(const Eigen::Vector3d&)> off_surface{};
};

std::vector<Kind> zoo();
/// @throws std::invalid_argument for a name that is not in the zoo
Kind kind_of(const std::string& name);

}  // namespace gradus::models

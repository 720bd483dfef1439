/// What is said of meshes of quadrilaterals, and how they are drawn.
#pragma once

#include <map>
#include <string>

#include "gradus/io/image.hpp"
#include "gradus/remesh/quads.hpp"
#include "json.hpp"

namespace gradus::app {

struct QuadReport {
    std::size_t vertices = 0, quads = 0, triangles = 0;
    double worst = 1, mean = 0;  ///< see quad_quality
    std::size_t not_convex = 0;
    std::map<int, std::size_t> valences;  ///< number of vertices inside by their number of elements

    double share() const {
        return quads + triangles > 0 ? static_cast<double>(quads) / static_cast<double>(quads + triangles) : 0;
    }
};
/// In its metrics where it has some.
QuadReport measure_quads(const QuadMesh& mesh);
std::string text_of(const QuadReport& report);
Json json_of(const QuadReport& report);

/// Planar meshes from above. @param width  of what is seen around a point, 0: all
Image draw_quads(const QuadMesh& mesh, const Eigen::Vector2d& middle = {0, 0}, double width = 0);

}  // namespace gradus::app

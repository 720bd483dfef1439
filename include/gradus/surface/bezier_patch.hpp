/// Tensor-product Bezier patches of any degree, polynomial or rational, over [0, 1] x [0, 1].
#pragma once

#include "gradus/surface/parametric_surface.hpp"

#include <array>
#include <memory>
#include <vector>

namespace gradus {

/// Control net of degree_u x degree_v; point (i, j), i along u, is points[j * (degree_u + 1) + i].
struct BezierNet {
    int degree_u = 3;
    int degree_v = 3;
    std::vector<Eigen::Vector3d> points;
    std::vector<double> weights;  ///< empty: polynomial; else one per point, > 0
};

/// @throws std::invalid_argument for a net of the wrong size, values that are not finite, or weights that are not positive
std::unique_ptr<const ParametricSurface> make_bezier_patch(BezierNet net);

}  // namespace gradus

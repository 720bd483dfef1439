/// Tensor-product Bezier patches of any degree, polynomial or rational, over [0, 1] x [0, 1].
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "gradus/surface/parametric_surface.hpp"

namespace gradus {

/// Largest degree in either direction (evaluation works in buffers of fixed size).
inline constexpr int max_bezier_degree = 25;

/// Control net of degree_u x degree_v; point (i, j), i along u, is points[j * (degree_u + 1) + i].
struct BezierNet {
    int degree_u = 3;
    int degree_v = 3;
    std::vector<Eigen::Vector3d> points;
    std::vector<double> weights;  ///< empty: polynomial; else one per point, > 0
};

/// The patch of a control net. Corners are interpolated exactly: position at (0, 0) is bitwise points[0], and so on.
/// Along a side with the same control points (and weights) two patches give bitwise the same positions, in whichever
/// direction u or v it runs; when it runs the other way, at parameters s and 1 - s of which both are exact (s a
/// multiple of 2^-53). Polynomial bicubic patches take a path of their own, about 20 ns per first-order jet.
/// @throws std::invalid_argument for a degree outside [1, max_bezier_degree], a net of the wrong size, values that are
/// not finite, or weights that are not positive
std::unique_ptr<const ParametricSurface> make_bezier_patch(BezierNet net);

}  // namespace gradus

/// Metrics from a solution: of the error of its linear interpolation. [Loseille & Alauzet 2011]
#pragma once

#include "gradus/control/tensor.hpp"
#include "gradus/mesh/tri_mesh.hpp"

#include <optional>
#include <span>
#include <vector>

namespace gradus {

/// Second derivatives of a field at the vertices of a triangle mesh, in the plane, or in the tangent planes of a
/// surface: those of the quadratic that fits the values around best, by least squares over two rings of neighbours at
/// least, and as many more as it takes. Exact where the field is a quadratic, at boundaries too.
/// @param values  one per vertex, finite
/// @throws std::invalid_argument for a wrong number of values, one that is not finite, or a mesh with fewer than six
/// vertices in a part
std::vector<Tensor> recovered_hessians(const TriMesh& mesh, std::span<const double> values);

struct HessianMetricOptions {
    /// Largest error of linear interpolation in an element, unit of the field: |H| 2 / (9 E) [Frey & Alauzet 2005] ...
    std::optional<double> error = {};
    /// ... or the number of vertices of a unit mesh, on which the error is least in the L^p norm.
    std::optional<double> vertices = {};
    double norm = 2;  ///< p, >= 1
    TensorBounds bounds = {};
};

struct HessianMetrics {
    std::vector<Tensor> metrics;                           ///< one per vertex
    double expected_vertices = 0, expected_triangles = 0;  ///< of a unit mesh
    int at_smallest = 0, at_largest = 0, at_aspect = 0;    ///< vertices where a bound holds
};

/// Metrics of the absolute values of Hessians; of several fields they are intersected.
/// @param hessians  of each field, one per vertex
/// @throws std::invalid_argument unless one of error and vertices is given and positive, for bounds that are none, or
/// no largest size: where a field is linear nothing else bounds sizes
HessianMetrics metrics_of_hessians(const TriMesh& mesh, std::span<const std::vector<Tensor>> hessians,
                                   const HessianMetricOptions& options);

}  // namespace gradus

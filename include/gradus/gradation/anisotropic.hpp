/// Bounds the change of metrics along the edges of their background mesh. Unit balls only ever shrink.
#pragma once

#include "gradus/control/tensor.hpp"
#include "gradus/gradation/measures.hpp"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace gradus {

/// What becomes of a metric where it changes too fast. The size of a metric along an edge is `size_along` it; a bound
/// on the H-variation, or the H-shock, is one on these sizes at the two ends. [Borouchaki 1998, section 3.1]
enum class TensorGradationMethod {
    /// It is scaled, so that unit balls keep their shape, by the largest factors that meet the bound: those are unique,
    /// whatever the order. Of the Hc-correction the exact form [eq. 20, 22].
    Shape,
    /// The same by the factors of the paper, edge after edge, until nothing changes [eq. 23]; of a variation [eq. 14].
    Paper,
    /// It is intersected with that of the neighbour, grown by 1 + alpha l in all directions, l the length of the edge
    /// in
    /// the neighbour's metric [eq. 17; the metric-space law of Alauzet 2010]: the shape spreads.
    Metric,
    /// Each size of the neighbour grows by alpha times the distance: far away the neighbour's metric is round [the
    /// physical-space law of Alauzet 2010].
    Physical,
    /// Between the two: (physical)^t (metric)^(1 - t) [Alauzet 2010].
    Mixed
};

struct TensorGradationOptions {
    TensorGradationMethod method = TensorGradationMethod::Shape;
    std::optional<double> shock =
        {};  ///< largest H-shock, > 1; of intersections the variation ln(shock), which implies it
    std::optional<double> variation = {};  ///< largest H-variation, > 0; both hold where both are given
    double mixing = 0.125;                 ///< t of Mixed, in [0, 1]
};

struct TensorGradationResult {
    int lowered = 0;            ///< vertices whose metric changed
    double largest_factor = 1;  ///< largest size before / after, in any direction
    bool converged = true;      ///< false: stopped at its largest number of visits
    long visits = 0;            ///< vertices taken from the work list, or sweeps of Paper
    /// What is left: the largest relative excess of an edge. Of sizes along edges over the bound; of intersections, of
    /// a neighbour's grown metric over what it is to be inside of, in any direction.
    double residual = 0;
    bool met = false;  ///< residual <= 1e-9; of Physical, whose chains of intersections shrink on and on, .001
    /// Shape: per vertex the neighbour whose bound its metric is tight against, -1 where it is the input.
    std::vector<int> parent;
    GradationReport before, after;  ///< by sizes along edges; nothing of triangles
};

/// H-variation, and logarithm of the H-shock, of an edge. [eq. 9, 10, 12]
double h_variation(const Eigen::Vector3d& e, const Tensor& metric_p, const Tensor& metric_q);
double log_h_shock(const Eigen::Vector3d& e, const Tensor& metric_p, const Tensor& metric_q);

/// Measures by sizes along edges; nothing of triangles.
GradationReport measure_gradation(const TriMesh& mesh, std::span<const Tensor> metrics);

/// Corrects metrics at the vertices of a mesh. On h^-2 I all methods but Paper give what limit_h_variation and, where
/// edges are not coarse, limit_h_shock give. Intersections are made in the order of rising sizes det(M)^(-1/4), of
/// equal ones in that of coordinates, so that the result does not depend on the order of vertices and edges; on
/// surfaces a metric is turned from tangent plane to tangent plane first.
/// @throws std::invalid_argument if no bound is given or one is out of range, or a metric is not positive definite
TensorGradationResult grade(const TriMesh& mesh, std::span<Tensor> metrics, const TensorGradationOptions& options);

/// One sweep that proves a result of Shape: every edge meets the bound, every metric is a multiple of the input by a
/// factor of at most 1, and tight against a parent where that is below 1, so that no factor can be larger: following
/// parents leads to a vertex that has its input, or around a circle along which excesses shrink.
/// @returns what is wrong, naming the first vertex or edge, or nothing
std::optional<std::string> check_shape_certificate(const TriMesh& mesh, const TensorGradationOptions& options,
                                                   std::span<const Tensor> input, std::span<const Tensor> result,
                                                   std::span<const int> parent);
/// The same of intersections: every metric is inside its input and inside its neighbours' grown ones.
std::optional<std::string> check_intersection_certificate(const TriMesh& mesh, const TensorGradationOptions& options,
                                                          std::span<const Tensor> input,
                                                          std::span<const Tensor> result);

}  // namespace gradus

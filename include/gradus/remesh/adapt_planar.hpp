/// The adaption loop of planar domains: sample the sizes wanted, correct them, mesh, and again from that mesh, until it
/// satisfies the map that would come next. [Borouchaki 1998, section 4.1]
#pragma once

#include "gradus/control/sampled_background.hpp"
#include "gradus/gradation/anisotropic.hpp"
#include "gradus/gradation/grade.hpp"
#include "gradus/remesh/planar.hpp"

#include <functional>
#include <optional>
#include <vector>

namespace gradus {

struct PlanarAdaptOptions {
    std::optional<GradationOptions> gradation = {};               ///< of sizes; none: as they are wanted
    std::optional<TensorGradationOptions> tensor_gradation = {};  ///< of size tensors
    SamplingOptions sampling = {};
    RemeshOptions remesh = {};
    int max_iterations = 20;
    /// The mesh satisfies what is wanted when this share of its edges has lengths in [1/sqrt(2), sqrt(2)] in the map
    /// that it was made with, and is not longer in the sizes wanted as they are sampled on it, before they are
    /// corrected. (A corrected map depends on the background it is corrected on, most of all where metrics are
    /// intersected.) The loop ends before where no iteration brings it nearer to that.
    double unit_share = 0.95;
    std::function<void(int iteration)> progress = {};  ///< called before each iteration; may be empty
};

/// A mesh against a map.
struct MetricFit {
    double worst = 1,
           mean = 0;        ///< area-length quality in the metric, of each triangle where it is worst of its corners
    double unit_share = 1;  ///< of the edges
    double not_long = 1;    ///< share of the edges of at most sqrt(2)
    double shortest = 0, longest = 0;  ///< metric length of an edge
};

/// @param sizes  one per vertex
template <class M>
MetricFit measure_fit(std::span<const Eigen::Vector3d> points, const Connectivity& mesh,
                      std::span<const typename M::Value> sizes);

struct PlanarAdaptIteration {
    int background_vertices = 0;
    double predicted_triangles = 0;  ///< by the map
    int triangles = 0;
    MetricFit own;            ///< in the map that the mesh was made with
    MetricFit wanted;         ///< in the sizes wanted, sampled on it
    MetricFit next;           ///< in the map that these become when they are corrected
    double shock_before = 1;  ///< largest H-shock of the map as sampled
    double shock = 1;         ///< and as it was meshed
    double seconds = 0;
};

template <class M>
struct PlanarAdaptResult {
    TriangleSoup mesh;
    std::vector<typename M::Value> sizes;   ///< of the map that the mesh was made with, at its vertices
    SampledBackground<M> background;        ///< with the sizes that the mesh was made with
    std::vector<typename M::Value> wanted;  ///< sizes of the background before they were corrected
    std::vector<PlanarAdaptIteration> iterations;
    RemeshStatistics statistics;  ///< of the last mesh
    bool converged = false;       ///< the mesh satisfies the next map
    bool graded = true;           ///< all maps meet their bound
};

/// @param domain  in z = 0; must stay
/// @throws as sampled_background, grade and PlanarMesher do
template <class M>
PlanarAdaptResult<M> adapt_planar(const Triangulation& domain, const SizeFunction<M>& wanted,
                                  const PlanarAdaptOptions& options = {});

}  // namespace gradus

/// A background that represents sizes given at any point: by a formula, or a program.
#pragma once

#include "gradus/control/control_space.hpp"

#include <functional>
#include <vector>

namespace gradus {

/// Size or size tensor wanted at a point; may change anywhere and jump. Called from one thread.
template <class M>
using SizeFunction = std::function<typename M::Value(const Eigen::Vector3d&)>;

struct SamplingOptions {
    double tolerance = 0.05;  ///< between interpolated sizes and those wanted, relative, in any direction, > 0
    /// Metric length of edges that are not cut any more, though the sizes between their ends are not what interpolation
    /// says, as where they jump.
    double shortest = 0.35;
    double spacing = 0.002;  ///< of the first samples, over the diagonal: what is thinner may be missed
    int max_triangles = 5'000'000;
};

/// Triangles with sizes at their vertices.
template <class M>
struct SampledBackground {
    std::vector<Eigen::Vector3d> points;
    Connectivity mesh;
    std::vector<typename M::Value> sizes;
    /// A vertex that came to the mesh: the ends of the edge that it is the middle of, and the tag of that.
    struct Cut {
        std::array<int, 2> ends;
        int tag;
    };
    std::vector<Cut> cuts;       ///< in order
    bool is_fine_enough = true;  ///< false: cutting ended at the largest number of triangles
};

/// Cuts the triangles of a mesh at their longest edges until the sizes wanted at samples on their edges and inside are
/// those interpolated between their corners: so what is thin is found, though no vertex lies in it. Vertices of the
/// mesh keep their numbers. Frozen edges stay. Where sizes differ by direction edges are compared in the metric, so
/// that triangles become as long as elements are.
/// @throws what the function throws
template <class M>
SampledBackground<M> sampled_background(std::vector<Eigen::Vector3d> points, Connectivity mesh,
                                        const SizeFunction<M>& wanted, const SamplingOptions& options = {});

/// Cuts edges that are long in other sizes at its vertices, as what they become once they are graded: so that what
/// follows from those depends little on where its vertices are. Sizes of the background at new vertices are those
/// wanted. @param sizes  one per vertex  @returns how many edges were cut
template <class M>
int cut_long_edges(SampledBackground<M>& background, const SizeFunction<M>& wanted,
                   std::vector<typename M::Value> sizes, double longest, int max_triangles);

extern template SampledBackground<Size> sampled_background(std::vector<Eigen::Vector3d>, Connectivity,
                                                           const SizeFunction<Size>&, const SamplingOptions&);
extern template SampledBackground<SizeTensor> sampled_background(std::vector<Eigen::Vector3d>, Connectivity,
                                                                 const SizeFunction<SizeTensor>&,
                                                                 const SamplingOptions&);

}  // namespace gradus

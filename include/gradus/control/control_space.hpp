/// The continuous control space: the sizes or metrics of a background mesh, interpolated between its vertices.
#pragma once

#include "gradus/control/tensor.hpp"
#include "gradus/control/triangle_locator.hpp"

#include <span>
#include <vector>

namespace gradus {

/// What a metric field is of: one size for all directions ...
struct Size {
    using Value = double;  ///< h
};
/// ... or sizes by directions.
struct SizeTensor {
    using Value = Tensor;  ///< H = M^(-1/2), whose eigenvalues are the sizes
};

/// The wanted sizes at each point of a surface.
template <class M>
class MetricField {
  public:
    virtual ~MetricField() = default;
    /// Size, or size tensor, at p. @param hint  what the call for a nearby point left in it
    virtual typename M::Value size(const Eigen::Vector3d& p, int& hint) const = 0;
};

/// Sizes are linear over each triangle, so that their gradient is that of the triangle everywhere on it: a bound that
/// holds on the triangles of the background holds between its vertices, however large they are for the sizes. (Where
/// sizes vary geometrically [Borouchaki 1998, eq. 6] the slope along an edge is up to r ln r / (r - 1) times as steep,
/// r the ratio of the sizes of its ends.) So are size tensors, which stay positive definite. Points are found as by
/// TriangleLocator; where, on a mesh without parameters, the walk ends farther from the point than a quarter of the
/// size, as behind a sharp edge of a coarse mesh, the closest triangle takes its place.
template <class M>
class InterpolatedField final : public MetricField<M> {
  public:
    using Value = typename M::Value;

    /// @param sizes  one per vertex: > 0 and finite, or positive definite
    /// @throws std::invalid_argument for a wrong number of sizes, or one that is none
    InterpolatedField(const Background& background, std::span<const Value> sizes);
    /// The same of a mesh without parameters, of which all triangles live; nothing of it is kept.
    InterpolatedField(std::span<const Eigen::Vector3d> points, const Connectivity& mesh, std::span<const Value> sizes);

    /// Size at p, walking from `triangle` (a triangle of the background near p), which is set to the one p falls into.
    Value size(const Eigen::Vector3d& p, int& triangle) const override;
    /// A triangle of the background that holds the parameters, or the nearest there is on that patch. Only of a
    /// background with parameters, as the size at a place.
    int locate(const SurfacePoint& at) const { return locator_.locate(at).triangle; }
    /// Size at a place of the surface, interpolated in (u, v).
    Value size(const SurfacePoint& at) const { return value(locator_.locate(at)); }
    /// Number of triangles a unit mesh has: the sum over triangles of the integral of 1 / (sqrt(3)/4 h^2), of tensors
    /// h^2 that of mean_square_size. Exact for sizes; for tensors by quadrature, to about 1e-4.
    double predicted_triangles() const;

    /// Smallest size over the largest coordinate of a triangle it is at.
    double least_relative_size() const;

    int num_triangles() const { return locator_.num_triangles(); }

  private:
    Value value(const TriangleLocator::Position& at) const;

    TriangleLocator locator_;
    std::vector<std::array<Value, 3>> values_;  // at the corners of each triangle
};

extern template class InterpolatedField<Size>;
extern template class InterpolatedField<SizeTensor>;

using ControlSpace = InterpolatedField<Size>;
using TensorSpace = InterpolatedField<SizeTensor>;

}  // namespace gradus

/// Meshes planar domains with sizes or metrics, by local operations in the plane.
#pragma once

#include "gradus/control/sampled_background.hpp"
#include "gradus/control/triangulation.hpp"
#include "gradus/remesh/parametric.hpp"
#include "gradus/remesh/support.hpp"

#include <memory>
#include <vector>

namespace gradus {

struct OptimiseOptions;
class StageClock;

/// The plane z = 0 with the feature curves of a domain, each a chain with its arc length. A place is nothing but its
/// point, inside, and its curve and arc length on one.
class PlanarSupport final : public Support {
  public:
    explicit PlanarSupport(std::span<const Eigen::Vector3d> points, const Features& features);
    std::optional<Foot> move(const Place& from, const Eigen::Vector3d& point,
                             const Eigen::Vector3d& target) const override;
    std::optional<Foot> slide(const Place& from, const Eigen::Vector3d& target) const override;
    int chain_of(int curve) const override { return curve; }
    Foot middle(int chain, const Foot& a, const Foot& b) const override;
    /// Of a vertex of the domain.
    Foot at_vertex(int vertex) const;

  private:
    struct Curve {
        std::vector<Eigen::Vector3d> points;  // the first one again at the end of a closed curve
        std::vector<double> length;           // from the start to each
        bool closed = false;

        double end() const { return length.back(); }
        int edge_at(double t) const;
    };
    Foot on_curve(int curve, double t, int cell) const;

    std::vector<Eigen::Vector3d> points_;
    std::vector<Curve> curves_;
    std::vector<std::pair<int, double>> curve_of_;  // of each vertex inside a chain: chain and arc length; else -1
};

/// A mesh of a planar domain on its way from one size map to the next.
template <class M>
class PlanarMesher {
  public:
    /// Begins with the triangles of the domain. @throws std::invalid_argument where it is not in z = 0 or has frozen
    /// triangles
    explicit PlanarMesher(const Triangulation& domain);
    ~PlanarMesher();
    PlanarMesher(PlanarMesher&&) noexcept;

    /// Takes the triangles of a background, which were cut from those that it has, and splits, collapses, flips and
    /// moves them until their edges have length 1 in its sizes, and there are as many as these ask for, or up to 5 %
    /// more: so no edge spans what is thin.
    /// @throws std::length_error, std::invalid_argument as remesh
    RemeshStatistics mesh(const SampledBackground<M>& background, const RemeshOptions& options = {});

    const std::vector<Eigen::Vector3d>& points() const { return points_; }
    const Connectivity& connectivity() const { return mesh_; }
    /// Of the last field, at the vertices; empty before the first.
    const std::vector<typename M::Value>& sizes() const { return sizes_; }
    /// With labels, feature edges and their labels, corners and required elements of the domain.
    TriangleSoup soup() const;

  private:
    RequiredElements required() const;
    void take_cuts(const SampledBackground<M>& background);
    void mesh_for(const MetricField<M>& field, const OptimiseOptions& options, RemeshStatistics& statistics,
                  StageClock& clock);

    struct State;
    std::vector<Eigen::Vector3d> points_;
    Connectivity mesh_;
    std::vector<typename M::Value> sizes_;
    std::unique_ptr<State> state_;
};

extern template class PlanarMesher<Size>;
extern template class PlanarMesher<SizeTensor>;

}  // namespace gradus

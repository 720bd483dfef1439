/// A smooth map from a rectangle of parameters (u, v) to space.
#pragma once

#include <Eigen/Core>
#include <span>

namespace gradus {

/// Rectangle of parameters.
struct Domain {
    Eigen::Vector2d min{0, 0};
    Eigen::Vector2d max{1, 1};
};

/// Position and first derivatives S, S_u, S_v.
struct Jet1 {
    Eigen::Vector3d p, du, dv;
};

/// Position, first and second derivatives S, S_u, S_v, S_uu, S_uv, S_vv.
struct Jet2 {
    Eigen::Vector3d p, du, dv, duu, duv, dvv;
};

/// Implementations are immutable and may be evaluated from several threads. Parameters a little outside the domain are
/// evaluated by the same formula (no clamping).
class ParametricSurface {
  public:
    virtual ~ParametricSurface() = default;
    virtual Domain domain() const = 0;
    virtual Eigen::Vector3d position(const Eigen::Vector2d& uv) const = 0;
    virtual Jet1 jet1(const Eigen::Vector2d& uv) const = 0;
    virtual Jet2 jet2(const Eigen::Vector2d& uv) const = 0;
    /// Where the curvature is to be taken that sizes at uv follow from: uv itself, but for surfaces that know of places
    /// where theirs is unbounded on parts too small to matter.
    virtual Eigen::Vector2d curvature_place(const Eigen::Vector2d& uv) const { return uv; }
    /// Second-order jets of many points at once. @pre uv.size() == jets.size()
    virtual void jets(std::span<const Eigen::Vector2d> uv, std::span<Jet2> jets) const;
};

}  // namespace gradus

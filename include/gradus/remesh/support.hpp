/// What the local operations know of the surface they work on: how to put a point back on it, and the size asked for there.
#pragma once

#include "gradus/control/control_space.hpp"
#include "gradus/surface/patch_model.hpp"

#include <optional>

namespace gradus {

/// Where a vertex lies: on a patch, and on a curve of the model where it is bound to one.
struct Place {
    SurfacePoint at;
    int curve = -1;  ///< feature curve it slides on, or -1
    double t = 0;    ///< parameter on that curve
    int cell = 0;    ///< triangle of the control space under it
};

/// A point of the surface with what the operations read of it.
struct Foot {
    Place place;
    Eigen::Vector3d point;
    Eigen::Vector3d normal;  ///< unit, outward
    double size;
};

class Support {
  public:
    virtual ~Support() = default;
    /// The point of the surface near `target`, coming from `from`: exactly on the surface, near the target only to within a tenth
    /// of the way. Nothing where the way is barred by a feature, a boundary or a pole.
    virtual std::optional<Foot> move(const Place& from, const Eigen::Vector3d& target) const = 0;
    /// The same along the curve that `from` is bound to.
    virtual std::optional<Foot> slide(const Place& from, const Eigen::Vector3d& target) const = 0;
    /// The point at parameter t of a feature curve. `cell` is a triangle of the control space near it.
    virtual Foot on_curve(int curve, double t, int cell) const = 0;
    /// Parameters of a feature curve at its ends a (t = 0) and b (t = 1), by position.
    virtual std::array<Eigen::Vector3d, 2> curve_ends(int curve) const = 0;
};

/// Patches glued along curves: free vertices cross smooth curves.
class PatchSupport final : public Support {
  public:
    PatchSupport(const PatchModel& model, const ControlSpace& control) : model_(model), control_(control) {}
    std::optional<Foot> move(const Place& from, const Eigen::Vector3d& target) const override;
    std::optional<Foot> slide(const Place& from, const Eigen::Vector3d& target) const override;
    Foot on_curve(int curve, double t, int cell) const override;
    std::array<Eigen::Vector3d, 2> curve_ends(int curve) const override;
    /// The foot of a place given by its parameters.
    Foot foot(Place place) const;

  private:
    const PatchModel& model_;
    const ControlSpace& control_;
};

}  // namespace gradus

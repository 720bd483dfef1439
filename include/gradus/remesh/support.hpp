/// What the local operations know of the surface they work on: how to put a point back on it.
#pragma once

#include "gradus/surface/surface_model.hpp"

#include <optional>

namespace gradus {

/// Where a vertex lies: on a patch, and on a curve of the model where it is bound to one.
struct Place {
    SurfacePoint at;
    int curve = -1;   ///< feature curve it slides on, or -1
    double t = 0;     ///< parameter on that curve
    int cell = 0;     ///< triangle of the control space under it
    int vertex = -1;  ///< vertex of the model it is, where none passes through smoothly, or -1
};

/// A point of the surface with what the operations read of it.
struct Foot {
    Place place;
    Eigen::Vector3d point;
    Eigen::Vector3d normal;  ///< unit, outward; on a crease between those of its two sides
    double lean = 1;         ///< cosine of the angle from there to either side's
};

/// Gives a foot on a crease its normal, from those of the two sides.
void between_sides(const Eigen::Vector3d& a, const Eigen::Vector3d& b, Foot& foot);

class Support {
  public:
    virtual ~Support() = default;
    /// The point of the surface near `target`, coming from a place and its point: exactly on the surface, near the
    /// target only to within a tenth of the way. Nothing where the way is barred by a feature, a boundary or a pole.
    virtual std::optional<Foot> move(const Place& from, const Eigen::Vector3d& point,
                                     const Eigen::Vector3d& target) const = 0;
    /// The point half way between two places along the section of the surface by the plane through them and `up`, a
    /// direction out of the surface there; nothing where no section leads from one to the other, or none is known.
    virtual std::optional<Foot> between(const Place&, const Place&, const Eigen::Vector3d& /*up*/) const {
        return std::nullopt;
    }
    /// Brings the normal of a foot to what elements of some size see of the surface there.
    virtual void settle(Foot&, double /*size*/) const {}
    /// As `move`, along the curve that `from` is bound to.
    virtual std::optional<Foot> slide(const Place& from, const Eigen::Vector3d& target) const = 0;
    /// Feature curves that continue each other smoothly form a chain, numbered from 0: vertices slide from one to the
    /// next.
    virtual int chain_of(int curve) const = 0;
    /// The point of a chain half way between two of its points, each on a curve of the chain or at an end of it.
    virtual Foot middle(int chain, const Foot& a, const Foot& b) const = 0;
};

/// Patches glued along curves: free vertices cross smooth curves.
class PatchSupport final : public Support {
  public:
    explicit PatchSupport(const SurfaceModel& model);
    std::optional<Foot> move(const Place& from, const Eigen::Vector3d& point,
                             const Eigen::Vector3d& target) const override;
    std::optional<Foot> slide(const Place& from, const Eigen::Vector3d& target) const override;
    int chain_of(int curve) const override { return links_[curve].chain; }
    Foot middle(int chain, const Foot& a, const Foot& b) const override;
    /// The foot of a place given by its parameters.
    Foot foot(const Place& place) const;
    /// The place of a model vertex that a chain passes through smoothly, and which therefore is no corner; else
    /// nothing.
    std::optional<Place> junction(int model_vertex) const;

  private:
    // The place of a curve in its chain. The chain's parameter is that of its n curves one after the other, in [0, n].
    struct Link {
        int chain = -1;
        int position = 0;
        bool reversed = false;  // the chain runs against the curve
    };
    struct Chain {
        std::vector<int> curves;
        bool closed = false;
    };
    void link_curves();
    Place on_chain(int chain, double t, int cell) const;
    double chain_parameter(const Place& place) const;
    Eigen::Vector3d leaving(int curve, bool from_end) const;

    const SurfaceModel& model_;
    std::vector<Link> links_;  // one per curve of the model
    std::vector<Chain> chains_;
    std::vector<CurveEnd> junctions_;  // one per model vertex: a curve that ends there, where two continue each other
};

}  // namespace gradus

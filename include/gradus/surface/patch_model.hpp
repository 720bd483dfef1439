/// A surface of patches glued along the curves they share.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "gradus/mesh/soup.hpp"
#include "gradus/surface/parametric_surface.hpp"

namespace gradus {

/// Side of a patch's domain. Each runs in the direction of the growing parameter (u for Bottom and Top).
enum class Side { Bottom, Right, Top, Left };  // v = min, u = max, v = max, u = min
inline bool along_u(Side side) { return side == Side::Bottom || side == Side::Top; }

/// A side of a patch as one use of a curve: `reversed` when the side runs against the curve.
struct SideUse {
    int patch = -1;
    Side side = Side::Bottom;
    bool reversed = false;
};

enum class CurveKind {
    Boundary,  ///< used by one side
    Smooth,    ///< two sides meet with (nearly) the same normal: not a feature
    Crease,    ///< two sides meet at an angle
    Pole       ///< the side is collapsed to a point
};
/// Kept by a mesh: its vertices and edges follow the curve.
inline bool is_feature(CurveKind kind) { return kind == CurveKind::Boundary || kind == CurveKind::Crease; }

/// A curve of the model: the trace of one or two patch sides. Its parameter t in [0, 1] is that of its first use
/// (affine in the side's parameter, reversed where uses[0].reversed; uses[0] is never reversed).
struct ModelCurve {
    CurveKind kind = CurveKind::Boundary;
    std::vector<SideUse> uses;        ///< one (Boundary, Pole) or two (Smooth, Crease); a seam has both on one patch
    std::array<int, 2> ends{-1, -1};  ///< model vertices at t = 0 and t = 1
    double length = 0;                ///< arc length
    double largest_angle = 0;         ///< largest angle between the normals of the two sides, radians (0 with one use)
    bool same_parameter = true;  ///< both uses have affinely equal parameters (else they are matched by closest point)
};

/// A point where curves end, poles included.
struct ModelVertex {
    Eigen::Vector3d point;
    std::vector<SurfacePoint> places;  ///< every patch corner that lies here
    bool pole = false;
};

struct GlueOptions {
    double tolerance =
        1e-6;  ///< distance below which boundary curves are the same, relative to the diagonal of the bounding box
    double crease_angle =
        0.2618;  ///< angle between the normals from which a shared curve is a crease, radians (15 degrees)
};

/// Patches with their shared curves. Immutable after construction.
///
/// Sides are glued where their curves coincide, never where only corners do: parts that touch or cross stay apart. A
/// side may meet another side of its own patch (a seam). Closed sides must start at the same point. Sides that coincide
/// only in part (T-junctions) stay boundaries.
///
/// Outside: a component whose boundary loops can be capped by less than 3/4 of its own area (a closed one above all) is
/// turned so that it encloses a positive volume; any other keeps the orientation of its first patch, S_u x S_v.
class PatchModel {
  public:
    /// Glues patch sides whose curves coincide, in either direction, and orients neighbours consistently
    /// (flipped(patch)).
    /// @throws std::invalid_argument naming the patch for not-a-number geometry or zero area, and naming the curve when
    ///         three or more sides share one or when the surface is one-sided
    explicit PatchModel(std::vector<std::unique_ptr<const ParametricSurface>> patches, const GlueOptions& options = {});

    /// Of more patches than these each is a small part of the surface, and few samples of it do.
    static constexpr int kMany = 512;
    int num_patches() const { return static_cast<int>(patches_.size()); }
    const ParametricSurface& patch(int i) const { return *patches_[i]; }
    /// True where the outside of the patch is -S_u x S_v, so that all patches of a component agree.
    bool flipped(int patch) const { return flipped_[patch]; }
    /// Connected component of a patch (by shared curves), 0-based.
    int component(int patch) const { return component_[patch]; }
    int num_components() const { return num_components_; }

    const std::vector<ModelCurve>& curves() const { return curves_; }
    const std::vector<ModelVertex>& vertices() const { return vertices_; }
    /// Curve of a side, and which of its uses that side is.
    struct SideCurve {
        int curve = -1;
        int use = 0;
    };
    SideCurve side_curve(int patch, Side side) const { return side_curves_[4 * patch + static_cast<int>(side)]; }
    /// Model vertex of a patch corner: 0 (umin, vmin), 1 (umax, vmin), 2 (umax, vmax), 3 (umin, vmax).
    int corner_vertex(int patch, int corner) const { return corner_vertices_[4 * patch + corner]; }

    /// Place on use `use` of curve `curve` at the curve's parameter t in [0, 1]. With the same control points on both
    /// sides the positions of both uses are bitwise equal.
    SurfacePoint on_curve(int curve, int use, double t) const;
    /// Curve parameter t of the point with side parameter s in [0, 1] (along the side's direction) on side `side` of
    /// `patch`.
    double curve_parameter(int patch, Side side, double s) const;

    Eigen::Vector3d position(const SurfacePoint& at) const { return patches_[at.patch]->position(at.uv); }
    /// Outward unit normal; at a pole the limit, never zero or not a number for a surface that has one.
    Eigen::Vector3d normal(const SurfacePoint& at) const;
    /// Diagonal of the bounding box of the control points or samples.
    double diagonal() const { return diagonal_; }

  private:
    struct Builder;
    /// Parameter on the other use's side of the point at side parameter s of a use, for curves without the same
    /// parameter.
    double follow_match(int curve, int use, double s) const;

    std::vector<std::unique_ptr<const ParametricSurface>> patches_;
    std::vector<char> flipped_;
    std::vector<int> component_;
    int num_components_ = 0;
    std::vector<ModelCurve> curves_;
    std::vector<ModelVertex> vertices_;
    std::vector<SideCurve> side_curves_;
    std::vector<int> corner_vertices_;
    std::vector<std::vector<double>>
        matches_;  // of each curve: parameters of its second side at even steps of the first
    double diagonal_ = 0;
};

}  // namespace gradus

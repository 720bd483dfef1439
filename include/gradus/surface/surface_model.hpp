/// A surface of patches, each bounded by loops of curves, that meet along the curves they share.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gradus/mesh/soup.hpp"
#include "gradus/surface/parametric_surface.hpp"
#include "gradus/surface/plane_curve.hpp"

namespace gradus {

/// A curve as a patch has it on its border: its image in the patch's parameters. `reversed` where the loop runs against
/// the curve. Loops have the patch on their left: outer ones run counter-clockwise in (u, v), holes clockwise.
struct CurveUse {
    int patch = -1;
    bool reversed = false;
    std::unique_ptr<const PlaneCurve> image;
};

/// A use by its numbers.
struct UseRef {
    int curve = -1;
    int use = 0;
    bool operator==(const UseRef&) const = default;
};

enum class CurveKind {
    Boundary,  ///< used once
    Smooth,    ///< used twice, with (nearly) the same normal on both sides: not a feature
    Crease,    ///< used twice, by patches that meet at an angle
    Pole       ///< collapsed to a point
};
/// Kept by a mesh: its vertices and edges follow the curve.
inline bool is_feature(CurveKind kind) { return kind == CurveKind::Boundary || kind == CurveKind::Crease; }

/// A curve of the model, with a parameter t in [0, 1]. It lies where its first use has it.
struct ModelCurve {
    CurveKind kind = CurveKind::Boundary;
    std::vector<CurveUse> uses;       ///< one (Boundary, Pole) or two (Smooth, Crease); a seam has both on one patch
    std::array<int, 2> ends{-1, -1};  ///< model vertices at t = 0 and t = 1
    double length = 0;                ///< arc length; that of two chords of models with more than kMany patches
    double largest_angle = 0;  ///< largest angle seen between the normals of the two sides, radians; 0 where the kind
                               ///< was given
};

/// A point where curves end, poles included.
struct ModelVertex {
    Eigen::Vector3d point;
    std::vector<SurfacePoint> places = {};  ///< every corner of a loop that lies here
    bool pole = false;
    bool tip = false;  ///< the surface has no tangent plane here, whatever its curves: a corner of the mesh
};

/// An end of a curve.
struct CurveEnd {
    int curve = -1;
    bool at_end = false;  ///< t = 1
};

/// What a model is made of: which curves bound which patches. Vertices follow: ends are one vertex where loops pass
/// from the one to the other.
struct Topology {
    struct Patch {
        std::unique_ptr<const ParametricSurface> surface;
        std::vector<std::vector<UseRef>> loops;  ///< uses one after the other, the outer loop first
        std::string name = {};                   ///< for messages; empty: "patch 3", from 0 on
    };
    struct Curve {
        std::vector<CurveUse> uses;
        std::optional<CurveKind> kind = {};  ///< by the number of uses and the angle between their normals if not given
    };
    std::vector<Patch> patches;
    std::vector<Curve> curves;
    std::vector<CurveEnd> tips = {};  ///< ends without a tangent plane
};

struct ModelOptions {
    /// Distance below which points are the same, relative to the diagonal of the bounding box.
    double tolerance = 1e-6;
    /// Angle between the normals from which a shared curve is a crease, radians (15 degrees).
    double crease_angle = 0.2618;
};

/// Patches with their curves. Immutable after construction.
///
/// Outside: a component whose boundary loops can be capped by less than 3/4 of its own area (a closed one above all) is
/// turned so that it encloses a positive volume; any other keeps the orientation of its first patch, S_u x S_v.
class SurfaceModel {
  public:
    /// Orients neighbours consistently (flipped(patch)), and finds kinds that are not given.
    /// @throws std::invalid_argument naming the patch for not-a-number geometry or zero area, naming the curve where
    /// uses are of no patch, in no loop or in two, where a loop does not close, or where the surface is one-sided
    explicit SurfaceModel(Topology topology, const ModelOptions& options = {});
    SurfaceModel(SurfaceModel&&) noexcept;
    SurfaceModel& operator=(SurfaceModel&&) noexcept;
    ~SurfaceModel();

    /// Of more patches than these each is a small part of the surface, and few samples of it do.
    static constexpr int kMany = 512;
    int num_patches() const { return static_cast<int>(patches_.size()); }
    const ParametricSurface& patch(int i) const { return *patches_[i].surface; }
    const std::vector<std::vector<UseRef>>& loops(int patch) const { return patches_[patch].loops; }
    /// True where the outside of the patch is -S_u x S_v, so that all patches of a component agree.
    bool flipped(int patch) const { return flipped_[patch]; }
    double area(int patch) const { return areas_[patch]; }
    /// Connected component of a patch (by shared curves), 0-based.
    int component(int patch) const { return component_[patch]; }
    int num_components() const { return num_components_; }

    const std::vector<ModelCurve>& curves() const { return curves_; }
    const std::vector<ModelVertex>& vertices() const { return vertices_; }
    const CurveUse& use(const UseRef& ref) const { return curves_[ref.curve].uses[ref.use]; }
    /// Model vertex at which a loop enters a use.
    int start_of(const UseRef& ref) const { return curves_[ref.curve].ends[use(ref).reversed]; }

    /// Place on use `use` of curve `curve` at the curve's parameter t in [0, 1].
    SurfacePoint on_curve(int curve, int use, double t) const;
    /// Where the curve is there, and its derivative by t.
    CurveJet curve_jet(int curve, double t) const;
    CurveJet2 curve_jet2(int curve, double t) const;
    Eigen::Vector3d curve_point(int curve, double t) const;

    /// Where a step in the parameters of a patch first leaves it.
    struct Exit {
        double fraction = 1;  ///< of the step
        UseRef use;
        double t = 0;  ///< of the curve
    };
    std::optional<Exit> exit(const SurfacePoint& from, const Eigen::Vector2d& step) const;
    /// A place on the border of its patch: on a use, at t of its curve.
    struct OnBorder {
        UseRef use;
        double t;
    };
    /// The uses that a place lies on, in the order of the loops. @param tolerance  relative to the patch's extent
    std::vector<OnBorder> border_at(const SurfacePoint& at, double tolerance = 1e-10) const;
    /// Whether a place is inside the loops of its patch, or on them.
    bool contains(const SurfacePoint& at) const;
    /// Parameters all over a patch: of a lattice over the box of its loops, where they are inside; if they do not fill
    /// it, of the loops too. @param intervals  in each direction, per_curve  on each curve
    std::vector<Eigen::Vector2d> samples(int patch, int intervals, int per_curve) const;

    Eigen::Vector3d position(const SurfacePoint& at) const { return patch(at.patch).position(at.uv); }
    /// Outward unit normal; at a pole the limit, never zero or not a number for a surface that has one.
    Eigen::Vector3d normal(const SurfacePoint& at) const;
    /// Diagonal of the bounding box of samples.
    double diagonal() const { return diagonal_; }

  private:
    struct Builder;
    class Border;

    std::vector<Topology::Patch> patches_;
    std::vector<Border> borders_;  // one per patch
    std::vector<double> areas_;
    std::vector<char> flipped_;
    std::vector<int> component_;
    int num_components_ = 0;
    std::vector<ModelCurve> curves_;
    std::vector<ModelVertex> vertices_;
    double diagonal_ = 0;
};

}  // namespace gradus

#include "gradus/surface/glue.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "../mesh/cells.hpp"
#include "trace.hpp"

namespace gradus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// -- Sides
// ---------------------------------------------------------------------------------------------------------------------

/// Side of a patch's domain, in the order of its loop. Each runs in the direction of the growing parameter.
enum class Side { Bottom, Right, Top, Left };  // v = min, u = max, v = max, u = min

const char* name_of(Side side) {
    constexpr std::array<const char*, 4> names{"bottom", "right", "top", "left"};
    return names[static_cast<int>(side)];
}

bool along_u(Side side) { return side == Side::Bottom || side == Side::Top; }
/// Whether the side runs counter-clockwise around the domain.
bool counter_clockwise(Side side) { return side == Side::Bottom || side == Side::Right; }

/// Parameters of the place at s in [0, 1] along a side.
Vector2d side_uv(const Domain& d, Side side, double s) {
    if (along_u(side))
        return {s == 1 ? d.max.x() : interpolate(d.min.x(), d.max.x(), s),
                side == Side::Bottom ? d.min.y() : d.max.y()};
    return {side == Side::Left ? d.min.x() : d.max.x(), s == 1 ? d.max.y() : interpolate(d.min.y(), d.max.y(), s)};
}

/// A side as a curve over s in [0, 1].
struct SideTrace {
    const ParametricSurface* surface;
    Side side;

    Vector2d uv(double s) const { return side_uv(surface->domain(), side, s); }
    Vector2d duv() const { return uv(1) - uv(0); }
    Vector3d point(double s) const { return surface->position(uv(s)); }
    Vector3d derivative(double s) const {
        const Jet1 jet = surface->jet1(uv(s));
        return jet.du * duv().x() + jet.dv * duv().y();
    }
    /// s of a place on the side
    double parameter(const Vector2d& at) const {
        const int axis = along_u(side) ? 0 : 1;
        return std::clamp((at[axis] - uv(0)[axis]) / duv()[axis], 0.0, 1.0);
    }
};

// -- Sides and which of them coincide
// ------------------------------------------------------------------------------------------

struct SampledSide {
    SideTrace curve;
    int patch = -1;
    std::array<Vector3d, curve_pieces + 1> points;
    bool pole = false;
};

SampledSide sample_side(const ParametricSurface& surface, int patch, Side side, double tolerance) {
    SampledSide result;
    result.curve = {&surface, side};
    result.patch = patch;
    for (int k = 0; k <= curve_pieces; ++k)
        result.points[k] = result.curve.point(static_cast<double>(k) / curve_pieces);
    result.pole = std::all_of(result.points.begin(), result.points.end(),
                              [&](const Vector3d& p) { return (p - result.points[0]).norm() <= tolerance; });
    return result;
}

/// How a second side follows a first.
struct Match {
    bool reversed = false;
    bool same_parameter = true;
    std::vector<double> table;  ///< parameters of the second side at k / curve_pieces on the first, if not the same
};

bool ends_agree(const SampledSide& a, const SampledSide& b, bool reversed, double tolerance) {
    const Vector3d& b0 = reversed ? b.points.back() : b.points.front();
    const Vector3d& b1 = reversed ? b.points.front() : b.points.back();
    return (a.points.front() - b0).norm() <= tolerance && (a.points.back() - b1).norm() <= tolerance;
}

bool samples_agree(const SampledSide& a, const SampledSide& b, bool reversed, double tolerance) {
    for (int k = 0; k <= curve_pieces; ++k)
        if ((a.points[k] - b.points[reversed ? curve_pieces - k : k]).norm() > tolerance) return false;
    return true;
}

/// Follows the samples of `a` along `b`; nothing if `b` is not the same trace.
std::optional<std::vector<double>> follow(const SampledSide& a, const SampledSide& b, bool reversed, double tolerance) {
    std::vector<double> table(curve_pieces + 1);
    double last = reversed ? 1 : 0;
    for (int k = 0; k <= curve_pieces; ++k) {
        const bool end = k == curve_pieces;
        if (k > 0)
            last = end        ? (reversed ? 0.0 : 1.0)
                   : reversed ? closest_from(b.curve, a.points[k], 0, last)
                              : closest_from(b.curve, a.points[k], last, 1);
        if ((b.curve.point(last) - a.points[k]).norm() > tolerance) return std::nullopt;
        table[k] = last;
    }
    // The other way round, so that `b` makes no excursion between the samples of `a`.
    for (int k = 0; k < curve_pieces; ++k) {
        const Vector3d p = b.curve.point((table[k] + table[k + 1]) / 2);
        const double s = closest_between(a.curve, p, static_cast<double>(k) / curve_pieces, (k + 1.0) / curve_pieces);
        if ((a.curve.point(s) - p).norm() > tolerance) return std::nullopt;
    }
    return table;
}

std::optional<Match> match(const SampledSide& a, const SampledSide& b, double tolerance) {
    for (const bool reversed : {false, true})
        if (ends_agree(a, b, reversed, tolerance) && samples_agree(a, b, reversed, tolerance))
            return Match{reversed, true, {}};
    for (const bool reversed : {false, true})
        if (ends_agree(a, b, reversed, tolerance))
            if (std::optional<std::vector<double>> table = follow(a, b, reversed, tolerance))
                return Match{reversed, false, std::move(*table)};
    return std::nullopt;
}

/// Sides whose ends coincide, in either order, have the middle between their ends in common.
Vector3d middle_of_ends(const SampledSide& s) { return (s.points.front() + s.points.back()) / 2; }

/// The image of a curve on a second side whose parameter is not an affine one of the first: each point of the curve is
/// matched by the closest one.
class FollowedImage final : public PlaneCurve {
  public:
    /// @param table  parameters of `second` at even steps of `first`
    FollowedImage(const SideTrace& first, const SideTrace& second, bool reversed, std::vector<double> table)
        : first_(first), second_(second), reversed_(reversed), table_(std::move(table)) {}

    Vector2d uv(double t) const override { return second_.uv(along_second(t)); }
    Vector2d duv(double t) const override {
        const double s = along_second(t), square = second_.derivative(s).squaredNorm();
        return second_.duv() * (square > 0 ? first_.derivative(t).dot(second_.derivative(s)) / square : 1);
    }
    /// What the side's own parameter has too little of is along the side: where it lies does not change by it.
    Vector2d dduv(double) const override { return {0, 0}; }
    double parameter(const Vector2d& uv) const override {
        const double s = second_.parameter(uv);
        if (s <= 0 || s >= 1) return reversed_ == (s <= 0) ? 1 : 0;
        int k = 0;
        while (k < curve_pieces - 1 && (reversed_ ? table_[k + 1] > s : table_[k + 1] < s)) ++k;
        return closest_between(first_, second_.point(s), static_cast<double>(k) / curve_pieces,
                               (k + 1.0) / curve_pieces);
    }
    bool is_straight() const override { return true; }

  private:
    double along_second(double t) const {
        if (t <= 0 || t >= 1) return reversed_ == (t <= 0) ? 1 : 0;
        const int k = std::min(static_cast<int>(t * curve_pieces), curve_pieces - 1);
        return closest_between(second_, first_.point(t), std::min(table_[k], table_[k + 1]),
                               std::max(table_[k], table_[k + 1]));
    }

    SideTrace first_, second_;
    bool reversed_;
    std::vector<double> table_;
};

// -- Gluing
// --------------------------------------------------------------------------------------------------------------------

class Gluing {
  public:
    Gluing(std::vector<std::unique_ptr<const ParametricSurface>> patches, const ModelOptions& options) {
        if (!(options.tolerance > 0)) throw std::invalid_argument("tolerance must be positive");
        topology_.patches.resize(patches.size());
        for (std::size_t p = 0; p < patches.size(); ++p) {
            if (!patches[p]) throw std::invalid_argument("patch " + std::to_string(p) + " is null");
            topology_.patches[p].surface = std::move(patches[p]);
        }
        const Eigen::AlignedBox3d box = box_of_samples();
        if (box.isEmpty()) return;
        tolerance_ = options.tolerance * box.diagonal().norm();
        constexpr double kLeastWidth = 1e-6;  // of the diagonal: there are not more cells than can be numbered
        Cells ends(box.min(),
                   std::max({4 * tolerance_, kLeastWidth * box.diagonal().norm(), std::numeric_limits<double>::min()}));
        join_sides(ends);
    }

    Topology take() { return std::move(topology_); }

  private:
    const ParametricSurface& patch(int p) const { return *topology_.patches[p].surface; }

    Eigen::AlignedBox3d box_of_samples() const {
        const int n = std::ssize(topology_.patches) > SurfaceModel::kMany ? 2 : 8;
        Eigen::AlignedBox3d box;
        for (int p = 0; p < std::ssize(topology_.patches); ++p) {
            const Domain d = patch(p).domain();
            for (int b = 0; b <= n; ++b)
                for (int a = 0; a <= n; ++a) {
                    const Vector3d point =
                        patch(p).position({interpolate(d.min.x(), d.max.x(), static_cast<double>(a) / n),
                                           interpolate(d.min.y(), d.max.y(), static_cast<double>(b) / n)});
                    if (!point.allFinite())
                        throw std::invalid_argument("patch " + std::to_string(p) + " has values that are not finite");
                    box.extend(point);
                }
        }
        return box;
    }

    void join_sides(Cells& ends) {
        const int n = 4 * static_cast<int>(topology_.patches.size());
        sides_.reserve(n);
        curve_of_.assign(n, -1);
        for (int k = 0; k < n; ++k) {
            const Side side = static_cast<Side>(k % 4);
            sides_.push_back(sample_side(patch(k / 4), k / 4, side, tolerance_));
            if (k % 4 == 0) topology_.patches[k / 4].loops.emplace_back();
            if (sides_[k].pole || !join_known_curve(k, ends)) {
                start_curve(k);
                if (!sides_[k].pole) ends.insert(middle_of_ends(sides_[k]), k);
            }
        }
    }

    /// The use of side k, whose image runs as the side does, or against it.
    CurveUse straight_use(int k, bool against_side) const {
        const SideTrace& side = sides_[k].curve;
        return {k / 4, counter_clockwise(side.side) == against_side,
                against_side ? straight_image(side.uv(1), side.uv(0)) : straight_image(side.uv(0), side.uv(1))};
    }

    void start_curve(int k) {
        Topology::Curve curve;
        curve.uses.push_back(straight_use(k, false));
        if (sides_[k].pole) curve.kind = CurveKind::Pole;
        curve_of_[k] = static_cast<int>(topology_.curves.size());
        topology_.curves.push_back(std::move(curve));
        topology_.patches[k / 4].loops[0].push_back({curve_of_[k], 0});
    }

    std::string describe(int k) const { return "patch " + std::to_string(k / 4) + " " + name_of(sides_[k].curve.side); }

    bool join_known_curve(int k, const Cells& ends) {
        std::vector<int> candidates;
        ends.for_each_near(middle_of_ends(sides_[k]), [&](int side) { candidates.push_back(side); });
        std::sort(candidates.begin(), candidates.end());
        for (const int other : candidates) {
            std::optional<Match> m = match(sides_[other], sides_[k], tolerance_);
            if (!m) continue;
            const int c = curve_of_[other];
            Topology::Curve& curve = topology_.curves[c];
            if (curve.uses.size() == 2) {
                const auto second = std::find(curve_of_.begin() + other + 1, curve_of_.end(), c) - curve_of_.begin();
                throw std::invalid_argument("three sides share curve " + std::to_string(c) + ": " + describe(other) +
                                            ", " + describe(static_cast<int>(second)) + " and " + describe(k));
            }
            CurveUse use = straight_use(k, m->reversed);
            if (!m->same_parameter)
                use.image = std::make_unique<FollowedImage>(sides_[other].curve, sides_[k].curve, m->reversed,
                                                            std::move(m->table));
            curve.uses.push_back(std::move(use));
            curve_of_[k] = c;
            topology_.patches[k / 4].loops[0].push_back({c, 1});
            return true;
        }
        return false;
    }

    Topology topology_;
    double tolerance_ = 0;
    std::vector<SampledSide> sides_;
    std::vector<int> curve_of_;  // of each side
};

}  // namespace

SurfaceModel glue(std::vector<std::unique_ptr<const ParametricSurface>> patches, const ModelOptions& options) {
    return SurfaceModel(Gluing(std::move(patches), options).take(), options);
}

}  // namespace gradus

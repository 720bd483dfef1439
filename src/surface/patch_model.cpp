#include "gradus/surface/patch_model.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "../mesh/disjoint_sets.hpp"
#include "gradus/surface/unit_normal.hpp"
#include "side_trace.hpp"

namespace gradus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// A component whose boundary can be capped by less than this share of its own area encloses a volume worth speaking of.
constexpr double largest_cap = 0.75;

const char* name_of(Side side) {
    constexpr std::array<const char*, 4> names{"bottom", "right", "top", "left"};
    return names[static_cast<int>(side)];
}

/// Whether the side runs counter-clockwise around the domain.
bool counter_clockwise(Side side) { return side == Side::Bottom || side == Side::Right; }

/// Corners of a patch at the two ends of a side.
std::array<int, 2> corners_of(Side side) {
    constexpr std::array<std::array<int, 2>, 4> corners{{{0, 1}, {1, 2}, {3, 2}, {0, 3}}};
    return corners[static_cast<int>(side)];
}

Vector2d corner_uv(const Domain& d, int corner) {
    return {corner == 1 || corner == 2 ? d.max.x() : d.min.x(), corner >= 2 ? d.max.y() : d.min.y()};
}

// -- Areas, volumes
// ------------------------------------------------------------------------------------------------------------

struct PatchIntegrals {
    double area = 0;
    double volume = 0;  ///< of the cone from a given apex over the patch, signed by S_u x S_v
};

PatchIntegrals integrate(const ParametricSurface& patch, const Vector3d& apex, int pieces) {
    const Domain d = patch.domain();
    const double du = (d.max.x() - d.min.x()) / pieces, dv = (d.max.y() - d.min.y()) / pieces;
    PatchIntegrals result;
    for (int a = 0; a < 5 * pieces; ++a)
        for (int b = 0; b < 5 * pieces; ++b) {
            const Vector2d uv(d.min.x() + du * (a / 5 + gauss_points[a % 5]),
                              d.min.y() + dv * (b / 5 + gauss_points[b % 5]));
            const Jet1 jet = patch.jet1(uv);
            const Vector3d n = jet.du.cross(jet.dv);
            const double weight = gauss_weights[a % 5] * gauss_weights[b % 5] * du * dv;
            result.area += weight * n.norm();
            result.volume += weight * (jet.p - apex).dot(n) / 3;
        }
    return result;
}

// -- Sides and which of them coincide
// ------------------------------------------------------------------------------------------

struct SampledSide {
    SideTrace curve;
    int patch = -1;
    std::array<Vector3d, side_pieces + 1> points;
    bool pole = false;
};

SampledSide sample_side(const ParametricSurface& surface, int patch, Side side, double tolerance) {
    SampledSide result;
    result.curve = {&surface, side};
    result.patch = patch;
    for (int k = 0; k <= side_pieces; ++k) result.points[k] = result.curve.point(static_cast<double>(k) / side_pieces);
    result.pole = std::all_of(result.points.begin(), result.points.end(),
                              [&](const Vector3d& p) { return (p - result.points[0]).norm() <= tolerance; });
    return result;
}

/// How a second side follows a first.
struct Match {
    bool reversed = false;
    bool same_parameter = true;
    std::vector<double> table;  ///< parameters of the second side at k / side_pieces on the first, if not the same
};

bool ends_agree(const SampledSide& a, const SampledSide& b, bool reversed, double tolerance) {
    const Vector3d& b0 = reversed ? b.points.back() : b.points.front();
    const Vector3d& b1 = reversed ? b.points.front() : b.points.back();
    return (a.points.front() - b0).norm() <= tolerance && (a.points.back() - b1).norm() <= tolerance;
}

bool samples_agree(const SampledSide& a, const SampledSide& b, bool reversed, double tolerance) {
    for (int k = 0; k <= side_pieces; ++k)
        if ((a.points[k] - b.points[reversed ? side_pieces - k : k]).norm() > tolerance) return false;
    return true;
}

/// Follows the samples of `a` along `b`; nothing if `b` is not the same trace.
std::optional<std::vector<double>> follow(const SampledSide& a, const SampledSide& b, bool reversed, double tolerance) {
    std::vector<double> table(side_pieces + 1);
    double last = reversed ? 1 : 0;
    for (int k = 0; k <= side_pieces; ++k) {
        const bool end = k == side_pieces;
        if (k > 0)
            last = end        ? (reversed ? 0.0 : 1.0)
                   : reversed ? closest_from(b.curve, a.points[k], 0, last)
                              : closest_from(b.curve, a.points[k], last, 1);
        if ((b.curve.point(last) - a.points[k]).norm() > tolerance) return std::nullopt;
        table[k] = last;
    }
    // The other way round, so that `b` makes no excursion between the samples of `a`.
    for (int k = 0; k < side_pieces; ++k) {
        const Vector3d p = b.curve.point((table[k] + table[k + 1]) / 2);
        const double s = closest_between(a.curve, p, static_cast<double>(k) / side_pieces, (k + 1.0) / side_pieces);
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

/// Finds sides whose ends coincide in either order: by the cell of a grid in which the middle between both ends lies.
class EndIndex {
  public:
    /// @param diagonal  of the model: cells are not smaller than what numbers of that size can tell apart
    EndIndex(double tolerance, double diagonal, const Vector3d& origin)
        : cell_(std::max(4 * tolerance, 1e-14 * diagonal)), origin_(origin) {}

    void insert(int side, const SampledSide& s) { cells_[cell_of(middle(s))].push_back(side); }

    /// Sides inserted so far that may coincide with s, ascending.
    std::vector<int> candidates(const SampledSide& s) const {
        const Cell c = cell_of(middle(s));
        std::vector<int> result;
        for (int x = -1; x <= 1; ++x)
            for (int y = -1; y <= 1; ++y)
                for (int z = -1; z <= 1; ++z)
                    if (const auto it = cells_.find({c[0] + x, c[1] + y, c[2] + z}); it != cells_.end())
                        result.insert(result.end(), it->second.begin(), it->second.end());
        std::sort(result.begin(), result.end());
        return result;
    }

  private:
    using Cell = std::array<std::int64_t, 3>;
    static Vector3d middle(const SampledSide& s) { return (s.points.front() + s.points.back()) / 2; }
    Cell cell_of(const Vector3d& p) const {
        const Vector3d x = (p - origin_) / cell_;
        return {static_cast<std::int64_t>(std::floor(x.x())), static_cast<std::int64_t>(std::floor(x.y())),
                static_cast<std::int64_t>(std::floor(x.z()))};
    }

    double cell_;
    Vector3d origin_;
    std::map<Cell, std::vector<int>> cells_;
};

// -- Vertices, components
// ------------------------------------------------------------------------------------------------------

/// Corners at t = 0 and t = 1 of a use of a curve, as 4 patch + corner.
std::array<int, 2> end_corners(const SideUse& use) {
    std::array<int, 2> c = corners_of(use.side);
    if (use.reversed) std::swap(c[0], c[1]);
    return {4 * use.patch + c[0], 4 * use.patch + c[1]};
}

/// Whether the curve runs counter-clockwise around the patch of this use.
bool runs_counter_clockwise(const SideUse& use) { return counter_clockwise(use.side) != use.reversed; }

std::string describe(const SideUse& use) { return "patch " + std::to_string(use.patch) + " " + name_of(use.side); }

double angle_between(const Vector3d& a, const Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

}  // namespace

// -- Construction
// --------------------------------------------------------------------------------------------------------------

/// The steps of the constructor, in order.
struct PatchModel::Builder {
    PatchModel& model;
    const GlueOptions& options;
    double tolerance = 0;  // absolute
    Vector3d low_corner{0, 0, 0};

    bool has_many() const { return model.num_patches() > PatchModel::kMany; }
    int pieces() const { return has_many() ? 1 : 3; }

    void check_options() const {
        if (!(options.tolerance > 0)) throw std::invalid_argument("PatchModel: tolerance must be positive");
        if (!(options.crease_angle >= 0)) throw std::invalid_argument("PatchModel: crease_angle must not be negative");
    }

    /// Samples each patch: numbers must be finite, the area positive. Sets the diagonal.
    void check_patches() {
        Vector3d low = Vector3d::Constant(INFINITY), high = -low;
        for (int i = 0; i < model.num_patches(); ++i) {
            if (!model.patches_[i]) throw std::invalid_argument("PatchModel: patch " + std::to_string(i) + " is null");
            const Domain d = model.patch(i).domain();
            Vector3d patch_low = Vector3d::Constant(INFINITY), patch_high = -patch_low;
            const int n = has_many() ? 2 : 8;
            for (int b = 0; b <= n; ++b)
                for (int a = 0; a <= n; ++a) {
                    const Jet1 jet =
                        model.patch(i).jet1({interpolate(d.min.x(), d.max.x(), static_cast<double>(a) / n),
                                             interpolate(d.min.y(), d.max.y(), static_cast<double>(b) / n)});
                    if (!jet.p.allFinite() || !jet.du.allFinite() || !jet.dv.allFinite())
                        throw std::invalid_argument("PatchModel: patch " + std::to_string(i) +
                                                    " has values that are not finite");
                    patch_low = patch_low.cwiseMin(jet.p);
                    patch_high = patch_high.cwiseMax(jet.p);
                }
            const double area = integrate(model.patch(i), patch_low, pieces()).area;
            // Collinear points leave an area of rounding errors, some 1e-16 of the square of the size.
            if (!(area > 1e-13 * (patch_high - patch_low).squaredNorm()))
                throw std::invalid_argument("PatchModel: patch " + std::to_string(i) + " has zero area");
            low = low.cwiseMin(patch_low);
            high = high.cwiseMax(patch_high);
        }
        if (model.num_patches() == 0) return;
        model.diagonal_ = (high - low).norm();
        low_corner = low;
        tolerance = options.tolerance * model.diagonal_;
    }

    void glue() {
        model.side_curves_.resize(4 * model.num_patches());
        std::vector<SampledSide> sides;
        sides.reserve(4 * model.num_patches());
        EndIndex index(tolerance, model.diagonal_, low_corner);
        std::vector<int> first_side;  // of each curve
        for (int k = 0; k < 4 * model.num_patches(); ++k) {
            const int patch = k / 4;
            const Side side = static_cast<Side>(k % 4);
            sides.push_back(sample_side(model.patch(patch), patch, side, tolerance));
            if (sides[k].pole) {
                add_curve({patch, side, false}, CurveKind::Pole);
                first_side.push_back(k);
                continue;
            }
            if (!join_known_curve(k, sides, index)) {
                add_curve({patch, side, false}, CurveKind::Boundary);
                first_side.push_back(k);
                index.insert(k, sides[k]);
            }
        }
        for (std::size_t c = 0; c < model.curves_.size(); ++c)
            if (model.curves_[c].kind != CurveKind::Pole)
                model.curves_[c].length = length_of(sides[first_side[c]].curve);
    }

    void add_curve(const SideUse& use, CurveKind kind) {
        model.side_curves_[4 * use.patch + static_cast<int>(use.side)] = {static_cast<int>(model.curves_.size()), 0};
        ModelCurve curve;
        curve.kind = kind;
        curve.uses = {use};
        model.curves_.push_back(curve);
        model.matches_.emplace_back();
    }

    bool join_known_curve(int k, const std::vector<SampledSide>& sides, const EndIndex& index) {
        for (const int other : index.candidates(sides[k])) {
            const std::optional<Match> m = match(sides[other], sides[k], tolerance);
            if (!m) continue;
            const int c = model.side_curves_[other].curve;
            ModelCurve& curve = model.curves_[c];
            const SideUse use{sides[k].patch, sides[k].curve.side, m->reversed};
            if (curve.uses.size() == 2)
                throw std::invalid_argument("PatchModel: three sides share curve " + std::to_string(c) + ": " +
                                            describe(curve.uses[0]) + ", " + describe(curve.uses[1]) + " and " +
                                            describe(use));
            curve.uses.push_back(use);
            curve.kind = CurveKind::Smooth;  // until the normals are seen
            curve.same_parameter = m->same_parameter;
            model.matches_[c] = m->table;
            model.side_curves_[k] = {c, 1};
            return true;
        }
        return false;
    }

    /// Corners are one vertex where curves or poles connect them, not where they merely coincide.
    void find_vertices() {
        const int n = 4 * model.num_patches();
        DisjointSets sets(n);
        for (const ModelCurve& curve : model.curves_) {
            const std::array<int, 2> a = end_corners(curve.uses[0]);
            if (curve.kind == CurveKind::Pole) sets.unite(a[0], a[1]);
            if (curve.uses.size() == 2) {
                const std::array<int, 2> b = end_corners(curve.uses[1]);
                sets.unite(a[0], b[0]);
                sets.unite(a[1], b[1]);
            }
        }
        model.corner_vertices_.assign(n, -1);
        for (int k = 0; k < n; ++k) {
            const int root = sets.find(k);
            const ParametricSurface& patch = model.patch(k / 4);
            const SurfacePoint place{k / 4, corner_uv(patch.domain(), k % 4)};
            if (root == k) {
                model.corner_vertices_[k] = static_cast<int>(model.vertices_.size());
                model.vertices_.push_back({patch.position(place.uv), {}, false});
            }
            model.corner_vertices_[k] = model.corner_vertices_[root];
            model.vertices_[model.corner_vertices_[k]].places.push_back(place);
        }
        for (ModelCurve& curve : model.curves_) {
            const std::array<int, 2> corners = end_corners(curve.uses[0]);
            curve.ends = {model.corner_vertices_[corners[0]], model.corner_vertices_[corners[1]]};
            if (curve.kind == CurveKind::Pole) model.vertices_[curve.ends[0]].pole = true;
        }
    }

    /// Spreads the first patch's orientation over each component.
    void orient() {
        model.flipped_.assign(model.num_patches(), 0);
        model.component_.assign(model.num_patches(), -1);
        for (int seed = 0; seed < model.num_patches(); ++seed) {
            if (model.component_[seed] >= 0) continue;
            std::vector<int> members{seed};
            model.component_[seed] = model.num_components_;
            for (std::size_t next = 0; next < members.size(); ++next)
                for (int s = 0; s < 4; ++s)
                    spread_across(model.side_curves_[4 * members[next] + s].curve, members[next], members);
            turn_outward(members);
            ++model.num_components_;
        }
    }

    void spread_across(int c, int from, std::vector<int>& members) {
        const ModelCurve& curve = model.curves_[c];
        if (curve.uses.size() != 2) return;
        const int to = curve.uses[0].patch == from ? curve.uses[1].patch : curve.uses[0].patch;
        // Neighbours agree when the curve runs around them in opposite senses.
        const bool opposite = runs_counter_clockwise(curve.uses[0]) != runs_counter_clockwise(curve.uses[1]);
        const char wanted = opposite ? model.flipped_[from] : !model.flipped_[from];
        if (model.component_[to] < 0) {
            model.component_[to] = model.num_components_;
            model.flipped_[to] = wanted;
            members.push_back(to);
        } else if (model.flipped_[to] != wanted) {
            throw std::invalid_argument("PatchModel: one-sided surface, no orientation agrees across curve " +
                                        std::to_string(c) + ": " + describe(curve.uses[0]) + " and " +
                                        describe(curve.uses[1]));
        }
    }

    /// Turns a component over if it encloses a negative volume, once its boundary loops are capped by cones over their
    /// centres.
    void turn_outward(const std::vector<int>& members) {
        const Vector3d apex = model.vertices_[model.corner_vertices_[4 * members[0]]].point;
        double area = 0, volume = 0, cap_area = 0;
        for (const int i : members) {
            const PatchIntegrals part = integrate(model.patch(i), apex, pieces());
            area += part.area;
            volume += model.flipped_[i] ? -part.volume : part.volume;
        }
        for (const std::vector<int>& loop : boundary_loops(members)) add_cap(loop, apex, volume, cap_area);
        const double smallest_volume = 1e-6 * std::pow(area, 1.5);  // less is flat, whatever its sign
        if (cap_area > largest_cap * area || std::abs(volume) < smallest_volume || volume > 0) return;
        for (const int i : members) model.flipped_[i] = !model.flipped_[i];
    }

    /// Boundary curves of a component, grouped by the vertices they meet at.
    std::vector<std::vector<int>> boundary_loops(const std::vector<int>& members) const {
        std::vector<int> boundary;
        for (const int i : members)
            for (int s = 0; s < 4; ++s)
                if (const int c = model.side_curves_[4 * i + s].curve; model.curves_[c].kind == CurveKind::Boundary)
                    boundary.push_back(c);
        std::map<int, int> curve_at;  // vertex to position in `boundary`
        DisjointSets sets(static_cast<int>(boundary.size()));
        for (int k = 0; k < static_cast<int>(boundary.size()); ++k)
            for (const int vertex : model.curves_[boundary[k]].ends)
                sets.unite(k, curve_at.emplace(vertex, k).first->second);
        std::map<int, std::vector<int>> loops;
        for (int k = 0; k < static_cast<int>(boundary.size()); ++k) loops[sets.find(k)].push_back(boundary[k]);
        std::vector<std::vector<int>> result;
        for (auto& [root, loop] : loops) result.push_back(std::move(loop));
        return result;
    }

    void add_cap(const std::vector<int>& loop, const Vector3d& apex, double& volume, double& cap_area) const {
        Vector3d centre = Vector3d::Zero();
        double length = 0;
        for_each_boundary_piece(loop, [&](const Vector3d& a, const Vector3d& b) {
            centre += (b - a).norm() * (a + b) / 2;
            length += (b - a).norm();
        });
        if (!(length > 0)) return;
        centre /= length;
        for_each_boundary_piece(loop, [&](const Vector3d& a, const Vector3d& b) {
            const Vector3d twice_area = (a - centre).cross(b - centre);
            cap_area += twice_area.norm() / 2;
            volume -= (centre - apex).dot(twice_area) / 6;  // the cap runs against the surface's boundary
        });
    }

    /// Calls visit(a, b) on pieces of the boundary curves, surface on the left seen from its outside.
    template <class Visit>
    void for_each_boundary_piece(const std::vector<int>& loop, const Visit& visit) const {
        for (const int c : loop) {
            const SideUse& use = model.curves_[c].uses[0];
            const SideTrace curve{&model.patch(use.patch), use.side};
            const bool forward = runs_counter_clockwise(use) != static_cast<bool>(model.flipped_[use.patch]);
            for (int k = 0; k < side_pieces; ++k) {
                const Vector3d a = curve.point(static_cast<double>(k) / side_pieces),
                               b = curve.point((k + 1.0) / side_pieces);
                forward ? visit(a, b) : visit(b, a);
            }
        }
    }

    void classify_curves() {
        for (int c = 0; c < static_cast<int>(model.curves_.size()); ++c) {
            ModelCurve& curve = model.curves_[c];
            if (curve.uses.size() != 2) continue;
            for (int k = 0; k <= side_pieces; ++k) {
                const double t = static_cast<double>(k) / side_pieces;
                curve.largest_angle = std::max(
                    curve.largest_angle,
                    angle_between(model.normal(model.on_curve(c, 0, t)), model.normal(model.on_curve(c, 1, t))));
            }
            curve.kind = curve.largest_angle >= options.crease_angle ? CurveKind::Crease : CurveKind::Smooth;
        }
    }
};

PatchModel::PatchModel(std::vector<std::unique_ptr<const ParametricSurface>> patches, const GlueOptions& options)
    : patches_(std::move(patches)) {
    Builder builder{*this, options};
    builder.check_options();
    builder.check_patches();
    builder.glue();
    builder.find_vertices();
    builder.orient();
    builder.classify_curves();
}

// -- Queries
// -------------------------------------------------------------------------------------------------------------------

SurfacePoint PatchModel::on_curve(int curve, int use, double t) const {
    const SideUse& at = curves_[curve].uses[use];
    // Rounded so that 1 - t is exact, too: both uses are then evaluated at the same places to the bit.
    double s = 1 - (1 - t);
    if (use == 1 && !curves_[curve].same_parameter)
        s = follow_match(curve, 0, s);
    else if (at.reversed)
        s = 1 - s;
    return {at.patch, side_uv(patch(at.patch).domain(), at.side, s)};
}

double PatchModel::curve_parameter(int patch, Side side, double s) const {
    const SideCurve at = side_curve(patch, side);
    const ModelCurve& curve = curves_[at.curve];
    if (at.use == 1 && !curve.same_parameter) return follow_match(at.curve, 1, s);
    return curve.uses[at.use].reversed ? 1 - s : s;
}

double PatchModel::follow_match(int curve, int use, double s) const {
    if (s <= 0 || s >= 1) return curves_[curve].uses[1].reversed == (s <= 0) ? 1 : 0;
    const SideUse& from = curves_[curve].uses[use];
    const SideUse& to = curves_[curve].uses[1 - use];
    const std::vector<double>& table = matches_[curve];
    // The piece of the first side that holds s, or whose image on the second side does.
    int k = 0;
    if (use == 0) {
        k = std::min(static_cast<int>(s * side_pieces), side_pieces - 1);
    } else {
        const bool reversed = to.reversed != from.reversed;
        while (k < side_pieces - 1 && (reversed ? table[k + 1] > s : table[k + 1] < s)) ++k;
    }
    const double a = use == 0 ? table[k] : static_cast<double>(k) / side_pieces;
    const double b = use == 0 ? table[k + 1] : (k + 1.0) / side_pieces;
    const Vector3d p = SideTrace{&patch(from.patch), from.side}.point(s);
    return closest_between({&patch(to.patch), to.side}, p, std::min(a, b), std::max(a, b));
}

Eigen::Vector3d PatchModel::normal(const SurfacePoint& at) const {
    const Vector3d n = unit_normal(patch(at.patch), at.uv);
    return flipped(at.patch) ? Vector3d(-n) : n;
}

}  // namespace gradus

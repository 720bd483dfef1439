#include "gradus/surface/surface_model.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include "../assert.hpp"
#include "../mesh/disjoint_sets.hpp"
#include "border.hpp"
#include "gradus/surface/unit_normal.hpp"
#include "trace.hpp"

namespace gradus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// A component whose boundary can be capped by less than this share of its own area encloses a volume worth speaking of.
constexpr double largest_cap = 0.75;

double angle_between(const Vector3d& a, const Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

/// A curve of a model in space.
struct CurveTrace {
    const SurfaceModel& model;
    int curve;

    Vector3d point(double t) const { return model.curve_point(curve, t); }
    Vector3d derivative(double t) const { return model.curve_jet(curve, t).d; }
};

struct PatchIntegrals {
    double area = 0;
    double volume = 0;  ///< of the cone from a given apex over the patch, signed by S_u x S_v
};

/// Gauss's rule on unit intervals one after the other: with five points on each, or with two.
struct GaussRule {
    bool coarse;

    int size() const { return coarse ? 2 : 5; }
    double place(int k) const {
        const int piece = k / size();
        return piece + (coarse ? 0.5 + (k % 2 - 0.5) / std::sqrt(3.0) : gauss_points[k % 5]);
    }
    double weight(int k) const { return coarse ? 0.5 : gauss_weights[k % 5]; }
};

std::string name_of_curve(int curve) { return "curve " + std::to_string(curve); }

}  // namespace

// -- Construction
// --------------------------------------------------------------------------------------------------------------

/// The steps of the constructor, in order.
struct SurfaceModel::Builder {
    SurfaceModel& model;
    const ModelOptions& options;
    std::vector<CurveEnd> tips;
    std::vector<char> kind_given;  // of each curve
    double tolerance = 0;          // absolute
    Vector3d apex{0, 0, 0};
    std::vector<PatchIntegrals> integrals = {};  // of each patch, volumes from the apex

    std::string name_of_patch(int patch) const {
        const std::string& given = model.patches_[patch].name;
        return given.empty() ? "patch " + std::to_string(patch) : given;
    }
    int num_curves() const { return static_cast<int>(model.curves_.size()); }
    bool has_many() const { return model.num_patches() > SurfaceModel::kMany; }
    /// Pieces that curves are sampled at, and that a patch is integrated by in each direction.
    int samples() const { return has_many() ? 4 : curve_pieces; }
    int pieces() const { return has_many() ? 1 : 3; }

    void check_options() const {
        if (!(options.tolerance > 0)) throw std::invalid_argument("tolerance must be positive");
        if (!(options.crease_angle >= 0)) throw std::invalid_argument("crease_angle must not be negative");
    }

    void take_curves(std::vector<Topology::Curve> curves) {
        for (Topology::Curve& given : curves) {
            ModelCurve& curve = model.curves_.emplace_back();
            curve.uses = std::move(given.uses);
            curve.kind = given.kind.value_or(curve.uses.size() == 2 ? CurveKind::Smooth : CurveKind::Boundary);
            kind_given.push_back(given.kind.has_value());
            if (curve.uses.empty() || curve.uses.size() > 2)
                throw std::invalid_argument(name_of_curve(num_curves() - 1) + " has " +
                                            std::to_string(curve.uses.size()) + " uses");
        }
    }

    /// Every use is in one loop, that of its patch.
    void check_loops() const {
        std::vector<std::array<int, 2>> seen(num_curves(), {0, 0});
        for (int p = 0; p < model.num_patches(); ++p) {
            if (!model.patches_[p].surface) throw std::invalid_argument(name_of_patch(p) + " is null");
            for (const std::vector<UseRef>& loop : model.loops(p))
                for (const UseRef& ref : loop) {
                    const bool known = ref.curve >= 0 && ref.curve < num_curves() && ref.use >= 0 &&
                                       ref.use < std::ssize(model.curves_[ref.curve].uses);
                    if (!known || model.use(ref).patch != p || ++seen[ref.curve][ref.use] > 1)
                        throw std::invalid_argument("a loop of " + name_of_patch(p) + " names " +
                                                    name_of_curve(ref.curve) + ", which it does not have there");
                }
        }
        for (int c = 0; c < num_curves(); ++c)
            for (std::size_t use = 0; use < model.curves_[c].uses.size(); ++use)
                if (seen[c][use] == 0) throw std::invalid_argument(name_of_curve(c) + " has a use in no loop");
    }

    void bound() {
        model.borders_.reserve(model.patches_.size());
        for (const Topology::Patch& patch : model.patches_) model.borders_.emplace_back(patch.loops, model.curves_);
    }

    /// Samples each patch: numbers must be finite, the area positive. Sets the diagonal.
    void check_patches() {
        Eigen::AlignedBox3d all;
        for (int i = 0; i < model.num_patches(); ++i) {
            const Eigen::AlignedBox3d here = box_of_samples(i);
            if (i == 0 && !here.isEmpty()) apex = here.min();
            integrals.push_back(here.isEmpty() ? PatchIntegrals{} : integrate(i));
            const double area = integrals.back().area;
            // Collinear points leave an area of rounding errors, some 1e-16 of the square of the size.
            const double rounding = 1e-13 * here.diagonal().squaredNorm();
            if (area < -rounding)
                throw std::invalid_argument("loops of " + name_of_patch(i) + " have it on their right");
            if (!(area > rounding)) throw std::invalid_argument(name_of_patch(i) + " has zero area");
            model.areas_.push_back(area);
            all.extend(here);
        }
        if (model.num_patches() == 0) return;
        model.diagonal_ = all.diagonal().norm();
        tolerance = options.tolerance * model.diagonal_;
    }

    Eigen::AlignedBox3d box_of_samples(int i) const {
        Eigen::AlignedBox3d result;
        for (const Vector2d& uv : model.samples(i, has_many() ? 2 : 8, samples())) result.extend(finite_point(i, uv));
        return result;
    }

    Vector3d finite_point(int patch, const Vector2d& uv) const {
        const Jet1 jet = model.patch(patch).jet1(uv);
        if (!jet.p.allFinite() || !jet.du.allFinite() || !jet.dv.allFinite())
            throw std::invalid_argument(name_of_patch(patch) + " has values that are not finite");
        return jet.p;
    }

    /// By Green's theorem: the integral of f is that of F dv around the loops, F that of f along u up to them.
    PatchIntegrals integrate(int patch) const {
        const ParametricSurface& surface = model.patch(patch);
        const double u0 = model.borders_[patch].box().min().x();
        const GaussRule rule{has_many()};
        const auto along_u = [&](const Vector2d& to) {
            PatchIntegrals sum;
            const double width = (to.x() - u0) / pieces();
            for (int a = 0; a < rule.size() * pieces() && width > 0; ++a) {
                const Jet1 jet = surface.jet1({u0 + width * rule.place(a), to.y()});
                const Vector3d n = jet.du.cross(jet.dv);
                sum.area += rule.weight(a) * width * n.norm();
                sum.volume += rule.weight(a) * width * (jet.p - apex).dot(n) / 3;
            }
            return sum;
        };
        PatchIntegrals result;
        for (const std::vector<UseRef>& loop : model.loops(patch))
            for (const UseRef& ref : loop) {
                const CurveUse& use = model.use(ref);
                const int steps = use.image->is_straight() ? pieces() : samples();
                for (int b = 0; b < rule.size() * steps; ++b) {
                    const double t = rule.place(b) / steps, dv = use.image->duv(t).y();
                    if (dv == 0) continue;
                    const PatchIntegrals row = along_u(use.image->uv(t));
                    const double weight = rule.weight(b) / steps * (use.reversed ? -dv : dv);
                    result.area += weight * row.area;
                    result.volume += weight * row.volume;
                }
            }
        return result;
    }

    /// Of many curves that of two chords.
    double length_of_curve(int c) const {
        if (!has_many()) return length_of(CurveTrace{model, c});
        const Vector3d middle = model.curve_point(c, 0.5);
        return (model.curve_point(c, 0) - middle).norm() + (model.curve_point(c, 1) - middle).norm();
    }

    void measure_lengths() {
        for (int c = 0; c < num_curves(); ++c)
            if (model.curves_[c].kind != CurveKind::Pole) model.curves_[c].length = length_of_curve(c);
    }

    /// Ends are one vertex where loops pass from one to the other, not where they merely coincide.
    void find_vertices() {
        const auto entry = [&](const UseRef& ref) { return 2 * ref.curve + model.use(ref).reversed; };
        const auto leave = [&](const UseRef& ref) { return 2 * ref.curve + !model.use(ref).reversed; };
        DisjointSets sets(2 * num_curves());
        for (int c = 0; c < num_curves(); ++c)
            if (model.curves_[c].kind == CurveKind::Pole) sets.unite(2 * c, 2 * c + 1);
        for (const Topology::Patch& patch : model.patches_)
            for (const std::vector<UseRef>& loop : patch.loops)
                for (std::size_t k = 0; k < loop.size(); ++k)
                    sets.unite(leave(loop[k]), entry(loop[(k + 1) % loop.size()]));
        std::vector<int> vertex_of(2 * num_curves(), -1);
        for (int p = 0; p < model.num_patches(); ++p)
            for (const std::vector<UseRef>& loop : model.loops(p))
                for (const UseRef& ref : loop) {
                    const SurfacePoint place{p, model.use(ref).image->uv(model.use(ref).reversed ? 1 : 0)};
                    int& vertex = vertex_of[sets.find(entry(ref))];
                    if (vertex < 0) {
                        vertex = static_cast<int>(model.vertices_.size());
                        model.vertices_.push_back({model.position(place)});
                    }
                    model.vertices_[vertex].places.push_back(place);
                }
        for (int c = 0; c < num_curves(); ++c) {
            ModelCurve& curve = model.curves_[c];
            curve.ends = {vertex_of[sets.find(2 * c)], vertex_of[sets.find(2 * c + 1)]};
            if (curve.kind == CurveKind::Pole) model.vertices_[curve.ends[0]].pole = true;
        }
        for (const CurveEnd& tip : tips) model.vertices_[model.curves_[tip.curve].ends[tip.at_end]].tip = true;
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
                for (const std::vector<UseRef>& loop : model.loops(members[next]))
                    for (const UseRef& ref : loop) spread_across(ref.curve, members[next], members);
            turn_outward(members);
            ++model.num_components_;
        }
    }

    void spread_across(int c, int from, std::vector<int>& members) {
        const ModelCurve& curve = model.curves_[c];
        if (curve.uses.size() != 2) return;
        const int to = curve.uses[0].patch == from ? curve.uses[1].patch : curve.uses[0].patch;
        // Neighbours agree when the curve runs around them in opposite senses.
        const bool opposite = curve.uses[0].reversed != curve.uses[1].reversed;
        const char wanted = opposite ? model.flipped_[from] : !model.flipped_[from];
        if (model.component_[to] < 0) {
            model.component_[to] = model.num_components_;
            model.flipped_[to] = wanted;
            members.push_back(to);
        } else if (model.flipped_[to] != wanted) {
            throw std::invalid_argument("one-sided surface, no orientation agrees across " + name_of_curve(c) +
                                        " between " + name_of_patch(curve.uses[0].patch) + " and " +
                                        name_of_patch(curve.uses[1].patch));
        }
    }

    /// Turns a component over if it encloses a negative volume, once its boundary loops are capped by cones over their
    /// centres.
    void turn_outward(const std::vector<int>& members) {
        double area = 0, volume = 0, cap_area = 0;
        for (const int i : members) {
            area += integrals[i].area;
            volume += model.flipped_[i] ? -integrals[i].volume : integrals[i].volume;
        }
        for (const std::vector<int>& loop : boundary_loops(members)) add_cap(loop, volume, cap_area);
        const double smallest_volume = 1e-6 * std::pow(area, 1.5);  // less is flat, whatever its sign
        if (cap_area > largest_cap * area || std::abs(volume) < smallest_volume || volume > 0) return;
        for (const int i : members) model.flipped_[i] = !model.flipped_[i];
    }

    /// Boundary curves of a component, grouped by the vertices they meet at.
    std::vector<std::vector<int>> boundary_loops(const std::vector<int>& members) const {
        std::vector<int> boundary;
        for (const int i : members)
            for (const std::vector<UseRef>& loop : model.loops(i))
                for (const UseRef& ref : loop)
                    if (model.curves_[ref.curve].kind == CurveKind::Boundary) boundary.push_back(ref.curve);
        std::map<int, int> curve_at;  // vertex to position in `boundary`
        DisjointSets sets(boundary.size());
        for (int k = 0; k < std::ssize(boundary); ++k)
            for (const int vertex : model.curves_[boundary[k]].ends)
                sets.unite(k, curve_at.emplace(vertex, k).first->second);
        std::map<int, std::vector<int>> loops;
        for (int k = 0; k < std::ssize(boundary); ++k) loops[sets.find(k)].push_back(boundary[k]);
        std::vector<std::vector<int>> result;
        for (auto& [root, loop] : loops) result.push_back(std::move(loop));
        return result;
    }

    void add_cap(const std::vector<int>& loop, double& volume, double& cap_area) const {
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
            const CurveUse& use = model.curves_[c].uses[0];
            const bool forward = use.reversed == static_cast<bool>(model.flipped_[use.patch]);
            for (int k = 0; k < samples(); ++k) {
                const Vector3d a = model.curve_point(c, static_cast<double>(k) / samples()),
                               b = model.curve_point(c, (k + 1.0) / samples());
                forward ? visit(a, b) : visit(b, a);
            }
        }
    }

    void classify_curves() {
        for (int c = 0; c < num_curves(); ++c) {
            ModelCurve& curve = model.curves_[c];
            if (curve.uses.size() != 2 || kind_given[c]) continue;
            for (int k = 0; k <= samples(); ++k) {
                const double t = static_cast<double>(k) / samples();
                curve.largest_angle = std::max(
                    curve.largest_angle,
                    angle_between(model.normal(model.on_curve(c, 0, t)), model.normal(model.on_curve(c, 1, t))));
            }
            curve.kind = curve.largest_angle >= options.crease_angle ? CurveKind::Crease : CurveKind::Smooth;
        }
    }

    /// Ends of curves are where the vertices are, on every use.
    void check_ends() const {
        for (int c = 0; c < num_curves(); ++c)
            for (int use = 0; use < std::ssize(model.curves_[c].uses); ++use)
                for (const int end : {0, 1}) {
                    const Vector3d& vertex = model.vertices_[model.curves_[c].ends[end]].point;
                    // Two uses and the loops on either side may each be off by the tolerance.
                    if (!((model.position(model.on_curve(c, use, end)) - vertex).norm() <= 4 * tolerance))
                        throw std::invalid_argument(name_of_curve(c) + " does not end where the next curve of " +
                                                    name_of_patch(model.curves_[c].uses[use].patch) + " begins");
                }
    }
};

SurfaceModel::SurfaceModel(Topology topology, const ModelOptions& options) : patches_(std::move(topology.patches)) {
    Builder builder{*this, options, std::move(topology.tips), {}};
    builder.check_options();
    builder.take_curves(std::move(topology.curves));
    builder.check_loops();
    builder.bound();
    builder.check_patches();
    builder.measure_lengths();
    builder.find_vertices();
    builder.check_ends();
    builder.orient();
    builder.classify_curves();
}

SurfaceModel::SurfaceModel(SurfaceModel&&) noexcept = default;
SurfaceModel& SurfaceModel::operator=(SurfaceModel&&) noexcept = default;
SurfaceModel::~SurfaceModel() = default;

// -- Queries
// -------------------------------------------------------------------------------------------------------------------

SurfacePoint SurfaceModel::on_curve(int curve, int use, double t) const {
    GRADUS_ASSERT(t >= 0 && t <= 1);
    const CurveUse& at = curves_[curve].uses[use];
    // Rounded so that 1 - t is exact, too: images that run in opposite directions are then evaluated at the same places
    // to the bit.
    return {at.patch, at.image->uv(1 - (1 - t))};
}

Vector3d SurfaceModel::curve_point(int curve, double t) const { return position(on_curve(curve, 0, t)); }

CurveJet SurfaceModel::curve_jet(int curve, double t) const {
    const SurfacePoint at = on_curve(curve, 0, t);
    const Jet1 jet = patch(at.patch).jet1(at.uv);
    const Vector2d along = curves_[curve].uses[0].image->duv(t);
    return {jet.p, jet.du * along.x() + jet.dv * along.y()};
}

CurveJet2 SurfaceModel::curve_jet2(int curve, double t) const {
    const SurfacePoint at = on_curve(curve, 0, t);
    const Jet2 jet = patch(at.patch).jet2(at.uv);
    const Vector2d a = curves_[curve].uses[0].image->duv(t), b = curves_[curve].uses[0].image->dduv(t);
    return {jet.p, jet.du * a.x() + jet.dv * a.y(),
            jet.duu * (a.x() * a.x()) + jet.duv * (2 * a.x() * a.y()) + jet.dvv * (a.y() * a.y()) + jet.du * b.x() +
                jet.dv * b.y()};
}

std::optional<SurfaceModel::Exit> SurfaceModel::exit(const SurfacePoint& from, const Vector2d& step) const {
    return borders_[from.patch].exit(from.uv, step);
}

std::vector<SurfaceModel::OnBorder> SurfaceModel::border_at(const SurfacePoint& at, double tolerance) const {
    return borders_[at.patch].touching(at.uv, tolerance);
}

bool SurfaceModel::contains(const SurfacePoint& at) const { return borders_[at.patch].contains(at.uv); }

std::vector<Vector2d> SurfaceModel::samples(int patch, int intervals, int per_curve) const {
    const Border& border = borders_[patch];
    const Vector2d &low = border.box().min(), &high = border.box().max();
    std::vector<Vector2d> result;
    bool fills_its_box = true;
    for (int b = 0; b <= intervals; ++b)
        for (int a = 0; a <= intervals; ++a) {
            const Vector2d uv(interpolate(low.x(), high.x(), static_cast<double>(a) / intervals),
                              interpolate(low.y(), high.y(), static_cast<double>(b) / intervals));
            if (border.contains(uv))
                result.push_back(uv);
            else
                fills_its_box = false;
        }
    if (fills_its_box) return result;
    for (const std::vector<UseRef>& loop : loops(patch))
        for (const auto& [curve, use] : loop)
            for (int k = 0; k < per_curve; ++k)
                result.push_back(on_curve(curve, use, static_cast<double>(k) / per_curve).uv);
    return result;
}

Vector3d SurfaceModel::normal(const SurfacePoint& at) const {
    const Vector3d n = unit_normal(patch(at.patch), at.uv);
    return flipped(at.patch) ? Vector3d(-n) : n;
}

}  // namespace gradus

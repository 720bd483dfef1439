#include "gradus/remesh/support.hpp"

#include "../assert.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace gradus {

namespace {

constexpr int kMostSteps = 8;        // Newton steps and crossings of patch borders of one move
constexpr double kNear2 = 1e-2;      // squared: a tenth of the way is near enough
constexpr double kSingular = 1e-12;  // sin^2 of the angle between S_u and S_v below which the parameters are singular

constexpr double kStraight = 0.966;  // cosine of 15 degrees: curves that meet within it continue each other

}  // namespace

void between_sides(const Eigen::Vector3d& a, const Eigen::Vector3d& b, Foot& foot) {
    const Eigen::Vector3d sum = a + b;
    const double length = sum.norm();
    foot.normal = length > 0 ? Eigen::Vector3d(sum / length) : a;
    foot.lean = length / 2;
}

Foot PatchSupport::foot(const Place& place) const {
    GRADUS_ASSERT(place.curve < 0 || (place.t >= 0 && place.t <= 1));
    Foot foot{place, model_.position(place.at), model_.normal(place.at)};
    if (place.curve >= 0 && model_.curves()[place.curve].kind == CurveKind::Crease)
        between_sides(model_.normal(model_.on_curve(place.curve, 0, place.t)),
                      model_.normal(model_.on_curve(place.curve, 1, place.t)), foot);
    return foot;
}

std::optional<Foot> PatchSupport::move(const Place& from, const Eigen::Vector3d& /*point*/,
                                       const Eigen::Vector3d& target) const {
    SurfacePoint at = from.at;
    const ParametricSurface* patch = &model_.patch(at.patch);
    Jet1 jet = patch->jet1(at.uv);
    const double goal2 = (target - jet.p).squaredNorm();
    bool arrived = false;
    for (int step = 0; step < kMostSteps; ++step) {
        const Eigen::Vector3d r = target - jet.p;
        const double E = jet.du.squaredNorm(), F = jet.du.dot(jet.dv), G = jet.dv.squaredNorm();
        const double det = E * G - F * F;
        if (!(det > kSingular * E * G)) return std::nullopt;
        const double a = jet.du.dot(r), b = jet.dv.dot(r);
        const Eigen::Vector2d d{(G * a - F * b) / det, (E * b - F * a) / det};
        if (step > 0 && a * d.x() + b * d.y() <= kNear2 * goal2) {
            arrived = true;
            break;
        }
        const std::optional<SurfaceModel::Exit> exit = model_.exit(at, d);
        if (!exit) {
            at.uv += d;
            jet = patch->jet1(at.uv);
            continue;
        }
        const auto [curve, use] = exit->use;
        if (model_.curves()[curve].kind != CurveKind::Smooth) return std::nullopt;
        at = model_.on_curve(curve, 1 - use, exit->t);
        patch = &model_.patch(at.patch);
        jet = patch->jet1(at.uv);
    }
    if (!arrived) return std::nullopt;
    Foot foot{{at, -1, 0, from.cell}, jet.p, jet.du.cross(jet.dv)};
    const double length = foot.normal.norm();
    if (!(length > 0)) return std::nullopt;
    foot.normal /= model_.flipped(at.patch) ? -length : length;
    return foot;
}

// Unit tangent of a curve that leaves its start, or its end.
Eigen::Vector3d PatchSupport::leaving(int curve, bool from_end) const {
    const Eigen::Vector3d along = model_.curve_jet(curve, from_end ? 1 : 0).d.stableNormalized();
    return from_end ? Eigen::Vector3d(-along) : along;
}

PatchSupport::PatchSupport(const SurfaceModel& model)
    : model_(model), links_(model.curves().size()), junctions_(model.vertices().size()) {
    link_curves();
}

void PatchSupport::link_curves() {
    using End = CurveEnd;
    const auto& curves = model_.curves();
    std::vector<std::vector<End>> ends(model_.vertices().size());
    for (int c = 0; c < static_cast<int>(curves.size()); ++c)
        if (is_feature(curves[c].kind))
            for (const bool at_end : {false, true}) ends[curves[c].ends[at_end]].push_back({c, at_end});
    for (std::size_t v = 0; v < ends.size(); ++v) {
        if (ends[v].size() != 2 || model_.vertices()[v].pole || model_.vertices()[v].tip) continue;
        const auto [a, b] = std::pair(ends[v][0], ends[v][1]);
        const bool straight = leaving(a.curve, a.at_end).dot(leaving(b.curve, b.at_end)) < -kStraight;
        if (straight && curves[a.curve].kind == curves[b.curve].kind) junctions_[v] = a;
    }
    // From each curve that is in no chain yet: back to the start of its chain, or once around, then forward.
    const auto beyond = [&](End out) -> std::optional<End> {
        const int v = curves[out.curve].ends[out.at_end];
        if (junctions_[v].curve < 0) return std::nullopt;
        const End& first = ends[v][0];
        return first.curve == out.curve && first.at_end == out.at_end ? ends[v][1] : first;
    };
    for (int c = 0; c < static_cast<int>(curves.size()); ++c) {
        if (!is_feature(curves[c].kind) || links_[c].chain >= 0) continue;
        End start{c, false};  // the end at which the chain enters its first curve
        Chain chain;
        while (const auto before = beyond(start)) {
            start = {before->curve, !before->at_end};
            if (start.curve == c && !start.at_end) {
                chain.closed = true;
                break;
            }
        }
        const int number = static_cast<int>(chains_.size());
        for (std::optional<End> in = start; in && links_[in->curve].chain < 0; in = beyond({in->curve, !in->at_end})) {
            links_[in->curve] = {number, static_cast<int>(chain.curves.size()), in->at_end};
            chain.curves.push_back(in->curve);
        }
        chains_.push_back(std::move(chain));
    }
}

std::optional<Place> PatchSupport::junction(int model_vertex) const {
    const auto [curve, at_end] = junctions_[model_vertex];
    if (curve < 0) return std::nullopt;
    const double t = at_end ? 1 : 0;
    return Place{model_.on_curve(curve, 0, t), curve, t};
}

double PatchSupport::chain_parameter(const Place& place) const {
    const Link& link = links_[place.curve];
    return link.position + (link.reversed ? 1 - place.t : place.t);
}

Place PatchSupport::on_chain(int chain, double t, int cell) const {
    const auto n = static_cast<int>(chains_[chain].curves.size());
    if (chains_[chain].closed) t -= n * std::floor(t / n);
    const int position = std::clamp(static_cast<int>(t), 0, n - 1);
    const int curve = chains_[chain].curves[position];
    const double s = std::clamp(t - position, 0.0, 1.0), on_curve = links_[curve].reversed ? 1 - s : s;
    return {model_.on_curve(curve, 0, on_curve), curve, on_curve, cell};
}

std::optional<Foot> PatchSupport::slide(const Place& from, const Eigen::Vector3d& target) const {
    const int chain = links_[from.curve].chain;
    const double last = static_cast<double>(chains_[chain].curves.size());
    Place place = from;
    for (int step = 0; step < 2; ++step) {
        const CurveJet jet = model_.curve_jet(place.curve, place.t);
        const double speed2 = jet.d.squaredNorm();
        if (!(speed2 > 0)) return std::nullopt;
        const double forward = std::clamp(jet.d.dot(target - jet.p) / speed2, -0.5, 0.5);
        const double t = chain_parameter(place) + (links_[place.curve].reversed ? -forward : forward);
        if (!chains_[chain].closed && !(t > 0 && t < last)) return std::nullopt;
        place = on_chain(chain, t, from.cell);
    }
    return foot(place);
}

Foot PatchSupport::middle(int chain, const Foot& a, const Foot& b) const {
    const double n = static_cast<double>(chains_[chain].curves.size());
    const bool a_inside = a.place.curve >= 0, b_inside = b.place.curve >= 0;
    // An end of an open chain; where the chain returns to its start, the end that is nearer along it.
    const auto end_near = [&](const Foot& corner, double other) {
        const Eigen::Vector3d first = model_.position(on_chain(chain, 0, 0).at),
                              last = model_.position(on_chain(chain, n, 0).at);
        if ((first - last).norm() <= 1e-9 * model_.diagonal()) return other > n / 2 ? n : 0.0;
        return (corner.point - first).squaredNorm() < (corner.point - last).squaredNorm() ? 0.0 : n;
    };
    double ta = a_inside ? chain_parameter(a.place) : 0, tb = b_inside ? chain_parameter(b.place) : 0;
    if (!a_inside) ta = end_near(a, tb);
    if (!b_inside) tb = end_near(b, ta);
    if (chains_[chain].closed && tb - ta > n / 2) tb -= n;
    if (chains_[chain].closed && ta - tb > n / 2) ta -= n;
    return foot(on_chain(chain, (ta + tb) / 2, a.place.cell));
}

}  // namespace gradus

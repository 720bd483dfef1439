#include "gradus/remesh/support.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace gradus {

namespace {

constexpr int kMostSteps = 8;        // Newton steps and crossings of patch borders of one move
constexpr double kNear2 = 1e-2;      // squared: a tenth of the way is near enough
constexpr double kSingular = 1e-12;  // sin^2 of the angle between S_u and S_v below which the parameters are singular

struct Exit {
    double fraction = 1;  // of the step, at which the domain is left
    Side side = Side::Bottom;
    bool leaves = false;
};

Exit exit_of(const Domain& domain, const Eigen::Vector2d& uv, const Eigen::Vector2d& d) {
    Exit exit;
    const auto cut = [&](double room, double step, Side side) {
        if (step > room && room < exit.fraction * step) exit = {std::max(0.0, room) / step, side, true};
    };
    cut(domain.max.x() - uv.x(), d.x(), Side::Right);
    cut(uv.x() - domain.min.x(), -d.x(), Side::Left);
    cut(domain.max.y() - uv.y(), d.y(), Side::Top);
    cut(uv.y() - domain.min.y(), -d.y(), Side::Bottom);
    return exit;
}

bool along_u(Side side) { return side == Side::Bottom || side == Side::Top; }

}  // namespace

Foot PatchSupport::foot(Place place) const {
    Foot foot{place, model_.position(place.at), model_.normal(place.at), 0};
    foot.size = control_.size(foot.point, foot.place.cell);
    return foot;
}

std::optional<Foot> PatchSupport::move(const Place& from, const Eigen::Vector3d& target) const {
    SurfacePoint at = from.at;
    const ParametricSurface* patch = &model_.patch(at.patch);
    Jet1 jet = patch->jet1(at.uv);
    const double goal2 = (target - jet.p).squaredNorm();
    for (int step = 0; step < kMostSteps; ++step) {
        const Eigen::Vector3d r = target - jet.p;
        const double E = jet.du.squaredNorm(), F = jet.du.dot(jet.dv), G = jet.dv.squaredNorm();
        const double det = E * G - F * F;
        if (!(det > kSingular * E * G)) return std::nullopt;
        const double a = jet.du.dot(r), b = jet.dv.dot(r);
        const Eigen::Vector2d d{(G * a - F * b) / det, (E * b - F * a) / det};
        if (step > 0 && a * d.x() + b * d.y() <= kNear2 * goal2) break;
        const Domain domain = patch->domain();
        const Exit exit = exit_of(domain, at.uv, d);
        if (!exit.leaves) {
            at.uv += d;
            jet = patch->jet1(at.uv);
            continue;
        }
        const auto [curve, use] = model_.side_curve(at.patch, exit.side);
        if (model_.curves()[curve].kind != CurveKind::Smooth) return std::nullopt;
        const Eigen::Vector2d border = at.uv + exit.fraction * d;
        const int axis = along_u(exit.side) ? 0 : 1;
        const double s = std::clamp((border[axis] - domain.min[axis]) / (domain.max[axis] - domain.min[axis]), 0.0, 1.0);
        at = model_.on_curve(curve, 1 - use, model_.curve_parameter(at.patch, exit.side, s));
        patch = &model_.patch(at.patch);
        jet = patch->jet1(at.uv);
    }
    Foot foot{{at, -1, 0, from.cell}, jet.p, jet.du.cross(jet.dv), 0};
    const double length = foot.normal.norm();
    if (!(length > 0)) return std::nullopt;
    foot.normal /= model_.flipped(at.patch) ? -length : length;
    foot.size = control_.size(foot.point, foot.place.cell);
    return foot;
}

std::optional<Foot> PatchSupport::slide(const Place& from, const Eigen::Vector3d& target) const {
    const SideUse use = model_.curves()[from.curve].uses[0];
    const ParametricSurface& patch = model_.patch(use.patch);
    const Domain domain = patch.domain();
    const int axis = along_u(use.side) ? 0 : 1;
    const double extent = domain.max[axis] - domain.min[axis];
    double t = from.t;
    for (int step = 0; step < 2; ++step) {
        const Jet1 jet = patch.jet1(model_.on_curve(from.curve, 0, t).uv);
        const Eigen::Vector3d tangent = (axis == 0 ? jet.du : jet.dv) * extent;
        const double speed2 = tangent.squaredNorm();
        if (!(speed2 > 0)) return std::nullopt;
        t += tangent.dot(target - jet.p) / speed2;
        if (!(t > 0 && t < 1)) return std::nullopt;
    }
    return on_curve(from.curve, t, from.cell);
}

Foot PatchSupport::on_curve(int curve, double t, int cell) const { return foot({model_.on_curve(curve, 0, t), curve, t, cell}); }

std::array<Eigen::Vector3d, 2> PatchSupport::curve_ends(int curve) const {
    const auto [a, b] = model_.curves()[curve].ends;
    return {model_.vertices()[a].point, model_.vertices()[b].point};
}

}  // namespace gradus

#include "gradus/quality/project.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace gradus {

namespace {

// Parameters this near a side, relative to the domain, lie on it: shared places are computed by affine maps.
constexpr double kOnSide = 1e-10;

double side_value(const Domain& domain, Side side) {
    switch (side) {
        case Side::Bottom: return domain.min[1];
        case Side::Right: return domain.max[0];
        case Side::Top: return domain.max[1];
        default: return domain.min[0];
    }
}

/// Parameter that varies along a side (0: u, 1: v).
int along_side(Side side) { return side == Side::Bottom || side == Side::Top ? 0 : 1; }

bool on_side(const Domain& domain, const Eigen::Vector2d& uv, Side side) {
    const int across = 1 - along_side(side);
    return std::abs(uv[across] - side_value(domain, side)) <= kOnSide * (domain.max[across] - domain.min[across]);
}

constexpr std::array<Side, 4> kSides{Side::Bottom, Side::Right, Side::Top, Side::Left};

std::vector<Side> sides_at(const Domain& domain, const Eigen::Vector2d& uv) {
    std::vector<Side> sides;
    for (const Side side : kSides)
        if (on_side(domain, uv, side)) sides.push_back(side);
    return sides;
}

bool collapsed(const PatchModel& model, int patch, Side side) {
    const int curve = model.side_curve(patch, side).curve;
    return curve >= 0 && model.curves()[curve].kind == CurveKind::Pole;
}

int corner_at(const Domain& domain, const Eigen::Vector2d& uv) {
    const bool right = on_side(domain, uv, Side::Right), top = on_side(domain, uv, Side::Top);
    return top ? (right ? 2 : 3) : (right ? 1 : 0);
}

/// Half the squared distance to a point as a function of the parameters, to second order.
struct Objective {
    double value;
    Eigen::Vector2d gradient;
    Eigen::Matrix2d first_form, hessian;

    Objective(const ParametricSurface& surface, const Eigen::Vector2d& uv, const Eigen::Vector3d& point) {
        const Jet2 jet = surface.jet2(uv);
        const Eigen::Vector3d r = jet.p - point;
        value = r.squaredNorm() / 2;
        gradient = {r.dot(jet.du), r.dot(jet.dv)};
        first_form << jet.du.squaredNorm(), jet.du.dot(jet.dv), jet.du.dot(jet.dv), jet.dv.squaredNorm();
        hessian << r.dot(jet.duu), r.dot(jet.duv), r.dot(jet.duv), r.dot(jet.dvv);
        hessian += first_form;
    }
};

/// Newton step of the free parameters; by the first form alone (Gauss-Newton) where the Hessian is no safe guide.
Eigen::Vector2d newton_step(const Objective& f, const std::array<bool, 2>& free) {
    constexpr double kSafe = 1e-2;      // part of the first form that the Hessian must keep
    constexpr double kSingular = 1e-24; // squared sine, or squared ratio of speeds, below which a direction is left alone
    const double scale = f.first_form.trace();
    Eigen::Vector2d step(0, 0);
    if (free[0] && free[1] && f.first_form.determinant() > kSingular * scale * scale) {
        const bool safe = f.hessian.determinant() > kSafe * f.first_form.determinant() && f.hessian(0, 0) > kSafe * f.first_form(0, 0);
        const Eigen::Matrix2d& m = safe ? f.hessian : f.first_form;
        step = -Eigen::Vector2d(m(1, 1) * f.gradient[0] - m(0, 1) * f.gradient[1], m(0, 0) * f.gradient[1] - m(1, 0) * f.gradient[0]) / m.determinant();
        return step;
    }
    // One parameter at a time: the faster of the free ones.
    const int k = free[0] && (!free[1] || f.first_form(0, 0) >= f.first_form(1, 1)) ? 0 : 1;
    const double speed = f.first_form(k, k);
    if (!free[k] || !(speed > kSingular * scale)) return step;
    step[k] = -f.gradient[k] / (f.hessian(k, k) > kSafe * speed ? f.hessian(k, k) : speed);
    return step;
}

struct Foot {
    Eigen::Vector2d uv;
    double value;  // half the squared distance
};

/// Local minimum of the distance over one patch.
Foot descend(const ParametricSurface& surface, const Domain& domain, const Eigen::Vector3d& point, const Eigen::Vector2d& start, double tolerance) {
    constexpr int kMaxSteps = 30, kMaxHalvings = 12;
    Eigen::Vector2d uv = start.cwiseMax(domain.min).cwiseMin(domain.max);
    Objective f(surface, uv, point);
    for (int i = 0; i < kMaxSteps; ++i) {
        std::array<bool, 2> free;
        for (int k = 0; k < 2; ++k)
            free[k] = !(uv[k] <= domain.min[k] && f.gradient[k] >= 0) && !(uv[k] >= domain.max[k] && f.gradient[k] <= 0);
        Eigen::Vector2d step = newton_step(f, free);
        const double length = std::sqrt(std::max(0.0, step.dot(f.first_form * step)));
        bool improved = false;
        for (int half = 0; half < kMaxHalvings && !improved; ++half, step /= 2) {
            const Eigen::Vector2d next_uv = (uv + step).cwiseMax(domain.min).cwiseMin(domain.max);
            if (next_uv == uv) break;
            const Objective next(surface, next_uv, point);
            if (!(next.value < f.value)) continue;
            uv = next_uv;
            f = next;
            improved = true;
        }
        // A step this short was one of quadratic convergence: what remains is its square.
        if (!improved || length < tolerance) break;
    }
    return {uv, f.value};
}

/// A start away from a collapsed side, in the direction along it that leads nearest to the point.
std::optional<SurfacePoint> leave_pole(const PatchModel& model, int patch, Side side, const Eigen::Vector3d& point) {
    constexpr int kDirections = 16;
    const ParametricSurface& surface = model.patch(patch);
    const Domain domain = surface.domain();
    const int along = along_side(side), across = 1 - along;
    const double inward = side == Side::Bottom || side == Side::Left ? 1 : -1;
    std::optional<SurfacePoint> best;
    double best_gain = 0;
    for (int i = 0; i < kDirections; ++i) {
        Eigen::Vector2d uv;
        uv[across] = side_value(domain, side);
        uv[along] = domain.min[along] + (i + .5) / kDirections * (domain.max[along] - domain.min[along]);
        const Jet1 jet = surface.jet1(uv);
        const Eigen::Vector3d direction = inward * (across == 0 ? jet.du : jet.dv);
        const double gain = direction.dot(point - jet.p), speed = direction.squaredNorm();
        if (!(speed > 0) || gain <= best_gain * std::sqrt(speed)) continue;
        best_gain = gain / std::sqrt(speed);
        uv[across] += inward * gain / speed;
        best = SurfacePoint{patch, uv};
    }
    return best;
}

/// Where to go on from a foot on the border of its patch.
std::vector<SurfacePoint> ways_on(const PatchModel& model, const SurfacePoint& at, const Eigen::Vector3d& point) {
    std::vector<SurfacePoint> starts;
    const Domain own = model.patch(at.patch).domain();
    if (sides_at(own, at.uv).empty()) return starts;
    for (const SurfacePoint& place : places_of(model, at)) {
        bool pole = false;
        for (const Side side : sides_at(model.patch(place.patch).domain(), place.uv)) {
            if (!collapsed(model, place.patch, side)) continue;
            pole = true;
            if (const auto start = leave_pole(model, place.patch, side, point)) starts.push_back(*start);
        }
        if (!pole && !(place.patch == at.patch && place.uv == at.uv)) starts.push_back(place);
    }
    return starts;
}

}  // namespace

std::vector<SurfacePoint> places_of(const PatchModel& model, const SurfacePoint& at) {
    std::vector<SurfacePoint> places{at};
    const Domain domain = model.patch(at.patch).domain();
    const std::vector<Side> sides = sides_at(domain, at.uv);
    if (sides.empty()) return places;

    const auto add_vertex = [&](int vertex) {
        for (const SurfacePoint& place : model.vertices()[vertex].places)
            if (place.patch != at.patch || !place.uv.isApprox(at.uv, kOnSide)) places.push_back(place);
    };
    if (sides.size() > 1) {
        add_vertex(model.corner_vertex(at.patch, corner_at(domain, at.uv)));
        return places;
    }
    const auto [curve_index, use] = model.side_curve(at.patch, sides[0]);
    if (curve_index < 0) return places;
    const ModelCurve& curve = model.curves()[curve_index];
    if (curve.kind == CurveKind::Pole) {
        add_vertex(curve.ends[0]);
        return places;
    }
    const int along = along_side(sides[0]);
    const double s = (at.uv[along] - domain.min[along]) / (domain.max[along] - domain.min[along]);
    const double t = model.curve_parameter(at.patch, sides[0], std::clamp(s, 0.0, 1.0));
    for (int other = 0; other < static_cast<int>(curve.uses.size()); ++other)
        if (other != use) places.push_back(model.on_curve(curve_index, other, t));
    return places;
}

bool on_pole(const PatchModel& model, const SurfacePoint& at, int& along) {
    for (const Side side : sides_at(model.patch(at.patch).domain(), at.uv)) {
        if (!collapsed(model, at.patch, side)) continue;
        along = along_side(side);
        return true;
    }
    return false;
}

Projection project(const PatchModel& model, const Eigen::Vector3d& point, const SurfacePoint& start) {
    constexpr int kMaxCrossings = 8;
    const double tolerance = 1e-9 * model.diagonal();
    const auto descend_from = [&](const SurfacePoint& from) {
        const ParametricSurface& surface = model.patch(from.patch);
        return descend(surface, surface.domain(), point, from.uv, tolerance);
    };
    SurfacePoint at = start;
    Foot foot = descend_from(start);
    at.uv = foot.uv;
    for (int crossing = 0; crossing < kMaxCrossings; ++crossing) {
        bool improved = false;
        for (const SurfacePoint& way : ways_on(model, at, point)) {
            const Foot next = descend_from(way);
            // Better by more than rounding, or two patches would hand the point to and fro.
            if (!(next.value < foot.value * (1 - 1e-12))) continue;
            foot = next;
            at = {way.patch, next.uv};
            improved = true;
        }
        if (!improved) break;
    }
    return {at, std::sqrt(2 * foot.value)};
}

}  // namespace gradus

#include "gradus/surface/unit_normal.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace gradus {
namespace {

// The cross product of rounded derivatives has a relative error of about 1e-16 / 1e-7 at this closeness to a pole.
constexpr double normal_threshold = 1e-7;

/// Sense in which to leave a bound of an interval: +1 in its lower half, -1 in its upper half.
double inwards(double x, double low, double high) { return x - low <= high - x ? 1.0 : -1.0; }

/// Limit of the unit normals at uv + d h, h -> 0, by Richardson's scheme on halved steps.
Eigen::Vector3d extrapolate_normal(const ParametricSurface& surface, const Eigen::Vector2d& uv,
                                   const Eigen::Vector2d& d) {
    constexpr int steps = 5;
    Eigen::Vector3d n[steps];
    double h = 1.0 / 32;
    for (int k = 0; k < steps; ++k, h /= 2) {
        const Jet1 jet = surface.jet1(uv + h * d);
        n[k] = jet.du.cross(jet.dv).normalized();
    }
    double power = 2;
    for (int order = 1; order < steps; ++order, power *= 2)
        for (int k = steps - 1; k >= order; --k) n[k] += (n[k] - n[k - 1]) / (power - 1);
    return n[steps - 1].normalized();
}

/// What way_out_of_degeneracy decides, a little more strictly and without roots: nearly every place passes.
bool surely_ordinary(const Jet2& jet, double eu, double ev, double threshold) {
    const double u2 = jet.du.squaredNorm() * eu * eu, v2 = jet.dv.squaredNorm() * ev * ev,
                 limit = threshold * threshold;
    const double change_uv = jet.duv.squaredNorm() * eu * eu * ev * ev;
    return u2 > 2 * limit * (jet.duu.squaredNorm() * eu * eu * eu * eu + change_uv) &&
           v2 > 2 * limit * (jet.dvv.squaredNorm() * ev * ev * ev * ev + change_uv) &&
           jet.du.cross(jet.dv).squaredNorm() * eu * eu * ev * ev > limit * u2 * v2;
}

/// The quick test: derivatives of comparable length that are not parallel. Comparable is generous: stretched is not
/// degenerate.
bool clearly_regular(const Jet1& jet, const Eigen::Vector3d& cross, const Eigen::Vector2d& extent) {
    const double u2 = jet.du.squaredNorm() * extent.x() * extent.x(),
                 v2 = jet.dv.squaredNorm() * extent.y() * extent.y();
    const double limit = normal_threshold * normal_threshold;
    return u2 > limit * v2 && v2 > limit * u2 &&
           cross.squaredNorm() > limit * jet.du.squaredNorm() * jet.dv.squaredNorm();
}

}  // namespace

std::optional<Eigen::Vector2d> way_out_of_degeneracy(const Domain& domain, const Eigen::Vector2d& uv, const Jet2& jet,
                                                     double threshold) {
    const double eu = domain.max.x() - domain.min.x(), ev = domain.max.y() - domain.min.y();
    if (surely_ordinary(jet, eu, ev, threshold)) return std::nullopt;
    const double u = jet.du.norm() * eu, v = jet.dv.norm() * ev;
    const double uv_change = jet.duv.norm() * eu * ev;
    const bool no_u = u <= threshold * (jet.duu.norm() * eu * eu + uv_change);
    const bool no_v = v <= threshold * (jet.dvv.norm() * ev * ev + uv_change);
    const bool parallel = jet.du.cross(jet.dv).norm() * eu * ev <= threshold * u * v;
    if (!no_u && !no_v && !parallel) return std::nullopt;
    const double in_u = eu * inwards(uv.x(), domain.min.x(), domain.max.x()),
                 in_v = ev * inwards(uv.y(), domain.min.y(), domain.max.y());
    // Along a collapsed side S_uu vanishes with S_u: leave it across. Where it does not, only the corner is degenerate.
    if (no_u && !no_v && jet.duu.norm() * eu * eu <= 0.1 * uv_change) return Eigen::Vector2d(0, in_v);
    if (no_v && !no_u && jet.dvv.norm() * ev * ev <= 0.1 * uv_change) return Eigen::Vector2d(in_u, 0);
    return Eigen::Vector2d(in_u, in_v);
}

Eigen::Vector3d unit_normal(const ParametricSurface& surface, const Eigen::Vector2d& uv) {
    const Jet1 first = surface.jet1(uv);
    const Eigen::Vector3d cross = first.du.cross(first.dv);
    const Domain domain = surface.domain();
    if (clearly_regular(first, cross, domain.max - domain.min)) return cross.normalized();

    const Jet2 jet = surface.jet2(uv);
    const std::optional<Eigen::Vector2d> out = way_out_of_degeneracy(domain, uv, jet, normal_threshold);
    if (!out) return cross.normalized();
    const Eigen::Vector3d change_u = out->x() * jet.duu + out->y() * jet.duv,
                          change_v = out->x() * jet.duv + out->y() * jet.dvv;
    const Eigen::Vector3d change = change_u.cross(jet.dv) + jet.du.cross(change_v);
    const double scale = (change_u.norm() + jet.du.norm()) * (change_v.norm() + jet.dv.norm());
    if (change.norm() > 1e-6 * scale) return change.normalized();
    return extrapolate_normal(surface, uv, *out);
}

}  // namespace gradus

#include "gradus/curvature/principal.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>

#include "gradus/surface/unit_normal.hpp"

namespace gradus {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// At this closeness to a pole rounding costs a relative 1e-16 / (1e-4)^2 of the curvature around it.
constexpr double curvature_threshold = 1e-4;

/// The second fundamental form in an orthonormal frame (e, f) of the tangent plane: [a b; b c].
struct ShapeInFrame {
    double a, b, c;
    Vector3d e, f, normal;
};

ShapeInFrame shape_of(const Jet2& jet) {
    const double u = jet.du.norm(), v = jet.dv.norm();
    ShapeInFrame s;
    s.e = jet.du / u;
    const Vector3d g = jet.dv / v;
    s.normal = s.e.cross(g);
    const double sine = s.normal.norm(), cosine = s.e.dot(g);
    s.normal /= sine;
    s.f = s.normal.cross(s.e);
    // Second derivatives per unit length along e and g, then from the oblique g to f = (g - cosine e) / sine.
    const double ee = jet.duu.dot(s.normal) / (u * u), eg = jet.duv.dot(s.normal) / (u * v),
                 gg = jet.dvv.dot(s.normal) / (v * v);
    s.a = ee;
    s.b = (eg - cosine * ee) / sine;
    s.c = (gg - 2 * cosine * eg + cosine * cosine * ee) / (sine * sine);
    return s;
}

/// Largest |eigenvalue| of [a b; b c].
double largest_curvature(const ShapeInFrame& s) { return std::abs(s.a + s.c) / 2 + std::hypot((s.a - s.c) / 2, s.b); }

PrincipalCurvatures diagonalise(const ShapeInFrame& s) {
    const double mean = (s.a + s.c) / 2, difference = (s.a - s.c) / 2, radius = std::hypot(difference, s.b);
    // Half the angle of (difference, b): zero at an umbilic, where any frame is principal.
    const double angle = radius > 0 ? std::atan2(s.b, difference) / 2 : 0;
    PrincipalCurvatures result;
    result.k1 = mean + radius;
    result.k2 = mean - radius;
    result.d1 = std::cos(angle) * s.e + std::sin(angle) * s.f;
    result.d2 = -std::sin(angle) * s.e + std::cos(angle) * s.f;
    result.normal = s.normal;
    return result;
}

/// The second fundamental form as a tensor in space: smooth up to a pole, where frames turn.
Matrix3d in_space(const ShapeInFrame& s) {
    return s.a * s.e * s.e.transpose() + s.b * (s.e * s.f.transpose() + s.f * s.e.transpose()) +
           s.c * s.f * s.f.transpose();
}

ShapeInFrame in_frame(const Matrix3d& tensor, const Vector3d& normal) {
    ShapeInFrame result;
    result.normal = normal;
    result.e = normal.unitOrthogonal();
    result.f = normal.cross(result.e);
    result.a = result.e.dot(tensor * result.e);
    result.b = result.e.dot(tensor * result.f);
    result.c = result.f.dot(tensor * result.f);
    return result;
}

/// Limit of the shape at uv + h d, h -> 0, by Richardson's scheme on halved steps; the closest sample if that does not
/// settle.
ShapeInFrame approach(const ParametricSurface& surface, const Vector2d& uv, const Vector2d& d) {
    constexpr int steps = 6;
    std::array<Matrix3d, steps> s;
    double h = 1.0 / 32;
    for (int k = 0; k < steps; ++k, h /= 2) s[k] = in_space(shape_of(surface.jet2(uv + h * d)));
    const Matrix3d closest = s[steps - 1];
    double last_correction = 0, first_correction = (s[steps - 1] - s[steps - 2]).norm();
    double power = 2;
    for (int order = 1; order < steps; ++order, power *= 2)
        for (int k = steps - 1; k >= order; --k) {
            const Matrix3d correction = (s[k] - s[k - 1]) / (power - 1);
            if (k == steps - 1) last_correction = correction.norm();
            s[k] += correction;
        }
    // Settled: the last correction is small beside the result, or beside the first one.
    const bool settled = last_correction <= 1e-3 * std::max(s[steps - 1].norm(), first_correction);
    return in_frame(settled ? s[steps - 1] : closest, unit_normal(surface, uv));
}

ShapeInFrame shape_at(const ParametricSurface& surface, const Domain& domain, const Vector2d& uv, const Jet2& jet) {
    const std::optional<Vector2d> out = way_out_of_degeneracy(domain, uv, jet, curvature_threshold);
    return out ? approach(surface, uv, *out) : shape_of(jet);
}

double radius_of(const ShapeInFrame& shape) {
    const double k = largest_curvature(shape);
    return k > 0 ? 1 / k : std::numeric_limits<double>::infinity();
}

}  // namespace

PrincipalCurvatures principal_curvatures(const Jet2& jet) { return diagonalise(shape_of(jet)); }

PrincipalCurvatures principal_curvatures(const ParametricSurface& surface, const Vector2d& uv) {
    return diagonalise(shape_at(surface, surface.domain(), uv, surface.jet2(uv)));
}

double minimal_radius(const ParametricSurface& surface, const Vector2d& uv) {
    const Vector2d at = surface.curvature_place(uv);
    return radius_of(shape_at(surface, surface.domain(), at, surface.jet2(at)));
}

void minimal_radii(const ParametricSurface& surface, std::span<const Vector2d> uv, std::span<double> radii) {
    if (uv.size() != radii.size())
        throw std::invalid_argument("minimal_radii: " + std::to_string(radii.size()) + " radii for " +
                                    std::to_string(uv.size()) + " places");
    const Domain domain = surface.domain();
    constexpr std::size_t batch = 64;
    std::array<Jet2, batch> jets;
    std::array<Vector2d, batch> places;
    for (std::size_t begin = 0; begin < uv.size(); begin += batch) {
        const std::size_t count = std::min(batch, uv.size() - begin);
        for (std::size_t k = 0; k < count; ++k) places[k] = surface.curvature_place(uv[begin + k]);
        surface.jets(std::span<const Vector2d>(places).first(count), std::span<Jet2>(jets).first(count));
        for (std::size_t k = 0; k < count; ++k)
            radii[begin + k] = radius_of(shape_at(surface, domain, places[k], jets[k]));
    }
}

}  // namespace gradus

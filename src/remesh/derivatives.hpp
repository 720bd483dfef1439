// First and second derivatives of the energy that a vertex lowers by moving.
#pragma once

#include "editor.hpp"

#include <algorithm>
#include <cmath>

namespace gradus {

// First and second derivatives of the energy sum in a tangent plane.
struct Derivatives {
    double value = 0, gx = 0, gy = 0, hxx = 0, hxy = 0, hyy = 0;
    double worst = 0;     // largest energy of a triangle
    bool folded = false;  // a penalty is part of the value, though not of its derivatives
};

// Adds triangle (x, a, b) as x moves along tangent axes. Exact for triangles in their plane; else off by the square of
// the angle between. Sizes and shapes are taken as they are at x.
template <class M>
void add_triangle(const VertexOf<M>& x, const VertexOf<M>& a, const VertexOf<M>& b, const TangentAxes& axes, Aim aim,
                  Derivatives& sum) {
    const Eigen::Vector3d ea = a.p - x.p, eb = b.p - x.p;
    const auto mean = mean_shape(x, a, b);
    const double ax = ea.dot(axes.along_u), ay = ea.dot(axes.along_v), bx = eb.dot(axes.along_u),
                 by = eb.dot(axes.along_v);
    const Eigen::Vector3d n = ea.cross(eb);
    const double twice_area = std::max(std::sqrt(n.squaredNorm()), 1e-300);
    const double S = mean.squared(ea) + mean.squared(eb) + mean.squared(eb - ea);
    const double Sx = -2 * mean.product(axes.u, ea, eb), Sy = -2 * mean.product(axes.v, ea, eb);
    const auto [uu, uv, vv] = mean.of_axes(axes.u, axes.v);
    // Twice the area is linear in the position.
    const double Ax = ay - by, Ay = bx - ax;
    constexpr double c = 1 / (2 * 1.7320508075688772);
    const double i = 1 / twice_area, shape = c * S * i;
    const double k = (2 / 1.7320508075688772) / (x.g * a.g * b.g), m = k * twice_area;
    const SizeTerm size = size_term(m);
    double value = shape + kSizeWeight * size.value;
    if (const double penalty = turn_penalty(x, a, b, n, twice_area); penalty > 0) {
        value += penalty;
        sum.folded = true;
    }
    const double d1 = -shape * i + kSizeWeight * k * size.slope;  // by twice the area
    const double d2 = 2 * shape * i * i + kSizeWeight * k * k * size.curvature;
    const double gx = c * i * Sx + d1 * Ax, gy = c * i * Sy + d1 * Ay;
    const double cross = -c * i * i;
    double hxx = 4 * c * i * uu + 2 * cross * Sx * Ax + d2 * Ax * Ax;
    double hyy = 4 * c * i * vv + 2 * cross * Sy * Ay + d2 * Ay * Ay;
    double hxy = cross * (Sx * Ay + Sy * Ax) + d2 * Ax * Ay + 4 * c * i * uv;
    sum.worst = std::max(sum.worst, value);
    double w1 = 1;
    if (aim == Aim::Worst) {
        const double e2 = value * value, e3 = e2 * value, e6 = e3 * e3;
        w1 = 8 * e6 * value;
        const double w2 = 56 * e6;
        hxx = w1 * hxx + w2 * gx * gx;
        hyy = w1 * hyy + w2 * gy * gy;
        hxy = w1 * hxy + w2 * gx * gy;
        value = e6 * e2;
    }
    sum.value += value;
    sum.gx += w1 * gx;
    sum.gy += w1 * gy;
    sum.hxx += hxx;
    sum.hxy += hxy;
    sum.hyy += hyy;
}

// Squared metric length of an edge over its squared length.
inline double by_square(const Vertex& x, const Vertex& a) { return 1 / (x.h * a.h); }
inline double by_square(const VertexOf<SizeTensor>& x, const VertexOf<SizeTensor>& a) {
    return squared_length(x, a) / (x.p - a.p).squaredNorm();
}
// Adds the edge (x, a) of a feature curve that runs along u.
template <class M>
void add_edge(const VertexOf<M>& x, const VertexOf<M>& a, const Eigen::Vector3d& u, Aim aim, Derivatives& sum) {
    const Eigen::Vector3d e = a.p - x.p;
    const double k = by_square(x, a), by_place = -2 * k * e.dot(u);
    const SizeTerm size = size_term(k * e.squaredNorm());
    const double value = 1 + kLengthWeight * size.value, g = kLengthWeight * size.slope * by_place;
    // Of an axis that has not the length 1.
    const double squared_step = std::is_same_v<M, Size> ? 1 : u.squaredNorm();
    const double h = kLengthWeight * (size.curvature * by_place * by_place + size.slope * 2 * k * squared_step);
    const double e3 = value * value * value;
    const double w1 = aim == Aim::Worst ? 8 * e3 * e3 * value : 1, w2 = aim == Aim::Worst ? 56 * e3 * e3 : 0;
    sum.value += weighted(value, aim);
    sum.gx += w1 * g;
    sum.hxx += w1 * h + w2 * g * g;
}

}  // namespace gradus

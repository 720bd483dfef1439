// Vertices that know their place on the surface and the metric there, and what lengths and shapes are in it. A metric M
// is its size h, 1 / h^2 the square root of its determinant on the tangent plane, and its shape N = h^2 M. Of sizes N
// is the identity, and nothing is kept of it.
#pragma once

#include "gradus/control/control_space.hpp"
#include "gradus/control/metric.hpp"
#include "gradus/remesh/support.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace gradus {

enum class Bound : char {
    Free,   // moves on the surface
    Curve,  // slides on its feature curve
    Fixed   // corners, poles and what is frozen
};

template <class M>
struct ShapeOf;
template <>
struct ShapeOf<Size> {};
template <>
struct ShapeOf<SizeTensor> {
    Tensor shape = round_tensor(1);  // N
};

template <class M>
struct alignas(64) VertexOf : ShapeOf<M> {
    Eigen::Vector3d p;
    double h = 1;       // size asked for
    Eigen::Vector3d n;  // unit normal of the surface
    double g = 1;       // h^(2/3): the mean h^2 of a triangle is the product of three
    Place place;
    Bound bound = Bound::Free;
    // Cosine of the angle between n and the normals that the surface has here: 1 where it has one, less on creases, and
    // kAnyNormal at corners, which are not held against their triangles.
    float lean = 1;
};
using Vertex = VertexOf<Size>;

inline constexpr float kAnyNormal = -1;
inline constexpr float kSharpest = 0.2F;  // two sides that meet like a blade say nothing of what lies between

// Cosine of the angle between a unit normal and the nearest that the surface has at a vertex.
template <class M>
double agreement(const VertexOf<M>& v, const Eigen::Vector3d& n) {
    const double cosine = n.dot(v.n);
    if (v.lean == 1) return cosine;
    if (v.lean < kSharpest || cosine >= v.lean) return 1;
    const double lean = v.lean;
    return cosine * lean + std::sqrt(std::max(0.0, (1 - cosine * cosine) * (1 - lean * lean)));
}

// What every vertex of an editor has: for assertions.
template <class M>
bool is_sound(const VertexOf<M>& v) {
    constexpr double kUnit = 1e-6, kSameSize = 1e-12;
    const bool placed = v.p.allFinite() && v.place.cell >= 0;
    const bool sized = v.h > 0 && std::isfinite(v.h) && std::abs(v.g * v.g * v.g / (v.h * v.h) - 1) < kSameSize;
    return placed && sized && std::abs(v.n.norm() - 1) < kUnit && v.lean >= kAnyNormal && v.lean <= 1 + kUnit;
}

inline void take_size(Vertex& v, double h) {
    v.h = h;
    v.g = std::cbrt(h * h);
}
inline void take_size(VertexOf<SizeTensor>& v, const Tensor& size) {
    const double h2 = mean_square_size(size, v.n);
    v.h = std::sqrt(h2);
    v.g = std::cbrt(h2);
    v.shape = h2 * metric_of(size);
}
inline double mean_size(double h, const Eigen::Vector3d&) { return h; }
inline double mean_size(const Tensor& size, const Eigen::Vector3d& n) { return std::sqrt(mean_square_size(size, n)); }

// Puts a vertex on the surface, with the size there.
template <class M>
void stand(VertexOf<M>& v, Foot foot, const Support& support, const MetricField<M>& field) {
    const auto size = field.size(foot.point, foot.place.cell);
    support.settle(foot, mean_size(size, foot.normal));
    v.place = foot.place;
    v.p = foot.point;
    v.n = foot.normal;
    v.lean = static_cast<float>(foot.lean);
    take_size(v, size);
}

// What lengths are in a shape: all the same, or by directions.
struct RoundShape {
    double squared(const Eigen::Vector3d& e) const { return e.squaredNorm(); }
    double product(const Eigen::Vector3d& u, const Eigen::Vector3d& a, const Eigen::Vector3d& b) const {
        return a.dot(u) + b.dot(u);
    }
    // u^T N u, u^T N v and v^T N v of two unit vectors that are orthogonal.
    std::array<double, 3> of_axes(const Eigen::Vector3d&, const Eigen::Vector3d&) const { return {1, 0, 1}; }
};
struct StretchedShape {
    Tensor n;
    double squared(const Eigen::Vector3d& e) const { return squared_in(n, e); }
    // u^T N (a + b)
    double product(const Eigen::Vector3d& u, const Eigen::Vector3d& a, const Eigen::Vector3d& b) const {
        return u.dot(times(n, a + b));
    }
    std::array<double, 3> of_axes(const Eigen::Vector3d& u, const Eigen::Vector3d& v) const {
        const Eigen::Vector3d nv = times(n, v);
        return {squared_in(n, u), u.dot(nv), v.dot(nv)};
    }
};
// The mean of the shapes at the corners of a triangle: the sum of the squares of its edges in it, over its area, is the
// mean of those in the metrics of its corners.
inline RoundShape mean_shape(const Vertex&, const Vertex&, const Vertex&) { return {}; }
inline StretchedShape mean_shape(const VertexOf<SizeTensor>& a, const VertexOf<SizeTensor>& b,
                                 const VertexOf<SizeTensor>& c) {
    return {(1.0 / 3) * (a.shape + b.shape + c.shape)};
}

// Squared length in the shape at a vertex: over h^2 it is that in its metric.
inline double squared_at(const Vertex&, const Eigen::Vector3d& e) { return e.squaredNorm(); }
inline double squared_at(const VertexOf<SizeTensor>& v, const Eigen::Vector3d& e) { return squared_in(v.shape, e); }

// Metric length of an edge.
inline double length_between(const Vertex& a, const Vertex& b) { return metric_length((a.p - b.p).norm(), a.h, b.h); }
inline double length_between(const VertexOf<SizeTensor>& a, const VertexOf<SizeTensor>& b) {
    const Eigen::Vector3d e = a.p - b.p;
    return mean_metric_length(std::sqrt(squared_in(a.shape, e)) / a.h, std::sqrt(squared_in(b.shape, e)) / b.h);
}
// Lengths in the metrics of its ends, the shorter one first: the metric length is between them.
inline std::array<double, 2> lengths_at_ends(const Vertex& a, const Vertex& b) {
    const double length = (a.p - b.p).norm();
    return {length / std::max(a.h, b.h), length / std::min(a.h, b.h)};
}
inline std::array<double, 2> lengths_at_ends(const VertexOf<SizeTensor>& a, const VertexOf<SizeTensor>& b) {
    const Eigen::Vector3d e = a.p - b.p;
    const double at_a = std::sqrt(squared_in(a.shape, e)) / a.h, at_b = std::sqrt(squared_in(b.shape, e)) / b.h;
    return {std::min(at_a, at_b), std::max(at_a, at_b)};
}
// The product of the lengths in the metrics of its ends.
inline double squared_length(const Vertex& a, const Vertex& b) { return (a.p - b.p).squaredNorm() / (a.h * b.h); }
inline double squared_length(const VertexOf<SizeTensor>& a, const VertexOf<SizeTensor>& b) {
    const Eigen::Vector3d e = a.p - b.p;
    return std::sqrt(squared_in(a.shape, e) * squared_in(b.shape, e)) / (a.h * b.h);
}

// Area-length quality, 1 for equilateral; in a metric that varies in that of the corner where it is worst.
inline double triangle_quality(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    const Eigen::Vector3d e1 = b - a, e2 = c - a;
    return 2 * 1.7320508075688772 * e1.cross(e2).norm() /
           (e1.squaredNorm() + e2.squaredNorm() + (e2 - e1).squaredNorm());
}
inline double triangle_quality(const Vertex& a, const Vertex& b, const Vertex& c) {
    return triangle_quality(a.p, b.p, c.p);
}
inline double triangle_quality(const VertexOf<SizeTensor>& a, const VertexOf<SizeTensor>& b,
                               const VertexOf<SizeTensor>& c) {
    const Eigen::Vector3d e1 = b.p - a.p, e2 = c.p - a.p, e3 = e2 - e1;
    double longest = 0;
    for (const auto* v : {&a, &b, &c})
        longest = std::max(longest, squared_in(v->shape, e1) + squared_in(v->shape, e2) + squared_in(v->shape, e3));
    return longest > 0 ? 2 * 1.7320508075688772 * e1.cross(e2).norm() / longest : 0;
}

// Axes in the plane through a vertex that are orthonormal in its shape, so that steps are measured, and slopes
// followed, as where sizes are all the same; with the axes that give coordinates in them. @param u  a tangent: its
// direction is kept
struct TangentAxes {
    Eigen::Vector3d u, v, along_u, along_v;
};
inline TangentAxes tangent_axes(const Vertex& x, const Eigen::Vector3d& u) {
    const Eigen::Vector3d v = x.n.cross(u);
    return {u, v, u, v};
}
inline TangentAxes tangent_axes(const VertexOf<SizeTensor>& x, const Eigen::Vector3d& u) {
    const Eigen::Vector3d unit = u / std::sqrt(squared_in(x.shape, u));
    // What is orthogonal to u in the shape; their parallelogram has an area of one, as that of the shape is.
    const Eigen::Vector3d across = x.n.cross(unit);
    const Eigen::Vector3d straight = across - unit.dot(times(x.shape, across)) * unit;
    const Eigen::Vector3d v = straight / (x.n.dot(unit.cross(straight)));
    return {unit, v, v.cross(x.n), x.n.cross(unit)};
}

}  // namespace gradus

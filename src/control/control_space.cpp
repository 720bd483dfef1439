#include "gradus/control/control_space.hpp"

#include "gradus/control/metric.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

namespace gradus {

namespace {

constexpr double kFar2 = 0.0625;  // squared: of the size, from a point to where a walk to it ends

// What differs between sizes and size tensors.
bool is_size(double h) { return h > 0 && std::isfinite(h); }
bool is_size(const Tensor& h) { return is_positive_definite(h); }
double typical(double h) { return h; }
double typical(const Tensor& h) { return std::cbrt(determinant(h)); }
double least(double h) { return h; }
double least(const Tensor& h) { return axes_of(h).values[0]; }

// Weights of the corners after those that are negative are dropped.
std::array<double, 3> clamped(double a, double b) {
    std::array<double, 3> w{std::max(0.0, 1 - a - b), std::max(0.0, a), std::max(0.0, b)};
    const double sum = w[0] + w[1] + w[2];
    for (double& x : w) x /= sum;
    return w;
}

// Integral of 1 / h^2 over the triangle of area 1/2, with h linear between its corners: the second divided difference
// of -ln h. [Hermite-Genocchi]
double mean_density(double a, double b, double c) {
    constexpr double kEven = 1.02;  // ratio up to which a quadrature is more exact than differences
    if (a > b) std::swap(a, b);
    if (b > c) std::swap(b, c);
    if (a > b) std::swap(a, b);
    if (c > kEven * a) {
        const auto first = [](double x, double y) { return y > x ? -log_size_ratio(x, y) / (y - x) : -1 / x; };
        return (first(b, c) - first(a, b)) / (c - a);
    }
    // Seven points, exact to degree 5 [Radon 1948].
    const double r = std::sqrt(15.0);
    const double a1 = (6 - r) / 21, a2 = (6 + r) / 21, w0 = 9.0 / 40, w1 = (155 - r) / 1200, w2 = (155 + r) / 1200;
    const auto density = [&](double s, double t) {
        const double h = a + s * (b - a) + t * (c - a);
        return 1 / (h * h);
    };
    const auto orbit = [&](double s) { return density(s, s) + density(s, 1 - 2 * s) + density(1 - 2 * s, s); };
    return 0.5 * (w0 * density(1.0 / 3, 1.0 / 3) + w1 * orbit(a1) + w2 * orbit(a2));
}

// The same of size tensors, over a triangle with the unit normal n, in four parts where the density differs much
// between its corners.
double mean_density(const Tensor& a, const Tensor& b, const Tensor& c, const Eigen::Vector3d& n, int depth = 0) {
    constexpr double kEven = 1.3;
    constexpr int kDeepest = 5;
    const auto density = [&](const Tensor& h) { return 1 / mean_square_size(h, n); };
    const std::array<double, 3> at{density(a), density(b), density(c)};
    const auto [low, high] = std::minmax_element(at.begin(), at.end());
    if (*high > kEven * *low && depth < kDeepest) {
        const Tensor ab = 0.5 * (a + b), bc = 0.5 * (b + c), ca = 0.5 * (c + a);
        return (mean_density(a, ab, ca, n, depth + 1) + mean_density(ab, b, bc, n, depth + 1) +
                mean_density(ca, bc, c, n, depth + 1) + mean_density(ab, bc, ca, n, depth + 1)) /
               4;
    }
    const auto weighted = [&](double u, double v, double w) { return density(u * a + v * b + w * c); };
    const double r = std::sqrt(15.0), a1 = (6 - r) / 21, a2 = (6 + r) / 21;
    const auto orbit = [&](double s) {
        return weighted(s, s, 1 - 2 * s) + weighted(s, 1 - 2 * s, s) + weighted(1 - 2 * s, s, s);
    };
    // As for sizes [Radon 1948].
    return 0.5 * (9.0 / 40 * weighted(1.0 / 3, 1.0 / 3, 1.0 / 3) + (155 - r) / 1200 * orbit(a1) +
                  (155 + r) / 1200 * orbit(a2));
}

// Integral over a triangle whose twice area is 1.
double integral(const std::array<double, 3>& h, const std::array<Eigen::Vector3d, 3>&) {
    return mean_density(h[0], h[1], h[2]);
}
double integral(const std::array<Tensor, 3>& h, const std::array<Eigen::Vector3d, 3>& corners) {
    const Eigen::Vector3d n = (corners[1] - corners[0]).cross(corners[2] - corners[0]).stableNormalized();
    return mean_density(h[0], h[1], h[2], n);
}

template <class Value>
void check_sizes(std::span<const Value> sizes, std::size_t vertices) {
    if (sizes.size() != vertices)
        throw std::invalid_argument("ControlSpace: " + std::to_string(sizes.size()) + " sizes for " +
                                    std::to_string(vertices) + " vertices");
    for (std::size_t v = 0; v < sizes.size(); ++v)
        if (!is_size(sizes[v]))
            throw std::invalid_argument("ControlSpace: size of vertex " + std::to_string(v) +
                                        " is not positive and finite");
}

}  // namespace

template <class M>
InterpolatedField<M>::InterpolatedField(std::span<const Eigen::Vector3d> points, const Connectivity& mesh,
                                        std::span<const Value> sizes)
    : locator_(points, mesh) {
    check_sizes(sizes, points.size());
    values_.reserve(mesh.num_triangles());
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const auto [a, b, c] = mesh.triangle(t);
        values_.push_back({sizes[a], sizes[b], sizes[c]});
    }
}

template <class M>
InterpolatedField<M>::InterpolatedField(const Background& background, std::span<const Value> sizes)
    : locator_(background) {
    check_sizes(sizes, background.mesh.n_vertices());
    values_.reserve(background.mesh.n_faces());
    for (const auto f : background.mesh.faces()) {
        std::array<Value, 3> h;
        auto halfedge = background.mesh.halfedge_handle(f);
        for (int k = 0; k < 3; ++k, halfedge = background.mesh.next_halfedge_handle(halfedge))
            h[k] = sizes[background.mesh.to_vertex_handle(halfedge).idx()];
        values_.push_back(h);
    }
}

template <class M>
typename M::Value InterpolatedField<M>::value(const TriangleLocator::Position& at) const {
    const auto& h = values_[at.triangle];
    const double w0 = 1 - at.a - at.b;
    if (w0 >= 0 && at.a >= 0 && at.b >= 0) return w0 * h[0] + at.a * h[1] + at.b * h[2];
    const auto w = clamped(at.a, at.b);
    return w[0] * h[0] + w[1] * h[1] + w[2] * h[2];
}

template <class M>
typename M::Value InterpolatedField<M>::size(const Eigen::Vector3d& p, int& triangle) const {
    const auto [at, distance2] = locator_.walk(p, triangle);
    triangle = at.triangle;
    if (distance2 == 0) return value(at);
    Value h = value(at);
    if (const double size = typical(h); distance2 > kFar2 * size * size) {
        const TriangleLocator::Position closest = locator_.closest(p, triangle);
        triangle = closest.triangle;
        h = value(closest);
    }
    return h;
}

template <class M>
double InterpolatedField<M>::least_relative_size() const {
    double smallest = std::numeric_limits<double>::infinity();
    for (int t = 0; t < num_triangles(); ++t) {
        const auto& [a, b, c] = values_[t];
        smallest =
            std::min(smallest, std::min({least(a), least(b), least(c)}) / locator_.corners(t)[0].cwiseAbs().maxCoeff());
    }
    return smallest;
}

template <class M>
double InterpolatedField<M>::predicted_triangles() const {
    double sum = 0;
    for (int t = 0; t < num_triangles(); ++t)
        if (const double twice_area = locator_.twice_area(t); twice_area > 0)
            sum += integral(values_[t], locator_.corners(t)) * twice_area;
    return sum / (std::numbers::sqrt3 / 4);
}

template class InterpolatedField<Size>;
template class InterpolatedField<SizeTensor>;

}  // namespace gradus

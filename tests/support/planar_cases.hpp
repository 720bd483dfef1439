/// Domains cut to unit length and facts of planar meshes, for the tests and benchmarks of the planar generator.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <vector>

#include "gradus/plane/delaunay.hpp"

namespace gradus::planar_cases {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kPi = 3.14159265358979323846;

inline Matrix2d metric_at(const PlaneMetric& metric, const Vector2d& p) {
    int hint = -1;
    return metric(p, hint);
}

/// Length of a segment in the metric by the midpoint rule: independent of how the generator measures.
inline double true_length(const PlaneMetric& metric, const Vector2d& a, const Vector2d& b, int samples = 8) {
    const Vector2d d = b - a;
    double sum = 0;
    for (int i = 0; i < samples; ++i)
        sum += std::sqrt(std::max(0.0, d.dot(metric_at(metric, a + (i + 0.5) / samples * d) * d)));
    return sum / samples;
}

/// Appends the points of a closed curve of sides, each cut into pieces of about unit length; a side of length 0 stays
/// whole.
inline void add_loop(PlanarDomain& domain, const PlaneMetric& metric,
                     const std::vector<std::function<Vector2d(double)>>& sides) {
    constexpr int kSamples = 4000;
    const int first = static_cast<int>(domain.points.size());
    for (const auto& side : sides) {
        std::vector<double> length(kSamples + 1, 0);
        for (int i = 0; i < kSamples; ++i)
            length[i + 1] =
                length[i] + true_length(metric, side(double(i) / kSamples), side(double(i + 1) / kSamples), 1);
        const int pieces = std::max(1, static_cast<int>(std::lround(length.back())));
        for (int i = 0, j = 0; i < pieces; ++i) {
            const double wanted = length.back() * i / pieces;
            while (j < kSamples - 1 && length[j + 1] < wanted) ++j;
            const double step = length[j + 1] - length[j];
            domain.points.push_back(side((j + (step > 0 ? (wanted - length[j]) / step : 0)) / kSamples));
        }
    }
    const int end = static_cast<int>(domain.points.size());
    for (int i = first; i < end; ++i) domain.segments.push_back({i, i + 1 == end ? first : i + 1});
}

inline void add_polygon(PlanarDomain& domain, const PlaneMetric& metric, const std::vector<Vector2d>& corners) {
    std::vector<std::function<Vector2d(double)>> sides;
    for (std::size_t k = 0; k < corners.size(); ++k) {
        const Vector2d a = corners[k], b = corners[(k + 1) % corners.size()];
        sides.push_back([a, b](double t) { return Vector2d(a + t * (b - a)); });
    }
    add_loop(domain, metric, sides);
}

inline void add_rectangle(PlanarDomain& domain, const PlaneMetric& metric, double width, double height) {
    add_polygon(domain, metric, {{0, 0}, {width, 0}, {width, height}, {0, height}});
}

inline void add_circle(PlanarDomain& domain, const PlaneMetric& metric, const Vector2d& centre, double radius) {
    add_loop(domain, metric, {[=](double t) {
                 return Vector2d(centre + radius * Vector2d(std::cos(2 * kPi * t), std::sin(2 * kPi * t)));
             }});
}

inline PlaneMetric constant_metric(const Matrix2d& m) {
    return [m](const Vector2d&, int&) { return m; };
}

inline PlaneMetric uniform_metric(double size) { return constant_metric(Matrix2d::Identity() / (size * size)); }

/// Isotropic, size growing linearly with the distance from a centre.
inline PlaneMetric radial_metric(const Vector2d& centre, double size, double slope) {
    return [=](const Vector2d& p, int&) {
        const double h = size + slope * (p - centre).norm();
        return Matrix2d(Matrix2d::Identity() / (h * h));
    };
}

/// Polar map of a cone with apex at v = 0: (u, v) is angle and distance.
inline PlaneMetric polar_metric(double size) {
    return [=](const Vector2d& p, int&) {
        return Matrix2d(Vector2d(p.y() * p.y(), 1).asDiagonal().toDenseMatrix() / (size * size));
    };
}

struct Facts {
    double mean_quality = 0, worst_quality = 2;  ///< area-length, in the metric
    double shortest = 1e300, longest = 0;        ///< of interior edges
    double regular = 0;                          ///< share of interior vertices of valence 6
    double metric_area = 0;                      ///< of the mesh, integrated at the middles of the edges
    int triangles = 0;                           ///< measured: those not `left_out`
};

/// Facts of a mesh, without the triangles and edges that have a point that is `left_out` (poles).
inline Facts measure(const PlanarMesh& mesh, const PlaneMetric& metric,
                     const std::function<bool(const Vector2d&)>& left_out = {}) {
    Facts facts;
    std::map<std::array<int, 2>, int> uses;
    const auto skip = [&](int i) { return left_out && left_out(mesh.points[i]); };
    for (const auto& t : mesh.triangles) {
        const Vector2d a = mesh.points[t[0]], b = mesh.points[t[1]], c = mesh.points[t[2]];
        for (int k = 0; k < 3; ++k) ++uses[{std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])}];
        const double area = ((b - a).x() * (c - a).y() - (b - a).y() * (c - a).x()) / 2;
        const auto density = [&](const Vector2d& p) {
            return std::sqrt(std::max(0.0, metric_at(metric, p).determinant()));
        };
        const double metric_area = area * (density((a + b) / 2) + density((b + c) / 2) + density((c + a) / 2)) / 3;
        facts.metric_area += metric_area;
        if (skip(t[0]) || skip(t[1]) || skip(t[2])) continue;
        double sum = 0;
        for (const double l : {true_length(metric, a, b), true_length(metric, b, c), true_length(metric, c, a)})
            sum += l * l;
        const double quality = 4 * std::sqrt(3.0) * metric_area / sum;
        facts.mean_quality += quality;
        facts.worst_quality = std::min(facts.worst_quality, quality);
        ++facts.triangles;
    }
    if (facts.triangles > 0) facts.mean_quality /= facts.triangles;
    std::vector<int> valence(mesh.points.size(), 0);
    std::vector<char> boundary(mesh.points.size(), 0);
    for (const auto& [edge, count] : uses) {
        for (const int i : edge) {
            ++valence[i];
            boundary[i] = boundary[i] || count == 1;
        }
        if (count == 1 || skip(edge[0]) || skip(edge[1])) continue;
        const double l = true_length(metric, mesh.points[edge[0]], mesh.points[edge[1]]);
        facts.shortest = std::min(facts.shortest, l);
        facts.longest = std::max(facts.longest, l);
    }
    int interior = 0, regular = 0;
    for (std::size_t i = 0; i < valence.size(); ++i) {
        interior += valence[i] > 0 && !boundary[i];
        regular += valence[i] == 6 && !boundary[i];
    }
    facts.regular = interior > 0 ? double(regular) / interior : 1;
    return facts;
}

}  // namespace gradus::planar_cases

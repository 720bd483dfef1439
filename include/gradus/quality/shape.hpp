/// Shape of the triangles of a mesh: three element measures, angles, valences, ratios of adjacent edges.
#pragma once

#include "gradus/quality/mesh_edges.hpp"
#include "gradus/quality/statistics.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace gradus {

/// What the measures of one triangle are made of. Corner k is opposite to side k.
struct TriangleSides {
    std::array<double, 3> squared{};  ///< squared lengths of the sides, in units of `unit` squared
    double twice_area = 0;            ///< in units of `unit` squared
    double unit =
        1;  ///< length the triangle was divided by: 1, or its extent where squares would leave the range of double
    bool degenerate = true;  ///< a side or the area is zero, or a coordinate is not finite
};

inline TriangleSides sides_of(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    TriangleSides s;
    Eigen::Vector3d ab = b - a, bc = c - b, ca = a - c;
    const double extent = ab.squaredNorm() + bc.squaredNorm() + ca.squaredNorm();
    // Fourth powers of lengths are needed, and must neither overflow nor lose digits.
    if (!(extent > 1e-100 && extent < 1e100)) {
        if (!(ab.allFinite() && bc.allFinite() && ca.allFinite())) return s;
        s.unit = std::max({ab.cwiseAbs().maxCoeff(), bc.cwiseAbs().maxCoeff(), ca.cwiseAbs().maxCoeff()});
        if (s.unit == 0) return s;
        ab /= s.unit, bc /= s.unit, ca /= s.unit;
    }
    s.squared = {bc.squaredNorm(), ca.squaredNorm(), ab.squaredNorm()};
    // Of the three equal cross products the one without the longest side cancels least.
    const bool longest_bc = s.squared[0] >= s.squared[1] && s.squared[0] >= s.squared[2];
    const bool longest_ca = !longest_bc && s.squared[1] >= s.squared[2];
    const Eigen::Vector3d normal = longest_bc ? ca.cross(ab) : longest_ca ? ab.cross(bc) : bc.cross(ca);
    s.twice_area = normal.norm();
    s.degenerate = !(s.twice_area > 0 && s.squared[0] > 0 && s.squared[1] > 0 && s.squared[2] > 0);
    return s;
}

/// 4 sqrt(3) A / (sum of squared sides); 1 for equilateral, 0 for degenerate, never not-a-number.
inline double area_length(const TriangleSides& s) {
    if (s.degenerate) return 0;
    return std::min(1.0, 2 * std::numbers::sqrt3 * s.twice_area / (s.squared[0] + s.squared[1] + s.squared[2]));
}

/// 2 sqrt(3) r / (longest side), r the radius of the inscribed circle; 1 for equilateral, 0 for degenerate.
inline double inradius_edge(const TriangleSides& s) {
    if (s.degenerate) return 0;
    const double l0 = std::sqrt(s.squared[0]), l1 = std::sqrt(s.squared[1]), l2 = std::sqrt(s.squared[2]);
    return std::min(1.0, 2 * std::numbers::sqrt3 * s.twice_area / ((l0 + l1 + l2) * std::max({l0, l1, l2})));
}

/// 2 r / R, the radii of the inscribed and the circumscribed circle; 1 for equilateral, 0 for degenerate.
inline double radius_ratio(const TriangleSides& s) {
    if (s.degenerate) return 0;
    const double l0 = std::sqrt(s.squared[0]), l1 = std::sqrt(s.squared[1]), l2 = std::sqrt(s.squared[2]);
    // In this order no intermediate result can leave the range of double.
    return std::min(1.0, 4 * (s.twice_area / (l0 * l1)) * (s.twice_area / (l2 * (l0 + l1 + l2))));
}

inline double area_length(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    return area_length(sides_of(a, b, c));
}
inline double inradius_edge(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    return inradius_edge(sides_of(a, b, c));
}
inline double radius_ratio(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    return radius_ratio(sides_of(a, b, c));
}

/// Angle at corner k, radians in [0, pi]; 0 where a side at the corner has no length.
inline double corner_angle(const TriangleSides& s, int k) {
    const double cosine_part = s.squared[(k + 1) % 3] + s.squared[(k + 2) % 3] - s.squared[k];
    return std::atan2(2 * s.twice_area, cosine_part);
}

struct ShapeReport {
    Summary area_length, inradius_edge, radius_ratio;  ///< over triangles
    Summary smallest_angle, largest_angle;             ///< of each triangle, degrees
    Summary adjacent_edge_ratio;    ///< over vertices: longest / shortest incident edge, infinite for a zero edge
    std::size_t degenerate = 0;     ///< triangles of no area
    double valence_6 = 0;           ///< share of all used vertices that have six edges
    double interior_valence_6 = 0;  ///< share of the interior vertices that have six edges
    Summary interior_valence,
        boundary_valence;  ///< edges at a vertex; a vertex on an edge without exactly two triangles is boundary
    Histogram area_length_histogram{0, 1, 10}, inradius_edge_histogram{0, 1, 10};
    Histogram smallest_angle_histogram{0, 60, 12};  ///< degrees
    Histogram valence_histogram{2.5, 10.5, 8};      ///< 3 (and less) ... 10 (and more), interior vertices
    std::vector<Offender> worst;                    ///< triangles of the smallest area-length, worst first
};

struct ShapeOptions {
    std::size_t worst = 10;  ///< how many of the worst triangles to list
};

/// @param edges  edges_of(mesh)
ShapeReport measure_shape(const MeshView& mesh, const MeshEdges& edges, const ShapeOptions& options = {});

/// Lengths of the edges, in edge order.
std::vector<double> edge_lengths(const MeshView& mesh, const MeshEdges& edges);

/// Number of edges at each vertex, 0 where it is unused.
std::vector<int> valences(const MeshView& mesh, const MeshEdges& edges);

/// Longest over shortest incident edge of each vertex, not a number where it has none.
std::vector<double> adjacent_edge_ratios(const MeshView& mesh, const MeshEdges& edges);

}  // namespace gradus

/// Parts as CAD programs tessellate them: prisms over outlines, with caps of needles.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <vector>

#include "gradus/mesh/soup.hpp"

namespace parts {

using Outline = std::vector<Eigen::Vector2d>;

/// A rectangle from the origin whose corners are rounds of some facets each, counter-clockwise.
inline Outline rounded(double width, double height, double radius, int facets) {
    Outline outline;
    const double right = width - radius, top = height - radius;
    const Eigen::Vector2d centres[] = {{right, radius}, {right, top}, {radius, top}, {radius, radius}};
    for (int c = 0; c < 4; ++c)
        for (int k = 0; k <= facets; ++k) {
            const double angle = (c - 1 + double(k) / facets) * std::numbers::pi / 2;
            outline.push_back(centres[c] + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
        }
    return outline;
}

inline Outline polygon(int sides) {
    Outline outline;
    for (int k = 0; k < sides; ++k)
        outline.emplace_back(std::cos(2 * std::numbers::pi * k / sides), std::sin(2 * std::numbers::pi * k / sides));
    return outline;
}

/// Over a convex outline, its caps fans from the first point: needles.
inline gradus::TriangleSoup prism(const Outline& outline, double height) {
    gradus::TriangleSoup soup;
    const int n = static_cast<int>(outline.size());
    for (const double z : {0.0, height})
        for (const Eigen::Vector2d& p : outline) soup.points.emplace_back(p.x(), p.y(), z);
    for (int i = 1; i + 1 < n; ++i) soup.triangles.insert(soup.triangles.end(), {{0, i + 1, i}, {n, n + i, n + i + 1}});
    for (int i = 0; i < n; ++i) {
        const int j = (i + 1) % n;
        soup.triangles.insert(soup.triangles.end(), {{i, j, n + j}, {i, n + j, n + i}});
    }
    return soup;
}

/// Over an outline that sees the origin from everywhere, turned by an angle from layer to layer; its caps fans from the
/// axis.
inline gradus::TriangleSoup twisted(const Outline& outline, double height, double angle, int layers) {
    gradus::TriangleSoup soup;
    const int n = static_cast<int>(outline.size()), bottom = n * (layers + 1);
    for (int k = 0; k <= layers; ++k)
        for (const Eigen::Vector2d& p : outline) {
            const Eigen::Vector2d q = Eigen::Rotation2Dd(angle * k / layers) * p;
            soup.points.emplace_back(q.x(), q.y(), height * k / layers);
        }
    soup.points.emplace_back(0, 0, 0);
    soup.points.emplace_back(0, 0, height);
    for (int i = 0; i < n; ++i) {
        const int j = (i + 1) % n, top = n * layers;
        for (int a = 0; a < top; a += n)
            soup.triangles.insert(soup.triangles.end(), {{a + i, a + j, a + n + j}, {a + i, a + n + j, a + n + i}});
        soup.triangles.insert(soup.triangles.end(), {{bottom, j, i}, {bottom + 1, top + i, top + j}});
    }
    return soup;
}

/// Teeth of radius 1 with rounded flanks of some facets each, counter-clockwise.
inline Outline gear(int teeth, int facets, double root) {
    Outline outline;
    for (int i = 0; i < teeth; ++i)
        for (int k = 0; k < 2 * (facets + 1); ++k) {
            const bool rises = k <= facets;
            const double share = double(k % (facets + 1)) / facets,
                         radius = root + (1 - root) * (rises ? share : 1 - share);
            const double angle = 2 * std::numbers::pi / teeth *
                                 (i + (rises ? 0.05 + 0.25 * std::sqrt(share) : 0.9 - 0.3 * std::sqrt(1 - share)));
            outline.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
        }
    return outline;
}

/// A profile of (radius, height), from the axis below to the axis above, turned around the z axis in some steps; planes
/// are pairs of triangles.
inline gradus::TriangleSoup revolved(const Outline& profile, int steps) {
    gradus::TriangleSoup soup;
    const int rings = static_cast<int>(profile.size()), bottom = rings * steps;
    for (const Eigen::Vector2d& p : profile)
        for (int i = 0; i < steps; ++i) {
            const double angle = 2 * std::numbers::pi * i / steps;
            soup.points.emplace_back(p.x() * std::cos(angle), p.x() * std::sin(angle), p.y());
        }
    soup.points.emplace_back(0, 0, profile.front().y());
    soup.points.emplace_back(0, 0, profile.back().y());
    for (int i = 0; i < steps; ++i) {
        const int j = (i + 1) % steps, top = (rings - 1) * steps;
        soup.triangles.push_back({bottom, j, i});
        soup.triangles.push_back({bottom + 1, top + i, top + j});
        for (int k = 0; k + 1 < rings; ++k) {
            const int a = k * steps + i, b = k * steps + j;
            soup.triangles.insert(soup.triangles.end(), {{a, b, b + steps}, {a, b + steps, a + steps}});
        }
    }
    return soup;
}

/// A box about the origin whose edges and corners are rounds of some facets each; flat faces are pairs of triangles.
inline gradus::TriangleSoup rounded_box(const Eigen::Vector3d& size, double radius, int facets) {
    gradus::TriangleSoup soup;
    const int columns = 4 * (facets + 1), rows = 2 * facets;  // all but the poles of the corners
    const Eigen::Vector3d inner = size / 2 - Eigen::Vector3d::Constant(radius);
    const auto point = [&](int corner, int side, double longitude, double latitude) {
        const Eigen::Vector3d sign(corner == 0 || corner == 3 ? 1 : -1, corner < 2 ? 1 : -1, side);
        const Eigen::Vector3d way(std::cos(latitude) * std::cos(longitude), std::cos(latitude) * std::sin(longitude),
                                  std::sin(latitude));
        soup.points.push_back(sign.cwiseProduct(inner) + radius * way);
    };
    const double step = std::numbers::pi / 2 / facets;
    for (int row = 0; row < rows; ++row) {
        const bool upper = row >= facets;
        const double latitude = upper ? (row - facets) * step : (row + 1 - facets) * step;
        for (int column = 0; column < columns; ++column) {
            const int corner = column / (facets + 1);
            point(corner, upper ? 1 : -1, (corner * facets + column % (facets + 1)) * step, latitude);
        }
    }
    const int poles = rows * columns;
    for (const int side : {-1, 1})
        for (int corner = 0; corner < 4; ++corner) point(corner, side, 0, side * std::numbers::pi / 2);
    for (int row = 0; row + 1 < rows; ++row)
        for (int c = 0; c < columns; ++c) {
            const int a = row * columns + c, b = row * columns + (c + 1) % columns;
            soup.triangles.insert(soup.triangles.end(), {{a, b, b + columns}, {a, b + columns, a + columns}});
        }
    for (int c = 0; c < columns; ++c) {
        const int next = (c + 1) % columns, here = c / (facets + 1), there = next / (facets + 1),
                  top = (rows - 1) * columns;
        soup.triangles.insert(soup.triangles.end(), {{poles + here, next, c}, {poles + 4 + here, top + c, top + next}});
        if (here != there)
            soup.triangles.insert(soup.triangles.end(), {{poles + here, poles + there, next},
                                                         {poles + 4 + there, poles + 4 + here, top + next}});
    }
    soup.triangles.insert(soup.triangles.end(), {{poles, poles + 2, poles + 1}, {poles, poles + 3, poles + 2}});
    soup.triangles.insert(soup.triangles.end(), {{poles + 4, poles + 5, poles + 6}, {poles + 4, poles + 6, poles + 7}});
    return soup;
}

inline double volume(const gradus::TriangleSoup& soup) {
    double sum = 0;
    for (const gradus::Triangle& t : soup.triangles)
        sum += soup.points[t[0]].dot(soup.points[t[1]].cross(soup.points[t[2]])) / 6;
    return sum;
}

}  // namespace parts

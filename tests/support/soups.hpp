/// Triangle soups for tests.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>

#include "gradus/mesh/soup.hpp"

namespace support {

/// A finite double of any magnitude: denormal, huge, tiny.
inline double any_double(std::mt19937_64& random) {
    while (true)
        if (const double value = std::bit_cast<double>(random()); std::isfinite(value)) return value;
}

/// A square of 2 n^2 triangles over [0, 1]^2, curved.
inline gradus::TriangleSoup grid(int n) {
    gradus::TriangleSoup soup;
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) {
            const double x = i / (1.0 * n), y = j / (1.0 * n);
            soup.points.push_back({x, y, 0.2 * std::sin(5 * x) * std::cos(4 * y)});
        }
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const int a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
            soup.triangles.push_back({a, b, d});
            soup.triangles.push_back({a, d, c});
        }
    return soup;
}

inline gradus::TriangleSoup tetrahedron() {
    gradus::TriangleSoup soup;
    soup.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    soup.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
    return soup;
}

/// Points of any magnitude, extremes among them, and triangles of any topology with everything that may come along.
inline gradus::TriangleSoup wild_soup(unsigned seed) {
    std::mt19937_64 random(seed);
    const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
    gradus::TriangleSoup soup;
    soup.points = {
        {5e-324, -2.2250738585072011e-308, 1e300}, {1.7976931348623157e308, -0.0, 0.1}, {1.0 / 3, 1e-300, -1e22}};
    while (soup.points.size() < 60) soup.points.push_back({any_double(random), any_double(random), any_double(random)});
    for (int t = 0; t < 100; ++t) {
        soup.triangles.push_back({below(60), below(60), below(60)});
        soup.labels.push_back(1 + below(7));
    }
    for (int i = 0; i < 40; ++i)
        soup.parameters.push_back({below(60), {below(9), {any_double(random), any_double(random)}}});
    for (int i = 0; i < 15; ++i) soup.edges.push_back({below(60), below(60)});
    for (int i = 0; i < 5; ++i) soup.corners.push_back(below(60));
    for (int i = 0; i < 4; ++i) soup.required.vertices.push_back(below(60));
    // Some are features too.
    soup.required.edges = {soup.edges[2], {1, 2}, soup.edges[9]};
    for (int i = 0; i < 6; ++i) soup.required.triangles.push_back(below(100));
    return soup;
}

inline bool same_bits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

inline bool same_bits(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return same_bits(a[0], b[0]) && same_bits(a[1], b[1]) && same_bits(a[2], b[2]);
}

inline bool same_points(const gradus::TriangleSoup& a, const gradus::TriangleSoup& b) {
    return std::equal(a.points.begin(), a.points.end(), b.points.begin(), b.points.end(),
                      [](const auto& p, const auto& q) { return same_bits(p, q); });
}

}  // namespace support

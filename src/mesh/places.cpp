#include "places.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "cells.hpp"
#include "flat.hpp"

namespace gradus {
namespace {

constexpr int kNone = -1;

}  // namespace

Points to_unit_box(const Points& points, const std::vector<char>& used) {
    double largest = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
        if (used[i]) largest = std::max(largest, points[i].cwiseAbs().maxCoeff());
    int exponent = 0;
    std::frexp(largest, &exponent);
    Points result(points.size(), Eigen::Vector3d::Zero());
    for (std::size_t i = 0; i < points.size(); ++i)
        if (used[i]) result[i] = scaled_by_power(points[i], -exponent);
    return result;
}

std::vector<int> equal_places(const Points& points, const std::vector<char>& used) {
    std::vector<int> order;
    for (int i = 0; i < static_cast<int>(points.size()); ++i)
        if (used[i]) order.push_back(i);
    const auto key = [&](int i) { return std::tuple(points[i].x(), points[i].y(), points[i].z(), i); };
    std::sort(order.begin(), order.end(), [&](int a, int b) { return key(a) < key(b); });
    std::vector<int> place(points.size(), kNone);
    for (std::size_t first = 0, k = 0; k < order.size(); ++k) {
        if (points[order[k]] != points[order[first]]) first = k;
        place[order[k]] = order[first];
    }
    return place;
}

std::vector<int> close_places(const Points& points, const std::vector<char>& used, double tolerance) {
    Eigen::Vector3d low = Eigen::Vector3d::Constant(2), high = -low;
    for (std::size_t i = 0; i < points.size(); ++i)
        if (used[i]) low = low.cwiseMin(points[i]), high = high.cwiseMax(points[i]);
    const double distance = tolerance * (high - low).norm();
    // Cells of a grid, counted in no more than 20 bits along each axis; few stay in one, as they are a tolerance apart.
    const double cell = std::max(distance, std::max((high - low).maxCoeff(), 1e-300) / (1 << 20));
    Cells stay(low, cell);
    std::vector<int> place(points.size(), kNone);
    for (int i = 0; i < static_cast<int>(points.size()); ++i) {
        if (!used[i]) continue;
        double closest = distance;
        stay.for_each_near(points[i], [&](int other) {
            const double d = (points[other] - points[i]).norm();
            const bool closer = place[i] == kNone ? d <= closest : d < closest || (d == closest && other < place[i]);
            if (closer) closest = d, place[i] = other;
        });
        if (place[i] != kNone) continue;
        place[i] = i;
        stay.insert(points[i], i);
    }
    return place;
}

}  // namespace gradus

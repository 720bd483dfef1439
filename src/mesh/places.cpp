#include "places.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <tuple>
#include <unordered_map>

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
    const auto key = [](const Eigen::Vector3i& c) {
        return static_cast<std::uint64_t>(c.x() + 1) << 42 | static_cast<std::uint64_t>(c.y() + 1) << 21 |
               static_cast<std::uint64_t>(c.z() + 1);
    };
    std::unordered_map<std::uint64_t, std::vector<int>> stay;
    std::vector<int> place(points.size(), kNone);
    for (int i = 0; i < static_cast<int>(points.size()); ++i) {
        if (!used[i]) continue;
        const Eigen::Vector3i centre = ((points[i] - low) / cell).cast<int>();
        double closest = distance;
        for (int k = 0; k < 27; ++k) {
            const auto found = stay.find(key(centre + Eigen::Vector3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1)));
            if (found == stay.end()) continue;
            for (const int other : found->second) {
                const double d = (points[other] - points[i]).norm();
                const bool closer =
                    place[i] == kNone ? d <= closest : d < closest || (d == closest && other < place[i]);
                if (closer) closest = d, place[i] = other;
            }
        }
        if (place[i] != kNone) continue;
        place[i] = i;
        stay[key(centre)].push_back(i);
    }
    return place;
}

}  // namespace gradus

#include "gradus/mesh/closest.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

#include "gradus/mesh/order.hpp"

namespace gradus {

namespace {

constexpr int kLeaf = 4;

std::vector<int> all_of(std::span<const Triangle> triangles) {
    std::vector<int> all(triangles.size());
    std::iota(all.begin(), all.end(), 0);
    return all;
}

}  // namespace

// By the region of the plane that p lies over. [Ericson 2005, 5.1.5]
Eigen::Vector3d closest_point(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                              const Eigen::Vector3d& c) {
    const Eigen::Vector3d ab = b - a, ac = c - a, ap = p - a;
    const double d1 = ab.dot(ap), d2 = ac.dot(ap);
    if (d1 <= 0 && d2 <= 0) return a;
    const Eigen::Vector3d bp = p - b;
    const double d3 = ab.dot(bp), d4 = ac.dot(bp);
    if (d3 >= 0 && d4 <= d3) return b;
    const Eigen::Vector3d cp = p - c;
    const double d5 = ab.dot(cp), d6 = ac.dot(cp);
    if (d6 >= 0 && d5 <= d6) return c;
    const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
    if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 > d3) return a + d1 / (d1 - d3) * ab;
    if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 > d6) return a + d2 / (d2 - d6) * ac;
    if (va <= 0 && d4 >= d3 && d5 >= d6 && (d4 - d3) + (d5 - d6) > 0)
        return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
    const double sum = va + vb + vc;
    if (sum > 0) return a + (vb / sum) * ab + (vc / sum) * ac;
    // Without area, and rounding has hidden the side it is on.
    const auto on_side = [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
        const Eigen::Vector3d along = to - from;
        const double squared = along.squaredNorm();
        return squared > 0 ? Eigen::Vector3d(from + std::clamp((p - from).dot(along) / squared, 0.0, 1.0) * along)
                           : from;
    };
    Eigen::Vector3d best = on_side(a, b);
    for (const Eigen::Vector3d& q : {on_side(b, c), on_side(c, a)})
        if ((q - p).squaredNorm() < (best - p).squaredNorm()) best = q;
    return best;
}

ClosestTriangle::ClosestTriangle(std::span<const Eigen::Vector3d> points, std::span<const Triangle> triangles)
    : ClosestTriangle(points, triangles, all_of(triangles)) {}

// What is next to each other along a Z-curve is next to each other in space: its halves are boxes without looking for
// the best cut.
ClosestTriangle::ClosestTriangle(std::span<const Eigen::Vector3d> points, std::span<const Triangle> triangles,
                                 std::vector<int> chosen)
    : points_(points), triangles_(triangles), chosen_(std::move(chosen)) {
    const auto centre = [&](int t) {
        const Triangle& v = triangles_[t];
        return Eigen::Vector3d(points_[v[0]] + points_[v[1]] + points_[v[2]]);
    };
    Eigen::AlignedBox3d box;
    for (const int t : chosen_) box.extend(centre(t));
    const ZCurve curve(box);
    std::vector<Coded> coded;
    coded.reserve(chosen_.size());
    for (const int t : chosen_) coded.emplace_back(curve.code(centre(t)), t);
    std::sort(coded.begin(), coded.end());
    for (std::size_t i = 0; i < coded.size(); ++i) chosen_[i] = coded[i].second;
    nodes_.reserve(2 * chosen_.size() / kLeaf + 2);
    build(coded, 0, static_cast<int>(chosen_.size()));
}

int ClosestTriangle::build(std::span<const Coded> coded, int first, int last) {
    const int index = static_cast<int>(nodes_.size());
    nodes_.push_back({{}, first, last});
    Box box;
    if (last - first <= kLeaf) {
        for (int i = first; i < last; ++i)
            for (const int v : triangles_[chosen_[i]]) box.extend({points_[v], points_[v]});
    } else {
        // Where the highest bit that is not the same for all changes.
        int middle = (first + last) / 2;
        if (const std::uint64_t differ = coded[first].first ^ coded[last - 1].first; differ != 0) {
            const std::uint64_t bit = std::bit_floor(differ);
            middle = static_cast<int>(std::partition_point(coded.begin() + first, coded.begin() + last,
                                                           [bit](const Coded& c) { return (c.first & bit) == 0; }) -
                                      coded.begin());
        }
        build(coded, first, middle);
        const int right = nodes_[index].right = build(coded, middle, last);
        box.extend(nodes_[index + 1].box);
        box.extend(nodes_[right].box);
    }
    nodes_[index].box = box;
    return index;
}

void ClosestTriangle::descend(int index, const Eigen::Vector3d& p, double& squared, int& triangle) const {
    const Node& node = nodes_[index];
    if (node.right < 0) {
        for (int i = node.first; i < node.last; ++i) {
            const int t = chosen_[i];
            const Triangle& v = triangles_[t];
            const double d = (closest_point(p, points_[v[0]], points_[v[1]], points_[v[2]]) - p).squaredNorm();
            if (d < squared || (d == squared && t < triangle)) squared = d, triangle = t;
        }
        return;
    }
    const int left = index + 1, right = node.right;
    const double to_left = nodes_[left].box.squared_distance(p), to_right = nodes_[right].box.squared_distance(p);
    const bool left_first = to_left <= to_right;
    // An equally distant box may hold an equally distant triangle of smaller index.
    if (std::min(to_left, to_right) <= squared) descend(left_first ? left : right, p, squared, triangle);
    if (std::max(to_left, to_right) <= squared) descend(left_first ? right : left, p, squared, triangle);
}

std::vector<int> ClosestTriangle::within(const Eigen::Vector3d& p, double distance) const {
    std::vector<int> found, left{0};
    while (!left.empty()) {
        const int index = left.back();
        const Node& node = nodes_[index];
        left.pop_back();
        if (node.box.squared_distance(p) > distance * distance) continue;
        if (node.right >= 0) {
            left.insert(left.end(), {index + 1, node.right});
            continue;
        }
        for (int i = node.first; i < node.last; ++i) {
            const Triangle& v = triangles_[chosen_[i]];
            if ((closest_point(p, points_[v[0]], points_[v[1]], points_[v[2]]) - p).norm() <= distance)
                found.push_back(chosen_[i]);
        }
    }
    std::sort(found.begin(), found.end());
    return found;
}

void ClosestTriangle::look(int index, const Cone& cone, const Accept& accept, double& squared, int& triangle) const {
    const Node& node = nodes_[index];
    // Farthest along the axis that a point of the box is: all of it beside the cone is nothing to look at.
    const Eigen::Vector3d middle = (node.box.low + node.box.high) / 2 - cone.apex,
                          half = (node.box.high - node.box.low) / 2;
    const double height = std::abs(middle.dot(cone.axis)) + half.dot(cone.axis.cwiseAbs());
    if (height * height < cone.cosine * cone.cosine * node.box.squared_distance(cone.apex)) return;
    if (node.right < 0) {
        for (int i = node.first; i < node.last; ++i) {
            const int t = chosen_[i];
            const Triangle& v = triangles_[t];
            const Eigen::Vector3d q = closest_point(cone.apex, points_[v[0]], points_[v[1]], points_[v[2]]);
            const double d = (q - cone.apex).squaredNorm();
            if (d > squared || (d == squared && t >= triangle) || d == 0) continue;
            if (std::abs((q - cone.apex).dot(cone.axis)) < cone.cosine * std::sqrt(d) || !accept(t, q)) continue;
            squared = d, triangle = t;
        }
        return;
    }
    const int left = index + 1, right = node.right;
    const double to_left = nodes_[left].box.squared_distance(cone.apex),
                 to_right = nodes_[right].box.squared_distance(cone.apex);
    const bool left_first = to_left <= to_right;
    if (std::min(to_left, to_right) <= squared) look(left_first ? left : right, cone, accept, squared, triangle);
    if (std::max(to_left, to_right) <= squared) look(left_first ? right : left, cone, accept, squared, triangle);
}

ClosestTriangle::Hit ClosestTriangle::closest_in_cone(const Cone& cone, double reach, const Accept& accept) const {
    double squared = reach * reach;
    int triangle = std::numeric_limits<int>::max();
    look(0, cone, accept, squared, triangle);
    if (triangle == std::numeric_limits<int>::max()) return {};
    return {triangle, std::sqrt(squared)};
}

ClosestTriangle::Hit ClosestTriangle::closest(const Eigen::Vector3d& p, int near) const {
    double squared = std::numeric_limits<double>::infinity();
    int triangle = -1;
    if (near >= 0) {
        const Triangle& v = triangles_[near];
        squared = (closest_point(p, points_[v[0]], points_[v[1]], points_[v[2]]) - p).squaredNorm();
        triangle = near;
    }
    descend(0, p, squared, triangle);
    return {triangle, std::sqrt(squared)};
}

}  // namespace gradus

#include "gradus/mesh/closest.hpp"

#include <algorithm>
#include <cmath>

namespace gradus {

namespace {

constexpr int kLeaf = 4;

Eigen::Vector3d closest_on_segment(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    const Eigen::Vector3d ab = b - a;
    const double squared = ab.squaredNorm();
    return squared > 0 ? Eigen::Vector3d(a + std::clamp((p - a).dot(ab) / squared, 0.0, 1.0) * ab) : a;
}

}  // namespace

Eigen::Vector3d closest_point(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    const Eigen::Vector3d ab = b - a, ac = c - a, ap = p - a;
    const double g11 = ab.squaredNorm(), g12 = ab.dot(ac), g22 = ac.squaredNorm(), r1 = ap.dot(ab), r2 = ap.dot(ac);
    const double det = g11 * g22 - g12 * g12;
    if (det > 0) {
        const double u = (r1 * g22 - r2 * g12) / det, v = (r2 * g11 - r1 * g12) / det;
        if (u >= 0 && v >= 0 && u + v <= 1) return a + u * ab + v * ac;
    }
    Eigen::Vector3d best = closest_on_segment(p, a, b);
    for (const Eigen::Vector3d& q : {closest_on_segment(p, b, c), closest_on_segment(p, c, a)})
        if ((q - p).squaredNorm() < (best - p).squaredNorm()) best = q;
    return best;
}

ClosestTriangle::ClosestTriangle(std::span<const Eigen::Vector3d> points, std::span<const Triangle> triangles, std::vector<int> chosen)
    : points_(points), triangles_(triangles), chosen_(std::move(chosen)) {
    nodes_.reserve(2 * chosen_.size() / kLeaf + 2);
    build(0, static_cast<int>(chosen_.size()));
}

int ClosestTriangle::build(int first, int last) {
    const int index = static_cast<int>(nodes_.size());
    Node node{{points_[triangles_[chosen_[first]][0]], points_[triangles_[chosen_[first]][0]]}, first, last};
    for (int i = first; i < last; ++i)
        for (const int v : triangles_[chosen_[i]]) {
            node.box.low = node.box.low.cwiseMin(points_[v]);
            node.box.high = node.box.high.cwiseMax(points_[v]);
        }
    nodes_.push_back(node);
    if (last - first <= kLeaf) return index;
    int axis = 0;
    (node.box.high - node.box.low).maxCoeff(&axis);
    const auto centre = [&](int t) {
        const Triangle& v = triangles_[t];
        return points_[v[0]][axis] + points_[v[1]][axis] + points_[v[2]][axis];
    };
    const int middle = (first + last) / 2;
    std::nth_element(chosen_.begin() + first, chosen_.begin() + middle, chosen_.begin() + last, [&](int s, int t) {
        const double x = centre(s), y = centre(t);
        return x != y ? x < y : s < t;
    });
    build(first, middle);
    const int right = build(middle, last);
    nodes_[index].right = right;
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

void ClosestTriangle::look(int index, const Cone& cone, const Accept& accept, double& squared, int& triangle) const {
    const Node& node = nodes_[index];
    // Farthest along the axis that a point of the box is: all of it beside the cone is nothing to look at.
    const Eigen::Vector3d middle = (node.box.low + node.box.high) / 2 - cone.apex, half = (node.box.high - node.box.low) / 2;
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
    const double to_left = nodes_[left].box.squared_distance(cone.apex), to_right = nodes_[right].box.squared_distance(cone.apex);
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

#include "gradus/mesh/order.hpp"

#include <algorithm>
#include <numeric>

namespace gradus {

namespace {

constexpr int kBits = 21;          // of a coordinate, in a code of 63
constexpr double kLargest = 1e40;  // of a coordinate; what is beyond no surface has

// The bits of a whole number below 2^21, two zeros between each and the next.
std::uint64_t spread_bits(double x) {
    auto bits = static_cast<std::uint64_t>(x);
    bits = (bits | bits << 32) & 0x001f00000000ffffULL;
    bits = (bits | bits << 16) & 0x001f0000ff0000ffULL;
    bits = (bits | bits << 8) & 0x100f00f00f00f00fULL;
    bits = (bits | bits << 4) & 0x10c30c30c30c30c3ULL;
    bits = (bits | bits << 2) & 0x1249249249249249ULL;
    return bits;
}

// Items by number, in the order of their keys.
template <class Item, class Key>
std::vector<int> order_by(const std::vector<Item>& items, const Key& key_of) {
    std::vector<std::pair<decltype(key_of(items[0])), int>> keyed;
    keyed.reserve(items.size());
    for (const Item& item : items) keyed.emplace_back(key_of(item), static_cast<int>(keyed.size()));
    std::sort(keyed.begin(), keyed.end());
    std::vector<int> order;
    order.reserve(keyed.size());
    for (const auto& [key, number] : keyed) order.push_back(number);
    return order;
}

// For each number its place in an order.
std::vector<int> places_in(const std::vector<int>& order) {
    std::vector<int> place(order.size());
    for (std::size_t i = 0; i < order.size(); ++i) place[order[i]] = static_cast<int>(i);
    return place;
}

}  // namespace

ZCurve::ZCurve(const Eigen::AlignedBox3d& box) : low_(box.min()) {
    const double extent = box.isEmpty() ? 0 : box.sizes().maxCoeff();
    scale_ = extent > 0 ? static_cast<double>((1 << kBits) - 1) / extent : 0;
}

std::uint64_t ZCurve::code(const Eigen::Vector3d& p) const {
    const Eigen::Vector3d at = (p - low_) * scale_;
    return spread_bits(at.x()) | spread_bits(at.y()) << 1 | spread_bits(at.z()) << 2;
}

Ordered as_it_is(TriangleSoup soup) {
    const auto numbers = [](std::size_t count) {
        std::vector<int> all(count);
        std::iota(all.begin(), all.end(), 0);
        return all;
    };
    std::vector<int> points = numbers(soup.points.size()), triangles = numbers(soup.triangles.size());
    return {std::move(soup), std::move(points), std::move(triangles)};
}

Ordered along_curve(TriangleSoup soup) {
    const bool sortable = std::all_of(soup.points.begin(), soup.points.end(),
                                      [](const Eigen::Vector3d& p) { return (p.array().abs() < kLargest).all(); });
    if (!sortable) return as_it_is(std::move(soup));
    Ordered ordered;
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d& p : soup.points) box.extend(p);
    const ZCurve curve(box);
    ordered.point_source = order_by(soup.points, [&](const Eigen::Vector3d& p) { return curve.code(p); });
    const std::vector<int> point = places_in(ordered.point_source);
    reorder(soup.points, ordered.point_source);
    for (Triangle& t : soup.triangles)
        for (int& v : t) v = point[v];
    for (TriangleSoup::Parameters& parameters : soup.parameters) parameters.vertex = point[parameters.vertex];
    for (std::array<int, 2>& edge : soup.edges) edge = {point[edge[0]], point[edge[1]]};
    for (int& v : soup.corners) v = point[v];
    for (int& v : soup.required.vertices) v = point[v];
    for (std::array<int, 2>& edge : soup.required.edges) edge = {point[edge[0]], point[edge[1]]};

    ordered.triangle_source =
        order_by(soup.triangles, [](const Triangle& t) { return int{*std::min_element(t.begin(), t.end())}; });
    const std::vector<int> triangle = places_in(ordered.triangle_source);
    reorder(soup.triangles, ordered.triangle_source);
    if (!soup.labels.empty()) reorder(soup.labels, ordered.triangle_source);
    for (int& t : soup.required.triangles) t = triangle[t];
    ordered.soup = std::move(soup);
    return ordered;
}

}  // namespace gradus

#include "curve_deviation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "gradus/mesh/closest.hpp"
#include "gradus/mesh/edge.hpp"

namespace gradus {

namespace {

using Eigen::Vector3d;

constexpr double kOnCurve = 1e-9;  // of the diagonal: vertices on a curve are there to rounding

double distance_to_segment(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
    return (closest_point(p, a, b, b) - p).norm();
}

}  // namespace

CurveDeviation::CurveDeviation(const Triangulation& surface) : surface_(surface) {
    for (const FeatureChain& chain : surface.features().chains)
        for (int i = 0; i < chain.num_edges(); ++i) number_[edge_between(chain.vertex(i), chain.vertex(i + 1))] = i;
}

// The point of the triangulation under a vertex, which may bulge from there.
Vector3d CurveDeviation::foot_of(const SurfaceMesh& mesh, int v) const {
    const SurfacePoint& at = mesh.places[v];
    const Triangle& t = surface_.soup().triangles[at.patch];
    const std::vector<Vector3d>& points = surface_.soup().points;
    return points[t[0]] + at.uv.x() * (points[t[1]] - points[t[0]]) + at.uv.y() * (points[t[2]] - points[t[0]]);
}

// On every curve that a vertex lies on; twice on a closed one where that begins.
std::vector<CurveDeviation::Position> CurveDeviation::positions_of(const SurfaceMesh& mesh, int v) const {
    const Connectivity& of = surface_.mesh();
    const std::vector<Vector3d>& points = surface_.soup().points;
    const Vector3d foot = foot_of(mesh, v);
    std::vector<Position> positions;
    const auto add = [&](int h) {
        const int chain = of.tag(h);
        if (chain < 0) return;
        const FeatureChain& curve = surface_.features().chains[chain];
        const int i = number_.at(edge_between(of.origin(h), of.target(h)));
        const Vector3d &a = points[curve.vertex(i)], &b = points[curve.vertex(i + 1)];
        if (distance_to_segment(foot, a, b) > kOnCurve * surface_.diagonal()) return;
        const double at = i + std::clamp((foot - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
        const auto is_same = [&](const Position& p) { return p.chain == chain && p.at == at; };
        if (std::none_of(positions.begin(), positions.end(), is_same)) positions.push_back({chain, at});
    };
    const int t = mesh.places[v].patch;
    for (int k = 0; k < 3; ++k)
        of.for_each_outgoing(of.origin(3 * t + k), [&](int h) {
            add(h);
            add(Connectivity::prev(h));
        });
    return positions;
}

// Of the vertices of a curve strictly between two of its places; beyond the end of a closed one it goes on.
CurveDeviation::Farthest CurveDeviation::farthest_between(const Vector3d& p, const Vector3d& q, int chain, double from,
                                                          double to) const {
    const FeatureChain& curve = surface_.features().chains[chain];
    Farthest farthest;
    for (int i = static_cast<int>(std::floor(from)) + 1; i < to; ++i) {
        const int v = curve.vertex(i);
        if (const double d = distance_to_segment(surface_.soup().points[v], p, q); d > farthest.distance)
            farthest = {d, v};
    }
    return farthest;
}

CurveDeviation::Farthest CurveDeviation::farthest_of(const SurfaceMesh& mesh, const std::array<int, 2>& edge,
                                                     double limit) const {
    const Vector3d &p = mesh.points[edge[0]], &q = mesh.points[edge[1]];
    std::optional<Farthest> nearest;
    const auto try_stretch = [&](int chain, double from, double to) {
        const Farthest farthest = farthest_between(p, q, chain, from, to);
        if (!nearest || farthest.distance < nearest->distance) nearest = farthest;
    };
    const std::vector<Position> ends = positions_of(mesh, edge[1]);
    for (const Position& a : positions_of(mesh, edge[0]))
        for (const Position& b : ends) {
            if (a.chain != b.chain) continue;
            const auto [from, to] = std::minmax(a.at, b.at);
            const FeatureChain& curve = surface_.features().chains[a.chain];
            const double around = curve.num_edges();
            const bool is_short = to - from <= around / 2;
            if (!curve.closed || is_short) try_stretch(a.chain, from, to);
            if (!curve.closed || (is_short && nearest->distance <= limit)) continue;
            try_stretch(a.chain, to, from + around);
            if (!is_short) try_stretch(a.chain, from, to);
        }
    Farthest farthest = nearest.value_or(Farthest{});
    for (const int v : edge)
        if (const double bulge = (mesh.points[v] - foot_of(mesh, v)).norm(); bulge > farthest.distance)
            farthest = {bulge, surface_.soup().triangles[mesh.places[v].patch][0]};
    return farthest;
}

OneSidedDistance CurveDeviation::measure(const SurfaceMesh& mesh, double limit) const {
    OneSidedDistance found;
    std::vector<std::pair<Farthest, std::array<int, 2>>> beyond;
    for (const std::array<int, 2>& edge : mesh.features) {
        const Farthest farthest = farthest_of(mesh, edge, limit);
        if (farthest.distance > found.largest) {
            found.largest = found.bound = farthest.distance;
            found.point = surface_.soup().points[farthest.vertex];
        }
        if (farthest.distance > limit) beyond.emplace_back(farthest, edge_between(edge[0], edge[1]));
    }
    if (beyond.empty()) return found;
    std::map<std::array<int, 2>, int> triangle;
    for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t)
        for (int k = 0; k < 3; ++k)
            triangle.emplace(edge_between(mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]), t);
    for (const auto& [farthest, edge] : beyond)
        found.beyond.push_back({triangle.at(edge), farthest.distance, surface_.soup().points[farthest.vertex],
                                surface_.mesh().outgoing(farthest.vertex) / 3});
    return found;
}

}  // namespace gradus

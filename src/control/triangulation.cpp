#include "gradus/control/triangulation.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace gradus {

namespace {

using Eigen::Vector3d;

constexpr double kSizeTolerance = 0.2;  // |ln(size / interpolated size)| at the middle of an edge that is worth a cut
constexpr double kShortest = 1;         // metric length of edges that are never cut: the mesh could not show more
constexpr int kMostPasses = 40;
constexpr double kEdgeShare = 2.5;      // of the rule's chord error, that single edges of the triangulation may be cut off by
// Squares of areas and of curvatures, and products of them with lengths, are to be doubles.
constexpr double kLargestCoordinate = 1e40, kLeastDiagonal = 1e-40;

double circle_curvature(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
    const Vector3d u = b - a, v = c - b, w = c - a;
    const double lengths = u.norm() * v.norm() * w.norm();
    return lengths > 0 ? 2 * u.cross(v).norm() / lengths : 0;
}

std::vector<double> curvature_of_chains(std::span<const Vector3d> points, const Features& features) {
    std::vector<double> curvature(points.size(), 0);
    for (const FeatureChain& chain : features.chains) {
        const int n = static_cast<int>(chain.vertices.size());
        for (int i = chain.closed ? 0 : 1; i < (chain.closed ? n : n - 1); ++i)
            curvature[chain.vertices[i]] = circle_curvature(points[chain.vertex(i + n - 1)], points[chain.vertices[i]], points[chain.vertex(i + 1)]);
    }
    return curvature;
}

double diagonal_of(const TriangleSoup& soup) {
    if (soup.triangles.empty()) throw std::invalid_argument("a surface without triangles");
    Vector3d low = soup.points[soup.triangles[0][0]], high = low;
    for (const Triangle& t : soup.triangles)
        for (const int v : t) {
            const Vector3d& point = soup.points[v];
            if (!point.allFinite()) throw std::invalid_argument(fmt::format("vertex {} has a coordinate that is not finite", v));
            if (const double largest = point.cwiseAbs().maxCoeff(); largest > kLargestCoordinate)
                throw std::invalid_argument(fmt::format("vertex {} has a coordinate of size {:.3g}, beyond {:g}; choose a larger unit of length",
                                                        v, largest, kLargestCoordinate));
            low = low.cwiseMin(point);
            high = high.cwiseMax(point);
        }
    const double diagonal = (high - low).stableNorm();
    if (diagonal == 0) throw std::invalid_argument("a surface without extent");
    if (diagonal < kLeastDiagonal)
        throw std::invalid_argument(
            fmt::format("the surface has a diagonal of {:.3g}, below {:g}; choose a smaller unit of length", diagonal, kLeastDiagonal));
    const bool has_area = std::any_of(soup.triangles.begin(), soup.triangles.end(), [&](const Triangle& t) {
        return (soup.points[t[1]] - soup.points[t[0]]).cross(soup.points[t[2]] - soup.points[t[0]]).norm() > 0;
    });
    if (!has_area) throw std::invalid_argument("a surface without area");
    return diagonal;
}

}  // namespace

Triangulation::Triangulation(TriangleSoup soup, const TriangulationOptions& options)
    : soup_(std::move(soup)), mesh_(static_cast<int>(soup_.points.size()), soup_.triangles), diagonal_(diagonal_of(soup_)) {
    KnownFeatures known{.edges = soup_.edges, .corners = soup_.corners};
    if (options.label_borders) known.labels = soup_.labels;
    features_ = find_features(soup_.points, mesh_, options.features, known);
    wedges_ = wedges_of(mesh_);
    const std::vector<Vector3d> normals = wedge_normals(soup_.points, mesh_, wedges_);
    curvature_ = estimate_curvature(soup_.points, mesh_, wedges_, normals, {.least_curvature = options.least_curvature});
    curve_curvature_ = curvature_of_chains(soup_.points, features_);
}

SmoothSupport Triangulation::support(const SmoothSupport::Options& options) const {
    std::vector<Vector3d> normals;
    normals.reserve(curvature_.size());
    for (const WedgeCurvature& c : curvature_) normals.push_back(c.normal);
    return SmoothSupport(soup_.points, mesh_, features_, wedges_, std::move(normals), options);
}

namespace {

TriangulationBackground background_of(std::span<const Vector3d> points, std::span<const Triangle> triangles, std::span<const double> sizes) {
    TriangulationBackground background{{make_mesh(points, triangles), {}, {}}, {sizes.begin(), sizes.end()}, std::vector<int>(points.size(), 0)};
    for (int t = static_cast<int>(triangles.size()) - 1; t >= 0; --t)
        for (const int v : triangles[t]) background.cells[v] = t;
    return background;
}

// The background while it is cut: curvature by corner, so that each side of a feature has its own.
class Cutter {
  public:
    Cutter(const Triangulation& surface, const SizingRule& rule)
        : rule_(rule), mesh_(surface.mesh()), points_(surface.soup().points), on_curve_(surface.curve_curvature()), at_corner_(3 * static_cast<std::size_t>(mesh_.num_triangles())) {
        for (std::size_t h = 0; h < at_corner_.size(); ++h) at_corner_[h] = std::abs(surface.curvature()[surface.wedges().of_corner[h]].k1);
        if (rule.kind == SizingRule::Kind::ChordError) heed_edges();
        sizes_.resize(points_.size(), rule.hmax);
        for (int v = 0; v < mesh_.num_vertices(); ++v)
            if (mesh_.is_live_vertex(v)) sizes_[v] = size_at(v);
    }

    void cut(int max_triangles) {
        for (int pass = 0; pass < kMostPasses; ++pass) {
            std::vector<std::pair<double, int>> long_edges;
            for (int h = 0; h < 3 * mesh_.num_triangles(); ++h)
                if (mesh_.twin(h) < h && needs_cut(h)) long_edges.emplace_back(-length(h), h);
            if (long_edges.empty()) return;
            std::sort(long_edges.begin(), long_edges.end());
            // The longest first, and of a triangle's edges only its longest, so that shapes stay what they are.
            for (const auto& [minus, h] : long_edges) {
                if (mesh_.num_triangles() >= max_triangles) return;
                if (-minus == length(h) && needs_cut(h)) split(longest_around(h));
            }
        }
    }

    const std::vector<double>& sizes() const { return sizes_; }

    TriangulationBackground result() const {
        std::vector<Triangle> triangles;
        for (int t = 0; t < mesh_.num_triangles(); ++t) triangles.push_back(mesh_.triangle(t));
        return background_of(points_, triangles, sizes_);
    }

  private:
    double length(int h) const { return (points_[mesh_.target(h)] - points_[mesh_.origin(h)]).norm(); }
    // An edge of length h across one where two facets meet at an angle is h / 2 sin(angle / 2) off it, as long as it reaches no farther
    // than the facets: there they ask for more than the curvature, which is smoothed.
    void heed_edges() {
        for (int h = 0; h < 3 * mesh_.num_triangles(); ++h) {
            const int g = mesh_.twin(h);
            if (g < h || mesh_.tag(h) >= 0) continue;
            const Vector3d edge = points_[mesh_.target(h)] - points_[mesh_.origin(h)];
            const Vector3d n = edge.cross(points_[mesh_.apex(h)] - points_[mesh_.origin(h)]), m = (points_[mesh_.apex(g)] - points_[mesh_.origin(h)]).cross(edge);
            const double angle = std::atan2(n.cross(m).norm(), n.dot(m)), rise = std::sin(angle / 2);
            const double width = std::min(n.norm(), m.norm()) / edge.norm(), gap = kEdgeShare * rule_.value;
            if (!(width * rise > gap)) continue;
            // The radius for which the rule gives the size 2 gap / rise.
            const double size = 2 * gap / rise, radius = (size * size / (4 * rule_.value) + rule_.value) / 2;
            for (const int side : {h, g})
                for (const int e : {side, Connectivity::next(side)}) at_corner_[e] = std::max(at_corner_[e], 1 / radius);
        }
    }

    double size_of(double curvature) const { return size_from_radius(rule_, 1 / std::max(curvature, 1e-300)); }

    double size_at(int v) const {
        double largest = on_curve_[v];
        mesh_.for_each_outgoing(v, [&](int h) { largest = std::max(largest, at_corner_[h]); });
        return size_of(largest);
    }

    double middle_curvature(int h) const { return (at_corner_[h] + at_corner_[Connectivity::next(h)]) / 2; }

    bool needs_cut(int h) const {
        const int g = mesh_.twin(h);
        double curvature = middle_curvature(h);
        if (g >= 0) curvature = std::max(curvature, middle_curvature(g));
        if (mesh_.tag(h) >= 0) curvature = std::max(curvature, (on_curve_[mesh_.origin(h)] + on_curve_[mesh_.target(h)]) / 2);
        const double ha = sizes_[mesh_.origin(h)], hb = sizes_[mesh_.target(h)];
        return length(h) > kShortest * std::min(ha, hb) && std::abs(std::log(size_of(curvature) / std::sqrt(ha * hb))) > kSizeTolerance;
    }

    // The longest edge of the triangles that follow each other, each across the longest edge of the last.
    int longest_around(int h) const {
        for (int step = 0; step < 100; ++step) {
            int longest = h;
            for (const int side : {h, mesh_.twin(h)}) {
                if (side < 0) continue;
                for (const int e : {side, Connectivity::next(side), Connectivity::prev(side)})
                    if (length(e) > length(longest)) longest = e;
            }
            if (longest == h) return h;
            h = longest;
        }
        return h;
    }

    void split(int h) {
        struct Side {
            std::array<int, 3> vertex;
            std::array<double, 3> curvature;
            double middle;
        };
        const int a = mesh_.origin(h), b = mesh_.target(h);
        std::vector<Side> sides;
        for (const int side : {h, mesh_.twin(h)}) {
            if (side < 0) continue;
            const int n = Connectivity::next(side), p = Connectivity::prev(side);
            sides.push_back({{mesh_.origin(side), mesh_.origin(n), mesh_.origin(p)}, {at_corner_[side], at_corner_[n], at_corner_[p]}, middle_curvature(side)});
        }
        const bool feature = mesh_.tag(h) >= 0;
        const int m = mesh_.split(h);
        points_.push_back((points_[a] + points_[b]) / 2);
        on_curve_.push_back(feature ? (on_curve_[a] + on_curve_[b]) / 2 : 0);
        at_corner_.resize(3 * static_cast<std::size_t>(mesh_.num_triangles()));
        mesh_.for_each_outgoing(m, [&](int e) {
            const int n = Connectivity::next(e), p = Connectivity::prev(e);
            // The side that has the corner opposite to the cut edge.
            const int across = mesh_.origin(n) == a || mesh_.origin(n) == b ? mesh_.origin(p) : mesh_.origin(n);
            const Side& side = sides.size() == 1 || sides[0].vertex[2] == across ? sides[0] : sides[1];
            at_corner_[e] = side.middle;
            for (const int corner : {n, p})
                for (int k = 0; k < 3; ++k)
                    if (side.vertex[k] == mesh_.origin(corner)) at_corner_[corner] = side.curvature[k];
        });
        sizes_.push_back(size_at(m));
    }

    const SizingRule& rule_;
    Connectivity mesh_;
    std::vector<Vector3d> points_;
    std::vector<double> on_curve_, at_corner_, sizes_;
};

}  // namespace

TriangulationBackground make_background(const Triangulation& surface, const SizingRule& rule, int max_triangles) {
    check(rule);
    Cutter cutter(surface, rule);
    cutter.cut(max_triangles);
    TriangulationBackground result = cutter.result();
    lower_to_prescribed(rule, points_of(result.background.mesh), result.sizes);
    return result;
}

TriangulationBackground make_background(const Triangulation& surface, std::span<const double> sizes) {
    return background_of(surface.soup().points, surface.soup().triangles, sizes);
}

std::vector<double> geometric_sizes(const Triangulation& surface, const SizingRule& rule) {
    check(rule);
    std::vector<double> sizes = Cutter(surface, rule).sizes();
    lower_to_prescribed(rule, surface.soup().points, sizes);
    return sizes;
}

}  // namespace gradus

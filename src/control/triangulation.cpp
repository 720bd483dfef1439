#include "gradus/control/triangulation.hpp"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <stdexcept>

#include "gradus/control/clearance.hpp"
#include "gradus/control/control_space.hpp"
#include "gradus/mesh/closest.hpp"
#include "gradus/mesh/edge.hpp"
#include "gradus/mesh/labels.hpp"
#include "gradus/mesh/parts.hpp"

namespace gradus {

namespace {

using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kAtEnd = 0.1;          // of an edge, where the width of strips is that at its vertex
constexpr double kSizeTolerance = 0.2;  // |ln(size / interpolated size)| at the middle of an edge that is worth a cut
constexpr double kShortest = 1;         // metric length of edges that are never cut: the mesh could not show more
constexpr double kManyRadii = 4;        // of the sharper end of an edge, that the other is away
constexpr double kHidden = 0.5;  // of the sizes at its ends, from which an edge off features may hide a smaller one
constexpr double kFinestPrescribed = 1e-9;  // of the diagonal, down to which the background is cut at a point
constexpr int kMostPasses = 40;
constexpr double kFlat = 1e-3;  // of the size: two triangles are flat that rise less
constexpr double kNearlyDelaunay = 1e-9;
constexpr std::size_t kMostFlips = 20;  // looks at an edge, on average
constexpr double kFarthestOff = 0.01;   // of the diagonal: meshes of the same surface are nearer to each other
constexpr double kEdgeShare =
    2.4;  // of the rule's chord error, that single edges of the triangulation may be cut off by
// Squares of areas and of curvatures, and products of them with lengths, are to be doubles.
constexpr double kLargestCoordinate = 1e40, kLeastDiagonal = 1e-40;

double circle_curvature(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
    const Vector3d u = b - a, v = c - b, w = c - a;
    const double lengths = u.norm() * v.norm() * w.norm();
    return lengths > 0 ? 2 * u.cross(v).norm() / lengths : 0;
}

// Curvatures at the vertices of feature curves.
class ChainCurvature {
  public:
    // @param finest  one for each vertex
    ChainCurvature(std::span<const Vector3d> points, double negligible_height, std::span<const double> finest)
        : points_(points), negligible_height_(negligible_height), finest_(finest), curvature_(points.size(), 0) {}

    void add(const FeatureChain& chain) {
        const int n = static_cast<int>(chain.vertices.size()), edges = chain.num_edges();
        for (int i = chain.closed ? 0 : 1; i < (chain.closed ? n : n - 1); ++i)
            curvature_[chain.vertices[i]] = circle_curvature(points_[chain.vertex(i + n - 1)],
                                                             points_[chain.vertices[i]], points_[chain.vertex(i + 1)]);
        if (chain.closed) return;
        const auto is_straight = [&](int i) { return is_straight_chord(points_, chain, i); };
        int first = 0, last = edges - 1;
        while (first < edges && !is_straight(first)) ++first;
        while (last >= 0 && !is_straight(last)) --last;
        if (last < 0) return;
        pass_over(chain, first + 1, first, -1);
        pass_over(chain, last, last + 1, 1);
    }

    std::vector<double> result() { return std::move(curvature_); }

  private:
    // From a straight chord to the end of the chain, if the bend there is negligible.
    void pass_over(const FeatureChain& chain, int before, int begin, int step) {
        const Vector3d& origin = points_[chain.vertices[begin]];
        const Vector3d straight = (origin - points_[chain.vertices[before]]).stableNormalized();
        double length = 0, height = 0;
        int i = begin;
        for (; i + step >= 0 && i + step < std::ssize(chain.vertices); i += step) {
            const Vector3d &p = points_[chain.vertices[i]], &q = points_[chain.vertices[i + step]];
            length += (q - p).norm();
            height = std::max(height, (q - origin).cross(straight).norm());
        }
        if (height > negligible_height_ && length > finest_[chain.vertices[begin]]) return;
        for (; i != before; i -= step) curvature_[chain.vertices[i]] = 0;
    }

    std::span<const Vector3d> points_;
    double negligible_height_;
    std::span<const double> finest_;
    std::vector<double> curvature_;
};

// @throws std::invalid_argument for what the constructor does not take
double checked_diagonal(const TriangleSoup& soup) {
    if (soup.triangles.empty()) throw std::invalid_argument("a surface without triangles");
    Vector3d low = soup.points[soup.triangles[0][0]], high = low;
    for (const Triangle& t : soup.triangles)
        for (const int v : t) {
            const Vector3d& point = soup.points[v];
            if (!point.allFinite())
                throw std::invalid_argument(fmt::format("vertex {} has a coordinate that is not finite", v));
            if (const double largest = point.cwiseAbs().maxCoeff(); largest > kLargestCoordinate)
                throw std::invalid_argument(fmt::format(
                    "vertex {} has a coordinate of size {:.3g}, beyond {:g}; choose a larger unit of length", v,
                    largest, kLargestCoordinate));
            low = low.cwiseMin(point);
            high = high.cwiseMax(point);
        }
    const double diagonal = (high - low).stableNorm();
    if (diagonal == 0) throw std::invalid_argument("a surface without extent");
    if (diagonal < kLeastDiagonal)
        throw std::invalid_argument(
            fmt::format("the surface has a diagonal of {:.3g}, below {:g}; choose a smaller unit of length", diagonal,
                        kLeastDiagonal));
    const bool has_area = std::any_of(soup.triangles.begin(), soup.triangles.end(), [&](const Triangle& t) {
        return (soup.points[t[1]] - soup.points[t[0]]).cross(soup.points[t[2]] - soup.points[t[0]]).norm() > 0;
    });
    if (!has_area) throw std::invalid_argument("a surface without area");
    return diagonal;
}

std::vector<double> part_shares(const TriangleSoup& soup, double diagonal) {
    const std::vector<int> part = connected_parts(soup.points.size(), soup.triangles);
    std::vector<Eigen::AlignedBox3d> boxes(soup.points.size());
    for (const Triangle& t : soup.triangles)
        for (const int v : t) boxes[part[v]].extend(soup.points[v]);
    std::vector<double> shares;
    for (const int p : part) shares.push_back(boxes[p].isEmpty() ? 1 : boxes[p].diagonal().norm() / diagonal);
    return shares;
}

// The flat face that a wedge touches, or -1.
std::vector<int> faces_of_wedges(const Wedges& wedges, const FlatFaces& flats) {
    std::vector<int> face(wedges.size(), -1);
    for (int h = 0; h < std::ssize(wedges.of_corner); ++h)
        if (flats.of(h / 3) >= 0) face[wedges.of_corner[h]] = flats.of(h / 3);
    return face;
}

// Curvature jumps where a flat face ends: it is told from each side alone, and what is larger counts. The surface bends
// somewhere in the first row of facets beside the face, for all that is known as much as behind it.
// @param face     of wedges
// @param normals  of facets, averaged around the wedges
std::vector<WedgeCurvature> estimate_by_sides(std::span<const Vector3d> points, const Connectivity& mesh,
                                              const Wedges& wedges, const FlatFaces& flats, std::span<const int> face,
                                              std::span<const Vector3d> normals, const EstimateOptions& options) {
    if (flats.empty()) return estimate_curvature(points, mesh, wedges, normals, options);
    const int corners = 3 * mesh.num_triangles();
    Connectivity parted = mesh;
    for (int h = 0; h < corners; ++h)
        if (const int g = mesh.twin(h); g > h && flats.of(h / 3) != flats.of(g / 3)) parted.set_tag(h, 0);
    const Wedges sides = wedges_of(parted);
    std::vector<Vector3d> normal_of_side(sides.size(), Vector3d::Zero());
    for (int h = 0; h < corners; ++h) normal_of_side[sides.of_corner[h]] = normals[wedges.of_corner[h]];
    const std::vector<WedgeCurvature> of_side = estimate_curvature(points, parted, sides, normal_of_side, options);
    std::vector<WedgeCurvature> curvature(wedges.size());
    const auto include = [](const WedgeCurvature& other, WedgeCurvature& largest) {
        const Vector3d normal = largest.normal.isZero() ? other.normal : largest.normal;
        if (largest.normal.isZero() || std::abs(other.k1) > std::abs(largest.k1)) largest = other;
        largest.normal = normal;
    };
    for (int h = 0; h < corners; ++h) {
        const int wedge = wedges.of_corner[h];
        include(of_side[sides.of_corner[h]], curvature[wedge]);
        if (flats.of(h / 3) >= 0 || face[wedge] < 0) continue;
        for (const int e : {Connectivity::next(h), Connectivity::prev(h)})
            include(of_side[sides.of_corner[e]], curvature[wedge]);
    }
    return curvature;
}

// Where the labels of edges change along a line.
std::vector<int> ends_of_labels(const TriangleSoup& soup) {
    std::map<int, int> label;
    std::vector<int> ends;
    for (std::size_t e = 0; e < soup.edge_labels.size(); ++e)
        for (const int v : soup.edges[e])
            if (const auto [known, is_new] = label.emplace(v, soup.edge_labels[e]);
                !is_new && known->second != soup.edge_labels[e])
                ends.push_back(v);
    return ends;
}

void label_chains(const TriangleSoup& soup, std::vector<FeatureChain>& chains) {
    std::map<std::array<int, 2>, int> label;
    for (std::size_t e = 0; e < soup.edge_labels.size(); ++e)
        label.emplace(edge_between(soup.edges[e][0], soup.edges[e][1]), soup.edge_labels[e]);
    if (label.empty()) return;
    for (FeatureChain& chain : chains)
        if (const auto found = label.find(edge_between(chain.vertex(0), chain.vertex(1))); found != label.end())
            chain.label = found->second;
}

}  // namespace

Triangulation::Triangulation(TriangleSoup soup, const TriangulationOptions& options)
    : soup_(std::move(soup)),
      mesh_(static_cast<int>(soup_.points.size()), soup_.triangles),
      diagonal_(checked_diagonal(soup_)) {
    std::vector<int> corners = soup_.corners;
    for (const int v : ends_of_labels(soup_)) corners.push_back(v);
    KnownFeatures known{.edges = soup_.edges, .corners = corners};
    if (options.label_borders) known.labels = soup_.labels;
    part_share_ = part_shares(soup_, diagonal_);
    std::vector<double> finest(soup_.points.size(), options.finest);
    for (std::size_t v = 0; options.finest_by_part && v < finest.size(); ++v) finest[v] *= part_share_[v];
    const PlanarRegions regions(soup_.points, mesh_);
    flats_ = find_flat_faces(soup_.points, mesh_, regions);
    const ThinRounds thin = find_thin_rounds(soup_.points, mesh_, regions, flats_, options.negligible_height, finest);
    FeatureOptions features = options.features;
    features.no_creases.insert(features.no_creases.end(), thin.others.begin(), thin.others.end());
    for (const std::array<int, 2>& edge : thin.others)
        features.no_corners.insert(features.no_corners.end(), edge.begin(), edge.end());
    std::vector<std::array<int, 2>> edges = soup_.edges;
    edges.insert(edges.end(), thin.ridges.begin(), thin.ridges.end());
    known.edges = edges;
    features_ = find_features(soup_.points, mesh_, features, known, &regions);
    label_chains(soup_, features_.chains);
    frozen_ = frozen_elements(soup_.points, mesh_, soup_.required);
    wedges_ = wedges_of(mesh_);
    std::vector<Vector3d> normals = wedge_normals(soup_.points, mesh_, wedges_);
    const std::vector<int> face = faces_of_wedges(wedges_, flats_);
    for (int wedge = 0; wedge < wedges_.size(); ++wedge)
        if (face[wedge] >= 0) normals[wedge] = flats_.normals[face[wedge]];
    curvature_ = estimate_by_sides(soup_.points, mesh_, wedges_, flats_, face, normals,
                                   {.least_curvature = options.least_curvature});
    ChainCurvature on_chains(soup_.points, options.negligible_height, finest);
    for (const FeatureChain& chain : features_.chains) on_chains.add(chain);
    curve_curvature_ = on_chains.result();
    heed_strips(regions, thin, face, normals);
}

namespace {

// What the planes around a vertex tell of the surface there.
class Strips {
  public:
    Strips(std::span<const Vector3d> points, const Connectivity& mesh, const Wedges& wedges,
           const PlanarRegions& regions, const FlatFaces& flats)
        : points_(points), mesh_(mesh), wedges_(wedges), regions_(regions), flats_(flats) {}

    void look_at(int wedge) {
        largest = along_long = 0;
        straight = Vector3d::Zero();
        long_strips.clear();
        wedges_.for_each(mesh_, wedge, [&](int h) {
            for (const int e : {h, Connectivity::prev(h)})
                if (mesh_.twin(e) >= 0 && mesh_.tag(e) < 0) look_across(e, wedges_.vertex[wedge]);
        });
    }

    double largest = 0;                    // curvature: how much strips turn over their width, 0 if there are none
    double along_long = 0;                 // the same of the edges along long strips
    std::vector<int> long_strips;          // regions that are long where others end
    Vector3d straight = Vector3d::Zero();  // unit, a direction in which there is a long strip and nothing as long
                                           // behind; zero if there is none

  private:
    bool is_plane(int h) const { return regions_.is_plane(regions_.of(h / 3)); }

    // Of the plane beside an edge near its end at v.
    double width_at(int h, int v) const {
        const PlanarRegions::Way way = regions_.across(h, kInfinity, mesh_.origin(h) == v ? kAtEnd : 1 - kAtEnd);
        return (way.exit >= 0 && regions_.is_parallel(h, way.exit) ? way : regions_.across(h)).length;
    }

    void look_across(int e, int v) {
        const double turn = regions_.turn_at(e);
        if (turn == 0) return;
        const int sides[] = {e, mesh_.twin(e)};
        double width[2], sum = 0;
        bool is_end = false;
        for (int k = 0; k < 2; ++k) width[k] = is_plane(sides[k]) ? width_at(sides[k], v) : 0;
        for (int k = 0; k < 2; ++k) {
            // What is wide is no part of the round that begins beside it.
            const bool is_long = width[k] > kAlikeWidths * width[1 - k] && width[1 - k] > 0;
            if (flats_.of(sides[k] / 3) < 0 && !is_long) sum += width[k] / 2;
            if (is_long && std::abs(turn) <= kSharpestRound)
                add_straight(sides[k]), long_strips.push_back(regions_.of(sides[k] / 3)), is_end = true;
        }
        if (!(sum > 0)) return;
        if (std::abs(turn) > std::abs(largest) * sum) largest = turn / sum;
        if (!is_end && std::abs(turn) > std::abs(along_long) * sum) along_long = turn / sum;
    }

    void add_straight(int h) {
        const Vector3d way =
            regions_.normal_at(h / 3).cross(points_[mesh_.target(h)] - points_[mesh_.origin(h)]).stableNormalized();
        straight = (straight + (straight.dot(way) < 0 ? Vector3d(-way) : way)).stableNormalized();
    }

    std::span<const Vector3d> points_;
    const Connectivity& mesh_;
    const Wedges& wedges_;
    const PlanarRegions& regions_;
    const FlatFaces& flats_;
};

}  // namespace

// Polynomials see what is flat and the rounds beside it, and little of rounds of few strips. The strips, between
// tangent planes, tell better; thin rounds do not count.
// @param face     of wedges, flat
// @param normals  of facets, averaged around the wedges; those of flat faces
void Triangulation::heed_strips(const PlanarRegions& regions, const ThinRounds& thin, std::span<const int> face,
                                std::span<const Vector3d> normals) {
    Strips strips(soup_.points, mesh_, wedges_, regions, flats_);
    std::vector<std::pair<int, double>> at_long_strips;
    for (int wedge = 0; wedge < wedges_.size(); ++wedge) {
        if (wedges_.first[wedge] == Connectivity::kNone) continue;
        bool of_planes = true, is_thin = !flats_.empty();
        wedges_.for_each(mesh_, wedge, [&](int h) {
            if (flats_.of(h / 3) < 0) is_thin = is_thin && thin.has(h / 3);
            of_planes = of_planes && regions.is_plane(regions.of(h / 3));
        });
        WedgeCurvature& curvature = curvature_[wedge];
        if (of_planes) curvature.normal = normals[wedge];
        if (is_thin) curvature = {0, 0, curvature.normal, 0, 0};
        const bool at_flat = face[wedge] >= 0;
        if (at_flat) curvature.normal = normals[wedge];
        if (is_thin || (!at_flat && !of_planes)) continue;
        strips.look_at(wedge);
        if (!at_flat)
            curvature.normal =
                (curvature.normal - curvature.normal.dot(strips.straight) * strips.straight).stableNormalized();
        const double largest = strips.largest,
                     k2 = at_flat ? 0 : std::clamp(curvature.k2, -std::abs(largest), std::abs(largest));
        if (largest != 0) curvature = {largest, k2, curvature.normal, 0, 0};
        wedges_.for_each(mesh_, wedge, [&](int h) {
            const std::vector<int>& ends = strips.long_strips;
            if (std::find(ends.begin(), ends.end(), regions.of(h / 3)) != ends.end())
                at_long_strips.emplace_back(h, std::abs(strips.along_long));
        });
    }
    corner_curvature_.resize(wedges_.of_corner.size());
    for (int h = 0; h < std::ssize(corner_curvature_); ++h)
        corner_curvature_[h] = flats_.of(h / 3) >= 0 ? 0 : std::abs(curvature_[wedges_.of_corner[h]].k1);
    for (const auto& [h, curvature] : at_long_strips) corner_curvature_[h] = curvature;
}

double Triangulation::largest_curvature(int vertex) const {
    double largest = curve_curvature_[vertex];
    mesh_.for_each_outgoing(vertex, [&](int h) { largest = std::max(largest, corner_curvature_[h]); });
    return largest;
}

SmoothSupport Triangulation::support(const SmoothSupport::Options& options) const {
    std::vector<Vector3d> normals;
    normals.reserve(curvature_.size());
    for (const WedgeCurvature& c : curvature_) normals.push_back(c.normal);
    return SmoothSupport(soup_.points, mesh_, features_, wedges_, flats_, std::move(normals), options);
}

namespace {

TriangulationBackground background_of(std::span<const Vector3d> points, std::span<const Triangle> triangles,
                                      std::span<const double> sizes) {
    TriangulationBackground background{
        {make_mesh(points, triangles), {}, {}}, {sizes.begin(), sizes.end()}, std::vector<int>(points.size(), 0)};
    for (int t = static_cast<int>(triangles.size()) - 1; t >= 0; --t)
        for (const int v : triangles[t]) background.cells[v] = t;
    return background;
}

// Elements beside frozen ones are to be as large as these, though larger than asked for only as far as the surface
// allows.
// @param most  largest size of a vertex that its surroundings allow, if that is below a length
template <class Most>
void heed_frozen(const Triangulation& surface, const Most& most, std::vector<double>& sizes) {
    const std::vector<double> lengths = frozen_edge_lengths(surface.soup().points, surface.mesh(), surface.frozen());
    for (int v = 0; v < static_cast<int>(lengths.size()); ++v) {
        if (lengths[v] == 0) continue;
        sizes[v] = lengths[v] < sizes[v] ? lengths[v] : std::max(sizes[v], most(v, lengths[v]));
    }
}

// Largest size of a vertex by curvature alone, if that is below a length.
auto most_by_curvature(const Triangulation& surface) {
    return [&surface](int v, double length) {
        return std::min(length, size_from_radius(SizingRule{}, 1 / std::max(surface.largest_curvature(v), 1e-300)));
    };
}

// What a rule says beside curvature, at places of the triangulation.
class Bounds {
  public:
    Bounds(const Triangulation& surface, const SizingRule& rule) : surface_(surface), rule_(rule), finder_(surface) {
        const std::vector<int>& labels = surface.soup().labels;
        for (const SizingRule::Region& region : rule.regions)
            if (std::find(labels.begin(), labels.end(), region.label) == labels.end())
                throw std::invalid_argument("no triangle has the label " + std::to_string(region.label) + "; " +
                                            labels_there(labels));
    }

    struct Bound {
        double size;
        Clearance faced = {};  // of the clearance that bounds it, where one does
    };
    /// @param size  by curvature; clearances above it are not looked for
    /// @param finest  that clearances lead to
    Bound at(std::span<const SidedPlace> sides, double size, double finest) const {
        Bound bound{size};
        for (const SidedPlace& side : sides) {
            lower(bound, rule_.feature_clearance, finest,
                  [&](double reach) { return finder_.feature(side, reach, reach); });
            lower(bound, rule_.sheet_clearance, finest, [&](double reach) { return finder_.sheet(side, reach); });
        }
        for (const SizingRule::Region& region : rule_.regions)
            for (const SidedPlace& side : sides)
                if (touches(side, region.label)) bound.size = std::min(bound.size, region.size);
        return bound;
    }

  private:
    template <class Find>
    void lower(Bound& bound, double fraction, double finest, const Find& find) const {
        if (fraction == 0 || bound.size <= finest) return;
        const Clearance clearance = find(bound.size / fraction);
        const double size = std::max(fraction * clearance.distance, finest);
        if (size < bound.size) bound = {size, clearance};
    }

    bool touches(const SidedPlace& side, int label) const {
        const std::vector<int>& labels = surface_.soup().labels;
        bool touching = labels[side.triangle] == label;
        if (side.wedge >= 0)
            surface_.wedges().for_each(surface_.mesh(), side.wedge,
                                       [&](int h) { touching = touching || labels[h / 3] == label; });
        const int g = side.half_edge >= 0 ? surface_.mesh().twin(side.half_edge) : -1;
        return touching || (g >= 0 && labels[g / 3] == label);
    }

    const Triangulation& surface_;
    const SizingRule& rule_;
    ClearanceFinder finder_;
};

// The background while it is cut: curvature by corner, so that each side of a feature has its own.
class Cutter {
  public:
    Cutter(const Triangulation& surface, const SizingRule& rule)
        : surface_(surface),
          rule_(rule),
          unlimited_{.kind = rule.kind, .value = rule.value, .most_turn = rule.most_turn},
          bounds_(surface, rule),
          share_(surface.part_share()),
          mesh_(surface.mesh()),
          points_(surface.soup().points),
          on_curve_(surface.curve_curvature()),
          at_corner_(surface.corner_curvature()),
          source_(at_corner_.size()),
          middle_size_(at_corner_.size(), kUnknown),
          parent_(mesh_.num_triangles()),
          faced_(mesh_.num_triangles()) {
        if (rule.kind == SizingRule::Kind::ChordError) heed_edges();
        std::iota(source_.begin(), source_.end(), 0);
        std::iota(parent_.begin(), parent_.end(), 0);
        piece_of_ = parent_;
        for (const int t : parent_) pieces_.push_back({mesh_.triangle(t), t});
        std::vector<Bounds::Bound> bounds(points_.size(), {rule.hmax});
        in_parallel(bounds.size(), [&](int v) {
            if (mesh_.is_live_vertex(v))
                bounds[v] = bounds_.at(sides_of_vertex(surface, v), curvature_size_at(v), limits_at(v).finest);
        });
        for (const Bounds::Bound& bound : bounds) sizes_.push_back(bound.size);
        heed_short_curves();
        SizingRule unclamped = rule;
        unclamped.hmax = kInfinity;
        const auto most = [&](int v, double length) {
            double curvature = on_curve_[v];
            mesh_.for_each_outgoing(v, [&](int h) { curvature = std::max(curvature, at_corner_[h]); });
            return bounds_
                .at(sides_of_vertex(surface, v),
                    std::min(length, size_from_radius(unclamped, 1 / std::max(curvature, 1e-300))), limits_at(v).finest)
                .size;
        };
        heed_frozen(surface, most, sizes_);
        for (const Bounds::Bound& bound : bounds) note(bound);
    }

    void cut(int max_triangles) {
        if (!rule_.at.empty()) {
            const ClosestTriangle tree(surface_.soup().points, surface_.soup().triangles);
            for (const SizingRule::At& at : rule_.at) cut_to(at, tree.closest(at.point).triangle, max_triangles);
        }
        for (int pass = 0; pass < kMostPasses && mesh_.num_triangles() < max_triangles; ++pass) {
            find_middle_sizes();
            std::vector<std::pair<double, int>> long_edges;
            for (int h = 0; h < 3 * mesh_.num_triangles(); ++h)
                if (mesh_.twin(h) < h && needs_cut(h)) long_edges.emplace_back(-length(h), h);
            if (long_edges.empty()) break;
            std::sort(long_edges.begin(), long_edges.end());
            // The longest first, and of a triangle's edges only its longest, so that shapes stay what they are.
            for (const auto& [minus, h] : long_edges) {
                if (mesh_.num_triangles() >= max_triangles) break;
                if (-minus == length(h) && needs_cut(h)) split(longest_around(h));
            }
        }
        for (int t = 0; t < mesh_.num_triangles(); ++t)
            for (const Faced& faced : faced_[t])
                if (is_missed(t, faced)) {
                    double& size = sizes_[nearest_corner(t, faced.point)];
                    size = std::min(size, faced.size);
                }
    }

    // Flat parts get the triangles that follow slopes best, Delaunay's: on slivers a bound on the slope of sizes says
    // little, slowly.
    void flatten_slivers() {
        std::vector<int> queue;
        std::vector<char> queued(3 * static_cast<std::size_t>(mesh_.num_triangles()), 0);
        const auto push = [&](int h) {
            if (mesh_.twin(h) < 0 || mesh_.tag(h) >= 0) return;
            h = std::min(h, mesh_.twin(h));
            if (!queued[h]) queued[h] = 1, queue.push_back(h);
        };
        for (int h = 0; h < 3 * mesh_.num_triangles(); ++h) push(h);
        const std::size_t most = kMostFlips * queue.size();
        for (std::size_t i = 0; i < queue.size() && i < most; ++i) {
            const int h = queue[i];
            queued[h] = 0;
            if (!is_better_flipped(h)) continue;
            mesh_.flip(h);
            for (const int side : {h, mesh_.twin(h)})
                for (const int e : {side, Connectivity::next(side), Connectivity::prev(side)}) push(e);
        }
    }

    const std::vector<double>& sizes() const { return sizes_; }

    TriangulationBackground result() const {
        std::vector<Triangle> triangles;
        triangles.reserve(mesh_.num_triangles());
        for (int t = 0; t < mesh_.num_triangles(); ++t) triangles.push_back(mesh_.triangle(t));
        return background_of(points_, triangles, sizes_);
    }

  private:
    static constexpr double kUnknown = -1;

    // A place that another one faces, and the size that is to be there.
    struct Faced {
        Vector3d point;
        double size;
    };

    template <class Work>
    static void in_parallel(std::size_t count, const Work& work) {
        tbb::parallel_for(tbb::blocked_range<int>(0, static_cast<int>(count), 64), [&](const auto& range) {
            for (int i = range.begin(); i < range.end(); ++i) work(i);
        });
    }

    // Whether the angles opposite to the edge of h sum to more than half a turn, in two triangles that are flat and
    // convex together.
    bool is_better_flipped(int h) const {
        const int g = mesh_.twin(h);
        if (g < 0 || mesh_.tag(h) >= 0 || mesh_.valence(mesh_.origin(h)) < 4 || mesh_.valence(mesh_.target(h)) < 4)
            return false;
        const Vector3d &a = points_[mesh_.origin(h)], &b = points_[mesh_.target(h)], &c = points_[mesh_.apex(h)],
                       &d = points_[mesh_.apex(g)];
        const auto cot = [](const Vector3d& at, const Vector3d& p, const Vector3d& q) {
            const double area2 = (p - at).cross(q - at).norm();
            return area2 > 0 ? (p - at).dot(q - at) / area2 : (p - at).dot(q - at) < 0 ? -1e30 : 1e30;
        };
        if (!(cot(c, a, b) + cot(d, a, b) < -kNearlyDelaunay)) return false;
        const Vector3d across = (b - a).cross(d - c);
        const double sizes = std::min(sizes_[mesh_.origin(h)], sizes_[mesh_.target(h)]);
        if (!(std::abs((c - a).dot(across)) < kFlat * sizes * across.norm())) return false;
        const Vector3d left = (d - c).cross(a - c), right = (b - c).cross(d - c);
        return left.dot(right) > 0 && mesh_.find_edge(mesh_.apex(h), mesh_.apex(g)) < 0;
    }

    double length(int h) const { return (points_[mesh_.target(h)] - points_[mesh_.origin(h)]).norm(); }

    // An edge of length h across one where two facets meet at an angle is h / 2 sin(angle / 2) off it, as long as it
    // reaches no farther than the facets: there they ask for more than the curvature, which is smoothed.
    void heed_edges() {
        for (int h = 0; h < 3 * mesh_.num_triangles(); ++h) {
            const int g = mesh_.twin(h);
            if (g < h || mesh_.tag(h) >= 0) continue;
            const Vector3d edge = points_[mesh_.target(h)] - points_[mesh_.origin(h)];
            const Vector3d n = edge.cross(points_[mesh_.apex(h)] - points_[mesh_.origin(h)]),
                           m = (points_[mesh_.apex(g)] - points_[mesh_.origin(h)]).cross(edge);
            const double angle = std::atan2(n.cross(m).norm(), n.dot(m)), rise = std::sin(angle / 2);
            const double width = std::min(n.norm(), m.norm()) / edge.norm(), gap = kEdgeShare * rule_.value;
            if (!(width * rise > gap)) continue;
            // The radius for which the rule gives the size 2 gap / rise.
            const double size = 2 * gap / rise, radius = (size * size / (4 * rule_.value) + rule_.value) / 2;
            for (const int side : {h, g})
                for (const int e : {side, Connectivity::next(side)})
                    at_corner_[e] = std::max(at_corner_[e], 1 / radius);
        }
    }

    // A curve between two corners is divided into pieces no longer than it is.
    void heed_short_curves() {
        if (rule_.feature_clearance == 0) return;
        for (const FeatureChain& chain : surface_.features().chains) {
            if (chain.closed || chain.vertices.front() == chain.vertices.back()) continue;
            double length = 0;
            for (int i = 0; i < chain.num_edges(); ++i)
                length += (points_[chain.vertex(i + 1)] - points_[chain.vertex(i)]).norm();
            const double most = std::max(rule_.feature_clearance * length, limits_at(chain.vertices.front()).finest);
            for (const int v : chain.vertices) sizes_[v] = std::min(sizes_[v], most);
        }
    }

    struct Limits {
        double hmin, hmax;
        double finest;  // that clearances lead to
    };
    Limits limits_at(int v) const {
        const double hmin = rule_.hmin * (rule_.hmin_by_part ? share_[v] : 1);
        return {hmin, std::max(hmin, rule_.hmax * (rule_.hmax_by_part ? share_[v] : 1)),
                rule_.hmin_by_part ? kFinestSize * hmin : hmin};
    }

    // @param v  a vertex of the same part
    double size_of(double curvature, int v) const {
        const Limits limits = limits_at(v);
        return std::clamp(size_from_radius(unlimited_, 1 / std::max(curvature, 1e-300)), limits.hmin, limits.hmax);
    }

    double curvature_size_at(int v) const {
        double largest = on_curve_[v];
        mesh_.for_each_outgoing(v, [&](int h) { largest = std::max(largest, at_corner_[h]); });
        return size_of(largest, v);
    }

    // What is as sharp as one end does not reach to the middle of an edge that is many radii long. Along a cone radii
    // grow evenly.
    double middle_curvature(int h) const {
        const double a = at_corner_[h], b = at_corner_[Connectivity::next(h)];
        if (std::max(a, b) * length(h) <= kManyRadii) return (a + b) / 2;
        return 2 * a * b / (a + b);
    }

    // Cuts the triangles at a prescribed point until one of their corners is no farther from it than the size that
    // holds there.
    void cut_to(const SizingRule::At& at, int closest, int max_triangles) {
        const double size = std::max(at.size, kFinestPrescribed * surface_.diagonal());
        while (mesh_.num_triangles() < max_triangles) {
            const int longest = longest_of(piece_at(closest, at.point));
            if (length(longest) <= size) return;
            split(longest_around(longest));
        }
    }

    // The middle of an edge as a place of the triangulation.
    std::vector<SidedPlace> middle_of(int h) const {
        const Vector3d middle = (points_[mesh_.origin(h)] + points_[mesh_.target(h)]) / 2;
        if (source_[h] >= 0) return sides_of_edge(surface_, source_[h], middle);
        return {{middle, parent_[h / 3]}};
    }

    Bounds::Bound middle_bound(int h) const {
        const int g = mesh_.twin(h);
        double curvature = middle_curvature(h);
        if (g >= 0) curvature = std::max(curvature, middle_curvature(g));
        if (mesh_.tag(h) >= 0)
            curvature = std::max(curvature, (on_curve_[mesh_.origin(h)] + on_curve_[mesh_.target(h)]) / 2);
        Bounds::Bound bound =
            bounds_.at(middle_of(h), size_of(curvature, mesh_.origin(h)), limits_at(mesh_.origin(h)).finest);
        // Along a frozen edge there is one element: larger ones are not asked for.
        if (source_[h] >= 0 && surface_.frozen().has_edge(source_[h])) {
            const double between = (sizes_[mesh_.origin(h)] + sizes_[mesh_.target(h)]) / 2;
            if (between < bound.size) bound = {between};
        }
        return bound;
    }

    void set_middle(int h, const Bounds::Bound& bound) {
        middle_size_[h] = bound.size;
        if (mesh_.twin(h) >= 0) middle_size_[mesh_.twin(h)] = bound.size;
        note(bound);
    }

    double middle_size(int h) {
        if (middle_size_[h] == kUnknown) set_middle(h, middle_bound(h));
        return middle_size_[h];
    }

    // Between its ends an edge may be nearer to what it faces than there.
    bool may_misrepresent(int h) const {
        const double least = std::min(sizes_[mesh_.origin(h)], sizes_[mesh_.target(h)]);
        return length(h) > kShortest * (mesh_.tag(h) >= 0 ? limits_at(mesh_.origin(h)).hmin : kHidden * least);
    }

    bool misrepresents(int h) {
        if (!may_misrepresent(h)) return false;
        const double ha = sizes_[mesh_.origin(h)], hb = sizes_[mesh_.target(h)], size = middle_size(h);
        return length(h) > kShortest * std::min({ha, hb, size}) &&
               std::abs(std::log(2 * size / (ha + hb))) > kSizeTolerance;
    }

    // All that cutting is going to ask for at first.
    void find_middle_sizes() {
        std::vector<int> unknown;
        for (int h = 0; h < 3 * mesh_.num_triangles(); ++h)
            if (mesh_.twin(h) < h && middle_size_[h] == kUnknown && may_misrepresent(h)) unknown.push_back(h);
        std::vector<Bounds::Bound> bounds(unknown.size(), {0});
        in_parallel(unknown.size(), [&](int i) { bounds[i] = middle_bound(unknown[i]); });
        for (std::size_t i = 0; i < unknown.size(); ++i) set_middle(unknown[i], bounds[i]);
    }

    bool needs_cut(int h) {
        return misrepresents(h) || hides_faced(h) || (mesh_.twin(h) >= 0 && hides_faced(mesh_.twin(h)));
    }

    // The longest edge of a triangle that something faces is cut.
    bool hides_faced(int h) const {
        const int t = h / 3;
        if (faced_[t].empty() || h != longest_of(t)) return false;
        return std::any_of(faced_[t].begin(), faced_[t].end(),
                           [&](const Faced& f) { return length(h) > kShortest * f.size && is_missed(t, f); });
    }

    bool is_missed(int t, const Faced& faced) const {
        const Triangle v = mesh_.triangle(t);
        const Vector3d &a = points_[v[0]], &b = points_[v[1]], &c = points_[v[2]], &q = faced.point;
        const double weight[3] = {(c - b).cross(q - b).norm(), (a - c).cross(q - c).norm(),
                                  (b - a).cross(q - a).norm()};
        const double whole = weight[0] + weight[1] + weight[2];
        if (!(whole > 0)) return false;
        double size = 0;
        for (int k = 0; k < 3; ++k) size += weight[k] / whole * sizes_[v[k]];
        return std::log(size / faced.size) > kSizeTolerance;
    }

    int longest_of(int t) const {
        int longest = 3 * t;
        for (const int h : {3 * t + 1, 3 * t + 2})
            if (length(h) > length(longest)) longest = h;
        return longest;
    }

    int nearest_corner(int t, const Vector3d& q) const {
        const Triangle v = mesh_.triangle(t);
        const auto is_nearer = [&](int x, int y) {
            return (points_[x] - q).squaredNorm() < (points_[y] - q).squaredNorm();
        };
        return *std::min_element(v.begin(), v.end(), is_nearer);
    }

    double distance(const Triangle& v, const Vector3d& q) const {
        return (closest_point(q, points_[v[0]], points_[v[1]], points_[v[2]]) - q).norm();
    }

    // The piece of a triangle of the triangulation that is closest to a point of it.
    int piece_at(int triangle, const Vector3d& q) const {
        int piece = triangle;
        while (pieces_[piece].half >= 0) {
            const int half = pieces_[piece].half;
            piece = distance(pieces_[half + 1].corners, q) < distance(pieces_[half].corners, q) ? half + 1 : half;
        }
        return pieces_[piece].triangle;
    }

    // Puts down what a bound faces, in the piece of its triangle that holds it, unless that is small.
    void note(const Bounds::Bound& bound) {
        if (bound.faced.triangle < 0) return;
        const int holder = piece_at(bound.faced.triangle, bound.faced.point);
        if (length(longest_of(holder)) > kShortest * bound.size)
            faced_[holder].push_back({bound.faced.point, bound.size});
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
        const double size = middle_size(h);
        const int a = mesh_.origin(h), b = mesh_.target(h), twin = mesh_.twin(h), known = mesh_.num_triangles();
        points_.push_back((points_[a] + points_[b]) / 2);
        share_.push_back(share_[a]);
        on_curve_.push_back(mesh_.tag(h) >= 0 ? (on_curve_[a] + on_curve_[b]) / 2 : 0);
        sizes_.push_back(size);
        mesh_.split(h);
        for (int t = known; t < mesh_.num_triangles(); ++t) divide(t == known ? h : twin, t);
    }

    // Divides what is known of the triangle of half-edge h, which now ends in the new vertex, with the triangle beyond
    // that.
    void divide(int h, int fresh) {
        const int t = h / 3, n = Connectivity::next(h), p = Connectivity::prev(h);
        parent_.push_back(parent_[t]);
        pieces_[piece_of_[t]].half = static_cast<int>(pieces_.size());
        piece_of_.push_back(0);
        for (const int half : {t, fresh})
            piece_of_[half] = static_cast<int>(pieces_.size()), pieces_.push_back({mesh_.triangle(half), half});
        const double middle = middle_curvature(h);
        at_corner_.insert(at_corner_.end(), {middle, at_corner_[n], at_corner_[p]});
        at_corner_[n] = middle;
        source_.insert(source_.end(), {source_[h], source_[n], -1});
        source_[n] = -1;
        middle_size_.insert(middle_size_.end(), {kUnknown, middle_size_[n], kUnknown});
        middle_size_[h] = middle_size_[n] = kUnknown;
        faced_.emplace_back();
        std::erase_if(faced_[t], [&](const Faced& faced) {
            const bool beyond = distance(mesh_.triangle(fresh), faced.point) < distance(mesh_.triangle(t), faced.point);
            if (beyond) faced_[fresh].push_back(faced);
            return beyond;
        });
    }

    const Triangulation& surface_;
    const SizingRule& rule_;
    const SizingRule unlimited_;  // by curvature alone
    Bounds bounds_;
    std::vector<double> share_;  // of each vertex, see Triangulation::part_share
    Connectivity mesh_;
    std::vector<Vector3d> points_;
    std::vector<double> on_curve_, at_corner_, sizes_;
    std::vector<int> source_;          // half-edge of the triangulation that holds each half-edge, or -1
    std::vector<double> middle_size_;  // of each half-edge's edge, or kUnknown
    std::vector<int> parent_;          // triangle of the triangulation that holds each triangle
    std::vector<std::vector<Faced>> faced_;
    // The triangles of the triangulation, by their numbers, and the pieces they were cut into, by halves.
    struct Piece {
        Triangle corners;
        int triangle;   // of the mesh, if it was not cut
        int half = -1;  // the first of two that follow each other; -1: it was not cut
    };
    std::vector<Piece> pieces_;
    std::vector<int> piece_of_;  // of each triangle of the mesh
};

}  // namespace

TriangulationBackground make_background(const Triangulation& surface, const SizingRule& rule, int max_triangles) {
    check(rule);
    Cutter cutter(surface, rule);
    cutter.cut(max_triangles);
    cutter.flatten_slivers();
    TriangulationBackground result = cutter.result();
    lower_to_prescribed(rule.at, points_of(result.background.mesh), result.sizes);
    return result;
}

TriangulationBackground make_background(const Triangulation& surface, std::span<const double> sizes) {
    std::vector<double> heeding(sizes.begin(), sizes.end());
    heed_frozen(surface, most_by_curvature(surface), heeding);
    return background_of(surface.soup().points, surface.soup().triangles, heeding);
}

namespace {

std::vector<char> in_triangles(std::size_t num_points, std::span<const Triangle> triangles) {
    std::vector<char> in(num_points, 0);
    for (const Triangle& t : triangles)
        for (const int v : t) in[v] = 1;
    return in;
}

struct MeshOf {
    std::span<const Vector3d> points;
    std::span<const Triangle> triangles;
};

// For each vertex of a mesh the closest triangle of another one.
std::vector<int> closest_triangles(const MeshOf& from, const MeshOf& to) {
    const ClosestTriangle tree(to.points, to.triangles);
    Eigen::AlignedBox3d box;
    for (const Triangle& t : to.triangles)
        for (const int v : t) box.extend(to.points[v]);
    std::vector<ClosestTriangle::Hit> hits(from.points.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, hits.size(), 512), [&](const auto& range) {
        int last = -1;  // vertices that follow each other are often near each other
        for (std::size_t v = range.begin(); v < range.end(); ++v)
            hits[v] = tree.closest(from.points[v], last), last = hits[v].triangle;
    });
    const std::vector<char> counts = in_triangles(from.points.size(), from.triangles);
    std::vector<int> closest;
    for (std::size_t v = 0; v < hits.size(); ++v) {
        if (counts[v] && hits[v].distance > kFarthestOff * box.diagonal().norm())
            throw std::invalid_argument(fmt::format(
                "not a mesh of the same surface: vertex {} of one (counted from 0) is {:.3g} from the other", v,
                hits[v].distance));
        closest.push_back(hits[v].triangle);
    }
    return closest;
}

bool begins_with(const TriangleSoup& mesh, const Triangulation& surface) {
    const std::vector<Vector3d>& points = surface.soup().points;
    if (mesh.points.size() < points.size() || !std::equal(points.begin(), points.end(), mesh.points.begin()))
        return false;
    const std::vector<char> in = in_triangles(mesh.points.size(), mesh.triangles);
    for (int v = 0; v < std::ssize(points); ++v)
        if (surface.mesh().is_live_vertex(v) && !in[v]) return false;
    return true;
}

}  // namespace

TriangulationBackground make_background(const Triangulation& surface, const TriangleSoup& mesh,
                                        std::span<const double> sizes) {
    if (mesh.triangles.empty()) throw std::invalid_argument("a background without triangles");
    if (sizes.size() != mesh.points.size())
        throw std::invalid_argument(
            fmt::format("{} sizes for the {} vertices of the background", sizes.size(), mesh.points.size()));
    TriangulationBackground result = background_of(mesh.points, mesh.triangles, sizes);
    if (begins_with(mesh, surface)) {
        heed_frozen(surface, most_by_curvature(surface), result.sizes);
        return result;
    }
    if (!surface.frozen().empty())
        throw std::invalid_argument(
            "where elements are required the background must begin with the vertices of the surface, in their order");
    result.cells = closest_triangles({surface.soup().points, surface.soup().triangles}, {mesh.points, mesh.triangles});
    return result;
}

std::vector<double> sizes_at(const TriangulationBackground& map, const TriangleSoup& mesh) {
    const ControlSpace control(map.background, map.sizes);
    const std::vector<Triangle> triangles = triangles_of(map.background.mesh);
    std::vector<int> closest =
        closest_triangles({mesh.points, mesh.triangles}, {points_of(map.background.mesh), triangles});
    std::vector<double> sizes;
    for (std::size_t v = 0; v < closest.size(); ++v) sizes.push_back(control.size(mesh.points[v], closest[v]));
    return sizes;
}

std::vector<double> geometric_sizes(const Triangulation& surface, const SizingRule& rule) {
    check(rule);
    std::vector<double> sizes = Cutter(surface, rule).sizes();
    lower_to_prescribed(rule.at, surface.soup().points, sizes);
    return sizes;
}

}  // namespace gradus

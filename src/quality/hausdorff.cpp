#include "gradus/quality/hausdorff.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <limits>
#include <stdexcept>

namespace gradus {

namespace {

using Eigen::Vector3d;

constexpr int kMostPieces = 1000;             // of a part, before it is quartered
constexpr std::size_t kMostAtOnce = 1 << 14;  // parts, those with the largest bounds
// Work in pieces; that of looking for the triangle closest to a corner. The most for a triangle on its own, and for all
// together.
constexpr std::size_t kWorkOfCorner = 8, kMostWorkOfOne = 1'000'000, kMostWork = 2'000'000, kMostWorkPerTriangle = 100;
constexpr double kSlack = 1e-10;      // of an edge: what sticks out by less stays with the triangle
constexpr double kResolution = 1e-9;  // of the surface's extent: smaller distances are not told apart
constexpr int kMostCorners = 12;

struct Corner {
    Vector3d p;
    ClosestTriangle::Hit hit;
};

struct Found {
    double largest = 0, bound = 0;
    double resolution = 0;  // without a limit: smaller distances are not told apart
    std::size_t work = 0;   // and what that took
    Vector3d point{0, 0, 0};
    int nearest = -1, last = -1;
    Witnesses* witnesses = nullptr;  // takes the triangles of the target that are held against, unless null
    bool asks_whether = false;       // nothing more is asked than whether the limit is kept

    void hold_against(int triangle, double farthest) {
        bound = std::max(bound, farthest);
        if (witnesses && triangle != last) witnesses->add(triangle);
        last = triangle;
    }
    void take(const Found& other) {
        if (other.largest > largest) largest = other.largest, point = other.point;
        bound = std::max(bound, other.bound);
        work += other.work;
    }
    void attain(const Corner& c) {
        if (c.hit.distance > largest || nearest < 0) largest = c.hit.distance, point = c.p, nearest = c.hit.triangle;
    }
};

// A part of a triangle that may have a point farther than any that was seen.
struct Part {
    std::array<Corner, 3> corner;
    double bound = std::numeric_limits<double>::infinity();
    int triangle = -1;    // of the target, that it is no farther from than that
    bool is_cut = false;  // along the target, out of a larger one
};

struct Polygon {
    std::array<Vector3d, kMostCorners> corner;
    int size = 0;

    Polygon() {}  // corners stay unset
    Polygon(const Polygon& other) { *this = other; }
    Polygon& operator=(const Polygon& other) {
        size = other.size;
        std::copy_n(other.corner.begin(), size, corner.begin());
        return *this;
    }
    void add(const Vector3d& p) {
        if (size < kMostCorners) corner[size++] = p;
    }
};

// Cuts a convex polygon by the plane through a: what lies more than `slack` beyond, along m, goes to `beyond`.
void cut(Polygon& polygon, const Vector3d& a, const Vector3d& m, double slack, Polygon& beyond) {
    beyond.size = 0;
    std::array<double, kMostCorners> height;
    int out = 0;
    for (int i = 0; i < polygon.size; ++i) height[i] = (polygon.corner[i] - a).dot(m) - slack, out += height[i] > 0;
    if (out == 0) return;
    if (out == polygon.size) {
        std::swap(polygon, beyond);
        polygon.size = 0;
        return;
    }
    Polygon inside;
    for (int i = 0; i < polygon.size; ++i) {
        const int j = (i + 1) % polygon.size;
        (height[i] > 0 ? beyond : inside).add(polygon.corner[i]);
        if ((height[i] > 0) == (height[j] > 0)) continue;
        const Vector3d crossing =
            polygon.corner[i] + height[i] / (height[i] - height[j]) * (polygon.corner[j] - polygon.corner[i]);
        inside.add(crossing);
        beyond.add(crossing);
    }
    polygon = inside;
}

}  // namespace

class DistanceSearch {
  public:
    DistanceSearch(const DistanceTarget& target, const OneSidedOptions& options) : target_(target), options_(options) {}

    Corner look(const Vector3d& p, int near = -1) const { return {p, target_.closest(p, near)}; }

    // Whether a triangle is proved to keep the limit, from a triangle of the target on that is near. @param bound
    // raised to the largest distance then
    bool keeps_limit(const Vector3d& a, const Vector3d& b, const Vector3d& c, int near, double& bound,
                     Witnesses& witnesses) const {
        witnesses.clear();
        const Vector3d middle = (a + b + c) / 3;
        auto [start, distance] = descend_to(middle, near);
        if (distance > options_.limit) {
            const auto closest = target_.closest(middle, start);
            if (closest.distance > options_.limit) return false;
            start = closest.triangle;
        }
        Polygon whole;
        for (const Vector3d* x : {&a, &b, &c}) whole.add(*x);
        Found found;
        found.witnesses = &witnesses;
        found.asks_whether = true;
        int pieces = 0;
        std::vector<Part> later;
        witnesses.proved = cut_down(whole, start, -1, pieces, [&](const Polygon& piece, int t, double farthest) {
            if (farthest <= options_.limit)
                found.hold_against(t, farthest);
            else
                hold(piece, t, found, later);
            return found.largest <= options_.limit;
        });
        if (witnesses.proved && !later.empty()) divide_all(std::move(later), found);
        witnesses.proved = witnesses.proved && std::max(found.bound, found.largest) <= options_.limit;
        if (witnesses.proved) bound = std::max(bound, found.bound);
        return witnesses.proved;
    }

    // Divides parts, and what they are divided into, until they say enough or that is too much work: then their bounds
    // hold.
    void divide_all(std::vector<Part> parts, Found& found) const {
        const std::size_t most = found.work + kMostWorkOfOne;
        for (std::size_t i = 0; i < parts.size(); ++i) {
            if (found.asks_whether && found.largest > options_.limit) return;
            if (found.work >= most)
                found.hold_against(parts[i].triangle, parts[i].bound);
            else
                divide(Part(parts[i]), found, parts);
        }
    }

    // Holds a part against a triangle of the target that is closest to a corner or the middle. Where that does not say
    // enough it is cut along the target, or quartered where that makes too many pieces, into parts for later.
    void divide(const Part& part, Found& found, std::vector<Part>& later) const {
        const auto& [a, b, c] = part.corner;
        for (const Corner& x : part.corner) found.attain(x);
        double bound = part.bound;
        int triangle = part.triangle;
        const auto is_near_that_of = [&](const Corner& x) {
            if (const double most = farthest(part, x.hit.triangle); most < bound)
                bound = most, triangle = x.hit.triangle;
            return bound <= enough(found);
        };
        for (const Corner& x : part.corner)
            if (is_near_that_of(x)) return found.hold_against(triangle, bound);
        // From under the middle: the corners may be nearest to triangles beyond a crease.
        const Corner middle = look((a.p + b.p + c.p) / 3, a.hit.triangle);
        found.attain(middle);
        found.work += kWorkOfCorner;
        if (is_near_that_of(middle)) return found.hold_against(triangle, bound);
        const std::size_t before = later.size();
        if (!part.is_cut && cut_along_target(part, middle.hit.triangle, found, later)) return;
        later.resize(before);
        found.work += 3 * kWorkOfCorner;
        const Corner ab = look((a.p + b.p) / 2, a.hit.triangle), bc = look((b.p + c.p) / 2, b.hit.triangle),
                     ca = look((c.p + a.p) / 2, c.hit.triangle);
        for (const auto& [x, y, z] :
             {std::array{a, ab, ca}, std::array{ab, b, bc}, std::array{ca, bc, c}, std::array{ab, bc, ca}})
            later.push_back({{x, y, z}, bound, triangle});
    }

    // The largest distance of a point of the parts first(i), i below a number. @param found  with the resolution, and
    // what their corners attain
    // @param most   work that is done, or little more; the bound holds for what is left too
    template <class First>
    OneSidedDistance largest_of(std::size_t number, const First& first, Found found, std::size_t most) const {
        std::vector<Part> parts;
        divide_side_by_side(number, first, found, parts);
        while (!parts.empty() && found.work < most) {
            std::stable_sort(parts.begin(), parts.end(),
                             [](const Part& a, const Part& b) { return a.bound > b.bound; });
            const std::size_t now = std::min(parts.size(), kMostAtOnce);
            std::vector<Part> left(parts.begin() + static_cast<std::ptrdiff_t>(now), parts.end());
            divide_side_by_side(
                now, [&](std::size_t i) { return parts[i]; }, found, left);
            parts = std::move(left);
        }
        for (const Part& part : parts) found.bound = std::max(found.bound, part.bound);
        // Rounding may set them apart where both are of one corner.
        return {found.largest, std::max(found.bound, found.largest), found.point, {}};
    }

    // The triangle that is reached from one by ever closer neighbours, and its distance.
    std::pair<int, double> descend_to(const Vector3d& p, int triangle) const {
        double here = distance_to(triangle, p);
        while (true) {
            const auto [b, c] = target_.facets_[triangle].coordinates(p);
            // Across the sides that p lies beyond; over the triangle there are none. Side k is opposite to corner k
            // - 1.
            const std::array<double, 3> beyond{c, 1 - b - c, b};
            int closer = -1;
            for (int k = 0; k < 3; ++k) {
                const int g = target_.neighbours_[triangle][k];
                if (g < 0 || beyond[k] >= 0) continue;
                const double there = distance_to(g, p);
                if (there < (1 - kSlack) * here) here = there, closer = g;
            }
            if (closer < 0) return {triangle, here};
            triangle = closer;
        }
    }

  private:
    // Divides parts, those of a block one after the other. @param later  takes what they are divided into; what does
    // not matter any more is taken out
    template <class PartOf>
    void divide_side_by_side(std::size_t number, const PartOf& part, Found& found, std::vector<Part>& later) const {
        constexpr std::size_t kBlock = 64;
        struct Block {
            Found found;
            std::vector<Part> later;
        };
        std::vector<Block> blocks((number + kBlock - 1) / kBlock, {found, {}});
        tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t b) {
            blocks[b].found.work = 0;
            for (std::size_t i = b * kBlock; i < std::min((b + 1) * kBlock, number); ++i)
                divide(part(i), blocks[b].found, blocks[b].later);
        });
        for (const Block& block : blocks) {
            found.take(block.found);
            later.insert(later.end(), block.later.begin(), block.later.end());
        }
        std::erase_if(later, [&](const Part& p) {
            const bool is_done = p.bound <= enough(found);
            if (is_done) found.bound = std::max(found.bound, p.bound);
            return is_done;
        });
    }

    double distance_to(int triangle, const Vector3d& p) const {
        const DistanceTarget::Facet& f = target_.facets_[triangle];
        if (f.is_under(p)) return std::abs(f.normal.dot(p - f.corner));
        const Triangle& t = target_.mesh_.triangles[triangle];
        const auto& points = target_.mesh_.points;
        return (p - closest_point(p, points[t[0]], points[t[1]], points[t[2]])).norm();
    }

    // Largest distance of the corners of a piece to a triangle; not looked for any more once it is above `enough`.
    double farthest_corner(const Polygon& piece, int triangle, double enough) const {
        double most = 0;
        for (int i = 0; i < piece.size && most <= enough; ++i)
            most = std::max(most, distance_to(triangle, piece.corner[i]));
        return most;
    }

    // Largest distance of a corner of a piece to a triangle, and the corner.
    std::pair<double, Vector3d> farthest_of(const Polygon& piece, int triangle) const {
        std::pair<double, Vector3d> farthest{0, piece.corner[0]};
        for (int i = 0; i < piece.size; ++i)
            if (const double d = distance_to(triangle, piece.corner[i]); d > farthest.first)
                farthest = {d, piece.corner[i]};
        return farthest;
    }

    // Distances that need no closer look: those that keep the limit or, where there is none or it is not kept, are
    // nothing new.
    double enough(const Found& found) const {
        if (options_.limit > 0 && found.largest <= options_.limit) return options_.limit;
        return (1 + options_.precision) * std::max(found.largest, found.resolution);
    }

    // Cuts off what lies beyond the sides of a triangle of the target, for its neighbours, and gives the rest to
    // use(piece, triangle, distance of its farthest corner where there is a limit) with it, while that returns true.
    // @returns whether it always did
    template <class Use>
    bool cut_down(Polygon& polygon, int t, int from, int& pieces, const Use& use) const {
        ++pieces;
        // What sticks out of the triangle may be near it all the same.
        double farthest = options_.limit > 0 ? farthest_corner(polygon, t, options_.limit) : 0;
        if (options_.limit > 0 && farthest <= options_.limit) return use(polygon, t, farthest);
        const Triangle& v = target_.mesh_.triangles[t];
        Polygon beyond;
        for (int k = 0; pieces < kMostPieces && k < 3; ++k) {
            const int g = target_.neighbours_[t][k];
            if (g < 0 || k == from || polygon.size + 3 > kMostCorners) continue;
            const Vector3d& start = target_.mesh_.points[v[k]];
            const Vector3d along = target_.mesh_.points[v[(k + 1) % 3]] - start,
                           m = along.cross(target_.facets_[t].normal + target_.facets_[g].normal);
            cut(polygon, start, m, kSlack * along.norm() * m.norm(), beyond);
            if (beyond.size == 0) continue;
            farthest = -1;
            const auto& back = target_.neighbours_[g];
            if (!cut_down(beyond, g, static_cast<int>(std::find(back.begin(), back.end(), t) - back.begin()), pieces,
                          use))
                return false;
            if (polygon.size == 0) return true;
        }
        if (farthest < 0 && options_.limit > 0) farthest = farthest_corner(polygon, t, options_.limit);
        return use(polygon, t, farthest);
    }

    // Cuts a part along the triangles of the target. @returns false where that comes to too many pieces, or to one
    bool cut_along_target(const Part& part, int triangle, Found& found, std::vector<Part>& later) const {
        Polygon whole;
        for (const Corner& x : part.corner) whole.add(x.p);
        int pieces = 0;
        const bool is_cut = cut_down(whole, triangle, -1, pieces, [&](const Polygon& piece, int t, double) {
            if (pieces == 1 || pieces >= kMostPieces) return false;
            hold(piece, t, found, later);
            return true;
        });
        found.work += static_cast<std::size_t>(pieces);
        return is_cut;
    }

    // Holds a piece against one triangle; where that does not say enough it becomes parts for later.
    void hold(const Polygon& piece, int triangle, Found& found, std::vector<Part>& later) const {
        const auto [bound, farthest] = farthest_of(piece, triangle);
        if (bound > enough(found)) found.attain(look(farthest, triangle)), found.work += kWorkOfCorner;
        if (bound <= enough(found)) return found.hold_against(triangle, bound);
        const Corner first = look(piece.corner[0], triangle);
        Corner last = look(piece.corner[1], triangle);
        for (int i = 2; i < piece.size; ++i) {
            const Corner next = look(piece.corner[i], triangle);
            later.push_back({{first, last, next}, bound, triangle, true});
            last = next;
        }
        found.work += static_cast<std::size_t>(piece.size) * kWorkOfCorner;
    }

    // Largest distance of the corners of a part to one triangle of the target.
    double farthest(const Part& part, int triangle) const {
        double most = 0;
        for (const Corner& x : part.corner)
            most = std::max(most, x.hit.triangle == triangle ? x.hit.distance : distance_to(triangle, x.p));
        return most;
    }

    const DistanceTarget& target_;
    const OneSidedOptions& options_;
};

DistanceTarget::DistanceTarget(const MeshView& mesh)
    : mesh_(mesh), tree_(std::make_unique<Tree>()), neighbours_(mesh.triangles.size(), {-1, -1, -1}) {
    if (mesh.triangles.empty()) throw std::invalid_argument("DistanceTarget: a surface without triangles");
    const MeshEdges edges = edges_of(mesh);
    for (int e = 0; e < edges.size(); ++e) {
        const auto uses = edges.uses_of(e);
        if (uses.size() != 2) continue;
        neighbours_[uses[0] / 3][uses[0] % 3] = uses[1] / 3;
        neighbours_[uses[1] / 3][uses[1] % 3] = uses[0] / 3;
    }
    facets_.reserve(mesh.triangles.size());
    for (const auto& [a, b, c] : mesh.triangles) {
        const Vector3d u = mesh.points[b] - mesh.points[a], v = mesh.points[c] - mesh.points[a], n = u.cross(v);
        // Without area no point is over it: the coordinates are no numbers then.
        facets_.push_back(
            {mesh.points[a], n.stableNormalized(), v.cross(n) / n.squaredNorm(), n.cross(u) / n.squaredNorm()});
    }
}

ClosestTriangle::Hit DistanceTarget::descend(const Vector3d& p, int from) const {
    const OneSidedOptions options;
    const auto [triangle, distance] = DistanceSearch(*this, options).descend_to(p, from);
    return {triangle, distance};
}

std::vector<TooFar> DistanceTarget::sample_from(const MeshView& from, double limit, std::span<const int> near) const {
    const OneSidedOptions options;
    const DistanceSearch search(*this, options);
    const auto n = static_cast<int>(from.triangles.size());
    std::vector<TooFar> found(n);
    tbb::parallel_for(tbb::blocked_range<int>(0, n, 256), [&](const auto& range) {
        for (int t = range.begin(); t < range.end(); ++t) {
            const auto& [a, b, c] = from.triangles[t];
            const Vector3d &pa = from.points[a], &pb = from.points[b], &pc = from.points[c];
            const std::pair<Vector3d, int> samples[] = {
                {(pa + pb + pc) / 3, a}, {(pa + pb) / 2, a}, {(pb + pc) / 2, b}, {(pc + pa) / 2, c}};
            for (const auto& [p, v] : samples) {
                const auto [start, at_most] = search.descend_to(p, near[v]);
                if (at_most <= std::max(limit, found[t].distance)) continue;
                const auto [triangle, distance] = closest(p, start);
                if (distance > std::max(limit, found[t].distance)) found[t] = {t, distance, p, triangle};
            }
        }
    });
    std::erase_if(found, [](const TooFar& f) { return f.triangle < 0; });
    return found;
}

const ClosestTriangle& DistanceTarget::tree() const {
    std::call_once(tree_->planted, [&] { tree_->tree.emplace(mesh_.points, mesh_.triangles); });
    return *tree_->tree;
}

namespace {

// Triangles that need a search: not those that are proved to keep the limit from what is known to be near them.
// @param bound  the largest distance of those
std::vector<char> open_triangles(const DistanceSearch& search, const MeshView& from, const OneSidedOptions& options,
                                 double& bound) {
    const auto num_triangles = static_cast<int>(from.triangles.size());
    std::vector<char> open(num_triangles, 1);
    for (int t = 0; t < std::ssize(options.skip); ++t) open[t] = !options.skip[t];
    if (!(options.limit > 0) || options.near.empty()) return open;
    const auto keep = [&](const tbb::blocked_range<int>& range, double largest) {
        Witnesses unused;
        for (int t = range.begin(); t < range.end(); ++t) {
            const auto& [a, b, c] = from.triangles[t];
            if (!open[t] || options.near[a] < 0) continue;
            Witnesses& witnesses = options.witnesses.empty() ? unused : options.witnesses[t];
            open[t] = !search.keeps_limit(from.points[a], from.points[b], from.points[c], options.near[a], largest,
                                          witnesses);
        }
        return largest;
    };
    bound = tbb::parallel_reduce(tbb::blocked_range<int>(0, num_triangles, 256), 0.0, keep,
                                 [](double x, double y) { return std::max(x, y); });
    return open;
}

}  // namespace

OneSidedDistance DistanceTarget::measure_from(const MeshView& from, const OneSidedOptions& options) const {
    DistanceSearch search(*this, options);
    const auto num_triangles = static_cast<int>(from.triangles.size());
    OneSidedDistance result;
    const std::vector<char> open = open_triangles(search, from, options, result.bound);
    // The others and their vertices, which are few where most are known to be near, have room for more.
    std::vector<int> triangles, vertices, corner_of(from.points.size(), -1);
    for (int t = 0; t < num_triangles; ++t) {
        if (!open[t]) continue;
        triangles.push_back(t);
        for (const int v : from.triangles[t]) corner_of[v] = 0;
    }
    for (int v = 0; v < std::ssize(corner_of); ++v)
        if (corner_of[v] == 0) corner_of[v] = static_cast<int>(vertices.size()), vertices.push_back(v);
    std::vector<Corner> corners(vertices.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, corners.size(), 512), [&](const auto& range) {
        int last = -1;  // vertices that follow each other are often near each other
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            corners[i] = search.look(from.points[vertices[i]], options.near.empty() ? last : options.near[vertices[i]]);
            last = corners[i].hit.triangle;
        }
    });
    const auto corner = [&](int v) { return corners[corner_of[v]]; };
    if (!(options.limit > 0)) {
        Found found;
        Eigen::AlignedBox3d box;
        for (const Corner& c : corners) found.attain(c), box.extend(c.p);
        if (!box.isEmpty()) found.resolution = kResolution * box.diagonal().norm();
        const auto part = [&](std::size_t i) {
            const auto& [a, b, c] = from.triangles[triangles[i]];
            return Part{{corner(a), corner(b), corner(c)}};
        };
        return search.largest_of(triangles.size(), part, found,
                                 kMostWork + kMostWorkPerTriangle * (triangles.size() + mesh_.triangles.size()));
    }
    std::vector<Found> found(triangles.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, found.size(), 256), [&](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            const auto& [a, b, c] = from.triangles[triangles[i]];
            Witnesses* const witnesses = options.witnesses.empty() ? nullptr : &options.witnesses[triangles[i]];
            if (witnesses) witnesses->clear();
            found[i].witnesses = witnesses;
            search.divide_all({{{corner(a), corner(b), corner(c)}}}, found[i]);
            if (!witnesses) continue;
            if (found[i].bound <= options.limit)
                witnesses->proved = true;
            else
                *witnesses = {};
        }
    });
    for (std::size_t i = 0; i < found.size(); ++i) {
        const Found& f = found[i];
        result.bound = std::max(result.bound, f.bound);
        if (f.largest > result.largest) result.largest = f.largest, result.point = f.point;
        if (f.bound > options.limit) result.beyond.push_back({triangles[i], f.largest, f.point, f.nearest});
    }
    // Rounding may set them apart where both are of one corner.
    result.bound = std::max(result.bound, result.largest);
    return result;
}

}  // namespace gradus

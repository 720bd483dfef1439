#include "gradus/mesh/flats.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

namespace gradus {

namespace {

using Eigen::Vector3d;

constexpr double kRoundings = 2;    // off a plane, of corners that are on it
constexpr double kFlatness = 1e-7;  // the same over the longest side of its largest facet
constexpr double kSameWay = 0.5;  // cosine between normals of facets of one plane, which are not folded over each other
constexpr double kBegins = 1.9;   // next turn over that of the joint where a round begins, about
constexpr double kRidge = 2.0 / 3;  // of its turn, that the facets beside a ridge do not explain
constexpr double kSameTurn = 1e-6;  // by how much turns of one round differ, relative
constexpr double kParallel = 0.7;   // cosine between edges on both sides of a strip
constexpr int kMostFacets = 200;    // on a way over a region
constexpr int kManySided = 8;       // regions around one: facets of rounds are triangles and strips

Vector3d area_vector(std::span<const Vector3d> points, const Triangle& t) {
    return (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]) / 2;
}

// What a side explains of a bend, as a facet of a round.
double explained_by(double turn, const BendSide& side, double other_reach) {
    const double next_turn = side.is_strip ? side.next_turn : std::min(side.next_turn, turn);
    if (side.reach > kAlikeWidths * other_reach || side.reach > kAlikeWidths * side.next_width) return 0;
    if (next_turn <= 0 || next_turn > kSharpestRound) return 0;
    // Behind the last facet of a round the turn is all its own; but a single facet between two flat faces is no round.
    const bool ends_there = side.next_width > kAlikeWidths * side.reach;
    if (!ends_there) return next_turn / 2;
    return other_reach > kAlikeWidths * side.reach ? 0 : next_turn;
}

}  // namespace

double resolution_of(std::span<const Vector3d> points) {
    double largest = 0;
    bool in_single = true;
    for (const Vector3d& p : points) {
        largest = std::max(largest, p.cwiseAbs().maxCoeff());
        for (const double x : p) in_single = in_single && static_cast<double>(static_cast<float>(x)) == x;
    }
    if (!(largest > 0)) return 0;
    constexpr double kSingle = 6e-8, kDouble = 4e-16;  // half a unit; what a few operations leave
    const double exact = kDouble * largest;
    // Coordinates with few decimals: the coarsest step of a power of ten that all are multiples of.
    const int top = static_cast<int>(std::floor(std::log10(largest)));
    double step = 0;
    for (int digits = 6; digits <= 9 && step == 0; ++digits) {
        const double unit = std::pow(10.0, top - digits + 1);
        const auto is_multiple = [&](const Vector3d& p) {
            const Vector3d q = p / unit;
            return ((q - q.array().round().matrix()).array().abs() <= 1e-5).all();
        };
        if (std::all_of(points.begin(), points.end(), is_multiple)) step = unit / 2;
    }
    if (step > 0) return std::max(exact, step);
    return in_single ? kSingle * largest : exact;
}

double unexplained_turn(double turn, const BendSide& one, const BendSide& other) {
    // Where a round begins it turns half as much as beyond.
    for (const BendSide& side : {one, other})
        if (side.is_strip && side.next_turn >= kBegins * turn && side.next_turn <= kSharpestRound) return 0;
    return std::max(0.0, turn - explained_by(turn, one, other.reach) - explained_by(turn, other, one.reach));
}

bool is_ridge(double turn, const BendSide& one, const BendSide& other) {
    return unexplained_turn(turn, one, other) > kRidge * turn;
}

PlanarRegions::PlanarRegions(std::span<const Vector3d> points, const Connectivity& mesh)
    : points_(points), mesh_(&mesh), region_(mesh.num_triangles(), -1) {
    const double roundings = kRoundings * resolution_of(points);
    std::vector<double> area(mesh.num_triangles(), 0);
    std::vector<int> order;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        if (!mesh.is_live_triangle(t)) continue;
        area[t] = area_vector(points, mesh.triangle(t)).norm();
        order.push_back(t);
    }
    // The largest first: their planes are the surest.
    std::sort(order.begin(), order.end(), [&](int s, int t) { return area[s] != area[t] ? area[s] > area[t] : s < t; });
    std::vector<int> members;
    for (const int seed : order) {
        if (region_[seed] >= 0) continue;
        const Triangle corners = mesh.triangle(seed);
        const Vector3d& origin = points[corners[0]];
        const Vector3d normal = area_vector(points, corners).stableNormalized();
        double longest = 0;
        for (int k = 0; k < 3; ++k)
            longest = std::max(longest, (points[corners[(k + 1) % 3]] - points[corners[k]]).norm());
        const double tolerance = std::max(roundings, kFlatness * longest);
        const int number = size();
        region_[seed] = number;
        members.assign(1, seed);
        Vector3d sum = area_vector(points, corners);
        for (std::size_t i = 0; i < members.size() && !normal.isZero(); ++i)
            for (int h = 3 * members[i]; h < 3 * members[i] + 3; ++h) {
                const int g = mesh.twin(h);
                if (g < 0 || region_[g / 3] >= 0 || std::abs(normal.dot(points[mesh.apex(g)] - origin)) > tolerance)
                    continue;
                const Vector3d part = area_vector(points, mesh.triangle(g / 3));
                // What is narrower than the tolerance has no normal of its own.
                const double width = 2 * part.norm() / (points[mesh.target(g)] - points[mesh.origin(g)]).norm();
                if (width > tolerance && normal.dot(part) < kSameWay * part.norm()) continue;
                region_[g / 3] = number;
                members.push_back(g / 3);
                sum += part;
            }
        normals_.push_back(members.size() == 1 ? normal : Vector3d(sum.stableNormalized()));
        num_facets_.push_back(static_cast<int>(members.size()));
    }
    find_planes();
    find_reaches();
}

void PlanarRegions::find_planes() {
    is_plane_.assign(size(), 1);
    for (int h = 0; h < std::ssize(region_) * 3; ++h) {
        const int region = region_[h / 3], g = mesh_->twin(h);
        if (region >= 0 && num_facets_[region] == 1 && g >= 0 && num_facets_[region_[g / 3]] == 1)
            is_plane_[region] = 0;
    }
}

// Strips are quadrangles. What has many sides is no facet of a round. Others of more than four corners reach as far
// from a joint as from most of their joints; where a crease cuts them off, that says nothing of how finely they were
// sampled.
void PlanarRegions::find_reaches() {
    struct Section {
        double width, length;
    };
    std::vector<std::vector<Section>> sections(size());
    std::vector<std::pair<int, int>> around;  // regions, and one beside each
    for (int h = 0; h < std::ssize(region_) * 3; ++h) {
        const int region = region_[h / 3], g = mesh_->twin(h);
        if (region < 0 || num_facets_[region] <= 2 || g < 0 || region_[g / 3] == region) continue;
        around.emplace_back(region, region_[g / 3]);
        if (std::abs(turn_at(h)) > kSharpestRound) continue;
        const Way way = across(h);
        const bool is_cut =
            way.exit < 0 ||
            (is_parallel(h, way.exit) && (mesh_->twin(way.exit) < 0 || std::abs(turn_at(way.exit)) > kSharpestRound));
        sections[region].push_back({is_cut ? std::numeric_limits<double>::infinity() : way.length,
                                    (points_[mesh_->target(h)] - points_[mesh_->origin(h)]).norm()});
    }
    std::sort(around.begin(), around.end());
    around.erase(std::unique(around.begin(), around.end()), around.end());
    std::vector<int> num_around(size(), 0);
    for (const auto& [region, other] : around) ++num_around[region];
    reach_.assign(size(), 0);
    is_many_sided_.assign(size(), 0);
    for (int region = 0; region < size(); ++region) {
        is_many_sided_[region] = num_around[region] >= kManySided;
        if (is_many_sided_[region]) {
            reach_[region] = std::numeric_limits<double>::infinity();
            continue;
        }
        std::vector<Section>& of = sections[region];
        std::sort(of.begin(), of.end(), [](const Section& a, const Section& b) { return a.width < b.width; });
        double all = 0, sum = 0;
        for (const Section& s : of) all += s.length;
        for (const Section& s : of)
            if (sum += s.length; sum >= all / 2) {
                reach_[region] = s.width;
                break;
            }
    }
}

PlanarRegions::Way PlanarRegions::across(int h, double farthest, double start) const {
    const int region = region_[h / 3];
    const Vector3d& normal = normals_[region];
    const Vector3d along = points_[mesh_->target(h)] - points_[mesh_->origin(h)];
    const Vector3d from = points_[mesh_->origin(h)] + start * along, way = normal.cross(along).stableNormalized(),
                   aside = way.cross(normal);
    Way found{0, h};
    for (int facets = 0; facets < kMostFacets; ++facets) {
        // The way goes on through the side opposite to the corner that is on the same side of it as the apex.
        const double apex = aside.dot(points_[mesh_->apex(h)] - from);
        h = apex < 0 ? Connectivity::next(h) : Connectivity::prev(h);
        // Side h runs over the way: where it cuts it.
        const Vector3d a = points_[mesh_->origin(h)] - from, b = points_[mesh_->target(h)] - from;
        const double left = aside.dot(a), right = aside.dot(b),
                     share = left != right ? std::clamp(left / (left - right), 0.0, 1.0) : 0.5;
        found = {std::max(found.length, way.dot(a + share * (b - a))), h};
        if (found.length >= farthest) return {farthest, -1};
        const int g = mesh_->twin(h);
        if (g < 0 || region_[g / 3] != region) return found;
        h = g;
    }
    return {std::min(found.length, farthest), -1};
}

double PlanarRegions::turn_at(int h) const {
    const int g = mesh_->twin(h);
    if (g < 0) return 0;
    const Vector3d &n = normal_at(h / 3), &m = normal_at(g / 3);
    const Vector3d axis = (points_[mesh_->target(h)] - points_[mesh_->origin(h)]).stableNormalized();
    return std::atan2(n.cross(m).dot(axis), n.dot(m));
}

bool PlanarRegions::is_parallel(int h, int g) const {
    const auto along = [&](int e) {
        return (points_[mesh_->target(e)] - points_[mesh_->origin(e)]).stableNormalized();
    };
    return std::abs(along(h).dot(along(g))) >= kParallel;
}

BendSide PlanarRegions::side_of(int h) const {
    const Way own = across(h);
    BendSide side{own.length, std::max(own.length, reach_[region_[h / 3]]), 0, 0};
    const Vector3d axis = (points_[mesh_->target(h)] - points_[mesh_->origin(h)]).stableNormalized();
    const double way = turn_at(h) >= 0 ? 1 : -1;
    const Vector3d& normal = normal_at(h / 3);
    const auto turn_to = [&](int t) {
        return -way * std::atan2(normal.cross(normal_at(t)).dot(axis), normal.dot(normal_at(t)));
    };
    if (own.exit < 0) return side;
    const int beyond = mesh_->twin(own.exit);
    if (is_parallel(h, own.exit)) {
        if (beyond >= 0) side.next_turn = turn_to(beyond / 3), side.next_width = across(beyond).length;
        return side;
    }
    // No strip but a facet with a corner: the farthest of those around it, as far as no crease cuts them off, says
    // whether the surface turns on.
    const int first = Connectivity::prev(h);
    const auto is_smooth = [&](int e) { return e >= 0 && std::abs(turn_at(e)) <= kSharpestRound; };
    const auto include = [&](int e) { side.next_turn = std::max(side.next_turn, turn_to(e / 3)); };
    int e = mesh_->rotate(first);
    for (; is_smooth(e) && e != first; e = mesh_->rotate(e)) include(e);
    const bool all_around = e == first;
    for (e = first; !all_around && mesh_->twin(e) >= 0 && is_smooth(e); include(e))
        e = Connectivity::next(mesh_->twin(e));
    side.next_width = side.width;
    side.is_strip = false;
    return side;
}

FlatFaces find_flat_faces(std::span<const Vector3d> points, const Connectivity& mesh, const PlanarRegions& regions) {
    std::vector<double> smooth(regions.size(), 0), wide(regions.size(), 0);
    const double least = std::cos(kSharpestRound);
    for (int h = 0; h < 3 * mesh.num_triangles(); ++h) {
        if (!mesh.is_live_triangle(h / 3)) continue;
        const int g = mesh.twin(h), region = regions.of(h / 3);
        if (g < 0 || regions.of(g / 3) == region || regions.normal_at(h / 3).dot(regions.normal_at(g / 3)) < least)
            continue;
        const bool of_strips = regions.is_plane(region) && regions.is_plane(regions.of(g / 3));
        BendSide own, beyond;
        if (of_strips) own = regions.side_of(h), beyond = regions.side_of(g);
        if (of_strips && is_ridge(std::abs(regions.turn_at(h)), own, beyond)) continue;
        const double length = (points[mesh.target(h)] - points[mesh.origin(h)]).norm();
        smooth[region] += length;
        // On scans a facet is among others of one; on parts what it meets are strips.
        if (regions.num_facets(region) == 1 && !regions.is_plane(regions.of(g / 3))) continue;
        // Where a facet of a round meets a plane it turns half as much as from there to the next. A bend that turns
        // more is that of a facet which is wider than its neighbours.
        if (!of_strips) own = regions.side_of(h), beyond = regions.side_of(g);
        const double turn = std::abs(regions.turn_at(h)),
                     next_turn = beyond.is_strip ? beyond.next_turn : beyond.next_turn / 2;
        if (next_turn > 0 && next_turn < kSharpestRound && turn > (1 + kSameTurn) * next_turn) continue;
        if (own.reach > kAlikeWidths * beyond.reach) wide[region] += length;
    }
    FlatFaces flats;
    std::vector<int> number(regions.size(), -1);
    for (int region = 0; region < regions.size(); ++region) {
        const double most = regions.num_facets(region) > 2 ? 0.5 : 1;
        if (regions.normal(region).isZero()) continue;
        if (!regions.is_many_sided(region) &&
            (wide[region] < most * smooth[region] || (!regions.is_plane(region) && smooth[region] == 0)))
            continue;
        number[region] = static_cast<int>(flats.normals.size());
        flats.normals.push_back(regions.normal(region));
    }
    if (flats.empty()) return flats;
    flats.of_triangle.assign(mesh.num_triangles(), -1);
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (mesh.is_live_triangle(t)) flats.of_triangle[t] = number[regions.of(t)];
    return flats;
}

}  // namespace gradus

#include "gradus/mesh/thin_rounds.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

namespace gradus {

namespace {

using Eigen::Vector3d;

constexpr int kMostStrips = 100;  // to one side
constexpr double kTie = 1e-6;     // relative: two rows of edges are as far from the middle

class Finder {
  public:
    Finder(std::span<const Vector3d> points, const Connectivity& mesh, const PlanarRegions& regions,
           const FlatFaces& flats, double height, std::span<const double> width)
        : points_(points), mesh_(mesh), regions_(regions), flats_(flats), height_(height), width_(width) {}

    ThinRounds run() {
        ThinRounds found;
        std::vector<double> thin(regions_.size(), 0), thick(regions_.size(), 0);  // length of the middles that say so
        std::vector<Row> rows;
        for (int h = 0; h < 3 * mesh_.num_triangles(); ++h) {
            if (!mesh_.is_live_triangle(h / 3) || mesh_.twin(h) < h) continue;
            const std::optional<Row> row = row_at(h);
            if (!row) continue;
            const double length = (points_[mesh_.target(h)] - points_[mesh_.origin(h)]).norm();
            for (const Arm& arm : row->arms)
                for (const int region : arm.strips)
                    if (row->is_middle) (row->is_thin ? thin : thick)[region] += length;
            rows.push_back(*row);
        }
        const auto is_passed_over = [&](int region) { return thin[region] > thick[region]; };
        for (const Row& row : rows) {
            const auto is_whole = [&](const Arm& arm) {
                return std::all_of(arm.strips.begin(), arm.strips.end(), is_passed_over);
            };
            if (!is_whole(row.arms[0]) || !is_whole(row.arms[1])) continue;
            (row.is_middle ? found.ridges : found.others).push_back({mesh_.origin(row.edge), mesh_.target(row.edge)});
        }
        if (found.ridges.empty()) return found;
        found.has_triangle.resize(mesh_.num_triangles());
        for (int t = 0; t < mesh_.num_triangles(); ++t)
            found.has_triangle[t] = mesh_.is_live_triangle(t) && is_passed_over(regions_.of(t));
        std::vector<double> width(regions_.size(), 0);
        for (const Row& row : rows)
            for (const Arm& arm : row.arms)
                for (const int region : arm.strips)
                    width[region] = std::max(width[region], row.arms[0].width + row.arms[1].width);
        join_at_corners(width, found);
        return found;
    }

  private:
    // From an edge straight over the strips on one side of it, up to a flat face.
    struct Arm {
        int face = -1;
        double width = 0, height = 0;  // of the strips; of the middle of the edge over the plane of the face
        double first = 0;              // width of the strip beside the edge
        std::vector<int> strips;       // regions
    };
    struct Row {
        int edge;
        std::array<Arm, 2> arms;
        bool is_middle, is_thin;  // thin: the round, if this is its middle
    };

    bool is_part_of_round(double turn, double first_turn) const {
        return turn * first_turn > 0 && std::abs(turn) <= kSharpestRound;
    }

    // Whether a round ends at an edge: there is a flat face, that itself is no chamfer as thin as such a round.
    bool is_side(int h) const {
        const double limit = std::max(width_[mesh_.origin(h)], 2 * height_);
        return flats_.of(h / 3) >= 0 && (limit == 0 || regions_.across(h, limit).exit < 0);
    }

    std::optional<Arm> arm_at(int h, double turn) const {
        Arm arm;
        const Vector3d from = (points_[mesh_.origin(h)] + points_[mesh_.target(h)]) / 2;
        for (int strips = 0; !is_side(h); ++strips) {
            if (strips == kMostStrips || !regions_.is_plane(regions_.of(h / 3))) return std::nullopt;
            const PlanarRegions::Way way = regions_.across(h);
            if (way.exit < 0 || mesh_.twin(way.exit) < 0 || !regions_.is_parallel(h, way.exit)) return std::nullopt;
            if (!is_part_of_round(regions_.turn_at(way.exit), turn)) return std::nullopt;
            if (strips == 0) arm.first = way.length;
            arm.width += way.length;
            arm.strips.push_back(regions_.of(h / 3));
            h = mesh_.twin(way.exit);
        }
        arm.face = flats_.of(h / 3);
        arm.height = std::abs(flats_.normals[arm.face].dot(from - points_[mesh_.origin(h)]));
        return arm;
    }

    std::optional<Row> row_at(int h) const {
        if (regions_.of(h / 3) == regions_.of(mesh_.twin(h) / 3)) return std::nullopt;
        const double turn = regions_.turn_at(h);
        if (!is_part_of_round(turn, turn)) return std::nullopt;
        auto one = arm_at(h, turn);
        if (!one) return std::nullopt;
        auto other = arm_at(mesh_.twin(h), turn);
        if (!other || one->strips.size() + other->strips.size() == 0) return std::nullopt;
        // So that of two rows as far from the middle all edges choose the same.
        if (other->face < one->face) std::swap(one, other);
        const double width = one->width + other->width, off = one->width - other->width;
        const auto is_nearer = [&](double there) {
            return std::abs(off) < std::abs(there) - kTie * width ||
                   (std::abs(std::abs(off) - std::abs(there)) <= kTie * width && off > 0);
        };
        const bool is_middle = (one->strips.empty() || is_nearer(off - 2 * one->first)) &&
                               (other->strips.empty() || is_nearer(off + 2 * other->first));
        return Row{h,
                   {*one, *other},
                   is_middle,
                   width <= width_[mesh_.origin(h)] || std::max(one->height, other->height) <= height_};
    }

    // What is left where thin rounds meet at a corner.
    struct Patch {
        std::vector<int> triangles;
        double widest = 0;  // of the rounds around it
        bool is_enclosed = true;
    };

    // All that hangs together with a triangle, of no flat face and no thin round.
    Patch patch_of(int triangle, std::span<const double> width, const ThinRounds& found,
                   std::vector<char>& seen) const {
        Patch patch{{triangle}};
        seen[triangle] = 1;
        for (std::size_t i = 0; i < patch.triangles.size(); ++i)
            for (int h = 3 * patch.triangles[i], end = h + 3; h < end; ++h) {
                const int g = mesh_.twin(h);
                if (g >= 0 && found.has(g / 3))
                    patch.widest = std::max(patch.widest, width[regions_.of(g / 3)]);
                else if (g < 0 || (flats_.of(g / 3) < 0 && std::abs(regions_.turn_at(h)) > kSharpestRound))
                    patch.is_enclosed = false;
                else if (flats_.of(g / 3) < 0 && !seen[g / 3])
                    seen[g / 3] = 1, patch.triangles.push_back(g / 3);
            }
        return patch;
    }

    // Thin rounds that meet at a corner have facets there that are of none of them, as those of an eighth of a sphere:
    // the ridges go on over its edges to one vertex.
    // @param width  of the round that each region is a strip of
    void join_at_corners(std::span<const double> width, ThinRounds& found) const {
        std::vector<char> at_ridge(points_.size(), 0), seen(mesh_.num_triangles(), 0);
        for (const auto& [a, b] : found.ridges) at_ridge[a] = at_ridge[b] = 1;
        for (int t = 0; t < mesh_.num_triangles(); ++t) {
            if (!mesh_.is_live_triangle(t) || seen[t] || found.has(t) || flats_.of(t) >= 0) continue;
            const Patch patch = patch_of(t, width, found, seen);
            if (!patch.is_enclosed || patch.widest == 0) continue;
            Eigen::AlignedBox3d box;
            for (const int piece : patch.triangles)
                for (const int v : mesh_.triangle(piece)) box.extend(points_[v]);
            if (box.diagonal().norm() > kAlikeWidths * patch.widest) continue;
            std::map<int, std::vector<int>> neighbours;
            for (const int piece : patch.triangles) {
                const Triangle v = mesh_.triangle(piece);
                for (int k = 0; k < 3; ++k)
                    neighbours[v[k]].insert(neighbours[v[k]].end(), {v[(k + 1) % 3], v[(k + 2) % 3]});
            }
            std::vector<int> ends;
            for (const auto& [v, others] : neighbours)
                if (at_ridge[v]) ends.push_back(v);
            if (ends.size() < 2) continue;
            const std::set<std::array<int, 2>> ways = shortest_star(neighbours, ends);
            found.ridges.insert(found.ridges.end(), ways.begin(), ways.end());
            for (const auto& [v, others] : neighbours)
                for (const int w : others)
                    if (v < w && !ways.contains({v, w})) found.others.push_back({v, w});
            for (const int piece : patch.triangles) found.has_triangle[piece] = 1;
        }
    }

    // The edges from some vertices to the one from which the ways to all of them are shortest.
    std::set<std::array<int, 2>> shortest_star(const std::map<int, std::vector<int>>& neighbours,
                                               std::span<const int> ends) const {
        std::map<int, double> sum;
        std::vector<std::map<int, int>> before(ends.size());  // of each vertex on the way from an end
        for (std::size_t i = 0; i < ends.size(); ++i) {
            std::map<int, double> length;
            std::set<std::pair<double, int>> front{{0.0, ends[i]}};
            length[ends[i]] = 0;
            while (!front.empty()) {
                const auto [so_far, v] = *front.begin();
                front.erase(front.begin());
                if (so_far > length[v]) continue;
                sum[v] += so_far;
                for (const int w : neighbours.at(v)) {
                    const double longer = so_far + (points_[w] - points_[v]).norm();
                    if (const auto known = length.find(w); known != length.end() && known->second <= longer) continue;
                    length[w] = longer;
                    before[i][w] = v;
                    front.emplace(longer, w);
                }
            }
        }
        const int middle = std::min_element(sum.begin(), sum.end(), [](const auto& a, const auto& b) {
                               return a.second < b.second;
                           })->first;
        std::set<std::array<int, 2>> edges;
        for (std::size_t i = 0; i < ends.size(); ++i)
            for (int v = middle; v != ends[i]; v = before[i].at(v))
                edges.insert({std::min(v, before[i].at(v)), std::max(v, before[i].at(v))});
        return edges;
    }

    std::span<const Vector3d> points_;
    const Connectivity& mesh_;
    const PlanarRegions& regions_;
    const FlatFaces& flats_;
    double height_;
    std::span<const double> width_;
};

}  // namespace

ThinRounds find_thin_rounds(std::span<const Vector3d> points, const Connectivity& mesh, const PlanarRegions& regions,
                            const FlatFaces& flats, double height, std::span<const double> width) {
    if (flats.empty()) return {};
    return Finder(points, mesh, regions, flats, height, width).run();
}

}  // namespace gradus

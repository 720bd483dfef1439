#include "sheets.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <tuple>

#include "disjoint_sets.hpp"

namespace gradus {
namespace {

constexpr int kNone = -1;

int next(int side) { return side % 3 == 2 ? side - 2 : side + 1; }
int previous(int side) { return side % 3 == 0 ? side + 2 : side - 1; }

/// All choices are made by triangle index and by geometry, not by the numbers of vertices.
class Joiner {
  public:
    Joiner(std::span<const Eigen::Vector3d> points, std::span<const Triangle> places,
           std::span<const Triangle> vertices)
        : points_(points), places_(places), vertices_(vertices), partner_(3 * places.size(), kNone) {
        sheets_.turned.assign(places.size(), 0);
        sheets_.crowded.assign(3 * places.size(), 0);
    }

    Sheets join() {
        find_edges();
        for (const Edge& edge : edges_) join_obvious(edge);
        orient();
        DisjointSets pieces = joined_triangles();
        for (const Edge& edge : edges_)
            if (edge.sides.size() > 2) join_sheets_at(edge, pieces);
        DisjointSets fans = joined_corners();
        while (part_doubled_edges(fans)) fans = joined_corners();
        turn_outward();
        sheets_.fan.resize(partner_.size());
        for (int corner = 0; corner < static_cast<int>(partner_.size()); ++corner)
            sheets_.fan[corner] = fans.find(corner);
        return std::move(sheets_);
    }

  private:
    struct Edge {
        std::array<int, 2> ends;     // places, the first one first by coordinates
        std::span<const int> sides;  // by triangle
    };

    int start(int side) const { return places_[side / 3][side % 3]; }
    int end(int side) const { return start(next(side)); }
    int apex(int side) const { return start(previous(side)); }
    /// The corner of the triangle of `side` at `place`, an end of the side.
    int corner_at(int side, int place) const { return start(side) == place ? side : next(side); }
    int vertex_at(int side, int place) const {
        const int corner = corner_at(side, place);
        return vertices_[corner / 3][corner % 3];
    }
    bool same_vertices(int a, int b) const {
        return vertex_at(a, start(a)) == vertex_at(b, start(a)) && vertex_at(a, end(a)) == vertex_at(b, end(a));
    }
    /// Whether the triangles of two sides at one edge agree in orientation, as given and as turned.
    bool agree_as_given(int a, int b) const { return start(a) != start(b); }
    bool agree(int a, int b) const { return agree_as_given(a, b) == (sheets_.turned[a / 3] == sheets_.turned[b / 3]); }
    void join(int a, int b) { partner_[a] = b, partner_[b] = a; }
    void part(int a) {
        if (partner_[a] != kNone) partner_[partner_[a]] = kNone, partner_[a] = kNone;
    }

    void find_edges() {
        struct Use {
            std::uint64_t edge;
            int side;
        };
        std::vector<Use> uses;
        uses.reserve(partner_.size());
        for (int side = 0; side < static_cast<int>(partner_.size()); ++side) {
            const auto [a, b] = std::minmax({start(side), end(side)});
            uses.push_back({static_cast<std::uint64_t>(a) << 32 | static_cast<std::uint64_t>(b), side});
        }
        std::sort(uses.begin(), uses.end(),
                  [](const Use& x, const Use& y) { return std::tie(x.edge, x.side) < std::tie(y.edge, y.side); });
        sides_.reserve(uses.size());
        for (const Use& use : uses) sides_.push_back(use.side);
        for (std::size_t first = 0, last = 0; first < uses.size(); first = last) {
            while (last < uses.size() && uses[last].edge == uses[first].edge) ++last;
            if (last - first < 2) continue;
            std::array<int, 2> ends{start(sides_[first]), end(sides_[first])};
            const auto key = [&](int place) {
                return std::tuple(points_[place].x(), points_[place].y(), points_[place].z());
            };
            if (key(ends[1]) < key(ends[0])) std::swap(ends[0], ends[1]);
            edges_.push_back({ends, std::span(sides_).subspan(first, last - first)});
            if (last - first == 2) continue;
            sheets_.has_cuts = true;
            for (const int side : edges_.back().sides) sheets_.crowded[side] = 1;
        }
    }

    /// Calls visit(sides) for the sides of an edge that have the same keys.
    template <class Key, class Visit>
    static void for_each_group(std::span<const int> sides, Key key, Visit visit) {
        std::vector<std::pair<std::pair<int, int>, int>> sorted;
        for (const int side : sides) sorted.emplace_back(key(side), side);
        std::sort(sorted.begin(), sorted.end());
        std::vector<int> group;
        for (std::size_t first = 0, last = 0; first < sorted.size(); first = last) {
            group.clear();
            for (; last < sorted.size() && sorted[last].first == sorted[first].first; ++last)
                group.push_back(sorted[last].second);
            visit(group);
        }
    }

    /// Two sides are one edge; of more, those that the input has made one.
    void join_obvious(const Edge& edge) {
        if (edge.sides.size() == 2) return join(edge.sides[0], edge.sides[1]);
        const auto key = [&](int side) {
            return std::pair(vertex_at(side, edge.ends[0]), vertex_at(side, edge.ends[1]));
        };
        for_each_group(edge.sides, key, [&](const std::vector<int>& group) {
            if (group.size() == 2) join(group[0], group[1]);
        });
    }

    /// Turns triangles until those joined agree, and parts those that cannot. What agrees as given is followed first,
    /// so it stays.
    void orient() {
        enum Order { Joined, Agreeing, Opposed };
        std::array<std::deque<int>, 3> waiting;  // sides of triangles reached
        std::vector<char> reached(places_.size(), 0);
        std::vector<int> piece;
        const auto reach = [&](int t) {
            reached[t] = 1;
            piece.push_back(t);
            for (int side = 3 * t; side < 3 * t + 3; ++side) {
                const int other = partner_[side];
                if (other == kNone) continue;
                waiting[!agree_as_given(side, other) ? Opposed
                        : same_vertices(side, other) ? Joined
                                                     : Agreeing]
                    .push_back(side);
            }
        };
        for (int root = 0; root < static_cast<int>(places_.size()); ++root) {
            if (reached[root]) continue;
            piece.clear();
            reach(root);
            while (true) {
                const auto some =
                    std::find_if(waiting.begin(), waiting.end(), [](const auto& queue) { return !queue.empty(); });
                if (some == waiting.end()) break;
                const int side = some->front();
                some->pop_front();
                const int other = partner_[side];
                if (other == kNone) continue;
                if (!reached[other / 3]) {
                    sheets_.turned[other / 3] = sheets_.turned[side / 3] ^ (agree_as_given(side, other) ? 0 : 1);
                    reach(other / 3);
                } else if (!agree(side, other)) {
                    part(side);
                    sheets_.has_cuts = true;
                }
            }
            const auto count = std::count_if(piece.begin(), piece.end(), [&](int t) { return sheets_.turned[t] != 0; });
            if (2 * static_cast<std::size_t>(count) > piece.size())
                for (const int t : piece) sheets_.turned[t] ^= 1;
        }
    }

    // Edges of three triangles and more
    // ----------------------------------------------------------------------------------

    struct Leaf {
        int side;
        int piece;               // triangles connected so far
        bool forward;            // from the first end to the second
        Eigen::Vector3d across;  // unit vector from the edge into the triangle
        double angle;            // around the edge
    };

    void join_sheets_at(const Edge& edge, DisjointSets& pieces) {
        // Pairing is cubic in the number of leaves; a book of so many is no surface anyway.
        constexpr std::size_t kMostLeaves = 100;
        if (edge.sides.size() > kMostLeaves) return;
        std::vector<Leaf> leaves;
        const Eigen::Vector3d origin = points_[edge.ends[0]],
                              axis = (points_[edge.ends[1]] - origin).stableNormalized();
        Eigen::Vector3d x, y;
        for (const int side : edge.sides) {
            if (partner_[side] != kNone) continue;
            const Eigen::Vector3d to_apex = points_[apex(side)] - origin;
            const Eigen::Vector3d across = (to_apex - axis.dot(to_apex) * axis).stableNormalized();
            if (leaves.empty()) x = across, y = axis.cross(x);
            const bool forward = (start(side) == edge.ends[0]) != (sheets_.turned[side / 3] != 0);
            leaves.push_back({side, pieces.find(side / 3), forward, across, std::atan2(y.dot(across), x.dot(across))});
        }
        while (leaves.size() > 1 && !join_solids(leaves) && join_straightest(leaves)) {
        }
    }

    /// Where leaves face each other in turn, those with the inside between them belong together.
    bool join_solids(const std::vector<Leaf>& given) {
        std::vector<Leaf> leaves = given;
        // Of two that lie on each other the forward one first: between them is no inside, but where two solids touch.
        std::stable_sort(leaves.begin(), leaves.end(), [](const Leaf& a, const Leaf& b) {
            return std::pair(a.angle, !a.forward) < std::pair(b.angle, !b.forward);
        });
        for (std::size_t i = 0; i < leaves.size(); ++i)
            if (leaves[i].forward == leaves[(i + 1) % leaves.size()].forward) return false;
        // The normal of a forward leaf points to larger angles, so the inside is below it.
        for (std::size_t i = 0; i < leaves.size(); ++i)
            if (leaves[i].forward) join(leaves[i].side, leaves[(i + leaves.size() - 1) % leaves.size()].side);
        return true;
    }

    /// Joins the two leaves that belong together best, and takes them out, unless they are oriented differently: leaves
    /// of one piece, that it may stay whole, before others, and those that continue each other straightest.
    /// @returns whether it did
    bool join_straightest(std::vector<Leaf>& leaves) {
        const auto rank = [&](std::size_t i, std::size_t k) {
            const Leaf &a = leaves[i], &b = leaves[k];
            return std::pair(a.piece == b.piece && a.forward != b.forward ? 0 : 1, a.across.dot(b.across));
        };
        std::array<std::size_t, 2> best{0, 1};
        for (std::size_t i = 0; i < leaves.size(); ++i)
            for (std::size_t k = i + 1; k < leaves.size(); ++k)
                if (rank(i, k) < rank(best[0], best[1])) best = {i, k};
        if (leaves[best[0]].forward == leaves[best[1]].forward) return false;
        join(leaves[best[0]].side, leaves[best[1]].side);
        leaves.erase(leaves.begin() + static_cast<std::ptrdiff_t>(best[1]));
        leaves.erase(leaves.begin() + static_cast<std::ptrdiff_t>(best[0]));
        return true;
    }

    DisjointSets joined_triangles() const {
        DisjointSets pieces(places_.size());
        for (int side = 0; side < static_cast<int>(partner_.size()); ++side)
            if (partner_[side] > side) pieces.unite(side / 3, partner_[side] / 3);
        return pieces;
    }

    // Fans
    // ---------------------------------------------------------------------------------------------------------------

    DisjointSets joined_corners() const {
        DisjointSets fans(partner_.size());
        for (const Edge& edge : edges_)
            for (const int side : edge.sides)
                if (partner_[side] > side)
                    for (const int place : edge.ends)
                        fans.unite(corner_at(side, place), corner_at(partner_[side], place));
        return fans;
    }

    /// Sides that are not joined but whose ends are, both, by way of other triangles, would still be one edge: joins
    /// them where they are two and agree; else frees the triangles there at one end, all but one pair.
    /// @returns whether some were freed; each time there is less to part
    bool part_doubled_edges(DisjointSets& fans) {
        std::vector<int> freed;  // corners
        for (const Edge& edge : edges_) {
            if (edge.sides.size() == 2 && partner_[edge.sides[0]] != kNone) continue;
            const auto key = [&](int side) {
                return std::pair(fans.find(corner_at(side, edge.ends[0])), fans.find(corner_at(side, edge.ends[1])));
            };
            for_each_group(edge.sides, key, [&](const std::vector<int>& group) {
                if (group.size() < 2 || (group.size() == 2 && partner_[group[0]] == group[1])) return;
                if (group.size() == 2 && agree(group[0], group[1])) return join(group[0], group[1]);
                const auto paired =
                    std::find_if(group.begin(), group.end(), [&](int side) { return partner_[side] != kNone; });
                const int kept = paired != group.end() ? *paired : group[0];
                for (const int side : group)
                    if (side != kept && side != partner_[kept]) freed.push_back(corner_at(side, edge.ends[0]));
            });
        }
        for (const int corner : freed) part(corner), part(previous(corner));
        return !freed.empty();
    }

    // Outside
    // ------------------------------------------------------------------------------------------------------------

    /// Turns closed pieces whose triangles did not agree as given, where they enclose a negative volume.
    void turn_outward() {
        DisjointSets pieces = joined_triangles();
        struct Piece {
            double volume = 0;
            bool open = false, mixed = false;
        };
        std::vector<Piece> of(places_.size());
        for (int t = 0; t < static_cast<int>(places_.size()); ++t) {
            const int root = pieces.find(t);
            Piece& piece = of[root];
            const Eigen::Vector3d& origin = points_[places_[root][0]];
            const Eigen::Vector3d a = points_[places_[t][0]] - origin, b = points_[places_[t][1]] - origin,
                                  c = points_[places_[t][2]] - origin;
            piece.volume += (sheets_.turned[t] ? -1 : 1) * a.dot(b.cross(c));
            piece.mixed = piece.mixed || sheets_.turned[t];
            for (int side = 3 * t; side < 3 * t + 3; ++side) piece.open = piece.open || partner_[side] == kNone;
        }
        for (int t = 0; t < static_cast<int>(places_.size()); ++t) {
            const Piece& piece = of[pieces.find(t)];
            if (piece.mixed && !piece.open && piece.volume < 0) sheets_.turned[t] ^= 1;
        }
    }

    std::span<const Eigen::Vector3d> points_;
    std::span<const Triangle> places_, vertices_;
    std::vector<int> sides_;    // by edge
    std::vector<Edge> edges_;   // of two sides or more
    std::vector<int> partner_;  // per side: the side joined to it
    Sheets sheets_;
};

/// Whether nothing was turned, and the corners at one vertex are those of one fan.
bool is_settled(const Sheets& sheets, std::span<const Triangle> vertices) {
    if (std::any_of(sheets.turned.begin(), sheets.turned.end(), [](char turned) { return turned != 0; })) return false;
    int num_vertices = 0;
    for (const Triangle& triangle : vertices)
        num_vertices = std::max({num_vertices, triangle[0] + 1, triangle[1] + 1, triangle[2] + 1});
    std::vector<int> fan_of(static_cast<std::size_t>(num_vertices), kNone), vertex_of(sheets.fan.size(), kNone);
    for (int corner = 0; corner < static_cast<int>(sheets.fan.size()); ++corner) {
        const int v = vertices[corner / 3][corner % 3], fan = sheets.fan[corner];
        if (fan_of[v] == kNone) fan_of[v] = fan;
        if (vertex_of[fan] == kNone) vertex_of[fan] = v;
        if (fan_of[v] != fan || vertex_of[fan] != v) return false;
    }
    return true;
}

/// As its two last corners change places.
void turn(Triangle& triangle) { std::swap(triangle[1], triangle[2]); }

/// Fans numbered in the order of the corners as turned: the same for the same result however it came about.
std::vector<int> numbered(const Sheets& sheets) {
    std::vector<int> number(sheets.fan.size(), kNone), result;
    int count = 0;
    for (int corner = 0; corner < static_cast<int>(sheets.fan.size()); ++corner) {
        const int k = corner % 3, turned = sheets.turned[corner / 3] && k > 0 ? corner + (k == 1 ? 1 : -1) : corner;
        int& n = number[sheets.fan[turned]];
        if (n == kNone) n = count++;
        result.push_back(n);
    }
    return result;
}

/// What is joined now, joined again: around cuts it may come out differently.
Sheets join_again(const Sheets& sheets, std::span<const Eigen::Vector3d> points, std::span<const Triangle> places) {
    std::vector<Triangle> turned_places(places.begin(), places.end()), joined(places.size());
    for (int t = 0; t < static_cast<int>(places.size()); ++t) {
        joined[t] = {sheets.fan[3 * t], sheets.fan[3 * t + 1], sheets.fan[3 * t + 2]};
        if (sheets.turned[t]) turn(turned_places[t]), turn(joined[t]);
    }
    const Sheets again = Joiner(points, turned_places, joined).join();
    if (is_settled(again, joined)) return sheets;
    Sheets result = sheets;
    for (int t = 0; t < static_cast<int>(places.size()); ++t) {
        // Fans are told by corners, and these have changed places.
        for (int k = 0; k < 3; ++k) {
            const auto old = [&](int corner) {
                const int m = corner % 3;
                return sheets.turned[corner / 3] && m > 0 ? corner + (m == 1 ? 1 : -1) : corner;
            };
            result.fan[old(3 * t + k)] = old(again.fan[3 * t + k]);
        }
        result.turned[t] = sheets.turned[t] ^ again.turned[t];
    }
    return result;
}

bool same(const Sheets& a, const Sheets& b) { return a.fan == b.fan && a.turned == b.turned; }

}  // namespace

Sheets join_sheets(std::span<const Eigen::Vector3d> points, std::span<const Triangle> places,
                   std::span<const Triangle> vertices) {
    Sheets sheets = Joiner(points, places, vertices).join();
    if (!sheets.has_cuts || is_settled(sheets, vertices)) return sheets;
    // Larger pieces stay together better, so the result is joined again until it stays. Very rarely it goes round in a
    // circle; then it is the least one there. The bound is for the unforeseen.
    constexpr int kMostRounds = 200;
    std::map<std::vector<int>, Sheets> seen;
    for (int round = 0; round < kMostRounds; ++round) {
        const Sheets again = join_again(sheets, points, places);
        if (same(again, sheets)) return sheets;
        sheets = again;
        if (!seen.emplace(numbered(sheets), sheets).second) break;
    }
    // Once round.
    const std::vector<int> start = numbered(sheets);
    std::vector<int> least = start;
    while (true) {
        sheets = join_again(sheets, points, places);
        const std::vector<int> here = numbered(sheets);
        if (here == start || !seen.contains(here)) break;
        least = std::min(least, here);
    }
    return seen.at(least);
}

}  // namespace gradus

#include "gradus/mesh/repair.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <optional>
#include <queue>
#include <set>
#include <stdexcept>
#include <tuple>
#include <utility>

#include <Eigen/Geometry>

#include "flat.hpp"
#include "gradus/mesh/edge.hpp"
#include "gradus/mesh/flats.hpp"
#include "junctions.hpp"
#include "places.hpp"
#include "sheets.hpp"

namespace gradus {
namespace {

using Edge = std::array<int, 2>;

constexpr int kNone = -1;
constexpr int kMostRounds = 100;  // of joining T-junctions and resolving flat triangles; a few do

/// A triangle on its way from the input to the result.
struct Piece {
    Triangle places;    ///< of its corners: the first vertex of each place
    Triangle vertices;  ///< of the input
    int source;         ///< triangle of the input
    bool alive = true;

    bool has_repeated_place() const {
        return places[0] == places[1] || places[1] == places[2] || places[2] == places[0];
    }
};

/// Collects what was done, by kind.
class Log {
  public:
    void add(RepairKind kind, const std::vector<int>& item) { steps_[kind].add(item); }
    std::vector<RepairStep> steps() const {
        std::vector<RepairStep> result;
        for (const auto& [kind, items] : steps_) result.push_back({kind, items});
        return result;
    }

  private:
    std::map<RepairKind, Findings<std::vector<int>>> steps_;
};

/// The same for all triangles of these places.
Triangle key_of(const Piece& piece) {
    Triangle key = piece.places;
    std::sort(key.begin(), key.end());
    return key;
}

// Triangles
// --------------------------------------------------------------------------------------------------------------

std::vector<Piece> usable_triangles(const TriangleSoup& soup, Log& log) {
    const int n = static_cast<int>(soup.points.size());
    std::vector<Piece> pieces;
    pieces.reserve(soup.triangles.size());
    for (int t = 0; t < static_cast<int>(soup.triangles.size()); ++t) {
        const Triangle& v = soup.triangles[t];
        if (std::any_of(v.begin(), v.end(), [&](int i) { return i < 0 || i >= n; }))
            log.add(RepairKind::OutOfRange, {t});
        else if (!std::all_of(v.begin(), v.end(), [&](int i) { return soup.points[i].allFinite(); }))
            log.add(RepairKind::BadNumbers, {t});
        else
            pieces.push_back({v, v, t});
    }
    return pieces;
}

std::vector<char> used_vertices(const std::vector<Piece>& pieces, std::size_t num_points) {
    std::vector<char> used(num_points, 0);
    for (const Piece& piece : pieces)
        for (const int v : piece.vertices) used[v] = 1;
    return used;
}

void drop_repeated(std::vector<Piece>& pieces, Log& log) {
    std::erase_if(pieces, [&](const Piece& piece) {
        if (piece.has_repeated_place()) log.add(RepairKind::RepeatedIndex, {piece.source});
        return piece.has_repeated_place();
    });
}

// Copies are dropped, but where they may be of two closed parts that lie against each other, if these are to stay:
// there they face opposite ways, and each edge has an even number of triangles with both of them.
void drop_copies(std::vector<Piece>& pieces, bool parts_may_touch, Log& log) {
    std::vector<Edge> sides;
    if (parts_may_touch)
        for (const Piece& piece : pieces)
            for (int k = 0; k < 3; ++k) sides.push_back(edge_between(piece.places[k], piece.places[(k + 1) % 3]));
    std::sort(sides.begin(), sides.end());
    const auto is_even = [&](const Edge& e) {
        const auto [first, last] = std::equal_range(sides.begin(), sides.end(), e);
        return (last - first) % 2 == 0;
    };
    const auto lie_against_each_other = [&](const Piece& a, const Piece& b) {
        const Triangle &t = a.places, &u = b.places;
        const auto turned = std::find(u.begin(), u.end(), t[0]) - u.begin();
        if (u[(turned + 1) % 3] == t[1]) return false;
        return is_even(edge_between(t[0], t[1])) && is_even(edge_between(t[1], t[2])) &&
               is_even(edge_between(t[2], t[0]));
    };
    std::vector<std::pair<Triangle, int>> keys;
    keys.reserve(pieces.size());
    for (int i = 0; i < static_cast<int>(pieces.size()); ++i) keys.emplace_back(key_of(pieces[i]), i);
    std::sort(keys.begin(), keys.end());
    std::vector<std::vector<int>> copies;
    for (std::size_t first = 0, k = 1; k < keys.size(); ++k) {
        if (keys[k].first != keys[first].first) {
            first = k;
            continue;
        }
        if (parts_may_touch && lie_against_each_other(pieces[keys[first].second], pieces[keys[k].second])) continue;
        pieces[keys[k].second].alive = false;
        copies.push_back({pieces[keys[first].second].source, pieces[keys[k].second].source});
    }
    std::sort(copies.begin(), copies.end());
    for (const auto& copy : copies) log.add(RepairKind::DuplicateTriangles, copy);
    std::erase_if(pieces, [](const Piece& piece) { return !piece.alive; });
}

// Flat triangles
// ---------------------------------------------------------------------------------------------------------

/// Step 5. Longest sides go first: what comes of them is shorter.
class FlatResolver {
  public:
    /// @param points  of the places, as given
    /// @param unit    the same in [-1, 1]
    /// @param flatness  see RepairOptions
    FlatResolver(const Points& points, const Points& unit, std::vector<Piece> pieces, double flatness)
        : points_(points), unit_(unit), pieces_(std::move(pieces)), merged_(points.size()), flatness_(flatness) {
        std::iota(merged_.begin(), merged_.end(), 0);
    }

    /// @returns whether it came to an end, with no flat triangle left
    bool resolve() {
        std::vector<int> low;
        for (int i = 0; i < static_cast<int>(pieces_.size()); ++i)
            if (is_on_line(i) || is_low(i)) low.push_back(i);
        if (low.empty()) return true;
        around_.resize(points_.size());
        for (int i = 0; i < static_cast<int>(pieces_.size()); ++i) list(i);
        for (const int i : low) enqueue(i);
        std::size_t budget = 1000 + 50 * waiting_.size();
        while (!waiting_.empty()) {
            const int i = -waiting_.top().second;
            waiting_.pop();
            if (!is_flat(i)) continue;
            if (budget-- == 0) return false;
            if (const auto side = vanishing_side(i))
                lose_side(i, *side);
            else
                split_across(i);
        }
        return true;
    }

    std::vector<Piece> take_pieces() {
        std::erase_if(pieces_, [](const Piece& piece) { return !piece.alive; });
        std::stable_sort(pieces_.begin(), pieces_.end(),
                         [](const Piece& a, const Piece& b) { return a.source < b.source; });
        return std::move(pieces_);
    }
    /// The place that a place has become.
    int merged(int place) const {
        while (merged_[place] != place) place = merged_[place];
        return place;
    }
    /// The vertex that now splits an edge, by its places.
    const std::map<Edge, int>& splits() const { return splits_; }
    /// A flat triangle and those split for it.
    const std::vector<std::vector<int>>& items() const { return items_; }

  private:
    bool is_on_line(int i) const {
        const auto& [a, b, c] = pieces_[i].places;
        return gradus::is_flat(points_[a], points_[b], points_[c]);
    }
    bool is_low(int i) const {
        const auto& [a, b, c] = pieces_[i].places;
        const Eigen::Vector3d u = unit_[b] - unit_[a], v = unit_[c] - unit_[a];
        return flatness_ > 0 &&
               u.cross(v).norm() <= flatness_ * std::max({u.squaredNorm(), v.squaredNorm(), (v - u).squaredNorm()});
    }
    // Whether it does not go on straight where one triangle is across its longest side.
    bool bends_away(int i) const {
        const auto k = static_cast<std::size_t>(longest_side(i));
        const int a = pieces_[i].places[k], b = pieces_[i].places[(k + 1) % 3];
        const Eigen::Vector3d along = (unit_[b] - unit_[a]).normalized();
        const auto off = [&](int place) -> Eigen::Vector3d {
            const Eigen::Vector3d d = unit_[place] - unit_[a];
            return (d - d.dot(along) * along).normalized();
        };
        int others = 0;
        bool bends = false;
        for (const int other : around_[a]) {
            const Triangle& places = pieces_[other].places;
            if (other == i || !pieces_[other].alive || std::find(places.begin(), places.end(), b) == places.end())
                continue;
            const int apex =
                *std::find_if(places.begin(), places.end(), [&](int place) { return place != a && place != b; });
            bends = off(apex).dot(off(pieces_[i].places[(k + 2) % 3])) > -kGoesOn;
            ++others;
        }
        return others == 1 && bends;
    }
    bool is_flat(int i) const { return pieces_[i].alive && (is_on_line(i) || (is_low(i) && bends_away(i))); }
    std::tuple<double, double, double> coordinates(int place) const {
        return {points_[place].x(), points_[place].y(), points_[place].z()};
    }
    /// Sides by length; ties by the coordinates of the ends, not by their numbers.
    auto side_key(int i, int k) const {
        const int a = pieces_[i].places[k], b = pieces_[i].places[(k + 1) % 3];
        return std::tuple((unit_[a] - unit_[b]).norm(), std::min(coordinates(a), coordinates(b)),
                          std::max(coordinates(a), coordinates(b)));
    }
    int shortest_side(int i) const {
        return std::min({0, 1, 2}, [&](int k, int m) { return side_key(i, k) < side_key(i, m); });
    }
    int longest_side(int i) const {
        return std::max({0, 1, 2}, [&](int k, int m) { return side_key(i, k) < side_key(i, m); });
    }

    void enqueue(int i) {
        if (!is_flat(i)) return;
        // Of copies one does: whatever is across its sides, it vanishes between them.
        const Triangle key = key_of(pieces_[i]);
        const auto [known, is_new] = flats_.emplace(key, i);
        if (!is_new && known->second != i && pieces_[known->second].alive && key_of(pieces_[known->second]) == key) {
            pieces_[i].alive = false;
            return;
        }
        known->second = i;
        waiting_.emplace(std::get<0>(side_key(i, longest_side(i))), -i);
    }
    void list(int i) {
        for (const int place : pieces_[i].places) around_[place].push_back(i);
    }

    /// A side as short as what rounding makes of its ends.
    std::optional<int> vanishing_side(int i) const {
        const int k = shortest_side(i);
        const Triangle& places = pieces_[i].places;
        const double largest =
            std::max(unit_[places[k]].cwiseAbs().maxCoeff(), unit_[places[(k + 1) % 3]].cwiseAbs().maxCoeff());
        if (std::get<0>(side_key(i, k)) > kRoundingOfProducts * largest) return {};
        return k;
    }

    void lose_side(int i, int k) {
        items_.push_back({pieces_[i].source});
        int kept = pieces_[i].places[k], gone = pieces_[i].places[(k + 1) % 3];
        if (coordinates(gone) < coordinates(kept)) std::swap(kept, gone);
        merged_[gone] = kept;
        for (const int other : std::exchange(around_[gone], {})) {
            Piece& piece = pieces_[other];
            if (!piece.alive || std::count(piece.places.begin(), piece.places.end(), gone) == 0) continue;
            std::replace(piece.places.begin(), piece.places.end(), gone, kept);
            if (piece.has_repeated_place()) {
                piece.alive = false;
                continue;
            }
            around_[kept].push_back(other);
            enqueue(other);
        }
    }

    void split_across(int i) {
        const auto k = static_cast<std::size_t>(longest_side(i));
        const Triangle places = pieces_[i].places;
        const int a = places[k], b = places[(k + 1) % 3], middle = places[(k + 2) % 3];
        const int vertex = pieces_[i].vertices[(k + 2) % 3];
        pieces_[i].alive = false;
        splits_.emplace(edge_between(a, b), vertex);
        std::vector<int> item{pieces_[i].source}, others;
        for (const int other : around_[a]) {
            const Piece& piece = pieces_[other];
            const auto has = [&](int place) { return std::count(piece.places.begin(), piece.places.end(), place) > 0; };
            if (piece.alive && has(a) && has(b)) others.push_back(other);
        }
        std::sort(others.begin(), others.end());
        others.erase(std::unique(others.begin(), others.end()), others.end());
        for (const int other : others) {
            item.push_back(pieces_[other].source);
            split(other, a, b, middle, vertex);
        }
        items_.push_back(std::move(item));
    }

    void split(int i, int a, int b, int middle, int vertex) {
        std::size_t k = 0;
        while (edge_between(pieces_[i].places[k], pieces_[i].places[(k + 1) % 3]) != edge_between(a, b)) ++k;
        // Its copy: both halves vanish.
        if (pieces_[i].places[(k + 2) % 3] == middle) {
            pieces_[i].alive = false;
            return;
        }
        Piece second = pieces_[i];
        Piece& first = pieces_[i];
        // The first keeps the end with the smaller coordinates, whichever way the triangle runs.
        std::size_t m = (k + 1) % 3;
        if (coordinates(first.places[m]) < coordinates(first.places[k])) std::swap(k, m);
        first.places[m] = middle, first.vertices[m] = vertex;
        second.places[k] = middle, second.vertices[k] = vertex;
        pieces_.push_back(second);
        const int added = static_cast<int>(pieces_.size()) - 1;
        around_[middle].push_back(i);
        list(added);
        enqueue(i);
        enqueue(added);
    }

    static constexpr double kGoesOn = 0.985;  // cosine of 10 degrees

    const Points& points_;
    const Points& unit_;
    std::vector<Piece> pieces_;
    std::vector<int> merged_;
    double flatness_;                                      // into which place
    std::vector<std::vector<int>> around_;                 // pieces at a place, with some that left it
    std::priority_queue<std::pair<double, int>> waiting_;  // longest side
    std::map<Triangle, int> flats_;                        // the latest piece with these places
    std::map<Edge, int> splits_;
    std::vector<std::vector<int>> items_;
};

// The result
// -------------------------------------------------------------------------------------------------------------

/// Vertices of the result for the fans of triangles.
struct Vertices {
    std::vector<int> of_corner;  ///< per corner 3 piece + k
    std::vector<int> source;     ///< vertex of the input, per vertex of the result
    std::vector<char> kept;      ///< per vertex of the input: the first vertices of the result are these, in order
};

/// Each fan takes the first free one of its vertices, or gets a new one.
Vertices make_vertices(const std::vector<Piece>& pieces, const std::vector<int>& fan, std::size_t num_points) {
    std::vector<std::array<int, 2>> members;  // fan, vertex
    members.reserve(fan.size());
    for (int corner = 0; corner < static_cast<int>(fan.size()); ++corner)
        members.push_back({fan[corner], pieces[corner / 3].vertices[corner % 3]});
    std::sort(members.begin(), members.end());

    Vertices result;
    result.kept.assign(num_points, 0);
    std::vector<int> vertex_of_fan(fan.size(), kNone);
    std::vector<std::array<int, 2>> added;  // fan, vertex
    for (std::size_t first = 0, last = 0; first < members.size(); first = last) {
        while (last < members.size() && members[last][0] == members[first][0]) ++last;
        std::size_t k = first;
        while (k < last && result.kept[members[k][1]]) ++k;
        if (k == last) {
            added.push_back(members[first]);
            continue;
        }
        vertex_of_fan[members[k][0]] = members[k][1];
        result.kept[members[k][1]] = 1;
    }
    std::vector<int> number(num_points, kNone);
    for (int v = 0; v < static_cast<int>(num_points); ++v) {
        if (!result.kept[v]) continue;
        number[v] = static_cast<int>(result.source.size());
        result.source.push_back(v);
    }
    for (int& v : vertex_of_fan)
        if (v != kNone) v = number[v];
    for (const auto& [f, v] : added) {
        vertex_of_fan[f] = static_cast<int>(result.source.size());
        result.source.push_back(v);
    }
    result.of_corner.reserve(fan.size());
    for (const int f : fan) result.of_corner.push_back(vertex_of_fan[f]);
    return result;
}

/// Side 3 piece + k as an edge of the input, its ends in order, and what it is in the result.
struct Image {
    Edge input;
    Edge result;
    int side;
};

std::vector<Image> edge_images(const std::vector<Piece>& pieces, const Vertices& vertices) {
    std::vector<Image> images;
    images.reserve(3 * pieces.size());
    for (int i = 0; i < static_cast<int>(pieces.size()); ++i)
        for (int k = 0; k < 3; ++k) {
            const int m = (k + 1) % 3;
            Edge input{pieces[i].vertices[k], pieces[i].vertices[m]},
                result{vertices.of_corner[3 * i + k], vertices.of_corner[3 * i + m]};
            if (input[1] < input[0]) std::swap(input[0], input[1]), std::swap(result[0], result[1]);
            images.push_back({input, result, 3 * i + k});
        }
    std::sort(images.begin(), images.end(), [](const Image& a, const Image& b) {
        return std::tie(a.input, a.result, a.side) < std::tie(b.input, b.result, b.side);
    });
    return images;
}

/// Edges and vertices of the input that are several now.
void log_cuts(const std::vector<Piece>& pieces, const Vertices& vertices, const std::vector<Image>& images,
              const std::vector<char>& crowded, std::size_t num_points, Log& log) {
    std::vector<char> explained(num_points, 0);
    for (std::size_t first = 0, last = 0; first < images.size(); first = last) {
        while (last < images.size() && images[last].input == images[first].input) ++last;
        if (images[last - 1].result == images[first].result) continue;
        const Edge& edge = images[first].input;
        log.add(crowded[images[first].side] ? RepairKind::NonManifoldEdges : RepairKind::OneSidedEdges,
                {edge[0], edge[1]});
        for (const int v : edge) explained[v] = 1;
    }
    std::vector<int> image(num_points, kNone);
    std::vector<char> several(num_points, 0);
    for (int corner = 0; corner < static_cast<int>(vertices.of_corner.size()); ++corner) {
        const int v = pieces[corner / 3].vertices[corner % 3];
        if (image[v] == kNone)
            image[v] = vertices.of_corner[corner];
        else if (image[v] != vertices.of_corner[corner])
            several[v] = 1;
    }
    for (int v = 0; v < static_cast<int>(num_points); ++v)
        if (several[v] && !explained[v]) log.add(RepairKind::NonManifoldVertices, {v});
}

/// What goes along with the vertices: feature edges, corners, required elements, parameters.
class Followers {
  public:
    Followers(const TriangleSoup& from, const std::vector<Piece>& pieces, const std::vector<int>& place,
              const Vertices& vertices, const std::vector<Image>& images, const std::map<Edge, int>& splits, Log& log)
        : from_(from),
          pieces_(pieces),
          place_(place),
          images_(images),
          splits_(splits),
          log_(log),
          of_vertex_(from.points.size()),
          of_place_(from.points.size()) {
        for (int corner = 0; corner < static_cast<int>(vertices.of_corner.size()); ++corner) {
            of_vertex_[pieces[corner / 3].vertices[corner % 3]].push_back(vertices.of_corner[corner]);
            of_place_[pieces[corner / 3].places[corner % 3]].push_back(vertices.of_corner[corner]);
        }
        for (auto* lists : {&of_vertex_, &of_place_})
            for (std::vector<int>& list : *lists) {
                std::sort(list.begin(), list.end());
                list.erase(std::unique(list.begin(), list.end()), list.end());
            }
    }

    void follow(TriangleSoup& to) {
        to.dimension = from_.dimension;
        for (const int source : follow_edges(from_.edges, to.edges))
            if (!from_.edge_labels.empty()) to.edge_labels.push_back(from_.edge_labels[source]);
        follow_vertices(from_.corners, to.corners);
        follow_vertices(from_.required.vertices, to.required.vertices);
        follow_edges(from_.required.edges, to.required.edges);
        follow_required_triangles(to.required.triangles);
        for (const TriangleSoup::Parameters& entry : from_.parameters) {
            for (const int image : images_of(entry.vertex)) to.parameters.push_back({image, entry.at});
            if (images_of(entry.vertex).empty()) log_.add(RepairKind::LostFeatures, {entry.vertex});
        }
    }

  private:
    // @returns for each of the result the edge that it is a piece of
    std::vector<int> follow_edges(const std::vector<Edge>& from, std::vector<Edge>& to) {
        std::map<Edge, Edge> first_edge;
        std::vector<int> sources;
        for (int e = 0; e < std::ssize(from); ++e) {
            const Edge& edge = from[e];
            bool found = false;
            std::set<Edge> halved;
            for (const Edge& image : edge_images(edge, halved)) {
                found = true;
                // Two that were welded are one.
                const Edge source = edge_between(edge[0], edge[1]);
                if (first_edge.emplace(edge_between(image[0], image[1]), source).first->second != source) continue;
                to.push_back(image);
                sources.push_back(e);
            }
            if (!found) log_.add(RepairKind::LostFeatures, {edge[0], edge[1]});
        }
        return sources;
    }

    void follow_vertices(const std::vector<int>& from, std::vector<int>& to) {
        std::map<int, int> first_vertex;
        for (const int v : from) {
            for (const int image : images_of(v))
                if (first_vertex.emplace(image, v).first->second == v) to.push_back(image);
            if (images_of(v).empty()) log_.add(RepairKind::LostFeatures, {v});
        }
    }

    // Those that are whole, or of which a copy is.
    void follow_required_triangles(std::vector<int>& to) {
        if (from_.required.triangles.empty()) return;
        std::map<Triangle, std::array<int, 2>> pieces;  // by their places: the first, and the triangle that took it
        for (int i = 0; i < static_cast<int>(pieces_.size()); ++i)
            pieces.emplace(key_of(pieces_[i]), std::array{i, kNone});
        for (const int t : from_.required.triangles) {
            if (t < 0 || t >= static_cast<int>(from_.triangles.size())) {
                log_.add(RepairKind::LostFeatures, {t});
                continue;
            }
            const Triangle& v = from_.triangles[t];
            Triangle key{kNone, kNone, kNone};
            if (std::all_of(v.begin(), v.end(), [&](int i) { return i >= 0 && i < static_cast<int>(place_.size()); }))
                std::transform(v.begin(), v.end(), key.begin(), [&](int i) { return place_[i]; });
            std::sort(key.begin(), key.end());
            const auto found = pieces.find(key);
            if (found == pieces.end()) {
                log_.add(RepairKind::LostFeatures, {v[0], v[1], v[2]});
                continue;
            }
            auto& [piece, taken] = found->second;
            if (taken == kNone) taken = t;
            if (taken == t) to.push_back(piece);
        }
    }

    const std::vector<int>& images_of(int v) const {
        static const std::vector<int> none;
        if (v < 0 || v >= static_cast<int>(of_vertex_.size()) || place_[v] == kNone) return none;
        return of_vertex_[v].empty() ? of_place_[place_[v]] : of_vertex_[v];
    }

    /// @param halved  edges that were, by their places: where points lie on lines to rounding only, splits of splits
    /// may come back
    std::vector<Edge> edge_images(const Edge& edge, std::set<Edge>& halved) const {
        const auto key = edge_between(edge[0], edge[1]);
        std::vector<Edge> result;
        auto image = std::lower_bound(images_.begin(), images_.end(), key,
                                      [](const Image& a, const Edge& b) { return a.input < b; });
        for (; image != images_.end() && image->input == key; ++image) {
            const Edge found = edge[0] == key[0] ? image->result : Edge{image->result[1], image->result[0]};
            if (result.empty() || result.back() != found) result.push_back(found);
        }
        if (!result.empty() || images_of(edge[0]).empty() || images_of(edge[1]).empty()) return result;
        const auto split = splits_.find(edge_between(place_[edge[0]], place_[edge[1]]));
        if (split != splits_.end() && halved.insert(split->first).second) {
            for (const Edge& half : {Edge{edge[0], split->second}, Edge{split->second, edge[1]}})
                for (const Edge& part : edge_images(half, halved)) result.push_back(part);
            return result;
        }
        const Edge ends{images_of(edge[0]).front(), images_of(edge[1]).front()};
        if (ends[0] != ends[1]) result.push_back(ends);
        return result;
    }

    const TriangleSoup& from_;
    const std::vector<Piece>& pieces_;
    const std::vector<int>& place_;
    const std::vector<Image>& images_;
    const std::map<Edge, int>& splits_;
    Log& log_;
    std::vector<std::vector<int>> of_vertex_, of_place_;  // vertices of the result, per vertex and place of the input
};

void log_vertices(const TriangleSoup& soup, const std::vector<int>& place, const Vertices& vertices, Log& log) {
    for (int v = 0; v < static_cast<int>(soup.points.size()); ++v) {
        if (place[v] == kNone)
            log.add(RepairKind::UnusedVertices, {v});
        else if (place[v] == v && !vertices.kept[v])
            log.add(RepairKind::UnusedVertices, {v});
        else if (place[v] != v && (!vertices.kept[v] || soup.points[v] != soup.points[place[v]]))
            log.add(RepairKind::WeldedVertices, {place[v], v});
    }
}

std::string what_was_done(RepairKind kind) {
    switch (kind) {
        case RepairKind::OutOfRange:
            return "triangles with an index out of range dropped";
        case RepairKind::BadNumbers:
            return "triangles with a coordinate that is not finite dropped";
        case RepairKind::WeldedVertices:
            return "vertices welded (kept-gone)";
        case RepairKind::RepeatedIndex:
            return "triangles that have a vertex twice dropped";
        case RepairKind::SplitEdges:
            return "open edges split at a vertex beside them (vertex-edge)";
        case RepairKind::FlatTriangles:
            return "flat triangles resolved (with those split across their long side)";
        case RepairKind::DuplicateTriangles:
            return "triangles that repeat another one dropped (kept-gone)";
        case RepairKind::TurnedTriangles:
            return "triangles turned round";
        case RepairKind::OneSidedEdges:
            return "edges cut where the surface has one side only";
        case RepairKind::NonManifoldEdges:
            return "edges of three triangles or more taken apart";
        case RepairKind::NonManifoldVertices:
            return "vertices where surfaces touch taken apart";
        case RepairKind::UnusedVertices:
            return "vertices in no triangle dropped";
        case RepairKind::LostFeatures:
            return "features and required elements without a place in the result dropped";
    }
    return "";
}

}  // namespace

namespace {

constexpr double kTwins = 4;             // roundings of the coordinates that twins are apart
constexpr double kFarBelow = 1e-3;       // of the edges
constexpr double kGap = 1e-4;            // height of slivers that hold gaps, over their length
constexpr double kShortestEdges = 0.05;  // share of the edges that count for nothing

double diagonal_of(const Points& points, const std::vector<char>& used) {
    Eigen::AlignedBox3d box;
    for (std::size_t v = 0; v < points.size(); ++v)
        if (used[v]) box.extend(points[v]);
    return box.isEmpty() ? 0 : box.diagonal().norm();
}

// What of a soup can be used, and its edges of one triangle where vertices at one place are one.
struct OpenSoup {
    explicit OpenSoup(const TriangleSoup& soup) : points(soup.points) {
        Log log;
        const std::vector<Piece> pieces = usable_triangles(soup, log);
        for (const Piece& piece : pieces) triangles.push_back(piece.vertices);
        used = used_vertices(pieces, points.size());
        diagonal = diagonal_of(points, used);
        place = equal_places(points, used);
        edges = open_edges(triangles, place);
    }

    const Points& points;
    std::vector<Triangle> triangles;
    std::vector<char> used;
    std::vector<int> place;
    std::vector<OpenEdge> edges;
    double diagonal;
};

// Places of vertices, where those at open edges that are within a distance are one.
// @param unit       the points in [-1, 1]
// @param tolerance  over the diagonal
std::vector<int> places_at_open_edges(const OpenSoup& soup, const Points& unit, double tolerance) {
    std::vector<int> place = soup.place;
    std::vector<char> open(unit.size(), 0);
    for (const OpenEdge& e : soup.edges) open[e.ends[0]] = open[e.ends[1]] = 1;
    const double whole = diagonal_of(unit, soup.used), part = diagonal_of(unit, open);
    if (!(part > 0)) return place;
    const std::vector<int> closest = close_places(unit, open, tolerance * whole / part);
    for (int& p : place)
        if (p >= 0 && open[p]) p = closest[p];
    return place;
}

double roundings_of(const OpenSoup& soup) {
    Points counting;
    for (std::size_t v = 0; v < soup.points.size(); ++v)
        if (soup.used[v]) counting.push_back(soup.points[v]);
    return kTwins * resolution_of(counting);
}

double tolerance_of(const OpenSoup& soup) {
    std::vector<double> lengths;
    for (const OpenEdge& e : soup.edges) lengths.push_back((soup.points[e.ends[1]] - soup.points[e.ends[0]]).norm());
    if (lengths.empty() || !(soup.diagonal > 0)) return 0;
    const auto short_one =
        lengths.begin() + static_cast<std::ptrdiff_t>(kShortestEdges * static_cast<double>(lengths.size() - 1));
    std::nth_element(lengths.begin(), short_one, lengths.end());
    return std::min(0.1, std::max(kFarBelow * *short_one, roundings_of(soup)) / soup.diagonal);
}

}  // namespace

double tolerance_of(const TriangleSoup& soup) { return tolerance_of(OpenSoup(soup)); }

RepairOptions default_repair(const TriangleSoup& soup) {
    return {.weld_tolerance = tolerance_of(soup), .only_open = true, .flatness = kGap};
}

Cracks find_cracks(const TriangleSoup& soup) {
    const OpenSoup open_soup(soup);
    const double tolerance = tolerance_of(open_soup);
    const Points unit = to_unit_box(soup.points, open_soup.used);
    const std::vector<int> place = tolerance > 0 ? places_at_open_edges(open_soup, unit, tolerance) : open_soup.place;
    std::vector<int> itself(soup.points.size());
    std::iota(itself.begin(), itself.end(), 0);
    std::vector<char> open(soup.points.size(), 0);
    for (const OpenEdge& e : open_edges(open_soup.triangles, itself)) open[e.ends[0]] = open[e.ends[1]] = 1;
    Cracks cracks;
    for (int v = 0; v < std::ssize(place); ++v) cracks.twins += open[v] && place[v] != v;
    std::vector<Triangle> places;
    for (const Triangle& t : open_soup.triangles)
        if (const Triangle p{place[t[0]], place[t[1]], place[t[2]]}; p[0] != p[1] && p[1] != p[2] && p[2] != p[0])
            places.push_back(p);
    for (const Junctions& found : find_junctions(unit, places, tolerance * diagonal_of(unit, open_soup.used)))
        cracks.junctions += static_cast<int>(found.vertices.size());
    return cracks;
}

int weld_roundings(TriangleSoup& soup) {
    const OpenSoup open_soup(soup);
    if (!(open_soup.diagonal > 0) || open_soup.edges.empty()) return 0;
    const std::vector<char>& used = open_soup.used;
    const std::vector<int> place =
        places_at_open_edges(open_soup, to_unit_box(soup.points, used), roundings_of(open_soup) / open_soup.diagonal);
    std::vector<int> number(soup.points.size(), kNone);
    Points kept;
    int gone = 0;
    for (int v = 0; v < std::ssize(soup.points); ++v) {
        if (used[v] && place[v] != v) {
            ++gone;
            continue;
        }
        number[v] = static_cast<int>(kept.size());
        kept.push_back(soup.points[v]);
    }
    if (gone == 0) return 0;
    for (Triangle& t : soup.triangles)
        for (int& v : t)
            if (v >= 0 && v < std::ssize(place)) v = number[used[v] ? place[v] : v];
    soup.points = std::move(kept);
    return gone;
}

namespace {

// Splits open edges at the vertices within them.
// @param splits  the first vertex of an edge
// @returns whether there are such
bool join_junctions(const Points& unit, double distance, std::vector<Piece>& pieces, std::map<Edge, int>& splits,
                    Log& log) {
    std::vector<Triangle> places;
    for (const Piece& piece : pieces) places.push_back(piece.places);
    const std::vector<Junctions> found = find_junctions(unit, places, distance);
    if (found.empty()) return false;
    std::map<Edge, int> piece_at;
    for (const Junctions& junctions : found) piece_at.emplace(junctions.edge, kNone);
    const auto note = [&](int i, int k) {
        const auto edge = piece_at.find(edge_between(pieces[i].places[k], pieces[i].places[(k + 1) % 3]));
        if (edge != piece_at.end()) edge->second = i;
    };
    for (int i = 0; i < std::ssize(pieces); ++i)
        for (int k = 0; k < 3; ++k) note(i, k);
    for (const auto& [edge, vertices] : found) {
        int last = edge[0];  // what is left of the triangle goes from here to the other end
        for (const int v : vertices) {
            const int i = piece_at.at(edge);
            const auto index_of = [&](int place) {
                return std::find(pieces[i].places.begin(), pieces[i].places.end(), place) - pieces[i].places.begin();
            };
            const auto from = static_cast<std::size_t>(index_of(last)),
                       to = static_cast<std::size_t>(index_of(edge[1]));
            log.add(RepairKind::SplitEdges, {v, pieces[i].vertices[from], pieces[i].vertices[to]});
            splits.emplace(edge_between(last, edge[1]), v);
            Piece cut_off = pieces[i];
            cut_off.places[to] = cut_off.vertices[to] = v;
            pieces[i].places[from] = pieces[i].vertices[from] = v;
            pieces.push_back(cut_off);
            for (int k = 0; k < 3; ++k) note(static_cast<int>(pieces.size()) - 1, k);
            last = v;
        }
    }
    std::stable_sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) { return a.source < b.source; });
    return true;
}

// A place is where its first vertex is that is to stay where it is, if there is one.
void stay_at_required(const RequiredElements& required, const std::vector<Triangle>& triangles,
                      std::vector<int>& place) {
    std::vector<int> stays = required.vertices;
    for (const std::array<int, 2>& e : required.edges) stays.insert(stays.end(), e.begin(), e.end());
    for (const int t : required.triangles) stays.insert(stays.end(), triangles[t].begin(), triangles[t].end());
    std::sort(stays.begin(), stays.end());
    std::vector<int> moved(place.size(), kNone);
    for (const int v : stays)
        if (v >= 0 && v < std::ssize(place) && place[v] != kNone && moved[place[v]] == kNone) moved[place[v]] = v;
    for (int& p : place)
        if (p != kNone && moved[p] != kNone) p = moved[p];
}

void check_arguments(const TriangleSoup& soup, const RepairOptions& options) {
    if (!(options.weld_tolerance >= 0 && options.weld_tolerance <= 0.1))
        throw std::invalid_argument("repair: weld tolerance " + std::to_string(options.weld_tolerance) +
                                    " is not in [0, 0.1]");
    if (!soup.labels.empty() && soup.labels.size() != soup.triangles.size())
        throw std::invalid_argument("repair: " + std::to_string(soup.labels.size()) + " labels for " +
                                    std::to_string(soup.triangles.size()) + " triangles");
}

// Of each vertex the one it is welded to.
std::vector<int> welded_places(const TriangleSoup& soup, const RepairOptions& options, const std::vector<char>& used,
                               const Points& unit) {
    std::vector<int> place;
    if (options.weld_tolerance == 0)
        place = equal_places(soup.points, used);
    else if (options.only_open)
        place = places_at_open_edges(OpenSoup(soup), unit, options.weld_tolerance);
    else
        place = close_places(unit, used, options.weld_tolerance);
    stay_at_required(soup.required, soup.triangles, place);
    return place;
}

// The triangles of the pieces, turned as their sheets are.
void add_triangles(const TriangleSoup& soup, std::span<const Piece> pieces, const Vertices& vertices,
                   const Sheets& sheets, Repaired& result, Log& log) {
    int last_turned = kNone;
    for (int i = 0; i < static_cast<int>(pieces.size()); ++i) {
        Triangle triangle{vertices.of_corner[3 * i], vertices.of_corner[3 * i + 1], vertices.of_corner[3 * i + 2]};
        if (sheets.turned[i]) {
            std::swap(triangle[1], triangle[2]);
            if (std::exchange(last_turned, pieces[i].source) != pieces[i].source)
                log.add(RepairKind::TurnedTriangles, {pieces[i].source});
        }
        result.soup.triangles.push_back(triangle);
        result.triangle_source.push_back(pieces[i].source);
        if (!soup.labels.empty()) result.soup.labels.push_back(soup.labels[pieces[i].source]);
    }
}

Repaired repair_once(const TriangleSoup& soup, const RepairOptions& options, bool parts_may_touch) {
    check_arguments(soup, options);
    Log log;
    std::vector<Piece> pieces = usable_triangles(soup, log);
    const std::vector<char> used = used_vertices(pieces, soup.points.size());
    const Points unit = to_unit_box(soup.points, used);
    std::vector<int> place = welded_places(soup, options, used, unit);
    for (Piece& piece : pieces)
        for (int& corner : piece.places) corner = place[corner];
    drop_repeated(pieces, log);
    drop_copies(pieces, parts_may_touch, log);

    // What one step drops may open an edge for the other.
    const double distance = options.weld_tolerance * diagonal_of(unit, used);
    std::map<Edge, int> splits;
    for (int round = 0; round < kMostRounds; ++round) {
        const bool joins = distance > 0 && join_junctions(unit, distance, pieces, splits, log);
        FlatResolver flats(soup.points, unit, pieces, options.flatness);
        const bool resolves = flats.resolve() && !flats.items().empty();
        if (resolves) {
            pieces = flats.take_pieces();
            splits.insert(flats.splits().begin(), flats.splits().end());
            for (const auto& item : flats.items()) log.add(RepairKind::FlatTriangles, item);
            for (int& p : place)
                if (p != kNone) p = flats.merged(p);
        }
        drop_copies(pieces, parts_may_touch, log);
        if (distance == 0 || (!joins && !resolves)) break;
    }

    std::vector<Triangle> places, corners;
    for (const Piece& piece : pieces) {
        places.push_back(piece.places);
        corners.push_back(piece.vertices);
    }
    const Sheets sheets = join_sheets(unit, places, corners);
    const Vertices vertices = make_vertices(pieces, sheets.fan, soup.points.size());
    const std::vector<Image> images = edge_images(pieces, vertices);
    log_cuts(pieces, vertices, images, sheets.crowded, soup.points.size(), log);
    log_vertices(soup, place, vertices, log);

    Repaired result;
    result.point_source = vertices.source;
    for (const int v : vertices.source) {
        const Eigen::Vector3d &own = soup.points[v], &common = soup.points[place[v]];
        result.soup.points.push_back(own == common ? own : common);
    }
    add_triangles(soup, pieces, vertices, sheets, result, log);
    Followers(soup, pieces, place, vertices, images, splits, log).follow(result.soup);
    result.steps = log.steps();
    return result;
}

// Whether all triangles are of closed surfaces, and none has the corners of another one.
bool is_of_closed_parts(std::vector<Triangle> triangles) {
    std::vector<Edge> edges;
    for (Triangle& t : triangles) {
        for (int k = 0; k < 3; ++k) edges.push_back(edge_between(t[k], t[(k + 1) % 3]));
        std::sort(t.begin(), t.end());
    }
    std::sort(triangles.begin(), triangles.end());
    if (std::adjacent_find(triangles.begin(), triangles.end()) != triangles.end()) return false;
    std::sort(edges.begin(), edges.end());
    for (std::size_t i = 0; i < edges.size(); i += 2)
        if (i + 1 == edges.size() || edges[i] != edges[i + 1]) return false;
    return true;
}

}  // namespace

Repaired repair(const TriangleSoup& soup, const RepairOptions& options) {
    Repaired repaired = repair_once(soup, options, false);
    const auto drops_copies = [](const RepairStep& step) { return step.kind == RepairKind::DuplicateTriangles; };
    if (std::none_of(repaired.steps.begin(), repaired.steps.end(), drops_copies)) return repaired;
    Repaired touching = repair_once(soup, options, true);
    return is_of_closed_parts(touching.soup.triangles) ? touching : repaired;
}

std::vector<Field> follow(std::span<const Field> fields, std::span<const int> source) {
    std::vector<Field> result;
    for (const Field& field : fields) {
        const auto n = static_cast<std::size_t>(field.components);
        Field& to = result.emplace_back(Field{field.name, field.components, {}, field.integer});
        to.values.reserve(n * source.size());
        for (const int item : source) {
            const std::size_t first = n * static_cast<std::size_t>(item);
            if (item < 0 || first + n > field.values.size())
                throw std::invalid_argument("follow: field '" + field.name + "' has no values for " +
                                            std::to_string(item));
            to.values.insert(to.values.end(), field.values.begin() + static_cast<std::ptrdiff_t>(first),
                             field.values.begin() + static_cast<std::ptrdiff_t>(first + n));
        }
    }
    return result;
}

std::string_view name_of(RepairKind kind) {
    switch (kind) {
        case RepairKind::OutOfRange:
            return "out_of_range";
        case RepairKind::BadNumbers:
            return "bad_numbers";
        case RepairKind::WeldedVertices:
            return "welded_vertices";
        case RepairKind::RepeatedIndex:
            return "repeated_index";
        case RepairKind::SplitEdges:
            return "split_edges";
        case RepairKind::FlatTriangles:
            return "flat_triangles";
        case RepairKind::DuplicateTriangles:
            return "duplicate_triangles";
        case RepairKind::TurnedTriangles:
            return "turned_triangles";
        case RepairKind::OneSidedEdges:
            return "one_sided_edges";
        case RepairKind::NonManifoldEdges:
            return "nonmanifold_edges";
        case RepairKind::NonManifoldVertices:
            return "nonmanifold_vertices";
        case RepairKind::UnusedVertices:
            return "unused_vertices";
        case RepairKind::LostFeatures:
            return "lost_features";
    }
    return "";
}

std::string summary(const std::vector<RepairStep>& steps) {
    constexpr std::size_t kNamed = 5;
    std::string text;
    for (const RepairStep& step : steps) {
        text += std::to_string(step.items.count) + " " + what_was_done(step.kind) + ":";
        for (std::size_t i = 0; i < std::min(kNamed, step.items.first.size()); ++i) {
            std::string item;
            for (const int index : step.items.first[i])
                item.append(item.empty() ? "" : "-").append(std::to_string(index));
            text += " " + item;
        }
        text += step.items.count > kNamed ? " ...\n" : "\n";
    }
    return text;
}

}  // namespace gradus

#include "gradus/mesh/features.hpp"

#include "disjoint_sets.hpp"
#include "gradus/mesh/closest.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace gradus {

namespace {

constexpr int kReach = 3;            // edges on either side that tell a corner from a jag
constexpr int kFarthest = 1000;      // edges of an outline that go on straight
constexpr double kSlight = 0.1;      // of a turn: bends that are none beside it
constexpr double kRelief = 0.15;     // of the scale
constexpr double kJag = 1;           // height of a jag over the scale, from which it is a corner nevertheless
constexpr double kSliver = 1.0 / 3;  // width of a facet between two creases over its length, at most
constexpr double kContinues = 0.5;   // cosine of the turn up to which an edge continues a crease
constexpr double kCorner =
    0.3;  // of its turn, what is unexplained of a corner of an outline that turns by as much as creases do
constexpr double kTip = 1.2;      // angle defect of the point of a cone, radians: it opens by less than 108 degrees
constexpr double kTipRelief = 1;  // height over the scale
// A crease stands out where the surface beside it turns little: by this part of the crease's own turn at most, or by
// what that exceeds kSurely by.
constexpr double kBeside = 0.15, kSurely = 1.05;
// The same of small rings and of networks whose curves are of few edges.
constexpr double kBesideRing = 0.05, kBesideJagged = 0.1, kCalm = 0.02;
constexpr int kLongCurve = 4;
constexpr double kFold = 1.05;  // turn of an edge that is a crease at places that need features, radians: 60 degrees
constexpr double kRounding = 1e-6;  // of a cosine, generously

using Points = std::span<const Eigen::Vector3d>;

// One number for both halves of an edge.
int edge_of(const Connectivity& mesh, int h) { return mesh.twin(h) >= 0 ? std::min(h, mesh.twin(h)) : h; }

class Finder {
  public:
    Finder(Points points, Connectivity& mesh, const FeatureOptions& options, const KnownFeatures& known,
           const PlanarRegions* regions)
        : regions_(regions),
          points_(points),
          mesh_(mesh),
          options_(options),
          places_(options.places),
          kind_(3 * static_cast<std::size_t>(mesh.num_triangles()), Kind::None),
          degree_(mesh.num_vertices(), 0) {
        std::sort(places_.begin(), places_.end(),
                  [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return a.x() < b.x(); });
        mark_certain(known);
        find_normals();
        if (regions_) mark_creases();
        for (const auto& [a, b] : options_.no_creases)
            if (const int h = mesh_.find_edge(a, b); h >= 0 && kind_[edge_of(mesh_, h)] <= Kind::Ridge)
                kind_[edge_of(mesh_, h)] = Kind::None;
        continue_creases();
        for (int h = 0; h < static_cast<int>(kind_.size()); ++h)
            if (kind_[h] >= Kind::Crease) ++degree_[mesh.origin(h)], ++degree_[mesh.target(h)];
        while (drop_unclear()) continue;
        drop_short();
        drop_small_networks();
        drop_doubled();
    }

    Features chains(std::span<const int> known_corners) {
        Features features;
        features.corner.assign(mesh_.num_vertices(), 0);
        for (const int v : known_corners) features.corner[v] = 1;
        for (int h = 0; h < static_cast<int>(kind_.size()); ++h) mesh_.set_tag(h, -1);
        std::vector<char> turns_on(mesh_.num_vertices(), 0);
        for (const int v : options_.no_corners) turns_on[v] = 1;
        for (int v = 0; v < mesh_.num_vertices(); ++v)
            if (degree_[v] > 0 ? degree_[v] != 2 || (!turns_on[v] && is_turn(v)) : is_tip(v)) features.corner[v] = 1;
        // Chains from corner to corner, then the closed ones.
        for (const bool from_corner : {true, false})
            for (int h = 0; h < static_cast<int>(kind_.size()); ++h) {
                if (!is_feature(h)) continue;
                for (const auto& [from, to] :
                     {std::pair(mesh_.origin(h), mesh_.target(h)), std::pair(mesh_.target(h), mesh_.origin(h))}) {
                    if (mesh_.tag(h) >= 0 || (from_corner && !features.corner[from])) continue;
                    features.chains.push_back(
                        trace(h, from, to, features.corner, static_cast<int>(features.chains.size())));
                }
            }
        return features;
    }

  private:
    // Of an edge, at its first half. A fold is where features are asked for, a ridge where planes meet that are no
    // facets of a round: that is evidence enough.
    enum class Kind : char { None, Weak, Crease, Fold, Ridge, Certain };

    bool is_found(int edge) const { return kind_[edge] == Kind::Crease || kind_[edge] == Kind::Ridge; }
    bool is_feature(int h) const { return kind_[edge_of(mesh_, h)] >= Kind::Crease; }
    Eigen::Vector3d along(int from, int to) const { return (points_[to] - points_[from]).stableNormalized(); }

    // An edge at v that is wanted, with its other end; -1 where there is none.
    template <class Wanted>
    std::pair<int, int> follow(int v, const Wanted& wanted) const {
        std::pair<int, int> found{-1, -1};
        mesh_.for_each_edge(v, [&](int e, int other) {
            if (const int edge = edge_of(mesh_, e); wanted(edge)) found = {edge, other};
        });
        return found;
    }

    void mark_certain(const KnownFeatures& known) {
        for (int h = 0; h < static_cast<int>(kind_.size()); ++h) {
            const int g = mesh_.twin(h);
            if (g < 0 || (h < g && !known.labels.empty() && known.labels[h / 3] != known.labels[g / 3]))
                kind_[h] = Kind::Certain;
        }
        for (const auto& [a, b] : known.edges)
            if (const int h = mesh_.find_edge(a, b); h >= 0) kind_[edge_of(mesh_, h)] = Kind::Certain;
    }

    void find_normals() {
        normals_.resize(mesh_.num_triangles());
        for (int t = 0; t < mesh_.num_triangles(); ++t) {
            const auto [a, b, c] = mesh_.triangle(t);
            normals_[t] = regions_ ? regions_->normal_at(t)
                                   : (points_[b] - points_[a]).cross(points_[c] - points_[a]).stableNormalized();
        }
    }

    void mark_creases() {
        // Most edges are far from being creases; near the limit the angle itself decides.
        const double nearly_flat = std::cos(std::min({options_.ridge_angle, options_.weak_angle, kFold})) + kRounding;
        for (int h = 0; h < static_cast<int>(kind_.size()); ++h) {
            const int g = mesh_.twin(h);
            if (g < h || kind_[h] == Kind::Certain) continue;
            const Eigen::Vector3d &n = normals_[h / 3], &m = normals_[g / 3];
            if (n.isZero() || m.isZero() || n.dot(m) > nearly_flat) continue;
            const double turn = std::abs(regions_->turn_at(h));
            if (turn > kFold && needs_features(mesh_.origin(h), mesh_.target(h))) {
                kind_[h] = Kind::Fold;
                continue;
            }
            if (options_.all_from_angle && turn >= options_.angle) {
                kind_[h] = Kind::Certain;
                continue;
            }
            const bool of_strips = regions_->is_plane(regions_->of(h / 3)) && regions_->is_plane(regions_->of(g / 3));
            if (turn < options_.weak_angle && !(of_strips && turn >= options_.ridge_angle)) continue;
            kind_[h] = kind_of(h, turn, of_strips);
        }
    }

    // @param of_strips  whether planes meet there
    Kind kind_of(int h, double turn, bool of_strips) const {
        const BendSide one = regions_->side_of(h), other = regions_->side_of(mesh_.twin(h));
        const double unexplained = unexplained_turn(turn, one, other), width = std::min(one.width, other.width);
        // Of one facet the width says less than what is behind it.
        const bool of_several = std::min(regions_->num_facets(regions_->of(h / 3)),
                                         regions_->num_facets(regions_->of(mesh_.twin(h) / 3))) > 1;
        const auto stands_out = [&] {
            return (of_several && rises(width, turn)) ||
                   (turn >= options_.weak_angle && relief(h) >= kRelief * options_.scale);
        };
        if (of_strips && turn >= options_.ridge_angle &&
            ((is_ridge(turn, one, other) && stands_out()) || sags(width, turn, one, other)))
            return Kind::Ridge;
        if (turn < options_.weak_angle) return Kind::None;
        if (turn >= options_.angle && (is_flat(h, one, other) || is_flat(mesh_.twin(h), other, one)) &&
            is_ridge(turn, one, other) && stands_out())
            return Kind::Ridge;
        if (turn < options_.sharp_angle && unexplained <= turn / 2) return Kind::None;
        if (options_.scale > 0 && relief(h) < kRelief * options_.scale) return Kind::None;
        return turn >= options_.angle ? Kind::Crease : Kind::Weak;
    }

    // Whether the side of h is a plane that no round has as a facet.
    bool is_flat(int h, const BendSide& own, const BendSide& other) const {
        return regions_->num_facets(regions_->of(h / 3)) > 1 && own.reach > kAlikeWidths * other.reach;
    }

    // Whether a round through a bend between facets, or chords, as wide as that rises too far over them. Where it
    // begins it turns half as much.
    bool sags(double width, double turn, const BendSide& one, const BendSide& other) const {
        for (const BendSide& side : {one, other})
            if (side.is_strip && side.next_turn < options_.sharp_angle) turn = std::max(turn, side.next_turn);
        return width * turn / 8 > options_.largest_sag;
    }

    // Whether a ridge stands out from the line between points as far from it on both sides.
    bool rises(double width, double turn) const { return width * std::sin(turn / 2) >= kRelief * options_.scale; }

    // Whether an edge is where every fold is to be a feature.
    bool needs_features(int a, int b) const {
        const Eigen::Vector3d &p = points_[a], &q = points_[b];
        const auto [left, right] = std::minmax(p.x(), q.x());
        const auto first = std::lower_bound(places_.begin(), places_.end(), left - options_.reach,
                                            [](const Eigen::Vector3d& place, double x) { return place.x() < x; });
        for (auto place = first; place != places_.end() && place->x() <= right + options_.reach; ++place)
            if ((closest_point(*place, p, q, q) - *place).norm() <= options_.reach) return true;
        return false;
    }

    // How far the middle of an edge lies from the line between the points at `scale` to either side, straight over the
    // facets.
    double relief(int h) const {
        const Eigen::Vector3d middle = (points_[mesh_.origin(h)] + points_[mesh_.target(h)]) / 2;
        const Eigen::Vector3d a = straight_from(h, middle), b = straight_from(mesh_.twin(h), middle), ab = b - a;
        const double length2 = ab.squaredNorm(),
                     t = length2 > 0 ? std::clamp((middle - a).dot(ab) / length2, 0.0, 1.0) : 0;
        return (a + t * ab - middle).norm();
    }

    Eigen::Vector3d straight_from(int entry, Eigen::Vector3d at) const {
        constexpr int kMostTriangles = 200;
        double left = options_.scale;
        const auto direction = [&](int h) { return along(mesh_.origin(h), mesh_.target(h)); };
        const auto inward = [&](int h) { return Eigen::Vector3d(normals_[h / 3].cross(direction(h))); };
        Eigen::Vector3d way = inward(entry);
        for (int step = 0; step < kMostTriangles; ++step) {
            int exit = -1;
            double first = left;
            for (const int h : {Connectivity::next(entry), Connectivity::prev(entry)}) {
                const double speed = -way.dot(inward(h)), room = (at - points_[mesh_.origin(h)]).dot(inward(h));
                if (speed > 0 && std::max(room, 0.0) < first * speed) first = std::max(room, 0.0) / speed, exit = h;
            }
            at += first * way;
            left -= first;
            if (exit < 0 || mesh_.twin(exit) < 0 || normals_[mesh_.twin(exit) / 3].isZero()) return at;
            const double ahead = way.dot(direction(exit)), across = std::max(0.0, -way.dot(inward(exit)));
            entry = mesh_.twin(exit);
            way = -ahead * direction(entry) + across * inward(entry);
        }
        return at;
    }

    double length(int h) const { return (points_[mesh_.target(h)] - points_[mesh_.origin(h)]).norm(); }

    // Of the triangle of h.
    double height_over(int h) const {
        const Eigen::Vector3d edge = points_[mesh_.target(h)] - points_[mesh_.origin(h)],
                              side = points_[mesh_.apex(h)] - points_[mesh_.origin(h)];
        return edge.cross(side).norm() / edge.norm();
    }

    // Weak edges that go on where a crease would end.
    void continue_creases() {
        std::vector<int> queue;
        for (int h = 0; h < static_cast<int>(kind_.size()); ++h)
            if (kind_[h] >= Kind::Crease && kind_[h] <= Kind::Ridge) queue.push_back(h);
        for (std::size_t i = 0; i < queue.size(); ++i) {
            const int h = queue[i];
            for (const auto& [from, at] :
                 {std::pair(mesh_.origin(h), mesh_.target(h)), std::pair(mesh_.target(h), mesh_.origin(h))}) {
                int best = -1, features = 0;
                double straightest = kContinues;
                const bool is_fold = kind_[h] == Kind::Fold;
                mesh_.for_each_edge(at, [&, from = from, at = at](int e, int other) {
                    const int edge = edge_of(mesh_, e);
                    if (kind_[edge] >= Kind::Crease) ++features;
                    const double straight = along(from, at).dot(along(at, other));
                    const bool goes_on =
                        is_fold ? kind_[edge] < Kind::Crease && turn_of(edge) > kFold : kind_[edge] == Kind::Weak;
                    if (goes_on && straight > straightest) straightest = straight, best = edge;
                });
                if (features > 1 || best < 0) continue;
                kind_[best] = is_fold ? Kind::Fold : Kind::Crease;
                queue.push_back(best);
            }
        }
    }

    // Angle between the two facets of an edge.
    double turn_of(int h) const {
        const Eigen::Vector3d &n = normals_[h / 3], &m = normals_[mesh_.twin(h) / 3];
        return std::atan2(n.cross(m).norm(), n.dot(m));
    }

    // Mean turn at the other sides of the triangles of some half-edges, as far as these sides are no features; nothing
    // where all are.
    std::optional<double> turn_beside(std::initializer_list<int> halfedges) const {
        double sum = 0;
        int count = 0;
        for (const int h : halfedges)
            for (const int e : {Connectivity::next(h), Connectivity::prev(h)})
                if (!is_feature(e)) sum += turn_of(e), ++count;
        return count > 0 ? std::optional(sum / count) : std::nullopt;
    }

    // Takes away creases, from where they begin, meet or end, that do not stand out from the surface beside them: on a
    // noisy or rough one single edges turn as much as a crease does. @returns whether there were any
    bool drop_unclear() {
        std::vector<char> seen(kind_.size(), 0);
        std::vector<int> dropped, run;
        for (int h = 0; h < static_cast<int>(kind_.size()); ++h) {
            if (kind_[h] != Kind::Crease || seen[h]) continue;
            run.assign(1, h);
            seen[h] = 1;
            for (int at : {mesh_.origin(h), mesh_.target(h)})
                while (degree_[at] == 2) {
                    const auto [following, beyond] =
                        follow(at, [&](int e) { return kind_[e] == Kind::Crease && !seen[e]; });
                    if (following < 0) break;
                    seen[following] = 1;
                    run.push_back(following);
                    at = beyond;
                }
            double length = 0, turn = 0, beside = 0;
            for (const int e : run) {
                const double part = this->length(e);
                length += part;
                turn += part * turn_of(e);
                beside += part * turn_beside({e, mesh_.twin(e)}).value_or(0);
            }
            if (beside > std::max(kBeside * turn, turn - kSurely * length))
                dropped.insert(dropped.end(), run.begin(), run.end());
        }
        for (const int e : dropped) drop(e);
        return !dropped.empty();
    }

    void drop(int edge) {
        kind_[edge] = Kind::None;
        --degree_[mesh_.origin(edge)];
        --degree_[mesh_.target(edge)];
    }

    void mark_crease(int edge) {
        kind_[edge] = Kind::Crease;
        ++degree_[mesh_.origin(edge)];
        ++degree_[mesh_.target(edge)];
    }

    // Takes away creases of few edges that end freely, all at once. What hangs together is followed from its free end.
    void drop_short() {
        std::vector<int> dropped;
        for (int v = 0; v < mesh_.num_vertices(); ++v) {
            if (degree_[v] != 1) continue;
            std::vector<int> edges;
            int at = v;
            while (static_cast<int>(edges.size()) < options_.shortest) {
                const auto [following, beyond] =
                    follow(at, [&](int e) { return is_feature(e) && (edges.empty() || e != edges.back()); });
                if (following < 0 || kind_[following] >= Kind::Fold) break;
                edges.push_back(following);
                at = beyond;
                if (degree_[at] != 2) break;
            }
            if (static_cast<int>(edges.size()) < options_.shortest)
                dropped.insert(dropped.end(), edges.begin(), edges.end());
        }
        for (const int e : dropped)
            if (kind_[e] == Kind::Crease) drop(e);  // those between two free ends are named twice
    }

    // What hangs together of features.
    struct Network {
        int edges = 0, vertices = 0, ends = 0;  // ends of curves, at corners
        // Turns times lengths: of the edges, of the surface on both sides of them, and of that on the calmer side of
        // each.
        double length = 0, turn = 0, beside = 0, calmer = 0;
        bool certain = false;

        bool is_tree() const { return edges < vertices; }
        // One of the sides of coarse parts is flat.
        bool stands_out(double share) const { return beside <= share * turn || calmer <= kCalm * turn; }
    };

    // Takes away networks of creases that are none: short trees, and on surfaces that are rough, where folds and spikes
    // turn as much as creases do, small rings and what turns a corner every few edges.
    void drop_small_networks() {
        DisjointSets sets(mesh_.num_vertices());
        const auto edges = [&](const auto& use) {
            for (int h = 0; h < static_cast<int>(kind_.size()); ++h)
                if (kind_[h] >= Kind::Crease) use(h);
        };
        edges([&](int h) { sets.unite(mesh_.origin(h), mesh_.target(h)); });
        std::vector<Network> networks(mesh_.num_vertices());
        Eigen::AlignedBox3d box;
        for (int v = 0; v < mesh_.num_vertices(); ++v) {
            if (mesh_.is_live_vertex(v)) box.extend(points_[v]);
            if (degree_[v] == 0) continue;
            Network& network = networks[sets.find(v)];
            ++network.vertices;
            if (degree_[v] != 2 || is_turn(v)) network.ends += degree_[v];
        }
        edges([&](int h) {
            Network& network = networks[sets.find(mesh_.origin(h))];
            const double length = this->length(h);
            ++network.edges;
            network.length += length;
            network.certain = network.certain || kind_[h] >= Kind::Fold;
            if (kind_[h] >= Kind::Fold) return;
            network.turn += length * turn_of(h);
            const std::optional<double> here = turn_beside({h}), there = turn_beside({mesh_.twin(h)});
            if (!here && !there) return;
            const double one = here ? *here : *there, other = there ? *there : *here;
            network.beside += length * (one + other) / 2;
            network.calmer += length * std::min(one, other);
        });
        const double shortest = options_.shortest_tree * box.diagonal().norm();
        const auto is_none = [&](const Network& network) {
            if (network.certain) return false;
            if (network.is_tree() && network.length < shortest) return true;
            if (network.edges < options_.shortest && !network.stands_out(kBesideRing)) return true;
            return kLongCurve * network.ends > 2 * network.edges && !network.stands_out(kBesideJagged);
        };
        std::vector<int> none;
        edges([&](int h) {
            if (is_none(networks[sets.find(mesh_.origin(h))])) none.push_back(h);
        });
        for (const int h : none) drop(h);
    }

    // A half-edge of a crease beside which another feature is close, less than what creases rise at least: at the apex
    // of its triangle.
    std::optional<int> doubled_side(int edge, const std::vector<char>& stays) const {
        if (!is_found(edge) || (stays[mesh_.origin(edge)] && stays[mesh_.target(edge)])) return std::nullopt;
        for (const int h : {edge, mesh_.twin(edge)}) {
            // Two bends sharper than rounds, the same way, are the rims of a plate.
            if (kind_[edge] == Kind::Ridge && turn_of(edge) > kSharpestRound &&
                regions_->side_of(h).next_turn > kSharpestRound)
                continue;
            const int next = Connectivity::next(h), prev = Connectivity::prev(h);
            // What goes on to the apex, and not beyond to others, is the same curve, unless it turns on the way.
            const auto goes_on = [&](int following, int from, int v, int to) {
                return is_feature(following) && degree_[v] == 2 && degree_[to] == 2 &&
                       along(from, v).dot(along(v, to)) > kContinues;
            };
            const int a = mesh_.origin(h), b = mesh_.target(h), apex = mesh_.apex(h);
            const bool is_own = goes_on(next, a, b, apex) || goes_on(prev, b, a, apex);
            // A facet may be a sliver of a wide plane.
            const double height = height_over(h), across = regions_->across(h).length,
                         width = across > kAlikeWidths * height ? across : height;
            if (!is_own && degree_[apex] > 0 && width < kRelief * options_.scale && width < kSliver * length(h))
                return h;
        }
        return std::nullopt;
    }

    // Whether the other feature is one between the apexes of two sides that meet at v.
    bool goes_on_beside(int side, int v, int next_side) const {
        int t = side / 3, apex = mesh_.apex(side);
        while (t != next_side / 3) {
            const int across = mesh_.find_edge(v, apex);
            const int h = across / 3 == t ? across : mesh_.twin(across);
            if (is_feature(across) || mesh_.twin(h) < 0) return false;
            t = mesh_.twin(h) / 3;
            if (t == next_side / 3) break;
            const Triangle corners = mesh_.triangle(t);
            const int beyond =
                *std::find_if(corners.begin(), corners.end(), [&](int w) { return w != v && w != apex; });
            if (!is_feature(mesh_.find_edge(apex, beyond))) return false;
            apex = beyond;
        }
        return mesh_.apex(next_side) == apex;
    }

    // Creases that hang together, by their doubled sides, and what it costs to do without them.
    struct Run {
        std::vector<int> sides;
        int steps = 0;      // where what is left of the crease would begin a short step beside the other
        double weight = 0;  // turns times lengths
    };

    // Calls use(half-edge, end, other end) for the edges from the other feature to both ends of a doubled side.
    template <class Use>
    void for_each_step(int side, const Use& use) const {
        use(Connectivity::next(side), mesh_.target(side), mesh_.origin(side));
        use(Connectivity::prev(side), mesh_.origin(side), mesh_.target(side));
    }

    std::vector<Run> doubled_runs(const std::vector<char>& stays) const {
        std::vector<Run> runs;
        std::vector<char> seen(kind_.size(), 0);
        for (int h = 0; h < static_cast<int>(kind_.size()); ++h) {
            const auto first = seen[h] ? std::nullopt : doubled_side(h, stays);
            if (!first) continue;
            seen[h] = 1;
            Run run{.sides = {*first}};
            std::vector<int> ends;
            for (int at : {mesh_.origin(h), mesh_.target(h)}) {
                for (int last = *first; degree_[at] == 2;) {
                    const auto goes_on = [&, at](int e) {
                        const auto side = seen[e] ? std::nullopt : doubled_side(e, stays);
                        return side && goes_on_beside(last, at, *side);
                    };
                    const auto [following, beyond] = follow(at, goes_on);
                    if (following < 0) break;
                    seen[following] = 1;
                    last = *doubled_side(following, stays);
                    run.sides.push_back(last);
                    at = beyond;
                }
                ends.push_back(at);
            }
            for (const int side : run.sides) {
                run.weight += turn_of(side) * length(side);
                for_each_step(side, [&](int step, int end, int) {
                    const bool is_end = degree_[end] == 2 && std::find(ends.begin(), ends.end(), end) != ends.end();
                    run.steps += is_end && !is_feature(step) && length(step) < kRelief * options_.scale;
                });
            }
            runs.push_back(std::move(run));
        }
        std::stable_sort(runs.begin(), runs.end(), [](const Run& a, const Run& b) {
            return std::pair(a.steps, a.weight) < std::pair(b.steps, b.weight);
        });
        return runs;
    }

    // Of two creases that run side by side within what creases rise at least, as those on both sides of slivers do, one
    // is enough: that of the smaller turn goes, and where it went on alone it begins at the other.
    void drop_doubled() {
        if (options_.scale == 0) return;
        std::vector<char> stays(mesh_.num_vertices(), 0);  // vertices between which features gave way to others already
        for (bool any = true; any;) {
            any = false;
            for (const Run& run : doubled_runs(stays)) {
                const auto is_doubled = [&](int side) { return doubled_side(edge_of(mesh_, side), stays) == side; };
                if (!std::all_of(run.sides.begin(), run.sides.end(), is_doubled)) continue;
                for (const int side : run.sides) drop(edge_of(mesh_, side));
                if (!std::all_of(run.sides.begin(), run.sides.end(),
                                 [&](int side) { return degree_[mesh_.apex(side)] > 0; })) {
                    for (const int side : run.sides) mark_crease(edge_of(mesh_, side));
                    continue;
                }
                any = true;
                for (const int side : run.sides) {
                    for (const int v : mesh_.triangle(side / 3)) stays[v] = 1;
                    for_each_step(side, [&](int step, int end, int other) {
                        if (degree_[end] != 1) return;
                        const int edge = edge_of(mesh_, step);
                        if (!is_feature(edge)) mark_crease(edge);
                        // The last that is left of what went.
                        else if (is_found(edge) && along(mesh_.apex(side), end).dot(along(end, other)) > kContinues)
                            drop(edge);
                    });
                }
            }
        }
    }

    std::array<int, 2> neighbours(int v) const {
        std::array<int, 2> both{-1, -1};
        int count = 0;
        mesh_.for_each_edge(v, [&](int e, int other) {
            if (is_feature(e) && count < 2) both[count++] = other;
        });
        return both;
    }

    // The vertex some edges along the feature curve from v towards w.
    int far_along(int v, int w) const {
        for (int i = 1; i < kReach && degree_[w] == 2; ++i) {
            const auto [a, b] = neighbours(w);
            const int further = a == v ? b : a;
            v = w;
            w = further;
        }
        return w;
    }

    // Whether the way from a over v to b turns by the corner angle.
    bool turns(int a, int v, int b) const { return along(a, v).dot(along(v, b)) <= std::cos(options_.corner_angle); }

    bool is_turn(int v) const {
        const auto [a, b] = neighbours(v);
        if (is_between_planes(a, v) && is_between_planes(v, b)) return is_outline_corner(a, v, b);
        return turns(a, v, b) && (is_high_jag(a, v, b) || turns(far_along(v, a), v, far_along(v, b)));
    }

    // Outlines of planes are exact: a bend from a over v to b is a corner where the edges beside it are no chords of a
    // round.
    bool is_outline_corner(int a, int v, int b) const {
        const Eigen::Vector3d before = along(a, v), after = along(v, b), axis = before.cross(after).stableNormalized();
        const double turn = std::atan2(before.cross(after).norm(), before.dot(after));
        if (turn < options_.ridge_angle) return false;
        const auto side_to = [&](int end) {
            const double width = (points_[end] - points_[v]).norm();
            BendSide side{width, width, 0, std::numeric_limits<double>::infinity()};
            if (degree_[end] != 2) return side;
            const auto [c, d] = neighbours(end);
            const int further = c == v ? d : c;
            const Eigen::Vector3d to_end = along(v, end), on = along(end, further);
            side.next_turn = (end == b ? 1 : -1) * std::atan2(to_end.cross(on).dot(axis), to_end.dot(on));
            side.next_width = (points_[further] - points_[end]).norm();
            return side;
        };
        const BendSide one = side_to(a), other = side_to(b);
        // Sampled unevenly, a corner may have short edges beside it, but these go on straight.
        const double width = std::min(straight_length(v, a, turn), straight_length(v, b, turn));
        if (sags(width, turn, one, other)) return true;
        return rises(width, turn) && (turn < options_.angle ? is_ridge(turn, one, other)
                                                            : unexplained_turn(turn, one, other) > kCorner * turn);
    }

    // How far it is from v over w and on, as long as the bends on the way are slight beside a turn.
    double straight_length(int v, int w, double turn) const {
        const int start = v;
        double bends = 0;
        for (int i = 1; i < kFarthest && degree_[w] == 2; ++i) {
            const auto [a, b] = neighbours(w);
            const int further = a == v ? b : a;
            const Eigen::Vector3d before = along(v, w), after = along(w, further);
            bends += std::atan2(before.cross(after).norm(), before.dot(after));
            if (bends > kSlight * turn || further == start) break;
            v = w;
            w = further;
        }
        return (points_[w] - points_[start]).norm();
    }

    // Whether an edge surely is a feature, with planes of several facets on both sides, or on the only one.
    bool is_between_planes(int a, int b) const {
        if (!regions_) return false;
        const int h = mesh_.find_edge(a, b), g = mesh_.twin(h);
        const auto is_plane = [&](int side) { return side < 0 || regions_->is_plane(regions_->of(side / 3)); };
        return kind_[edge_of(mesh_, h)] >= Kind::Ridge && is_plane(h) && is_plane(g);
    }

    bool is_high_jag(int a, int v, int b) const {
        return options_.scale > 0 && (points_[v] - points_[a]).cross(along(a, b)).norm() > kJag * options_.scale;
    }

    // What the angles around a vertex are short of a whole turn; none at features.
    double defect(int v) const {
        if (!mesh_.is_live_vertex(v) || degree_[v] > 0) return 0;
        double sum = 0;
        mesh_.for_each_outgoing(v, [&](int h) {
            const Eigen::Vector3d a = along(v, mesh_.target(h)), b = along(v, mesh_.apex(h));
            sum += std::atan2(a.cross(b).norm(), a.dot(b));
        });
        return 2 * std::numbers::pi - sum;
    }

    // Whether the facets around v surely are short of a whole turn by less than a tip. Seen along a normal from which
    // none of theirs is farther than an angle t they go around once at least, and are seen with angles of 1 / cos t of
    // theirs at most.
    bool is_blunt(int v) const {
        static const double least = 1 - kTip / (2 * std::numbers::pi) + kRounding;
        const Eigen::Vector3d& seen_from = normals_[mesh_.outgoing(v) / 3];
        bool blunt = true;
        mesh_.for_each_outgoing(v, [&](int h) { blunt = blunt && normals_[h / 3].dot(seen_from) > least; });
        return blunt;
    }

    // A row of facets from a vertex to where the surface ends all around: nothing behind them says that it is round and
    // not a cone.
    bool is_row_of_cone(int v) const {
        bool ends = true;
        Eigen::Vector3d axis(0, 0, 0);
        mesh_.for_each_outgoing(v, [&](int h) {
            const int side = Connectivity::next(h);
            ends = ends && (mesh_.twin(side) < 0 || kind_[edge_of(mesh_, side)] >= Kind::Crease);
            axis += normals_[h / 3];
        });
        if (!ends) return false;
        axis = axis.stableNormalized();
        double turn = 0;
        mesh_.for_each_outgoing(v, [&](int h) { turn += axis.cross(normals_[h / 3]).norm(); });
        return turn > kCalm * mesh_.valence(v);
    }

    // The point of a cone: sharp, with no such neighbour, and high enough, or of facets of which nothing says that they
    // are round.
    bool is_tip(int v) const {
        if (!mesh_.is_live_vertex(v) || degree_[v] > 0) return false;
        if (is_row_of_cone(v)) return true;
        if (is_blunt(v)) return false;
        const double own = defect(v);
        if (!(own > kTip)) return false;
        Eigen::Vector3d axis(0, 0, 0);
        double beside = 0, height = 0;
        int count = 0;
        mesh_.for_each_edge(v, [&](int, int other) { axis += along(other, v); });
        axis = axis.stableNormalized();
        mesh_.for_each_edge(v, [&](int, int other) {
            beside = std::max(beside, std::abs(defect(other)));
            height += axis.dot(points_[v] - points_[other]);
            ++count;
        });
        return beside < own / 2 && height > count * kTipRelief * options_.scale;
    }

    FeatureChain trace(int h, int from, int to, const std::vector<char>& corner, int number) {
        FeatureChain chain{{from}, false, false};
        int edge = h, at = to;
        while (true) {
            mesh_.set_tag(edge, number);
            chain.certain = chain.certain || kind_[edge_of(mesh_, edge)] >= Kind::Ridge;
            if (at == from && !corner[at]) {
                chain.closed = true;
                return chain;
            }
            chain.vertices.push_back(at);
            if (corner[at]) return chain;
            const auto [following, beyond] = follow(at, [&](int e) { return is_feature(e) && mesh_.tag(e) < 0; });
            if (following < 0) return chain;
            edge = following;
            at = beyond;
        }
    }

    const PlanarRegions* regions_;  // null where no edge can be a crease
    Points points_;
    Connectivity& mesh_;
    const FeatureOptions& options_;
    std::vector<Eigen::Vector3d> places_;   // that need features, by their first coordinate
    std::vector<Eigen::Vector3d> normals_;  // of facets; zero where they have none
    std::vector<Kind> kind_;
    std::vector<int> degree_;  // feature edges per vertex
};

}  // namespace

bool is_straight_chord(Points points, const FeatureChain& chain, int i) {
    const int edges = chain.num_edges();
    const auto length = [&](int j) { return (points[chain.vertex(j + 1)] - points[chain.vertex(j)]).norm(); };
    const bool before = i > 0 || chain.closed, after = i + 1 < edges || chain.closed;
    return (!before || length(i) > kAlikeWidths * length((i + edges - 1) % edges)) &&
           (!after || length(i) > kAlikeWidths * length((i + 1) % edges));
}

Features find_features(Points points, Connectivity& mesh, const FeatureOptions& options, const KnownFeatures& known,
                       const PlanarRegions* regions) {
    std::optional<PlanarRegions> own;
    if (!regions && options.angle < std::numbers::pi) regions = &own.emplace(points, mesh);
    return Finder(points, mesh, options, known, regions).chains(known.corners);
}

Wedges wedges_of(const Connectivity& mesh) {
    Wedges wedges;
    wedges.of_corner.resize(3 * static_cast<std::size_t>(mesh.num_triangles()));
    wedges.vertex.resize(mesh.num_vertices());
    wedges.first.assign(mesh.num_vertices(), Connectivity::kNone);
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        wedges.vertex[v] = v;
        if (!mesh.is_live_vertex(v)) continue;
        bool seen = false;
        const auto begin = [&](int h) {
            const int wedge = seen ? wedges.size() : v;
            if (seen)
                wedges.vertex.push_back(v), wedges.first.push_back(h);
            else
                wedges.first[v] = h;
            seen = true;
            wedges.for_each(mesh, wedge, [&](int e) { wedges.of_corner[e] = wedge; });
        };
        mesh.for_each_outgoing(v, [&](int h) {
            if (mesh.tag(h) >= 0) begin(h);
        });
        if (!seen) begin(mesh.outgoing(v));
    }
    return wedges;
}

}  // namespace gradus

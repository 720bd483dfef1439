#include "gradus/quality/offenders.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <tuple>

#include "gradus/mesh/frozen.hpp"
#include "gradus/mesh/parts.hpp"
#include "gradus/quality/shape.hpp"
#include "gradus/quality/topology.hpp"

namespace gradus {

namespace {

using Eigen::Vector3d;
using Kind = OffenderCause::Kind;

constexpr double kDegrees = 180 / std::numbers::pi;
// Of the size. An isosceles triangle over an edge this long, its other edges of the size, has its smallest angle of 32
// degrees.
constexpr double kNearCorners = 0.55;
// A triangle between two lines this far apart, with edges of the size along them, has an area-length of .87; of .60 at
// .29.
constexpr double kNearCurves = 0.5;
constexpr double kNarrowLoop = 3 * kNearCorners;
constexpr double kJumpInTriangle = 2;
constexpr int kFewest = 4;         // triangles around a vertex: three make a point of any round
constexpr double kSharpTurn = 60;  // degrees from a triangle to the next: six of them make a round

double distance_to_segment(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
    const Vector3d ab = b - a;
    const double length2 = ab.squaredNorm(), t = length2 > 0 ? std::clamp((p - a).dot(ab) / length2, 0.0, 1.0) : 0;
    return (p - a - t * ab).norm();
}

// Smaller is graver.
double gravity(const OffenderCause& cause) {
    return cause.kind == Kind::SizeJump || cause.kind == Kind::SharpTurn ? -cause.value : cause.value;
}

// The mesh with its features: says of a triangle what leaves it no room.
class Causes {
  public:
    Causes(const MeshView& mesh, const OffenderOptions& options, Connectivity connectivity, std::vector<double> sizes)
        : points_(mesh.points), options_(options), mesh_(std::move(connectivity)), sizes_(std::move(sizes)) {
        const double none = std::numbers::pi;
        const FeatureOptions given_only{.angle = none, .sharp_angle = none, .weak_angle = none};
        features_ = options.features ? find_features(points_, mesh_, given_only, *options.features)
                                     : find_features(points_, mesh_);
        if (options.required) frozen_ = frozen_elements(points_, mesh_, *options.required);
        find_narrow_wedges();
        find_tight_corners();
        find_narrow_loops();
    }

    const Connectivity& mesh() const { return mesh_; }

    OffenderCause of_triangle(int t) const {
        const OffenderCause cause = of(t, kJumpInTriangle);
        return cause.kind != Kind::None ? cause : of_surroundings(mesh_.triangle(t));
    }

    OffenderCause of_vertex(int v) const {
        OffenderCause cause;
        mesh_.for_each_outgoing(v, [&](int h) { take_graver(cause, of(h / 3, kJumpInTriangle)); });
        if (cause.kind != Kind::None) return cause;
        double low = sizes_[v], high = low;
        mesh_.for_each_outgoing(v, [&](int h) {
            for (const int other : {mesh_.target(h), mesh_.apex(h)})
                low = std::min(low, sizes_[other]), high = std::max(high, sizes_[other]);
        });
        if (high > options_.limits.edge_ratio * low) cause = {Kind::SizeJump, high / low};
        return cause.kind != Kind::None ? cause : of_surroundings(std::array{v});
    }

  private:
    // Corners that are near each other, or a narrow loop, and how far around elements have to grow from what is between
    // them to the size.
    struct Tight {
        Vector3d point;
        double reach;
        OffenderCause cause;
    };

    void find_tight_corners() {
        for (int v = 0; v < mesh_.num_vertices(); ++v) {
            OffenderCause cause;
            if (features_.corner[v]) heed_near_corners(v, cause);
            if (cause.kind != Kind::NearCorners) continue;
            const double size = (sizes_[cause.ids[0]] + sizes_[cause.ids[1]]) / 2;
            tight_.push_back({points_[v], (1 - cause.value) * size, cause});
        }
    }

    // Closed paths of three edges with no triangle inside.
    void find_narrow_loops() {
        std::vector<int> neighbours;
        for (int a = 0; a < mesh_.num_vertices(); ++a) {
            neighbours.clear();
            mesh_.for_each_edge(a, [&](int, int other) {
                if (other > a) neighbours.push_back(other);
            });
            for (const int b : neighbours)
                for (const int c : neighbours)
                    if (b < c) heed_loop({a, b, c});
        }
    }

    void heed_loop(const Triangle& v) {
        const auto distance = [&](int i, int j) { return (points_[v[i]] - points_[v[j]]).norm(); };
        const double length = distance(0, 1) + distance(1, 2) + distance(2, 0),
                     size = (sizes_[v[0]] + sizes_[v[1]] + sizes_[v[2]]) / 3;
        if (!(length < kNarrowLoop * size)) return;
        const int h = edge_between(v[0], v[1]), g = mesh_.twin(h);
        if (mesh_.apex(h) == v[2] || (g >= 0 && mesh_.apex(g) == v[2]) || edge_between(v[1], v[2]) < 0) return;
        const OffenderCause cause{Kind::NarrowLoop, length / size};
        for (const int corner : v) tight_.push_back({points_[corner], (1 - cause.value / 3) * size, cause});
    }

    // Edges around a vertex, off the features, where the surface turns by more than elements can follow.
    void heed_sharp_turns(int v, OffenderCause& cause) const {
        const auto normal = [&](int t) {
            const Triangle c = mesh_.triangle(t);
            return Vector3d((points_[c[1]] - points_[c[0]]).cross(points_[c[2]] - points_[c[0]]));
        };
        mesh_.for_each_outgoing(v, [&](int h) {
            for (const int edge : {h, Connectivity::next(h)}) {
                const int g = mesh_.twin(edge);
                if (g < 0 || mesh_.tag(edge) >= 0) continue;
                const Vector3d a = normal(edge / 3), b = normal(g / 3);
                const double turn = kDegrees * std::atan2(a.cross(b).norm(), a.dot(b));
                if (turn > kSharpTurn) take_graver(cause, {Kind::SharpTurn, turn, {-1, -1}});
            }
        });
    }

    // In either direction, or -1: one of a boundary has one only.
    int edge_between(int a, int b) const {
        const int h = mesh_.find_edge(a, b);
        return h >= 0 ? h : mesh_.find_edge(b, a);
    }

    OffenderCause of_surroundings(std::span<const int> vertices) const {
        OffenderCause cause;
        for (const Tight& tight : tight_)
            for (const int v : vertices)
                if ((points_[v] - tight.point).norm() <= tight.reach) take_graver(cause, tight.cause);
        if (cause.kind == Kind::None)
            for (const int v : vertices) heed_sharp_turns(v, cause);
        return cause;
    }

    // Kinds come in the order in which they rule.
    static void take_graver(OffenderCause& cause, const OffenderCause& other) {
        if (other.kind == Kind::None) return;
        if (cause.kind == Kind::None || std::pair(other.kind, gravity(other)) < std::pair(cause.kind, gravity(cause)))
            cause = other;
    }

    double angle_at(int h) const {
        const Vector3d a = points_[mesh_.target(h)] - points_[mesh_.origin(h)],
                       b = points_[mesh_.apex(h)] - points_[mesh_.origin(h)];
        return kDegrees * std::atan2(a.cross(b).norm(), a.dot(b));
    }

    // Calls use(other end, curve) for the feature edges at v.
    template <class Use>
    void for_each_feature_edge(int v, const Use& use) const {
        mesh_.for_each_edge(v, [&](int h, int other) {
            if (mesh_.tag(h) >= 0) use(other, mesh_.tag(h));
        });
    }

    // All around a vertex off the features.
    bool is_point(int wedge) const { return mesh_.tag(wedges_.first[wedge]) < 0; }

    void find_narrow_wedges() {
        wedges_ = wedges_of(mesh_);
        narrow_.assign(wedges_.size(), 0);
        for (int wedge = 0; wedge < wedges_.size(); ++wedge) {
            const int begin = wedges_.first[wedge];
            if (begin == Connectivity::kNone) continue;
            double sum = 0;
            int last = begin;
            wedges_.for_each(mesh_, wedge, [&](int h) { sum += angle_at(h), last = h; });
            // Where no features meet the surface comes to a point.
            if (!(sum < (is_point(wedge) ? kFewest : 1) * options_.limits.angle)) continue;
            narrow_[wedge] = sum;
            if (is_point(wedge)) continue;
            const int a = mesh_.tag(begin), b = mesh_.tag(Connectivity::prev(last));
            narrow_between_.insert({{std::min(a, b), std::max(a, b)}, {sum, wedges_.vertex[wedge]}});
        }
    }

    OffenderCause of(int t, double jump) const {
        OffenderCause cause;
        const Triangle v = mesh_.triangle(t);
        for (int h = 3 * t; h < 3 * t + 3; ++h) {
            if (frozen_.has_edge(h)) take_graver(cause, {Kind::Frozen});
            if (const int wedge = wedges_.of_corner[h]; narrow_[wedge] > 0)
                take_graver(cause, {is_point(wedge) ? Kind::SharpPoint : Kind::NarrowCorner,
                                    narrow_[wedge],
                                    {wedges_.vertex[wedge], -1}});
        }
        for (const int a : v) heed_near_corners(a, cause);
        for (const int a : v)
            for (const int b : v) heed_frozen_near_curve(a, b, cause);
        for (int k = 0; k < 3; ++k) heed_near_curves(v[k], v[(k + 1) % 3], cause);
        const auto [low, high] = std::minmax({sizes_[v[0]], sizes_[v[1]], sizes_[v[2]]});
        if (high > jump * low) take_graver(cause, {Kind::SizeJump, high / low});
        return cause;
    }

    bool is_fixed(int v) const { return features_.corner[v] || frozen_.has_vertex(v); }

    void heed_near_corners(int a, OffenderCause& cause) const {
        if (!is_fixed(a)) return;
        const auto look = [&](int b) {
            const double size = (sizes_[a] + sizes_[b]) / 2, distance = (points_[b] - points_[a]).norm();
            if (!is_fixed(b) || !(distance < kNearCorners * size)) return;
            if (features_.corner[a] && features_.corner[b])
                take_graver(cause, {Kind::NearCorners, distance / size, {std::min(a, b), std::max(a, b)}});
            else
                take_graver(cause, {Kind::Frozen});
        };
        mesh_.for_each_outgoing(a, [&](int h) {
            look(mesh_.target(h));
            look(mesh_.apex(h));
        });
    }

    // A frozen vertex beside a curve that it is not on.
    void heed_frozen_near_curve(int a, int b, OffenderCause& cause) const {
        if (a == b || !frozen_.has_vertex(a)) return;
        for_each_feature_edge(b, [&](int next, int curve) {
            const double size = (sizes_[a] + sizes_[b]) / 2;
            if (!meets(a, curve) && distance_to_segment(points_[a], points_[b], points_[next]) < kNearCurves * size)
                take_graver(cause, {Kind::Frozen});
        });
    }

    // Of an edge across from one curve to another that does not begin there.
    void heed_near_curves(int a, int b, OffenderCause& cause) const {
        const double size = (sizes_[a] + sizes_[b]) / 2;
        for_each_feature_edge(a, [&](int next_a, int curve_a) {
            for_each_feature_edge(b, [&](int next_b, int curve_b) {
                if (curve_a == curve_b || next_a == b || next_b == a || meets(b, curve_a) || meets(a, curve_b) ||
                    join(a, curve_a, b, curve_b))
                    return;
                const double distance = std::min(distance_to_segment(points_[a], points_[b], points_[next_b]),
                                                 distance_to_segment(points_[b], points_[a], points_[next_a]));
                if (!(distance < kNearCurves * size)) return;
                const std::array<int, 2> curves{std::min(curve_a, curve_b), std::max(curve_a, curve_b)};
                const auto narrow = narrow_between_.find(curves);
                if (narrow != narrow_between_.end())
                    take_graver(cause, {Kind::NarrowCorner, narrow->second.first, {narrow->second.second, -1}});
                else
                    take_graver(cause, {Kind::NearCurves, distance / size, curves});
            });
        });
    }

    bool meets(int v, int curve) const {
        bool found = false;
        for_each_feature_edge(v, [&](int, int other) { found = found || other == curve; });
        return found;
    }

    // Whether two curves end in one vertex next to a on the one and b on the other.
    bool join(int a, int curve_a, int b, int curve_b) const {
        bool found = false;
        for_each_feature_edge(a, [&](int x, int on_a) {
            for_each_feature_edge(
                b, [&](int y, int on_b) { found = found || (x == y && on_a == curve_a && on_b == curve_b); });
        });
        return found;
    }

    std::span<const Vector3d> points_;
    const OffenderOptions& options_;
    Connectivity mesh_;
    std::vector<double> sizes_;
    Features features_;
    Frozen frozen_;
    Wedges wedges_;
    std::vector<Tight> tight_;
    std::vector<double> narrow_;  // angle of each wedge that is too narrow, at a corner or a point, degrees, else 0
    std::map<std::array<int, 2>, std::pair<double, int>> narrow_between_;  // angle and vertex, by curves
};

std::vector<double> sizes_of(const MeshView& mesh, const MeshEdges& edges, std::span<const double> given) {
    if (!given.empty() && given.size() != mesh.points.size())
        throw std::invalid_argument(
            fmt::format("find_offenders: {} sizes for {} vertices", given.size(), mesh.points.size()));
    if (!given.empty()) return {given.begin(), given.end()};
    std::vector<double> sum(mesh.points.size(), 0);
    const std::vector<int> count = valences(mesh, edges);
    const std::vector<double> lengths = edge_lengths(mesh, edges);
    for (int e = 0; e < edges.size(); ++e)
        for (const int v : edges.ends[e]) sum[v] += lengths[e];
    for (std::size_t v = 0; v < sum.size(); ++v) sum[v] /= std::max(count[v], 1);
    return sum;
}

// Where every vertex has its edges and no fan is apart from another; else nothing.
std::optional<Connectivity> manifold(const MeshView& mesh) {
    for (const Triangle& t : mesh.triangles)
        for (const int v : t)
            if (!mesh.points[v].allFinite()) return std::nullopt;
    try {
        return Connectivity(static_cast<int>(mesh.points.size()), mesh.triangles);
    } catch (const std::invalid_argument&) {
        return std::nullopt;
    }
}

struct Found {
    enum class What { Quality, Angle, EdgeRatio } what;
    double value;
    int element;  // triangle, or vertex
    OffenderCause cause = {};
};

Shortfall& of(OffenderGroup& group, Found::What what) {
    return what == Found::What::Quality ? group.quality : what == Found::What::Angle ? group.angle : group.edge_ratio;
}

void add(Shortfall& sum, Found::What what, double value) {
    const bool worse = what == Found::What::EdgeRatio ? value > sum.worst : value < sum.worst;
    if (sum.count++ == 0 || worse) sum.worst = value;
}

std::vector<Found> fall_short(const MeshView& mesh, const MeshEdges& edges, const OffenderOptions& options) {
    std::vector<Found> found;
    for (int t = 0; t < std::ssize(mesh.triangles); ++t) {
        const auto& [a, b, c] = mesh.triangles[t];
        const TriangleSides sides = sides_of(mesh.points[a], mesh.points[b], mesh.points[c]);
        if (const double q = area_length(sides); q < options.limits.quality)
            found.push_back({Found::What::Quality, q, t});
        const double angle =
            kDegrees * std::min({corner_angle(sides, 0), corner_angle(sides, 1), corner_angle(sides, 2)});
        if (angle < options.limits.angle) found.push_back({Found::What::Angle, angle, t});
    }
    const std::vector<double> ratios = adjacent_edge_ratios(mesh, edges);
    for (int v = 0; v < std::ssize(ratios); ++v)
        if (ratios[v] > options.limits.edge_ratio) found.push_back({Found::What::EdgeRatio, ratios[v], v});
    return found;
}

// A number for what hangs together, per vertex.
std::vector<int> places_of(const MeshView& mesh, const MeshEdges& edges, const std::vector<Found>& found) {
    std::vector<char> marked(mesh.points.size(), 0);
    std::vector<Triangle> pieces;
    for (const Found& f : found) {
        if (f.what == Found::What::EdgeRatio) {
            marked[f.element] = 1;
        } else {
            pieces.push_back(mesh.triangles[f.element]);
            for (const int v : pieces.back()) marked[v] = 1;
        }
    }
    for (const auto& [a, b] : edges.ends)
        if (marked[a] && marked[b]) pieces.push_back({a, b, b});
    return connected_parts(mesh.points.size(), pieces);
}

}  // namespace

std::string name_of(OffenderCause::Kind kind) {
    switch (kind) {
        case Kind::None:
            return "none";
        case Kind::Frozen:
            return "frozen";
        case Kind::SharpPoint:
            return "sharp_point";
        case Kind::NarrowCorner:
            return "narrow_corner";
        case Kind::NearCorners:
            return "near_corners";
        case Kind::NearCurves:
            return "near_curves";
        case Kind::NarrowLoop:
            return "narrow_loop";
        case Kind::SizeJump:
            return "size_jump";
        case Kind::SharpTurn:
            return "sharp_turn";
    }
    return "";
}

std::string to_text(const OffenderCause& cause) {
    switch (cause.kind) {
        case Kind::None:
            return "none found";
        case Kind::Frozen:
            return "frozen element";
        case Kind::SharpPoint:
            return fmt::format("sharp point: {:.2g} degrees all around", cause.value);
        case Kind::NarrowCorner:
            return fmt::format("narrow corner of the features: {:.2g} degrees", cause.value);
        case Kind::NearCorners:
            return fmt::format("two corners {:.2g} sizes apart", cause.value);
        case Kind::NearCurves:
            return fmt::format("feature edges nearer than the size: curves {} and {}, {:.2g} sizes apart", cause.ids[0],
                               cause.ids[1], cause.value);
        case Kind::NarrowLoop:
            return fmt::format("tube, hole or patch {:.2g} sizes around: three edges", cause.value);
        case Kind::SizeJump:
            return fmt::format("sizes of neighbours in a ratio of {:.2g}", cause.value);
        case Kind::SharpTurn:
            return fmt::format("the surface turns by {:.0f} degrees between elements: it is finer than they are",
                               cause.value);
    }
    return "";
}

namespace {

// Offenders at one place with one cause, as they come.
class Groups {
  public:
    Groups(const MeshView& mesh, const OffenderLimits& limits) : mesh_(mesh), limits_(limits) {}

    void add(const Found& found, int place) {
        auto& [group, worst] = groups_[{place, found.cause.kind, found.cause.ids}];
        if (worst == std::numeric_limits<double>::infinity() || gravity(found.cause) < gravity(group.cause))
            group.cause = found.cause;
        if (const double part = part_of_limit(found); part < worst) {
            worst = part;
            group.point = point_of(found);
        }
        gradus::add(of(group, found.what), found.what, found.value);
    }

    // Those without a cause first, then what smaller elements may mend.
    std::vector<OffenderGroup> sorted(std::size_t most) const {
        std::vector<const Gathered*> order;
        for (const auto& [key, gathered] : groups_) order.push_back(&gathered);
        std::stable_sort(order.begin(), order.end(), [](const Gathered* a, const Gathered* b) {
            const auto rank = [](Kind kind) { return std::pair(kind != Kind::None, kind != Kind::SharpTurn); };
            return std::pair(rank(a->group.cause.kind), a->worst) < std::pair(rank(b->group.cause.kind), b->worst);
        });
        std::vector<OffenderGroup> first;
        for (std::size_t i = 0; i < std::min(order.size(), most); ++i) first.push_back(order[i]->group);
        return first;
    }
    std::size_t size() const { return groups_.size(); }

  private:
    using Key = std::tuple<int, Kind, std::array<int, 2>>;
    struct Gathered {
        OffenderGroup group;
        double worst = std::numeric_limits<double>::infinity();
    };

    // How far beyond its limit, whatever it is of.
    double part_of_limit(const Found& found) const {
        if (found.what == Found::What::EdgeRatio) return limits_.edge_ratio / found.value;
        return found.value / (found.what == Found::What::Quality ? limits_.quality : limits_.angle);
    }
    Vector3d point_of(const Found& found) const {
        if (found.what == Found::What::EdgeRatio) return mesh_.points[found.element];
        const auto& [a, b, c] = mesh_.triangles[found.element];
        return (mesh_.points[a] + mesh_.points[b] + mesh_.points[c]) / 3;
    }

    const MeshView& mesh_;
    const OffenderLimits& limits_;
    std::map<Key, Gathered> groups_;
};

void count(const Found& found, OffenderReport& report) {
    for (const auto& [what, all, unexplained] :
         {std::tuple(Found::What::Quality, &report.quality, &report.unexplained_quality),
          std::tuple(Found::What::Angle, &report.angle, &report.unexplained_angle),
          std::tuple(Found::What::EdgeRatio, &report.edge_ratio, &report.unexplained_edge_ratio)}) {
        if (what != found.what) continue;
        add(*all, found.what, found.value);
        if (found.cause.kind == Kind::None) add(*unexplained, found.what, found.value);
    }
}

}  // namespace

OffenderReport find_offenders(const MeshView& mesh, const OffenderOptions& options) {
    const MeshEdges edges = edges_of(mesh);
    OffenderReport report;
    report.limits = options.limits;
    std::vector<double> sizes = sizes_of(mesh, edges, options.sizes);
    std::vector<Found> found = fall_short(mesh, edges, options);
    std::optional<Connectivity> connectivity = manifold(mesh);
    report.features_known = connectivity.has_value();
    if (connectivity && !found.empty()) {
        const Causes causes(mesh, options, std::move(*connectivity), std::move(sizes));
        for (Found& f : found)
            f.cause = f.what == Found::What::EdgeRatio ? causes.of_vertex(f.element) : causes.of_triangle(f.element);
    }
    const std::vector<int> place = places_of(mesh, edges, found);
    Groups groups(mesh, options.limits);
    for (const Found& f : found) {
        groups.add(f, place[f.what == Found::What::EdgeRatio ? f.element : mesh.triangles[f.element][0]]);
        count(f, report);
    }
    report.num_groups = groups.size();
    report.groups = groups.sorted(options.most);
    return report;
}

std::string to_text(const OffenderReport& report, std::size_t places) {
    if (report.num_groups == 0) return "elements short of the limits: none\n";
    std::string text =
        fmt::format("{:<38}{:>10} {:>11} {:>14}\n", "elements short of the limits", "count", "worst", "without cause");
    const auto row = [&](const std::string& name, const Shortfall& all, const Shortfall& unexplained) {
        text += fmt::format("  {:<36}{:>10}", name, all.count);
        text += all.count > 0 ? fmt::format(" {:>11.4g} {:>14}\n", all.worst, unexplained.count) : "\n";
    };
    row(fmt::format("area-length below {:g}", report.limits.quality), report.quality, report.unexplained_quality);
    row(fmt::format("angle below {:g} degrees", report.limits.angle), report.angle, report.unexplained_angle);
    row(fmt::format("edges at a vertex, ratio above {:g}", report.limits.edge_ratio), report.edge_ratio,
        report.unexplained_edge_ratio);
    if (!report.features_known) text += "  causes are not known, as the mesh is no oriented manifold\n";
    const std::size_t listed = std::min(places, report.groups.size());
    for (std::size_t i = 0; i < listed; ++i) {
        const OffenderGroup& g = report.groups[i];
        std::string what;
        const auto part = [&](const char* name, const Shortfall& s) {
            if (s.count > 0)
                what += fmt::format("{}{} {}{:.3g}", what.empty() ? "" : ", ", name,
                                    s.count > 1 ? fmt::format("x{} ", s.count) : "", s.worst);
        };
        part("quality", g.quality);
        part("angle", g.angle);
        part("ratio", g.edge_ratio);
        text += fmt::format("  at {:.5g} {:.5g} {:.5g}: {}\n      cause: {}\n", g.point.x(), g.point.y(), g.point.z(),
                            what, to_text(g.cause));
    }
    if (report.num_groups > listed) text += fmt::format("  and {} more places\n", report.num_groups - listed);
    return text;
}

}  // namespace gradus

#include "gradus/quality/deviation.hpp"

#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>

namespace gradus {

namespace {

using Eigen::Vector3d;

// Of distances beyond the limit, by which sizes are lowered: they need no better.
constexpr double kPrecision = 0.1;
constexpr double kBelongs = 2;      // over the limit
constexpr double kMostPieces = 16;  // of an edge of the surface that is looked at
constexpr int kLarge = 16;          // vertices over a triangle of the surface from which it is cut into pieces
constexpr int kOverPiece = 8;       // and vertices over each of those, about
// Over the distance of a point: the triangle that leaves a place out is not always the one closest to it.
constexpr double kAlmostClosest = 1.3;

void check_under(const char* function, const MeshView& mesh, std::span<const int> under) {
    if (under.size() != mesh.points.size())
        throw std::invalid_argument(std::string(function) + ": " + std::to_string(under.size()) + " triangles under " +
                                    std::to_string(mesh.points.size()) + " vertices");
}

// For each vertex of the reference a triangle of a mesh near it, or -1: those at the mesh's vertices, spread over the
// reference.
std::vector<int> triangles_over(const Connectivity& reference, const MeshView& mesh, std::span<const int> under) {
    std::vector<int> over(reference.num_vertices(), -1), queue;
    queue.reserve(over.size());
    const auto reach = [&](int vertex, int triangle) {
        if (over[vertex] < 0) over[vertex] = triangle, queue.push_back(vertex);
    };
    for (int t = 0; t < std::ssize(mesh.triangles); ++t)
        for (const int v : mesh.triangles[t])
            if (under[v] >= 0)
                for (const int corner : reference.triangle(under[v])) reach(corner, t);
    for (std::size_t i = 0; i < queue.size(); ++i)
        reference.for_each_outgoing(queue[i], [&](int h) {
            reach(reference.target(h), over[queue[i]]);
            reach(reference.apex(h), over[queue[i]]);
        });
    return over;
}

// For each point of one mesh a vertex of another that is exactly there, or -1.
std::vector<int> same_points(std::span<const Vector3d> from, std::span<const Vector3d> to) {
    const auto before = [](const Vector3d& a, const Vector3d& b) {
        return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
    };
    std::vector<int> sorted(to.size());
    std::iota(sorted.begin(), sorted.end(), 0);
    std::sort(sorted.begin(), sorted.end(), [&](int a, int b) { return before(to[a], to[b]); });
    std::vector<int> same(from.size(), -1);
    for (std::size_t v = 0; v < from.size(); ++v) {
        const auto at = std::lower_bound(sorted.begin(), sorted.end(), from[v],
                                         [&](int a, const Vector3d& p) { return before(to[a], p); });
        if (at != sorted.end() && to[*at] == from[v]) same[v] = *at;
    }
    return same;
}

// The same triangle from its smallest vertex on.
Triangle from_smallest(Triangle t) {
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    return t;
}

// For each triangle of one mesh that with the same corners, bit for bit, in another, or -1.
std::vector<int> same_triangles(const MeshView& from, const MeshView& to) {
    std::vector<int> same(from.triangles.size(), -1);
    if (from.triangles.empty()) return same;
    // The other mesh's triangles by their smallest vertex: those of vertex v are filed[first[v]] ... filed[first[v + 1]
    // - 1].
    std::vector<int> first(to.points.size() + 1, 0), filed(to.triangles.size());
    for (const Triangle& t : to.triangles) ++first[from_smallest(t)[0] + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    std::vector<int> next(first.begin(), first.end() - 1);
    for (int t = 0; t < std::ssize(to.triangles); ++t) filed[next[from_smallest(to.triangles[t])[0]]++] = t;

    const std::vector<int> vertex = same_points(from.points, to.points);
    for (std::size_t i = 0; i < same.size(); ++i) {
        const auto& [a, b, c] = from.triangles[i];
        if (vertex[a] < 0 || vertex[b] < 0 || vertex[c] < 0) continue;
        const Triangle wanted = from_smallest({vertex[a], vertex[b], vertex[c]});
        for (int k = first[wanted[0]]; k < first[wanted[0] + 1]; ++k)
            if (from_smallest(to.triangles[filed[k]]) == wanted) same[i] = filed[k];
    }
    return same;
}

// Whether all witnesses are still there. They take their new numbers as far as they are.
bool take_numbers(Witnesses& witnesses, const std::vector<int>& now) {
    for (int i = 0; i < witnesses.size && witnesses.proved; ++i)
        witnesses.proved = (witnesses[i] = now[witnesses[i]]) >= 0;
    return witnesses.proved;
}

}  // namespace

Deviation measure_deviation(const ReferenceView& reference, const MeshView& mesh, std::span<const int> under,
                            double precision) {
    check_under("measure_deviation", mesh, under);
    return {
        DistanceTarget(reference.surface).measure_from(mesh, {.precision = precision, .near = under}),
        DistanceTarget(mesh).measure_from(
            reference.surface, {.precision = precision, .near = triangles_over(reference.connectivity, mesh, under)})};
}

DeviationProof::DeviationProof(const ReferenceView& reference, double limit)
    : reference_(reference), limit_(limit), target_(reference.surface) {
    if (!(limit > 0))
        throw std::invalid_argument("DeviationProof: limit is " + std::to_string(limit) + ", not above 0");
}

ProvedDeviation DeviationProof::prove(const MeshView& mesh, std::span<const int> under) {
    check_under("DeviationProof::prove", mesh, under);
    if (witnesses_.empty()) cut_large(under);
    const DistanceTarget target(mesh);
    const std::vector<int> now = same_triangles({points_, triangles_}, mesh);
    ProvedDeviation proved;
    proved.deviation.from_mesh = prove_from_mesh(mesh, under, now);
    proved.deviation.from_reference = prove_from_reference(mesh, target, under, now);
    points_.assign(mesh.points.begin(), mesh.points.end());
    triangles_.assign(mesh.triangles.begin(), mesh.triangles.end());
    proved.at_fault = proved.deviation.from_mesh.beyond;
    for (const TooFar& f : proved.deviation.from_reference.beyond)
        for (const int t : target.within(f.point, kAlmostClosest * f.distance))
            proved.at_fault.push_back({t, f.distance, f.point, f.triangle});
    return proved;
}

bool DeviationProof::is_kept_by(const MeshView& part, int changed, std::span<const int> under,
                                const std::optional<Vector3d>& also) {
    const OneSidedOptions options{.limit = limit_, .precision = kPrecision, .near = under};
    if (!target_.measure_from({part.points, part.triangles.first(changed)}, options).beyond.empty()) return false;

    const Connectivity& surface = reference_.connectivity;
    const auto points = reference_.surface.points;
    seen_.resize(surface.num_triangles(), 0);
    ++parts_;
    std::vector<int> queue;
    const auto reach = [&](int t) {
        if (seen_[t] != parts_) seen_[t] = parts_, queue.push_back(t);
    };
    double shortest = std::numeric_limits<double>::infinity();
    for (const Triangle& t : part.triangles.first(changed))
        for (int k = 0; k < 3; ++k) {
            reach(under[t[k]]);
            shortest = std::min(shortest, (part.points[t[k]] - part.points[t[(k + 1) % 3]]).norm());
        }
    const DistanceTarget target(part);
    if (also && target.distance(*also) > limit_) return false;
    bool kept = true;
    int near = 0;
    // Whether a point is closest to a triangle that changed.
    const auto is_over = [&](const Vector3d& p) {
        auto hit = target.descend(p, near);
        if (hit.distance > limit_) {
            hit = target.closest(p, hit.triangle);
            // Beside the part there may be triangles that are closer, and what is much farther belongs to those.
            if (hit.distance > limit_ && hit.distance < kBelongs * limit_ &&
                (hit.triangle < changed || target.is_over(p, hit.triangle)))
                kept = false;
        }
        near = hit.triangle;
        return near < changed;
    };
    for (std::size_t i = 0; i < queue.size() && kept; ++i) {
        bool over = false;
        for (int h = 3 * queue[i]; h < 3 * queue[i] + 3; ++h) {
            const Vector3d &a = points[surface.origin(h)], &b = points[surface.target(h)];
            const int pieces = static_cast<int>(std::clamp(std::ceil((b - a).norm() / shortest), 1.0, kMostPieces));
            for (int k = 0; k < pieces; ++k) over = is_over(a + k * (b - a) / pieces) || over;
        }
        for (int h = 3 * queue[i]; over && h < 3 * queue[i] + 3; ++h)
            if (surface.twin(h) >= 0) reach(surface.twin(h) / 3);
    }
    return kept;
}

// @param now  for each triangle of the last mesh its number in this one, or -1
OneSidedDistance DeviationProof::prove_from_mesh(const MeshView& mesh, std::span<const int> under,
                                                 const std::vector<int>& now) {
    std::vector<char> kept(mesh.triangles.size(), 0);
    for (std::size_t t = 0; t < now.size(); ++t)
        if (now[t] >= 0 && kept_[t]) kept[now[t]] = 1;
    OneSidedDistance found =
        target_.measure_from(mesh, {.limit = limit_, .precision = kPrecision, .near = under, .skip = kept});
    kept_.assign(mesh.triangles.size(), 1);
    for (const TooFar& f : found.beyond) kept_[f.triangle] = 0;
    include_proved_before(found);
    return found;
}

OneSidedDistance DeviationProof::prove_from_reference(const MeshView& mesh, const DistanceTarget& target,
                                                      std::span<const int> under, const std::vector<int>& now) {
    std::vector<char> kept(witnesses_.size());
    for (std::size_t t = 0; t < kept.size(); ++t) kept[t] = take_numbers(witnesses_[t], now);
    std::vector<int> over = triangles_over(reference_.connectivity, mesh, under);
    for (const int v : pieces_.beside) over.push_back(over[v]);
    const MeshView surface =
        pieces_.triangles.empty() ? reference_.surface : MeshView{pieces_.points, pieces_.triangles};
    OneSidedDistance found = target.measure_from(
        surface, {.limit = limit_, .precision = kPrecision, .near = over, .skip = kept, .witnesses = witnesses_});
    if (!pieces_.of.empty())
        for (TooFar& f : found.beyond) f.triangle = pieces_.of[f.triangle];
    include_proved_before(found);
    return found;
}

void DeviationProof::cut_large(std::span<const int> under) {
    const std::span<const Triangle> triangles = reference_.surface.triangles;
    std::vector<int> over(triangles.size(), 0);
    for (const int t : under)
        if (t >= 0) ++over[t];
    if (std::any_of(over.begin(), over.end(), [](int n) { return n > kLarge; })) {
        pieces_.points.assign(reference_.surface.points.begin(), reference_.surface.points.end());
        for (int t = 0; t < std::ssize(triangles); ++t)
            cut_into(over[t] > kLarge ? over[t] / kOverPiece : 1, triangles[t], t);
    }
    witnesses_.resize(pieces_.triangles.empty() ? triangles.size() : pieces_.triangles.size());
}

// Halves a triangle of the surface, or a piece of one, until there is a number of pieces, each across its longest side.
void DeviationProof::cut_into(int number, const Triangle& corners, int triangle) {
    if (number <= 1) {
        pieces_.triangles.push_back(corners);
        pieces_.of.push_back(triangle);
        return;
    }
    const auto length2 = [&](int k) {
        return (pieces_.points[corners[(k + 1) % 3]] - pieces_.points[corners[k]]).squaredNorm();
    };
    int k = 0;
    for (const int other : {1, 2})
        if (length2(other) > length2(k)) k = other;
    const int a = corners[k], b = corners[(k + 1) % 3], c = corners[(k + 2) % 3];
    const auto middle = static_cast<int>(pieces_.points.size());
    pieces_.points.push_back((pieces_.points[a] + pieces_.points[b]) / 2);
    pieces_.beside.push_back(reference_.surface.triangles[triangle][0]);
    cut_into(number / 2, {a, middle, c}, triangle);
    cut_into(number - number / 2, {middle, b, c}, triangle);
}

void DeviationProof::include_proved_before(OneSidedDistance& found) {
    bound_of_proved_ = std::max(bound_of_proved_, std::min(limit_, found.bound));
    found.bound = std::max(found.bound, bound_of_proved_);
}

}  // namespace gradus

#include "gradus/surface/smooth_support.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace gradus {

namespace {

using Eigen::Vector3d;

constexpr double kSteepest = 0.5;  // cosine of the angle between an edge and its curve: no steeper than 60 degrees

constexpr double kNormalCosine = 0.87;   // normals of vertices count as far as 30 degrees from the facet's
constexpr double kInnerReach = 0.15;     // over the shortest edge
constexpr double kRiseOverWidth = 0.25;  // of the curve of an edge, over the width of the narrower facet beside it, and
                                         // of a patch over that of its own
constexpr double kInnerBulge =
    1.5;  // of an inner control point: a round one has about twice the height of the edges' middles

// Weight of a corner that is exact for spheres, times its normal [Max 1999].
Vector3d corner_share(std::span<const Vector3d> points, const Connectivity& mesh, int h) {
    const Vector3d a = points[mesh.target(h)] - points[mesh.origin(h)],
                   b = points[mesh.apex(h)] - points[mesh.origin(h)];
    const double scale = a.squaredNorm() * b.squaredNorm();
    return scale > 0 ? Vector3d(a.cross(b) / scale) : Vector3d::Zero();
}

Vector3d unit_or_zero(const Vector3d& v) {
    const double length = v.norm();
    return length > 0 ? Vector3d(v / length) : Vector3d::Zero();
}

Vector3d without(const Vector3d& v, const Vector3d& direction) { return v - v.dot(direction) * direction; }

// Tangent at b of the circle through three points; of the chord where they are on a line.
Vector3d circle_tangent(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
    const Vector3d u = b - a, v = c - b;
    const double lu = u.norm(), lv = v.norm();
    if (!(lu > 0) || !(lv > 0)) return unit_or_zero(c - a);
    return unit_or_zero(u * (lv / lu) + v * (lu / lv));
}

// Coordinates (b, c) of the point of triangle (p0, p1, p2) closest to p, and the squared distance.
struct Closest {
    double b, c, distance2;
};
Closest closest_in(const Vector3d& p, const Vector3d& p0, const Vector3d& p1, const Vector3d& p2) {
    const Vector3d e1 = p1 - p0, e2 = p2 - p0, d = p - p0;
    const double a11 = e1.squaredNorm(), a12 = e1.dot(e2), a22 = e2.squaredNorm(), d1 = e1.dot(d), d2 = e2.dot(d);
    const double det = a11 * a22 - a12 * a12;
    const auto at = [&](double b, double c) { return Closest{b, c, (d - b * e1 - c * e2).squaredNorm()}; };
    if (det > 0) {
        const double b = (a22 * d1 - a12 * d2) / det, c = (a11 * d2 - a12 * d1) / det;
        if (b >= 0 && c >= 0 && b + c <= 1) return at(b, c);
    }
    const auto along = [](double t, double length2) { return length2 > 0 ? std::clamp(t / length2, 0.0, 1.0) : 0.0; };
    Closest best = at(along(d1, a11), 0);
    if (const Closest other = at(0, along(d2, a22)); other.distance2 < best.distance2) best = other;
    const Vector3d e3 = p2 - p1;
    const double s = along(e3.dot(p - p1), e3.squaredNorm());
    if (const Closest other = at(1 - s, s); other.distance2 < best.distance2) best = other;
    return best;
}

}  // namespace

std::vector<Vector3d> wedge_normals(std::span<const Vector3d> points, const Connectivity& mesh, const Wedges& wedges) {
    std::vector<Vector3d> normals(wedges.size(), Vector3d::Zero());
    for (int h = 0; h < 3 * mesh.num_triangles(); ++h) normals[wedges.of_corner[h]] += corner_share(points, mesh, h);
    for (Vector3d& n : normals) n = unit_or_zero(n);
    return normals;
}

SmoothSupport::SmoothSupport(std::span<const Vector3d> points, const Connectivity& mesh, const Features& features,
                             const Wedges& wedges, const FlatFaces& flats, std::vector<Vector3d> normals,
                             const Options& options)
    : points_(points), mesh_(&mesh), wedges_(&wedges), flats_(&flats), options_(options), normals_(std::move(normals)) {
    find_tangents(features);
    turn_normals(features);
    hold_flats();
    find_folds();
}

Vector3d SmoothSupport::facet_normal(int triangle) const {
    if (const int kept = normal_near_folds_[triangle]; kept >= 0) return facet_normals_[kept];
    const Triangle v = mesh_->triangle(triangle);
    return (points_[v[1]] - points_[v[0]]).cross(points_[v[2]] - points_[v[0]]).stableNormalized();
}

void SmoothSupport::find_folds() {
    const Connectivity& mesh = *mesh_;
    const int n = mesh.num_triangles();
    normal_near_folds_.assign(n, -1);
    std::vector<Vector3d> normals(n);
    for (int t = 0; t < n; ++t) normals[t] = facet_normal(t);
    std::vector<int> near;
    const auto reach = [&](int vertex) {
        mesh.for_each_outgoing(vertex, [&](int e) {
            if (int& number = normal_near_folds_[e / 3]; number < 0)
                number = static_cast<int>(near.size()), near.push_back(e / 3);
        });
    };
    for (int h = 0; h < 3 * n; ++h) {
        const int g = mesh.twin(h);
        if (g < h || mesh.tag(h) >= 0 || normals[h / 3].dot(normals[g / 3]) > kFold) continue;
        reach(mesh.origin(h));
        reach(mesh.target(h));
    }
    for (std::size_t begin = 0, ring = 0; ring < 2; ++ring) {
        const std::size_t end = near.size();
        for (; begin < end; ++begin)
            for (const int v : mesh.triangle(near[begin])) reach(v);
    }
    facet_normals_.reserve(near.size());
    for (const int t : near) facet_normals_.push_back(normals[t]);
}

// A chord that is longer than those it meets is straight, as a flat face is, and the others follow its direction; else
// the tangent is that of the circle through three points.
void SmoothSupport::find_tangents(const Features& features) {
    tangents_.assign(mesh_->num_vertices(), Vector3d::Zero());
    is_tip_ = features.corner;
    for (const FeatureChain& chain : features.chains)
        for (const int v : chain.vertices) is_tip_[v] = 0;
    for (const FeatureChain& chain : features.chains) {
        const int n = static_cast<int>(chain.vertices.size()), edges = chain.num_edges();
        for (int i = chain.closed ? 0 : 1; i < (chain.closed ? n : n - 1); ++i) {
            const Vector3d &a = points_[chain.vertex(i + n - 1)], &b = points_[chain.vertices[i]],
                           &c = points_[chain.vertex(i + 1)];
            const int before = (i + edges - 1) % edges;
            Vector3d& tangent = tangents_[chain.vertices[i]];
            if (is_straight_chord(points_, chain, before))
                tangent = unit_or_zero(b - a);
            else if (is_straight_chord(points_, chain, i))
                tangent = unit_or_zero(c - b);
            else
                tangent = circle_tangent(a, b, c);
        }
    }
}

// Where one flat face is in a wedge its normal is the wedge's: what comes after it begins in its plane.
void SmoothSupport::hold_flats() {
    if (flats_->empty()) return;
    for (int wedge = 0; wedge < wedges_->size(); ++wedge) {
        if (wedges_->first[wedge] == Connectivity::kNone) continue;
        int face = -1;
        bool single = true;
        wedges_->for_each(*mesh_, wedge, [&](int h) {
            const int here = flats_->of(h / 3);
            if (here >= 0 && face >= 0 && here != face) single = false;
            if (here >= 0) face = here;
        });
        if (face >= 0 && single) normals_[wedge] = flats_->normals[face];
    }
}

// The tangent plane of a wedge holds the tangents of the curves on both its sides.
void SmoothSupport::turn_normals(const Features& features) {
    const Connectivity& mesh = *mesh_;
    for (int wedge = 0; wedge < wedges_->size(); ++wedge) {
        const int v = wedges_->vertex[wedge], begin = wedges_->first[wedge];
        if (begin == Connectivity::kNone || mesh.tag(begin) < 0) continue;
        Vector3d& normal = normals_[wedge];
        if (!tangents_[v].isZero()) {
            normal = unit_or_zero(without(normal, tangents_[v]));
            continue;
        }
        int last = begin;
        wedges_->for_each(mesh, wedge, [&](int h) { last = h; });
        const int end = Connectivity::prev(last);
        if (!features.corner[v] || mesh.tag(end) < 0) continue;
        const Vector3d u = unit_or_zero(handles(begin).from - points_[v]),
                       w = unit_or_zero(handles(end).to - points_[v]);
        const Vector3d across = u.cross(w);
        constexpr double kNotParallel = 0.1;
        if (across.norm() > kNotParallel) normal = unit_or_zero(across.dot(normal) < 0 ? Vector3d(-across) : across);
    }
}

// Height of the lower of the facets beside an edge over it.
double SmoothSupport::width_beside(int h) const {
    const Vector3d &a = points_[mesh_->origin(h)], along = points_[mesh_->target(h)] - a;
    double area2 = along.cross(points_[mesh_->apex(h)] - a).squaredNorm();
    if (const int g = mesh_->twin(h); g >= 0)
        area2 = std::min(area2, along.cross(points_[mesh_->apex(g)] - a).squaredNorm());
    return std::sqrt(area2 / along.squaredNorm());
}

// Circle-like: handles of 2/3 of the chord over 1 + cosine of the angle to it; parabola-like for small angles either
// way.
SmoothSupport::Handles SmoothSupport::handles(int h) const {
    const int a = mesh_->origin(h), b = mesh_->target(h);
    const Vector3d &pa = points_[a], &pb = points_[b];
    const Vector3d chord = pb - pa;
    const double length = chord.norm();
    if (!(length > 0)) return {pa, pb};
    // Straight lines lead to the point of a cone.
    if (is_tip_[a] || is_tip_[b]) return {pa + chord / 3, pb - chord / 3};
    const int here = flats_->of(h / 3), there = mesh_->twin(h) >= 0 ? flats_->of(mesh_->twin(h) / 3) : -1;
    // Flat faces meet in a line, and what passes over into a flat face does.
    if ((here >= 0 && there >= 0) || (mesh_->tag(h) < 0 && (here >= 0 || there >= 0)))
        return {pa + chord / 3, pb - chord / 3};
    const Vector3d along = chord / length;
    Vector3d ta = along, tb = along;
    if (mesh_->tag(h) >= 0) {
        const auto turned = [&](const Vector3d& t) { return t.dot(along) < 0 ? Vector3d(-t) : t; };
        const bool has_a = !tangents_[a].isZero(), has_b = !tangents_[b].isZero();
        if (has_a) ta = turned(tangents_[a]);
        if (has_b) tb = turned(tangents_[b]);
        // A corner takes the tangent of the circle that leaves the other end.
        if (!has_a && has_b) ta = 2 * tb.dot(along) * along - tb;
        if (!has_b && has_a) tb = 2 * ta.dot(along) * along - ta;
        // The border of a flat face is in its plane.
        if (const int face = std::max(here, there); face >= 0) {
            ta = unit_or_zero(without(ta, flats_->normals[face]));
            tb = unit_or_zero(without(tb, flats_->normals[face]));
        }
    } else {
        const auto tangent = [&](int corner) {
            const Vector3d t = unit_or_zero(without(along, normals_[wedges_->of_corner[corner]]));
            return t.isZero() ? along : t;
        };
        ta = tangent(h);
        tb = tangent(Connectivity::next(h));
    }
    const auto handle = [&](const Vector3d& t) {
        const double cosine = t.dot(along);
        if (cosine >= kSteepest) return Vector3d(length * (2.0 / 3) / (1 + cosine) * t);
        // Too steep to be meant: bent towards the edge.
        const Vector3d across = unit_or_zero(t - cosine * along);
        return Vector3d(length * (2.0 / 3) / (1 + kSteepest) *
                        (kSteepest * along + std::sqrt(1 - kSteepest * kSteepest) * across));
    };
    Vector3d from = handle(ta), to = handle(tb);
    // The middle of the cubic lies 3/8 of the difference of the handles off the chord, a bend either way .29 of one of
    // them.
    const double bulge = std::max({0.375 * without(from - to, along).norm(), 0.29 * without(from, along).norm(),
                                   0.29 * without(to, along).norm()});
    const double most = std::min(options_.largest_bulge, kRiseOverWidth * width_beside(h));
    if (bulge > most) {
        const double share = most / bulge;
        from = chord / 3 + share * (from - chord / 3);
        to = chord / 3 + share * (to - chord / 3);
    }
    return {pa + from, pb - to};
}

Vector3d SmoothSupport::curve_point(int h, double s) const {
    const auto [from, to] = handles(h);
    const double r = 1 - s;
    return r * r * r * points_[mesh_->origin(h)] + 3 * r * r * s * from + 3 * r * s * s * to +
           s * s * s * points_[mesh_->target(h)];
}

GregoryPatch SmoothSupport::patch(int triangle) const {
    GregoryPatch patch;
    auto& [p, side, inner, normals] = patch;
    std::array<std::array<Vector3d, 4>, 3> cubic;
    for (int k = 0; k < 3; ++k) p[k] = points_[mesh_->origin(3 * triangle + k)];
    for (int k = 0; k < 3; ++k) {
        // Both triangles of an edge take the same cubic, to the last bit.
        const int h = 3 * triangle + k, g = mesh_->twin(h);
        Handles on_edge;
        if (g >= 0 && g < h) {
            const Handles other = handles(g);
            on_edge = {other.to, other.from};
        } else {
            on_edge = handles(h);
        }
        const auto& q = cubic[k] = {p[k], on_edge.from, on_edge.to, p[(k + 1) % 3]};
        side[k] = {(q[0] + 3 * q[1]) / 4, (q[1] + q[2]) / 2, (3 * q[2] + q[3]) / 4};
    }
    for (int k = 0; k < 3; ++k) {
        const auto& q = cubic[k];
        const auto& edge = side[k];
        const Vector3d w0 = q[1] - q[0], w1 = q[2] - q[1], w2 = q[3] - q[2];
        const Vector3d a0 = unit_or_zero(corner_normal(triangle, k).cross(w0)),
                       a2 = unit_or_zero(corner_normal(triangle, (k + 1) % 3).cross(w2));
        const Vector3d a1 = unit_or_zero(a0 + a2);
        // First row beside the side: known at its ends, where it belongs to the two other sides.
        const Vector3d d0 = side[(k + 2) % 3][2] - (q[0] + edge[0]) / 2,
                       d3 = side[(k + 1) % 3][0] - (edge[2] + q[3]) / 2;
        const double n0 = w0.squaredNorm(), n2 = w2.squaredNorm();
        const double l0 = n0 > 0 ? d0.dot(w0) / n0 : 0, l1 = n2 > 0 ? d3.dot(w2) / n2 : 0, m0 = d0.dot(a0),
                     m1 = d3.dot(a2);
        inner[k][0] = (edge[0] + edge[1]) / 2 + (l1 * w0 + 2 * l0 * w1 + m1 * a0 + 2 * m0 * a1) / 3;
        inner[k][1] = (edge[1] + edge[2]) / 2 + (2 * l1 * w1 + l0 * w2 + 2 * m1 * a1 + m0 * a2) / 3;
    }
    // Control points of a fair patch lie over those of the facet, not far off it; what tangents that disagree would
    // throw farther is held back, else the patch folds or leaves its facet.
    const Vector3d area = (p[1] - p[0]).cross(p[2] - p[0]), facing = area.stableNormalized();
    const auto [shortest, longest] = std::minmax({(p[1] - p[0]).norm(), (p[2] - p[1]).norm(), (p[0] - p[2]).norm()});
    const double width = longest > 0 ? area.stableNorm() / longest : 0,
                 most = kInnerBulge * std::min(options_.largest_bulge, kRiseOverWidth * width);
    const bool is_flat = flats_->of(triangle) >= 0;
    const double reach = kInnerReach * shortest;
    for (int k = 0; k < 3; ++k) {
        for (int i = 0; i < 2; ++i) {
            const Vector3d flat = p[0] + p[1] + p[2] + p[(k + i) % 3];
            Vector3d off = inner[k][i] - flat / 4;
            const double height = facing.dot(off);
            off -= height * facing;
            const double slide = off.norm();
            if (slide > reach) off *= reach / slide;
            inner[k][i] = flat / 4 + off + (is_flat ? 0 : std::clamp(height, -most, most)) * facing;
        }
    }
    for (int k = 0; k < 3; ++k) normals[k] = held_normal(triangle, k, facing);
    return patch;
}

// Where the vertices' normals say little of the facet, the facet says more. @param facing  its own
Vector3d SmoothSupport::held_normal(int triangle, int k, const Vector3d& facing) const {
    if (const int face = flats_->of(triangle); face >= 0) return flats_->normals[face];
    const Vector3d& normal = corner_normal(triangle, k);
    const double cosine = normal.dot(facing);
    if (cosine >= kNormalCosine) return normal;
    return kNormalCosine * facing +
           std::sqrt(1 - kNormalCosine * kNormalCosine) * unit_or_zero(normal - cosine * facing);
}

Vector3d GregoryPatch::point(double b, double c) const {
    const std::array<double, 3> w{1 - b - c, b, c};
    const auto pow2 = [](double x) { return x * x; };
    Vector3d sum = Vector3d::Zero();
    for (int k = 0; k < 3; ++k) {
        const double x = w[k], y = w[(k + 1) % 3], z = w[(k + 2) % 3];
        sum += pow2(x * x) * corner[k] + 4 * x * y * (x * x * side[k][0] + y * y * side[k][2]) +
               6 * pow2(x * y) * side[k][1];
        // Near corner k: from the side that leaves it and the one that reaches it.
        const double share = y + z > 0 ? y / (y + z) : 0.5;
        sum += 12 * x * x * y * z * (share * inner[k][0] + (1 - share) * inner[(k + 2) % 3][1]);
    }
    return sum;
}

SmoothSupport::Foot SmoothSupport::within(int triangle, const Vector3d& p) const {
    const Triangle v = mesh_->triangle(triangle);
    const Closest at = closest_in(p, points_[v[0]], points_[v[1]], points_[v[2]]);
    return {triangle, at.b, at.c, false, at.distance2};
}

SmoothSupport::Foot SmoothSupport::walk(int triangle, const Vector3d& p) const {
    const Connectivity& mesh = *mesh_;
    const auto look = [&](int t) {
        const Triangle v = mesh.triangle(t);
        return closest_in(p, points_[v[0]], points_[v[1]], points_[v[2]]);
    };
    Closest here = look(triangle);
    constexpr double kEnd = 1e-12;
    while (true) {
        const std::array<double, 3> w{1 - here.b - here.c, here.b, here.c};
        int best = -1;
        bool barred = false;
        Closest there = here;
        there.distance2 *= 1 - kEnd;
        const auto consider = [&](int t) {
            if (const Closest other = look(t); other.distance2 < there.distance2) there = other, best = t;
        };
        for (int k = 0; k < 3; ++k) {
            // Corner k without weight: the way out leads across the side opposite to it.
            if (w[k] > kEnd) continue;
            const int h = 3 * triangle + (k + 1) % 3;
            if (mesh.tag(h) >= 0 || mesh.twin(h) < 0)
                barred = true;
            else
                consider(mesh.twin(h) / 3);
        }
        for (int k = 0; k < 3; ++k) {
            if (w[k] < 1 - kEnd) continue;
            // At corner k: its fan up to features on either side.
            const int start = 3 * triangle + k;
            int h = start;
            do {
                if (barred = mesh.tag(Connectivity::prev(h)) >= 0 || mesh.rotate(h) == Connectivity::kNone; barred)
                    break;
                h = mesh.rotate(h);
                consider(h / 3);
            } while (h != start);
            if (!barred) continue;
            for (h = start; mesh.tag(h) < 0 && mesh.twin(h) >= 0;) {
                h = Connectivity::next(mesh.twin(h));
                consider(h / 3);
            }
        }
        if (best < 0) return {triangle, here.b, here.c, barred, here.distance2};
        triangle = best;
        here = look(best);
    }
}

}  // namespace gradus

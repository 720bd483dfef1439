#include "gradus/mesh/self_contact.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Dense>
#include <algorithm>
#include <numeric>
#include <span>

#include "places.hpp"
#include "predicates3d.hpp"

namespace gradus {
namespace {

using exact::orient2d;
using exact::orient3d;
using Vector = Eigen::Vector3d;
using Pair = SelfContacts::Pair;

/// What a sum of three products of numbers in [-1, 1] may be off, as a fraction of the largest.
constexpr double kRounding = 1e-15;

/// A triangle with an axis along which it has an area.
struct Face {
    Triangle places;
    std::array<Vector, 3> corners;
    int index;
    int axis;
};

/// Closed triangles and segments. Signs are those of orient3d of the corners of a face and a point.
bool in_range(double x, double a, double b) { return std::min(a, b) <= x && x <= std::max(a, b); }

/// For points on one line, seen along an axis.
bool on_segment(const Vector& p, const Vector& a, const Vector& b, int axis) {
    const int x = (axis + 1) % 3, y = (axis + 2) % 3;
    return in_range(p[x], a[x], b[x]) && in_range(p[y], a[y], b[y]);
}

bool segments_meet(const Vector& p, const Vector& q, const Vector& a, const Vector& b, int axis) {
    const int pa = orient2d(a, b, p, axis), qa = orient2d(a, b, q, axis);
    const int ap = orient2d(p, q, a, axis), bp = orient2d(p, q, b, axis);
    if (pa * qa < 0 && ap * bp < 0) return true;
    return (pa == 0 && on_segment(p, a, b, axis)) || (qa == 0 && on_segment(q, a, b, axis)) ||
           (ap == 0 && on_segment(a, p, q, axis)) || (bp == 0 && on_segment(b, p, q, axis));
}

bool in_face(const Vector& p, const Face& f) {
    const auto& [a, b, c] = f.corners;
    const std::array<int, 3> signs{orient2d(a, b, p, f.axis), orient2d(b, c, p, f.axis), orient2d(c, a, p, f.axis)};
    const auto [low, high] = std::minmax_element(signs.begin(), signs.end());
    return *low >= 0 || *high <= 0;
}

/// A segment and a face in one plane.
bool meets_in_plane(const Vector& p, const Vector& q, const Face& f) {
    if (in_face(p, f)) return true;
    for (int k = 0; k < 3; ++k)
        if (segments_meet(p, q, f.corners[k], f.corners[(k + 1) % 3], f.axis)) return true;
    return false;
}

bool meets(const Vector& p, const Vector& q, int sign_p, int sign_q, const Face& f) {
    if (sign_p * sign_q > 0) return false;
    if (sign_p == 0 && sign_q == 0) return meets_in_plane(p, q, f);
    const auto& [a, b, c] = f.corners;
    const int ab = orient3d(p, q, a, b), bc = orient3d(p, q, b, c);
    if (ab * bc < 0) return false;
    const int ca = orient3d(p, q, c, a);
    return ab * ca >= 0 && bc * ca >= 0;
}

using Signs = std::array<int, 3>;

/// Where the corners of g are, from the plane of f. @param shared  a corner of g that is one of f
Signs sides_of(const Face& f, const Face& g, int shared) {
    Signs signs{};
    for (int k = 0; k < 3; ++k)
        if (k != shared) signs[k] = orient3d(f.corners[0], f.corners[1], f.corners[2], g.corners[k]);
    return signs;
}

bool has_no_corner_in_common_and_meets(const Face& f, const Face& g) {
    // A plane between them, to save the exact tests.
    const Vector between = g.corners[0] + g.corners[1] + g.corners[2] - f.corners[0] - f.corners[1] - f.corners[2];
    const auto height = [&](const Vector& p) { return between.dot(p); };
    if (std::max({height(f.corners[0]), height(f.corners[1]), height(f.corners[2])}) +
            4 * kRounding * between.lpNorm<1>() <
        std::min({height(g.corners[0]), height(g.corners[1]), height(g.corners[2])}))
        return false;
    const Signs of_g = sides_of(f, g, -1);
    if (of_g[0] == of_g[1] && of_g[1] == of_g[2] && of_g[0] != 0) return false;
    const Signs of_f = sides_of(g, f, -1);
    if (of_f[0] == of_f[1] && of_f[1] == of_f[2] && of_f[0] != 0) return false;
    for (int k = 0; k < 3; ++k) {
        const int m = (k + 1) % 3;
        if (meets(g.corners[k], g.corners[m], of_g[k], of_g[m], f) ||
            meets(f.corners[k], f.corners[m], of_f[k], of_f[m], g))
            return true;
    }
    return false;
}

/// What they have in common, with the shared corner, is a segment or an area that ends in the side opposite the corner,
/// of one or the other.
bool meets_beyond_corner(const Face& f, const Face& g, int i, int k) {
    const Vector &at = f.corners[i], &fa = f.corners[(i + 1) % 3], &fb = f.corners[(i + 2) % 3],
                 &ga = g.corners[(k + 1) % 3], &gb = g.corners[(k + 2) % 3];
    // A plane through the corner between them, to save the exact tests.
    const Vector a = fa - at, b = fb - at, c = ga - at, d = gb - at;
    const Vector between =
        (a.normalized() + b.normalized()).normalized() - (c.normalized() + d.normalized()).normalized();
    const auto above = [&](const Vector& u) {
        return between.dot(u) > kRounding * between.cwiseAbs().dot(u.cwiseAbs());
    };
    if (above(a) && above(b) && above(-c) && above(-d)) return false;
    const Signs of_g = sides_of(f, g, k);
    const int sign_ga = of_g[(k + 1) % 3], sign_gb = of_g[(k + 2) % 3];
    if (sign_ga * sign_gb > 0) return false;
    const Signs of_f = sides_of(g, f, i);
    const int sign_fa = of_f[(i + 1) % 3], sign_fb = of_f[(i + 2) % 3];
    if (sign_fa * sign_fb > 0) return false;
    return meets(ga, gb, sign_ga, sign_gb, f) || meets(fa, fb, sign_fa, sign_fb, g);
}

/// @param i, k  the corners that are not shared
bool folds_onto(const Face& f, const Face& g, int i, int k) {
    if (orient3d(f.corners[0], f.corners[1], f.corners[2], g.corners[k]) != 0) return false;
    const Vector &a = f.corners[(i + 1) % 3], &b = f.corners[(i + 2) % 3];
    return orient2d(a, b, f.corners[i], f.axis) == orient2d(a, b, g.corners[k], f.axis);
}

bool in_contact(const Face& f, const Face& g) {
    std::array<bool, 3> f_shared{}, g_shared{};
    int shared = 0;
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
            if (f.places[i] == g.places[k]) f_shared[i] = g_shared[k] = true, ++shared;
    const auto find = [](const std::array<bool, 3>& flags, bool value) {
        return static_cast<int>(std::find(flags.begin(), flags.end(), value) - flags.begin());
    };
    switch (shared) {
        case 0:
            return has_no_corner_in_common_and_meets(f, g);
        case 1:
            return meets_beyond_corner(f, g, find(f_shared, true), find(g_shared, true));
        case 2:
            return folds_onto(f, g, find(f_shared, false), find(g_shared, false));
        default:
            return true;
    }
}

struct Box {
    Vector low, high;

    static Box of(const Face& f) {
        return {f.corners[0].cwiseMin(f.corners[1]).cwiseMin(f.corners[2]),
                f.corners[0].cwiseMax(f.corners[1]).cwiseMax(f.corners[2])};
    }
    bool meets(const Box& other) const {
        return (low.array() <= other.high.array()).all() && (other.low.array() <= high.array()).all();
    }
};

/// A tree of boxes over faces, which it puts in its order.
class BoxTree {
  public:
    explicit BoxTree(std::vector<Face>& faces) : faces_(faces) {
        if (faces.empty()) return;
        nodes_.reserve(faces.size());
        build(0, static_cast<int>(faces.size()));
        for (const Face& face : faces) boxes_.push_back(Box::of(face));
    }

    /// Calls visit(k) for the faces k > i whose boxes meet that of face i.
    template <class Visit>
    void for_each_later(int i, Visit visit) const {
        descend(0, i, visit);
    }

  private:
    static constexpr int kLeaf = 4;
    struct Node {
        Box box;
        int first, last;
        int right = -1;  // the left child follows; -1: leaf
    };

    int build(int first, int last) {
        const int index = static_cast<int>(nodes_.size());
        Box box = Box::of(faces_[first]);
        for (int i = first + 1; i < last; ++i) {
            const Box other = Box::of(faces_[i]);
            box = {box.low.cwiseMin(other.low), box.high.cwiseMax(other.high)};
        }
        nodes_.push_back({box, first, last});
        if (last - first <= kLeaf) return index;
        int axis = 0;
        (box.high - box.low).maxCoeff(&axis);
        const auto centre = [axis](const Face& f) {
            return std::pair(f.corners[0][axis] + f.corners[1][axis] + f.corners[2][axis], f.index);
        };
        const int middle = first + (last - first) / 2;
        std::nth_element(faces_.begin() + first, faces_.begin() + middle, faces_.begin() + last,
                         [&](const Face& f, const Face& g) { return centre(f) < centre(g); });
        build(first, middle);
        const int right = build(middle, last);
        nodes_[index].right = right;
        return index;
    }

    template <class Visit>
    void descend(int index, int i, Visit& visit) const {
        const Node& node = nodes_[index];
        if (node.last <= i + 1 || !node.box.meets(boxes_[i])) return;
        if (node.right >= 0) {
            descend(index + 1, i, visit);
            descend(node.right, i, visit);
            return;
        }
        for (int k = std::max(node.first, i + 1); k < node.last; ++k)
            if (boxes_[k].meets(boxes_[i])) visit(k);
    }

    std::vector<Face>& faces_;
    std::vector<Box> boxes_;
    std::vector<Node> nodes_;
};

std::vector<Face> faces_of(const TriangleSoup& soup) {
    const int n = static_cast<int>(soup.points.size());
    const auto is_sound = [&](const Triangle& t) {
        return std::all_of(t.begin(), t.end(), [&](int v) { return v >= 0 && v < n && soup.points[v].allFinite(); });
    };
    std::vector<char> used(soup.points.size(), 0);
    for (const Triangle& t : soup.triangles)
        if (is_sound(t))
            for (const int v : t) used[v] = 1;
    const Points points = to_unit_box(soup.points, used);
    const std::vector<int> place = equal_places(points, used);
    std::vector<Face> faces;
    faces.reserve(soup.triangles.size());
    for (int t = 0; t < static_cast<int>(soup.triangles.size()); ++t) {
        const Triangle& v = soup.triangles[t];
        if (!is_sound(v)) continue;
        Face face{{place[v[0]], place[v[1]], place[v[2]]}, {points[v[0]], points[v[1]], points[v[2]]}, t, 0};
        const Vector normal = (face.corners[1] - face.corners[0]).cross(face.corners[2] - face.corners[0]);
        normal.cwiseAbs().maxCoeff(&face.axis);
        const int first = face.axis;
        while (orient2d(face.corners[0], face.corners[1], face.corners[2], face.axis) == 0) {
            face.axis = (face.axis + 1) % 3;
            if (face.axis == first) break;
        }
        if (orient2d(face.corners[0], face.corners[1], face.corners[2], face.axis) != 0) faces.push_back(face);
    }
    return faces;
}

/// Those to be listed, in order.
void keep_first(std::vector<Pair>& pairs, std::size_t most) {
    std::sort(pairs.begin(), pairs.end());
    if (pairs.size() > most) pairs.resize(most);
}

/// Of one face.
struct Contacts {
    std::vector<Pair> first;
    std::size_t count = 0, tests = 0;

    void add(int a, int b, std::size_t most) {
        ++count;
        first.push_back({std::min(a, b), std::max(a, b)});
        if (first.size() >= 2 * most) keep_first(first, most);
    }
};

}  // namespace

SelfContacts find_self_contacts(const TriangleSoup& soup, std::size_t most) {
    std::vector<Face> faces = faces_of(soup);
    const BoxTree tree(faces);
    const int n = static_cast<int>(faces.size());
    // A surface takes a few dozen tests per triangle; where all lies upon all, so many take seconds.
    const std::size_t most_tests = 5'000'000 + 200 * static_cast<std::size_t>(n);
    constexpr int kBlock = 512;
    std::vector<Contacts> found(kBlock);
    std::vector<Pair> first;
    SelfContacts result;
    std::size_t tests = 0;
    for (int begin = 0; begin < n; begin += kBlock) {
        const int end = std::min(n, begin + kBlock);
        tbb::parallel_for(tbb::blocked_range<int>(begin, end, 8), [&](const tbb::blocked_range<int>& range) {
            for (int i = range.begin(); i < range.end(); ++i) {
                Contacts& mine = found[i - begin];
                mine = {};
                tree.for_each_later(i, [&](int k) {
                    ++mine.tests;
                    if (in_contact(faces[i], faces[k])) mine.add(faces[i].index, faces[k].index, most);
                });
            }
        });
        for (int i = begin; i < end; ++i) {
            tests += found[i - begin].tests;
            result.pairs.count += found[i - begin].count;
            first.insert(first.end(), found[i - begin].first.begin(), found[i - begin].first.end());
        }
        keep_first(first, most);
        if (tests > most_tests && end < n) {
            result.complete = false;
            break;
        }
    }
    result.pairs.first = std::move(first);
    return result;
}

}  // namespace gradus

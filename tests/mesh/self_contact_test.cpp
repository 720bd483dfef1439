#include "gradus/mesh/self_contact.hpp"

#include <tbb/global_control.h>

#include <catch2/catch.hpp>
#include <numeric>
#include <set>

#include "gradus/mesh/repair.hpp"
#include "support/soups.hpp"

using namespace gradus;
using support::grid;
using support::tetrahedron;

namespace {

using Pair = SelfContacts::Pair;
using Pairs = std::vector<Pair>;
using Integer = long long;
using Point = std::array<Integer, 3>;

// The oracle: small integers, and all that two triangles have in common by clipping one with the half-spaces of the
// other, in fractions. A common set is convex; it is the hull of the points where an edge of one meets the other, so it
// is enough to find one of these that is neither a shared vertex nor on the shared edge.

Point minus(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Point cross(const Point& a, const Point& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Integer dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
bool is_zero(const Point& a) { return a == Point{0, 0, 0}; }

/// A point with a common denominator > 0.
struct Fraction {
    Point over;
    Integer under;
    auto operator<=>(const Fraction&) const = default;
};

/// In lowest terms, so that equal ones are equal.
Fraction lowest(Fraction f) {
    Integer common = f.under;
    for (const Integer x : f.over) common = std::gcd(common, x);
    if (f.under < 0) common = -common;
    for (Integer& x : f.over) x /= common;
    f.under /= common;
    return f;
}

/// Extreme points of what segment pq and triangle abc have in common.
std::set<Fraction> common(const Point& p, const Point& q, const std::array<Point, 3>& t) {
    const Point normal = cross(minus(t[1], t[0]), minus(t[2], t[0])), along = minus(q, p);
    const Integer at_p = dot(normal, minus(p, t[0])), at_q = dot(normal, minus(q, t[0]));
    if ((at_p > 0 && at_q > 0) || (at_p < 0 && at_q < 0)) return {};
    // The part s in [low, high] / under, clipped by the sides of the triangle.
    struct Ratio {
        Integer over, under;  // under > 0
        bool operator<(const Ratio& o) const { return over * o.under < o.over * under; }
    };
    const auto ratio = [](Integer a, Integer b) { return b < 0 ? Ratio{-a, -b} : Ratio{a, b}; };
    Ratio low{0, 1}, high{1, 1};
    if (at_p != at_q) low = high = ratio(at_p, at_p - at_q);
    for (int k = 0; k < 3; ++k) {
        const Point inward = cross(normal, minus(t[(k + 1) % 3], t[k]));
        const Integer start = dot(inward, minus(p, t[k])), rate = dot(inward, along);  // start + s rate >= 0
        if (rate == 0) {
            if (start < 0) return {};
            continue;
        }
        const Ratio bound = ratio(-start, rate);
        if (rate > 0 && low < bound) low = bound;
        if (rate < 0 && bound < high) high = bound;
        if (high < low) return {};
    }
    std::set<Fraction> points;
    for (const Ratio& s : {low, high}) {
        Fraction f{{}, s.under};
        for (int k = 0; k < 3; ++k) f.over[k] = p[k] * s.under + along[k] * s.over;
        points.insert(lowest(f));
    }
    return points;
}

bool oracle(const std::array<Point, 3>& s, const std::array<Point, 3>& t) {
    std::vector<Point> shared;
    for (const Point& p : s)
        if (std::find(t.begin(), t.end(), p) != t.end()) shared.push_back(p);
    for (const auto& [f, g] : {std::pair(s, t), std::pair(t, s)})
        for (int k = 0; k < 3; ++k)
            for (const Fraction& point : common(f[k], f[(k + 1) % 3], g)) {
                bool accounted = false;
                for (const Point& p : shared) accounted = accounted || point == Fraction{p, 1};
                if (shared.size() >= 2 && !accounted) {
                    Point a{}, b{};
                    for (int m = 0; m < 3; ++m) {
                        a[m] = point.over[m] - shared[0][m] * point.under;
                        b[m] = shared[1][m] - shared[0][m];
                    }
                    accounted = shared.size() == 2 && is_zero(cross(a, b)) && dot(a, b) >= 0 &&
                                dot(a, a) <= dot(b, b) * point.under * point.under;
                }
                if (!accounted) return true;
            }
    return shared.size() == 3;
}

Pairs oracle(const TriangleSoup& soup) {
    Pairs pairs;
    std::vector<std::array<Point, 3>> triangles;
    for (const Triangle& t : soup.triangles) {
        std::array<Point, 3> corners;
        for (int k = 0; k < 3; ++k)
            for (int m = 0; m < 3; ++m) corners[k][m] = static_cast<Integer>(soup.points[t[k]][m]);
        triangles.push_back(corners);
    }
    const auto has_area = [](const std::array<Point, 3>& t) {
        return !is_zero(cross(minus(t[1], t[0]), minus(t[2], t[0])));
    };
    for (int i = 0; i < static_cast<int>(triangles.size()); ++i)
        for (int k = i + 1; k < static_cast<int>(triangles.size()); ++k)
            if (has_area(triangles[i]) && has_area(triangles[k]) && oracle(triangles[i], triangles[k]))
                pairs.push_back({i, k});
    return pairs;
}

Pairs contacts(const TriangleSoup& soup) { return find_self_contacts(soup).pairs.first; }

}  // namespace

TEST_CASE("surfaces that do not touch themselves have no contacts", "[mesh][contact][exact]") {
    CHECK(find_self_contacts({}).pairs.empty());
    CHECK(contacts(tetrahedron()).empty());
    CHECK(contacts(grid(30)).empty());
    TriangleSoup flat = grid(30);
    for (Eigen::Vector3d& p : flat.points) p.z() = 0.1 * p.x() + 0.3 * p.y();
    CHECK(contacts(flat).empty());
}

TEST_CASE("each kind of contact is found", "[mesh][contact][exact]") {
    TriangleSoup soup;
    soup.points = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
    soup.triangles = {{0, 1, 2}};
    const auto with = [&](std::vector<Eigen::Vector3d> points, Triangle triangle) {
        TriangleSoup result = soup;
        result.points.insert(result.points.end(), points.begin(), points.end());
        result.triangles.push_back(triangle);
        return contacts(result);
    };
    const Pairs found{{0, 1}};
    CHECK(with({{1, 1, -1}, {1, 1, 1}, {9, 9, 0}}, {3, 4, 5}) == found);     // through
    CHECK(with({{1, 1, 0}, {1, 1, 1}, {1, 2, 1}}, {3, 4, 5}) == found);      // a corner on it
    CHECK(with({{1, 1, 1e-60}, {1, 1, 1}, {1, 2, 1}}, {3, 4, 5}).empty());   // above
    CHECK(with({{.5, .5, 0}, {1, .5, 0}, {.5, 1, 0}}, {3, 4, 5}) == found);  // inside, in the plane
    CHECK(with({{2, 2, 0}, {4, 4, 0}, {2, 4, 0}}, {3, 4, 5}) == found);      // touching, in the plane
    CHECK(with({{3, 3, 0}, {4, 4, 0}, {3, 4, 0}}, {3, 4, 5}).empty());
    CHECK(with({{4, 4, 0}}, {2, 1, 3}).empty());   // beyond a common edge
    CHECK(with({{1, 1, 0}}, {2, 1, 3}) == found);  // folded onto
    CHECK(with({{1, 1, 1}}, {2, 1, 3}).empty());
    CHECK(with({{1, 2, 0}, {2, 1, 0}}, {0, 3, 4}) == found);   // with a common corner, in the plane
    CHECK(with({{1, 1, 1}, {1, 1, -1}}, {0, 3, 4}) == found);  // with a common corner, through
    CHECK(with({{2, 0, 0}, {2, 0, 1}}, {0, 3, 4}) == found);   // along a side
    CHECK(with({{-1, 0, 1}, {-1, 0, -1}}, {0, 3, 4}).empty());
    CHECK(with({{0, 0, 0}, {-1, 0, 0}, {0, -1, 0}}, {3, 4, 5}).empty());  // at a corner given twice
    CHECK(with({}, {1, 0, 2}) == found);                                  // a copy
    CHECK(with({{1, 1, 0}, {2, 2, 0}}, {0, 3, 4}).empty());               // without area
}

TEST_CASE("contacts agree with brute force in whole numbers", "[mesh][contact][property]") {
    std::mt19937_64 random(17);
    std::size_t some = 0;
    for (int run = 0; run < 600; ++run) {
        CAPTURE(run);
        TriangleSoup soup;
        const unsigned side = 2 + static_cast<unsigned>(random() % 8);
        for (int i = 0; i < 12; ++i)
            soup.points.push_back(
                {double(random() % side), double(random() % side), double(random() % 3 ? random() % side : 0)});
        for (int t = 0; t < 14; ++t)
            soup.triangles.push_back({int(random() % 12), int(random() % 12), int(random() % 12)});
        const Pairs expected = oracle(soup);
        some += expected.size();
        REQUIRE(contacts(soup) == expected);
    }
    CHECK(some > 1000);
}

TEST_CASE("contacts are counted, the first listed, the same for any number of threads", "[mesh][contact][property]") {
    // Two waves that cross.
    TriangleSoup soup = grid(60);
    const int n = static_cast<int>(soup.points.size()), m = static_cast<int>(soup.triangles.size());
    for (int i = 0; i < n; ++i)
        soup.points.push_back(soup.points[i] + Eigen::Vector3d(0.013, 0.007, 0.04 * std::sin(i)));
    for (int t = 0; t < m; ++t)
        soup.triangles.push_back({soup.triangles[t][0] + n, soup.triangles[t][1] + n, soup.triangles[t][2] + n});
    const SelfContacts all = find_self_contacts(soup);
    CHECK(all.complete);
    CHECK(all.pairs.count > 1000);
    CHECK(all.pairs.first.size() == Findings<Pair>::kListed);
    CHECK(std::is_sorted(all.pairs.first.begin(), all.pairs.first.end()));
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    CHECK(find_self_contacts(soup).pairs.first == all.pairs.first);
    CHECK(find_self_contacts(soup).pairs.count == all.pairs.count);
}

TEST_CASE("where all lies upon all, the search for contacts ends soon and says that there are more",
          "[mesh][contact][regression]") {
    std::mt19937_64 random(4);
    std::uniform_real_distribution<double> place(0, 1);
    TriangleSoup soup;
    for (int t = 0; t < 6000; ++t) {
        for (int k = 0; k < 3; ++k) soup.points.push_back({place(random), place(random), place(random)});
        soup.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
    const SelfContacts contacts = find_self_contacts(soup);
    CHECK_FALSE(contacts.complete);
    CHECK(contacts.pairs.count > 100'000);
    CHECK(contacts.pairs.first.size() == Findings<SelfContacts::Pair>::kListed);
    CHECK(std::is_sorted(contacts.pairs.first.begin(), contacts.pairs.first.end()));
}

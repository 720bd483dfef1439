// Offenders are counted, put together by place, and each has its cause where the features, the sizes or frozen elements
// force it.
#include "gradus/quality/offenders.hpp"

#include <catch2/catch.hpp>

#include "gradus/quality/shape.hpp"
#include "support/triangulations.hpp"

using namespace gradus;
using Eigen::Vector3d;
using Kind = OffenderCause::Kind;

namespace {

// A flat sector around the origin with rows of edge length 1.
TriangleSoup sector(double degrees, int rows) {
    const double angle = degrees * std::numbers::pi / 180;
    TriangleSoup soup;
    soup.points = {{0, 0, 0}};
    for (int i = 1; i <= rows; ++i) {
        soup.points.push_back({double(i), 0, 0});
        soup.points.push_back({i * std::cos(angle), i * std::sin(angle), 0});
        const int a = 2 * i - 1, b = 2 * i;
        if (i == 1) {
            soup.triangles.push_back({0, a, b});
            continue;
        }
        soup.triangles.push_back({a - 2, a, b});
        soup.triangles.push_back({a - 2, b, b - 2});
    }
    return soup;
}

// The unit square with a vertex of one triangle inside moved next to the opposite side.
struct Needle {
    TriangleSoup soup = triangulations::soup(triangulations::graph(
        10, [](double, double) { return 0; }, 0));
    int triangle = 90;
    Needle() {
        const auto [a, b, c] = soup.triangles[triangle];
        soup.points[c] = 0.5 * (soup.points[a] + soup.points[b]) + 0.05 * (soup.points[c] - soup.points[a]);
    }
};

MeshView view(const TriangleSoup& soup) { return {soup.points, soup.triangles}; }

void check_sums(const TriangleSoup& soup, const OffenderReport& report) {
    Shortfall quality, angle, ratio;
    std::size_t unexplained = 0;
    REQUIRE(report.groups.size() == report.num_groups);
    bool explained_before = false;
    for (const OffenderGroup& g : report.groups) {
        CHECK(g.quality.count + g.angle.count + g.edge_ratio.count > 0);
        quality.count += g.quality.count;
        angle.count += g.angle.count;
        ratio.count += g.edge_ratio.count;
        const bool none = g.cause.kind == Kind::None;
        if (none) unexplained += g.quality.count + g.angle.count + g.edge_ratio.count;
        CHECK_FALSE((none && explained_before));
        explained_before = explained_before || !none;
    }
    CHECK(quality.count == report.quality.count);
    CHECK(angle.count == report.angle.count);
    CHECK(ratio.count == report.edge_ratio.count);
    CHECK(unexplained ==
          report.unexplained_quality.count + report.unexplained_angle.count + report.unexplained_edge_ratio.count);
    std::size_t below = 0;
    double worst = 1;
    for (const auto& [a, b, c] : soup.triangles) {
        const double q = area_length(soup.points[a], soup.points[b], soup.points[c]);
        below += q < report.limits.quality;
        worst = std::min(worst, q);
    }
    CHECK(report.quality.count == below);
    if (below > 0) CHECK(report.quality.worst == worst);
}

}  // namespace

TEST_CASE("a sound sphere has no offenders", "[quality]") {
    const TriangleSoup soup = triangulations::soup(triangulations::sphere(4, 1, 0));
    const OffenderReport report = find_offenders(view(soup));
    CHECK(report.features_known);
    CHECK(report.num_groups == 0);
    CHECK(report.quality.count + report.angle.count + report.edge_ratio.count == 0);
}

TEST_CASE("in a wedge of 10 degrees the corner is the cause", "[quality]") {
    const TriangleSoup soup = sector(10, 6);
    const std::vector<double> sizes(soup.points.size(), 1);
    const OffenderReport report = find_offenders(view(soup), {.sizes = sizes});
    check_sums(soup, report);
    REQUIRE(report.num_groups >= 1);
    CHECK(report.unexplained_quality.count + report.unexplained_edge_ratio.count == 0);
    bool at_tip = false;
    for (const OffenderGroup& g : report.groups) {
        if (g.cause.kind == Kind::None) continue;
        CHECK(g.cause.kind == Kind::NarrowCorner);
        CHECK(g.cause.value == Approx(10));
        CHECK(g.cause.ids[0] == 0);
        CHECK(to_text(g.cause) == "narrow corner of the features: 10 degrees");
        at_tip = at_tip || g.point.norm() < 2;
    }
    CHECK(at_tip);

    // A wide one is no cause.
    const TriangleSoup wide = sector(70, 3);
    for (const OffenderGroup& g : find_offenders(view(wide), {.limits = {.quality = 0.99}}).groups)
        CHECK(g.cause.kind == Kind::None);
}

TEST_CASE("the point of a needle is the cause of its narrow triangles", "[quality]") {
    TriangleSoup soup = triangulations::soup(triangulations::sphere(2, 1, 0));
    soup.points[0] *= 8;
    const KnownFeatures none;
    const OffenderReport report = find_offenders(view(soup), {.features = &none});
    check_sums(soup, report);
    double around = 0;
    std::size_t triangles = 0;
    for (const auto& [a, b, c] : soup.triangles)
        for (const auto& [p, q, r] : {std::array{a, b, c}, std::array{b, c, a}, std::array{c, a, b}})
            if (p == 0)
                ++triangles, around += std::acos((soup.points[q] - soup.points[0])
                                                     .normalized()
                                                     .dot((soup.points[r] - soup.points[0]).normalized()));
    REQUIRE(around < std::acos(0.0));
    CHECK(report.angle.count == triangles);
    CHECK(report.unexplained_angle.count == 0);
    REQUIRE(report.num_groups >= 1);
    for (const OffenderGroup& g : report.groups) {
        CHECK(g.cause.kind == Kind::SharpPoint);
        CHECK(g.cause.value == Approx(90 * around / std::acos(0.0)));
        CHECK(g.cause.ids[0] == 0);
    }
}

TEST_CASE("on a box flatter than the size, corners and edges near each other are the causes", "[quality]") {
    TriangleSoup soup = triangulations::soup(triangulations::cube(4));
    // One row of the sides is left: the rows between are moved to the upper face and welded away by hand.
    TriangleSoup box;
    std::vector<int> number(soup.points.size(), -1);
    for (std::size_t v = 0; v < soup.points.size(); ++v) {
        Vector3d p = soup.points[v];
        if (p.z() > 0 && p.z() < 1) continue;
        p.z() *= 0.1;
        number[v] = static_cast<int>(box.points.size());
        box.points.push_back(p);
    }
    for (const Triangle& t : soup.triangles)
        if (number[t[0]] >= 0 && number[t[1]] >= 0 && number[t[2]] >= 0)
            box.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
    const auto find = [&](double x, double y, double z) {
        for (std::size_t v = 0; v < box.points.size(); ++v)
            if ((box.points[v] - Vector3d(x, y, z)).norm() < 1e-9) return static_cast<int>(v);
        return -1;
    };
    const auto add_side = [&](double x0, double y0, double x1, double y1) {
        const int a = find(x0, y0, 0), b = find(x1, y1, 0), c = find(x1, y1, 0.1), d = find(x0, y0, 0.1);
        box.triangles.push_back({a, b, c});
        box.triangles.push_back({a, c, d});
    };
    for (int i = 0; i < 4; ++i) {
        const double s = i / 4.0, t = s + 0.25;
        add_side(s, 0, t, 0);
        add_side(1, s, 1, t);
        add_side(t, 1, s, 1);
        add_side(0, t, 0, s);
    }
    const std::vector<double> sizes(box.points.size(), 0.25);
    const OffenderReport report = find_offenders(view(box), {.sizes = sizes});
    check_sums(box, report);
    CHECK(report.features_known);
    CHECK(report.angle.count == 32);
    CHECK(report.unexplained_angle.count == 0);
    int corners = 0, curves = 0;
    for (const OffenderGroup& g : report.groups) {
        CAPTURE(to_text(g.cause));
        CHECK((g.cause.kind == Kind::NearCorners || g.cause.kind == Kind::NearCurves));
        CHECK(g.cause.value == Approx(0.4));
        corners += g.cause.kind == Kind::NearCorners;
        curves += g.cause.kind == Kind::NearCurves;
    }
    CHECK(corners == 4);
    CHECK(curves == 4);
    // With sizes that fit, nothing forces the same triangles.
    const std::vector<double> small(box.points.size(), 0.1);
    CHECK(find_offenders(view(box), {.sizes = small}).unexplained_angle.count == 32);
}

TEST_CASE("a needle is its own fault, unless it is frozen", "[quality]") {
    const Needle needle;
    const OffenderReport free = find_offenders(view(needle.soup));
    check_sums(needle.soup, free);
    REQUIRE(free.num_groups == 1);
    CHECK(free.groups[0].cause.kind == Kind::None);
    CHECK(to_text(free.groups[0].cause) == "none found");
    CHECK(free.groups[0].quality.worst < 0.2);
    Vector3d centroid = Vector3d::Zero();
    for (const int v : needle.soup.triangles[needle.triangle]) centroid += needle.soup.points[v] / 3;
    CHECK((free.groups[0].point - centroid).norm() < 1e-12);

    const RequiredElements required{.triangles = {needle.triangle}};
    const OffenderReport frozen = find_offenders(view(needle.soup), {.required = &required});
    check_sums(needle.soup, frozen);
    bool found = false;
    for (const OffenderGroup& g : frozen.groups)
        if (g.quality.count > 0 && g.quality.worst == free.groups[0].quality.worst) {
            CHECK(g.cause.kind == Kind::Frozen);
            CHECK(to_text(g.cause) == "frozen element");
            found = true;
        }
    CHECK(found);
}

TEST_CASE("elements that grow from between two close corners to the size have these as their cause", "[quality]") {
    // A sheet of elements of .1 with two corners .001 apart, and a needle that touches neither.
    const int n = 10;
    TriangleSoup sheet = triangulations::soup(testing::square(n));
    const auto at = [&](int i, int j) {
        return static_cast<int>(std::find_if(sheet.points.begin(), sheet.points.end(),
                                             [&](const Vector3d& p) {
                                                 return (p - Vector3d(i / double(n), j / double(n), 0)).norm() < 1e-9;
                                             }) -
                                sheet.points.begin());
    };
    const int corner = at(4, 0), other = at(5, 0), above = at(4, 1), beyond = at(4, 2);
    sheet.points[other].x() = 0.401;
    sheet.points[above].y() = 0.08;
    sheet.points[beyond].y() = 0.085;
    const std::vector<double> sizes(sheet.points.size(), 0.1);
    const std::array<int, 2> corners{corner, other};
    const KnownFeatures with{.corners = corners}, without{};
    std::size_t unexplained = 0;
    for (const bool known : {true, false}) {
        const OffenderReport report =
            find_offenders(view(sheet), {.sizes = sizes, .features = known ? &with : &without});
        for (const OffenderGroup& g : report.groups)
            if (g.cause.kind == Kind::NearCorners) CHECK(g.cause.value == Approx(0.01));
        if (known)
            unexplained = report.unexplained_angle.count;
        else
            CHECK(report.unexplained_angle.count > unexplained + 3);
    }
    // Farther off than the size nothing is theirs.
    sheet.points[at(4, 8)].y() = 0.705;
    CHECK(find_offenders(view(sheet), {.sizes = sizes, .features = &with}).unexplained_angle.count > unexplained);
}

TEST_CASE("sizes that jump are a cause", "[quality]") {
    TriangleSoup soup = triangulations::soup(triangulations::graph(
        8, [](double, double) { return 0; }, 0));
    std::vector<double> sizes;
    for (Vector3d& p : soup.points) {
        sizes.push_back(p.x() < 0.45 ? 0.125 : 0.5);
        if (p.x() > 0.45) p.x() = 0.45 + 5 * (p.x() - 0.45);
    }
    const OffenderReport jump = find_offenders(view(soup), {.sizes = sizes});
    check_sums(soup, jump);
    bool found = false;
    for (const OffenderGroup& g : jump.groups)
        if (g.cause.kind == Kind::SizeJump) {
            CHECK(g.cause.value == Approx(4));
            found = true;
        }
    CHECK(found);
    CHECK_THROWS_AS(find_offenders(view(soup), {.sizes = std::span(sizes).first(3)}), std::invalid_argument);
}

TEST_CASE("the edge of a plate that is thinner than the elements is a cause", "[quality]") {
    // A closed sheet: two layers .002 apart with steps of .1, their rim a row of quadrilaterals.
    constexpr int n = 10;
    TriangleSoup soup;
    const auto at = [](int i, int j, int side) { return 2 * (i * (n + 1) + j) + side; };
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n; ++j)
            for (const int side : {0, 1}) soup.points.emplace_back(0.1 * i, 0.1 * j, side == 0 ? -0.001 : 0.001);
    const auto add = [&](int a, int b, int c, int d) {
        soup.triangles.push_back({a, b, c});
        soup.triangles.push_back({a, c, d});
    };
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            add(at(i, j, 1), at(i + 1, j, 1), at(i + 1, j + 1, 1), at(i, j + 1, 1));
            add(at(i, j, 0), at(i, j + 1, 0), at(i + 1, j + 1, 0), at(i + 1, j, 0));
        }
    // The rim leans out, so that the surface turns by more than 90 degrees there.
    for (int k = 0; k < n; ++k) {
        add(at(k, 0, 0), at(k + 1, 0, 0), at(k + 1, 0, 1), at(k, 0, 1));
        add(at(k + 1, n, 0), at(k, n, 0), at(k, n, 1), at(k + 1, n, 1));
        add(at(0, k + 1, 0), at(0, k, 0), at(0, k, 1), at(0, k + 1, 1));
        add(at(n, k, 0), at(n, k + 1, 0), at(n, k + 1, 1), at(n, k, 1));
    }
    for (std::size_t v = 0; v < soup.points.size(); v += 2) soup.points[v].x() *= 1.01;
    const KnownFeatures none;
    const std::vector<double> sizes(soup.points.size(), 0.1);
    const OffenderReport report = find_offenders(view(soup), {.sizes = sizes, .features = &none});
    check_sums(soup, report);
    CHECK(report.quality.count >= 8 * n);
    const auto is_turn = [](const OffenderGroup& g) { return g.cause.kind == Kind::SharpTurn && g.cause.value > 90; };
    CHECK(std::any_of(report.groups.begin(), report.groups.end(), is_turn));
}

TEST_CASE("offenders of what is no manifold are found, their causes are not", "[quality]") {
    TriangleSoup soup = sector(10, 3);
    std::swap(soup.triangles[2][0], soup.triangles[2][1]);
    const OffenderReport report = find_offenders(view(soup));
    CHECK_FALSE(report.features_known);
    CHECK(report.angle.count > 0);
    CHECK(report.unexplained_angle.count == report.angle.count);
    CHECK(find_offenders({}).num_groups == 0);
}

TEST_CASE("no more places are listed than asked for, the worst of them", "[quality]") {
    TriangleSoup soup;
    for (int i = 0; i < 5; ++i) {
        const int n = static_cast<int>(soup.points.size());
        soup.points.insert(soup.points.end(),
                           {{10.0 * i, 0, 0}, {10.0 * i + 1, 0, 0}, {10.0 * i + 0.5, 0.05 + 0.01 * i, 0}});
        soup.triangles.push_back({n, n + 1, n + 2});
    }
    const KnownFeatures none;
    const OffenderReport report = find_offenders(view(soup), {.features = &none, .most = 2});
    CHECK(report.num_groups == 5);
    REQUIRE(report.groups.size() == 2);
    CHECK(report.groups[0].point.x() < 2);
    CHECK(report.quality.count == 5);
}

TEST_CASE(
    "a tube that is narrower than its elements leaves them no room, in the middle of a wide one nothing forces a "
    "needle",
    "[quality]") {
    const KnownFeatures none;
    const int sides = GENERATE(3, 12);
    const double radius = 0.15 * sides / 3;
    TriangleSoup soup = triangulations::soup(testing::grid(sides, 8, true, false, [&](double u, double v) {
        const double a = 2 * std::numbers::pi * u;
        return Vector3d(radius * std::cos(a), radius * std::sin(a), 8 * v);
    }));
    const std::vector<double> sizes(soup.points.size(), 1.0);
    const OffenderReport report = find_offenders(view(soup), {.sizes = sizes, .features = &none});
    check_sums(soup, report);
    CHECK(report.angle.count == soup.triangles.size());
    std::size_t in_loops = 0;
    for (const OffenderGroup& g : report.groups) {
        if (g.cause.kind != Kind::NarrowLoop) continue;
        in_loops += g.angle.count;
        CHECK(g.cause.value == Approx(3 * std::sqrt(3) * radius));
    }
    // At the ends corners are near each other.
    CHECK(in_loops == (sides == 3 ? soup.triangles.size() - 12 : 0));
    CHECK(report.unexplained_angle.count == (sides == 3 ? 0 : soup.triangles.size()));
}

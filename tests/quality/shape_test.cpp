#include "gradus/quality/shape.hpp"

#include "quality/meshes.hpp"

#include <Eigen/Dense>
#include <catch2/catch.hpp>

using namespace gradus;
using namespace gradus::testing;
using Eigen::Vector3d;

namespace {

constexpr double kPi = std::numbers::pi;

/// Radius of the circle through three points, its centre from the linear equations of equal distance.
double circumradius(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
    Eigen::Matrix3d rows;
    rows << 2 * (b - a).transpose(), 2 * (c - a).transpose(), (b - a).cross(c - a).transpose();
    const Vector3d right(b.squaredNorm() - a.squaredNorm(), c.squaredNorm() - a.squaredNorm(),
                         (b - a).cross(c - a).dot(a));
    return (rows.fullPivLu().solve(right) - a).norm();
}

/// Radius of the inscribed circle: distance of its centre, the mean of the corners weighted by opposite sides, to a
/// side.
double inradius(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
    const double la = (b - c).norm(), lb = (c - a).norm(), lc = (a - b).norm();
    const Vector3d centre = (la * a + lb * b + lc * c) / (la + lb + lc);
    return Eigen::ParametrizedLine<double, 3>::Through(a, b).distance(centre);
}

double area(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
    return Eigen::ParametrizedLine<double, 3>::Through(a, b).distance(c) * (a - b).norm() / 2;
}

}  // namespace

TEST_CASE("the measures are one for an equilateral triangle of any size and place", "[quality][exact]") {
    const double size = GENERATE(1., 1e-3, 1e7, 1e-120, 1e-200, 1e140, 1e200);
    const Vector3d a(0, 0, 0), b(size, 0, 0), c(size / 2, 0, size * std::sqrt(3.) / 2);
    CHECK(area_length(a, b, c) == Approx(1).epsilon(1e-12));
    CHECK(inradius_edge(a, b, c) == Approx(1).epsilon(1e-12));
    CHECK(radius_ratio(b, c, a) == Approx(1).epsilon(1e-12));
    for (int k = 0; k < 3; ++k) CHECK(corner_angle(sides_of(a, b, c), k) == Approx(kPi / 3));
}

TEST_CASE("the measures of right-angled triangles have closed forms", "[quality][exact]") {
    const Vector3d o(1, 1, 1);
    SECTION("isosceles") {
        const Vector3d b = o + Vector3d(2, 0, 0), c = o + Vector3d(0, 2, 0);
        CHECK(area_length(o, b, c) == Approx(std::sqrt(3.) / 2));
        CHECK(inradius_edge(o, b, c) == Approx(2 * std::sqrt(3.) * (2 - std::sqrt(2.)) / (2 * std::sqrt(2.))));
        CHECK(radius_ratio(o, b, c) == Approx(2 * (std::sqrt(2.) - 1)));
        CHECK(corner_angle(sides_of(o, b, c), 0) == Approx(kPi / 2));
        CHECK(corner_angle(sides_of(o, b, c), 1) == Approx(kPi / 4));
    }
    SECTION("3 4 5") {
        const Vector3d b = o + Vector3d(3, 0, 0), c = o + Vector3d(0, 0, 4);  // area 6, r = 1, R = 2.5
        CHECK(area_length(o, b, c) == Approx(4 * std::sqrt(3.) * 6 / 50));
        CHECK(inradius_edge(o, b, c) == Approx(2 * std::sqrt(3.) / 5));
        CHECK(radius_ratio(o, b, c) == Approx(.8));
    }
}

TEST_CASE("the measures of degenerate triangles are zero, never not-a-number", "[quality][exact]") {
    const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
    using Corners = std::array<Vector3d, 3>;
    const Corners t =
        GENERATE_COPY(values<Corners>({{Vector3d(1, 2, 3), Vector3d(1, 2, 3), Vector3d(1, 2, 3)},
                                       {Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(1, 0, 0)},
                                       {Vector3d(0, 0, 0), Vector3d(1, 1, 1), Vector3d(2, 2, 2)},
                                       {Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(nan, 1, 0)},
                                       {Vector3d(0, 0, 0), Vector3d(infinity, 0, 0), Vector3d(1, 1, 0)}}));
    for (int k = 0; k < 3; ++k) {
        CHECK(area_length(t[k], t[(k + 1) % 3], t[(k + 2) % 3]) == 0);
        CHECK(inradius_edge(t[k], t[(k + 1) % 3], t[(k + 2) % 3]) == 0);
        CHECK(radius_ratio(t[k], t[(k + 1) % 3], t[(k + 2) % 3]) == 0);
        CHECK_FALSE(std::isnan(corner_angle(sides_of(t[0], t[1], t[2]), k)));
    }
}

TEST_CASE("the measures agree with circles found by brute force", "[quality][property]") {
    std::mt19937 random(11);
    std::normal_distribution<double> normal;
    for (int i = 0; i < 500; ++i) {
        const auto point = [&] { return Vector3d(normal(random), normal(random), normal(random)); };
        const Vector3d a = point(), b = point(), c = point();
        const double squares = (a - b).squaredNorm() + (b - c).squaredNorm() + (c - a).squaredNorm();
        const double longest = std::max({(a - b).norm(), (b - c).norm(), (c - a).norm()});
        CHECK(area_length(a, b, c) == Approx(4 * std::sqrt(3.) * area(a, b, c) / squares));
        CHECK(inradius_edge(a, b, c) == Approx(2 * std::sqrt(3.) * inradius(a, b, c) / longest));
        CHECK(radius_ratio(a, b, c) == Approx(2 * inradius(a, b, c) / circumradius(a, b, c)));
        const TriangleSides s = sides_of(a, b, c);
        CHECK(corner_angle(s, 0) + corner_angle(s, 1) + corner_angle(s, 2) == Approx(kPi));
        CHECK(corner_angle(s, 0) == Approx(std::acos((b - a).normalized().dot((c - a).normalized()))));
    }
}

TEST_CASE("shape does not depend on place, size or labels", "[quality][property]") {
    const Mesh mesh = shaken(torus(20, 9), .1, 3);
    const Mesh other = relabelled(moved(mesh, GENERATE(1e-6, 1., 4e5)), 5);
    const ShapeReport a = measure_shape(mesh.view(), edges_of(mesh.view())),
                      b = measure_shape(other.view(), edges_of(other.view()));
    const auto check = [](const Summary& x, const Summary& y) {
        CHECK(x.count == y.count);
        for (const auto member : {&Summary::min, &Summary::p001, &Summary::p01, &Summary::median, &Summary::mean,
                                  &Summary::p99, &Summary::p999, &Summary::max})
            CHECK(x.*member == Approx(y.*member).epsilon(1e-9));
    };
    check(a.area_length, b.area_length);
    check(a.inradius_edge, b.inradius_edge);
    check(a.radius_ratio, b.radius_ratio);
    check(a.smallest_angle, b.smallest_angle);
    check(a.largest_angle, b.largest_angle);
    check(a.adjacent_edge_ratio, b.adjacent_edge_ratio);
    check(a.interior_valence, b.interior_valence);
    CHECK(a.worst.front().value == a.area_length.min);
    CHECK(a.area_length.min <= a.area_length.p01);
    CHECK(a.area_length_histogram.total() == mesh.triangles.size());
}

TEST_CASE("valences and adjacent edges of a square grid", "[quality][exact]") {
    const Mesh mesh = square(8);
    const ShapeReport report = measure_shape(mesh.view(), edges_of(mesh.view()));
    CHECK(report.interior_valence_6 == 1);
    CHECK(report.valence_6 == Approx(49. / 81));
    CHECK(report.interior_valence.count == 49);
    CHECK(report.boundary_valence.min == 2);
    CHECK(report.boundary_valence.max == 4);
    CHECK(report.valence_histogram.counts[3] == 49);
    CHECK(report.adjacent_edge_ratio.median == Approx(std::sqrt(2.)));
    CHECK(report.smallest_angle.max == Approx(45));
    CHECK(report.largest_angle.min == Approx(90));
    CHECK(report.degenerate == 0);
}

TEST_CASE("an edge of no length has an infinite ratio to its neighbours", "[quality]") {
    const Mesh mesh{{{0, 0, 0}, {0, 0, 0}, {1, 0, 0}}, {{0, 1, 2}}};
    const ShapeReport report = measure_shape(mesh.view(), edges_of(mesh.view()));
    CHECK(std::isinf(report.adjacent_edge_ratio.max));
    CHECK(report.degenerate == 1);
}

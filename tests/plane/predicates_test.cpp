#include "gradus/plane/predicates.hpp"

#include <boost/multiprecision/cpp_int.hpp>
#include <catch2/catch.hpp>
#include <random>

using namespace gradus;
using Eigen::Vector2d;
using Rational = boost::multiprecision::cpp_rational;

namespace {

int rational_orient(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
    const Rational det = (Rational(a.x()) - Rational(c.x())) * (Rational(b.y()) - Rational(c.y())) -
                         (Rational(a.y()) - Rational(c.y())) * (Rational(b.x()) - Rational(c.x()));
    return det.sign();
}

int rational_incircle(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d) {
    const auto x = [&](const Vector2d& p) { return Rational(Rational(p.x()) - Rational(d.x())); };
    const auto y = [&](const Vector2d& p) { return Rational(Rational(p.y()) - Rational(d.y())); };
    const auto lift = [&](const Vector2d& p) { return Rational(x(p) * x(p) + y(p) * y(p)); };
    const auto cross = [&](const Vector2d& p, const Vector2d& q) { return Rational(x(p) * y(q) - x(q) * y(p)); };
    return Rational(lift(a) * cross(b, c) + lift(b) * cross(c, a) + lift(c) * cross(a, b)).sign();
}

}  // namespace

TEST_CASE("orient2d agrees with rational arithmetic on nearly collinear points", "[predicates][exact]") {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> unit(-1, 1);
    std::uniform_int_distribution<int> ulps(-2, 2);
    const double scale = GENERATE(1.0, 1e-6, 1e6, 1e-30);
    int signs[3] = {0, 0, 0};
    for (int i = 0; i < 4000; ++i) {
        const Vector2d offset = i % 2 ? Vector2d(12.5, -3.25) : Vector2d(0, 0);
        const Vector2d a = scale * (Vector2d(unit(random), unit(random)) + offset),
                       direction(unit(random), unit(random));
        const Vector2d b = a + scale * direction;
        Vector2d c = a + scale * (i % 3 ? unit(random) : 0.5) * direction;
        for (int k = 0; k < std::abs(ulps(random)); ++k) c.x() = std::nextafter(c.x(), 1e9);
        const int expected = rational_orient(a, b, c);
        ++signs[expected + 1];
        REQUIRE(orient2d(a, b, c) == expected);
        REQUIRE(orient2d(b, c, a) == expected);
        REQUIRE(orient2d(b, a, c) == -expected);
    }
    CHECK(signs[0] > 100);
    CHECK(signs[2] > 100);
}

TEST_CASE("incircle agrees with rational arithmetic on nearly cocircular points", "[predicates][exact]") {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> angle(0, 6.283185307179586);
    const double scale = GENERATE(1.0, 1e-6, 1e6);
    int decided = 0;
    for (int i = 0; i < 1500; ++i) {
        const Vector2d centre = i % 2 ? Vector2d(0, 0) : Vector2d(scale * 31.7, scale * 0.1);
        Vector2d p[4];
        for (Vector2d& q : p) {
            const double t = angle(random);
            q = centre + scale * Vector2d(std::cos(t), std::sin(t));
        }
        if (rational_orient(p[0], p[1], p[2]) < 0) std::swap(p[0], p[1]);
        if (rational_orient(p[0], p[1], p[2]) == 0) continue;
        const int expected = rational_incircle(p[0], p[1], p[2], p[3]);
        decided += expected != 0;
        REQUIRE(incircle(p[0], p[1], p[2], p[3]) == expected);
        REQUIRE(incircle(p[1], p[2], p[0], p[3]) == expected);
    }
    CHECK(decided > 1000);
}

TEST_CASE("Predicates are zero exactly on lines and circles", "[predicates][exact]") {
    CHECK(orient2d({0.1, 0.1}, {0.2, 0.2}, {0.7, 0.7}) == 0);
    CHECK(incircle({0, 0}, {1, 0}, {1, 1}, {0, 1}) == 0);
    CHECK(incircle({5, 0}, {4, 3}, {-3, 4}, {0, -5}) == 0);
    CHECK(incircle({0, 0}, {1, 0}, {1, 1}, {0.5, 0.5}) == 1);
    CHECK(incircle({0, 0}, {1, 0}, {1, 1}, {0, 1.0000000000000002}) == -1);
}

#include "gradus/control/sizing.hpp"

#include <catch2/catch.hpp>

#include <cmath>
#include <limits>
#include <numbers>

using namespace gradus;

namespace {

using Kind = SizingRule::Kind;
constexpr double inf = std::numeric_limits<double>::infinity();

SizingRule rule_of(Kind kind, double value, double hmin = 0, double hmax = inf) {
    SizingRule rule;
    rule.kind = kind;
    rule.value = value;
    rule.hmin = hmin;
    rule.hmax = hmax;
    return rule;
}

}  // namespace

TEST_CASE("The chord of the size asked for has the error asked for on a circle", "[control][exact]") {
    const double rho = GENERATE(1e-6, 0.3, 1., 70.);
    // Gap of a chord of length h under its arc: rho - sqrt(rho^2 - h^2 / 4).
    const auto gap = [&](double h) { return rho - std::sqrt(rho * rho - h * h / 4); };
    for (const double share : {0.01, 0.1, 0.5, 1.}) {
        CHECK(gap(size_from_radius(rule_of(Kind::RelativeChordError, share), rho)) ==
              Approx(share * rho).epsilon(1e-9));
        CHECK(gap(size_from_radius(rule_of(Kind::ChordError, share * rho), rho)) == Approx(share * rho).epsilon(1e-9));
    }
    for (const double angle : {0.1, 0.5, 1., std::numbers::pi}) {
        const double h = size_from_radius(rule_of(Kind::NormalAngle, angle), rho);
        CHECK(2 * std::asin(h / (2 * rho)) == Approx(angle).epsilon(1e-7));
    }
    CHECK(size_from_radius(rule_of(Kind::Proportional, 0.3), rho) == 0.3 * rho);
    // A circle below the error is spanned by its diameter.
    CHECK(size_from_radius(rule_of(Kind::ChordError, 2 * rho), rho) == 2 * rho);
    // With a bound on the turn by the side of the hexagon.
    SizingRule bounded = rule_of(Kind::ChordError, 2 * rho);
    bounded.most_turn = std::numbers::pi / 3;
    CHECK(size_from_radius(bounded, rho) == Approx(rho).epsilon(1e-14));
    bounded.value = 0.01 * rho;
    CHECK(size_from_radius(bounded, rho) == size_from_radius(rule_of(Kind::ChordError, 0.01 * rho), rho));
}

TEST_CASE("Sizes stay within their bounds", "[control][property]") {
    for (const Kind kind : {Kind::Proportional, Kind::RelativeChordError, Kind::ChordError, Kind::NormalAngle}) {
        const SizingRule rule = rule_of(kind, 0.3, 0.01, 2);
        CHECK(size_from_radius(rule, 0) == 0.01);
        CHECK(size_from_radius(rule, inf) == 2);
        CHECK(size_from_radius(rule_of(kind, 0.3), inf) == inf);
        double before = 0;
        for (double rho = 1e-4; rho < 1e4; rho *= 1.3) {
            const double h = size_from_radius(rule, rho);
            CHECK(h >= before);
            before = h;
        }
    }
}

TEST_CASE("Rules out of range are refused by name", "[control]") {
    const auto refused = [](const SizingRule& rule, const std::string& name) {
        CHECK_THROWS_AS(check(rule), std::invalid_argument);
        CHECK_THROWS_WITH(check(rule), Catch::Contains(name));
    };
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const double bad : {0., -1., nan, inf}) {
        refused(rule_of(Kind::Proportional, bad), "alpha");
        refused(rule_of(Kind::ChordError, bad), "chord error");
    }
    for (const double bad : {0., -1., nan, 1.01})
        refused(rule_of(Kind::RelativeChordError, bad), "relative chord error");
    for (const double bad : {0., -1., nan, 3.2}) refused(rule_of(Kind::NormalAngle, bad), "normal angle");
    refused(rule_of(Kind::Proportional, 1, -1), "hmin");
    refused(rule_of(Kind::Proportional, 1, nan), "hmin");
    refused(rule_of(Kind::Proportional, 1, 0, 0), "hmax");
    refused(rule_of(Kind::Proportional, 1, 2, 1), "hmin");
    SizingRule rule;
    rule.at = {{Eigen::Vector3d(0, nan, 0), 1}};
    refused(rule, "coordinate");
    rule.at = {{Eigen::Vector3d(0, 0, -1e101), 1}};
    refused(rule, "coordinate");
    rule.at = {{Eigen::Vector3d::Zero(), 0}};
    refused(rule, "prescribed size");
    CHECK_NOTHROW(check(SizingRule{}));
}

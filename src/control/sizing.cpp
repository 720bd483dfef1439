#include "gradus/control/sizing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace gradus {

namespace {

constexpr double kLargestCoordinate = 1e100;  // beyond it squares of distances are no numbers

}  // namespace

void check(const SizingRule& rule) {
    const auto require = [](bool holds, const std::string& name, double value, const std::string& range) {
        if (!holds) throw std::invalid_argument(fmt::format("sizing: {} = {:g} must be {}", name, value, range));
    };
    switch (rule.kind) {
        case SizingRule::Kind::Proportional:
            require(rule.value > 0 && std::isfinite(rule.value), "alpha", rule.value, "positive");
            break;
        case SizingRule::Kind::RelativeChordError:
            require(rule.value > 0 && rule.value <= 1, "relative chord error", rule.value, "in (0, 1]");
            break;
        case SizingRule::Kind::ChordError:
            require(rule.value > 0 && std::isfinite(rule.value), "chord error", rule.value, "positive");
            break;
        case SizingRule::Kind::NormalAngle:
            require(rule.value > 0 && rule.value <= std::numbers::pi, "normal angle (radians)", rule.value,
                    "in (0, pi]");
            break;
    }
    require(rule.most_turn > 0 && rule.most_turn <= std::numbers::pi, "most turn (radians)", rule.most_turn,
            "in (0, pi]");
    require(rule.hmin >= 0 && std::isfinite(rule.hmin), "hmin", rule.hmin, "0 or more");
    require(rule.hmax > 0, "hmax", rule.hmax, "positive");
    require(rule.hmin <= rule.hmax, "hmin", rule.hmin, "no larger than hmax = " + std::to_string(rule.hmax));
    for (const SizingRule::At& at : rule.at) {
        for (const double x : at.point)
            require(std::abs(x) <= kLargestCoordinate, "a coordinate of a prescribed size", x, "within 1e100");
        require(at.size > 0 && std::isfinite(at.size), "a prescribed size", at.size, "positive");
    }
    require(rule.feature_clearance >= 0 && std::isfinite(rule.feature_clearance), "feature clearance",
            rule.feature_clearance, "0 or more");
    require(rule.sheet_clearance >= 0 && std::isfinite(rule.sheet_clearance), "sheet clearance", rule.sheet_clearance,
            "0 or more");
    for (const SizingRule::Region& region : rule.regions)
        require(region.size > 0 && std::isfinite(region.size), "the size of a label", region.size, "positive");
}

double size_from_radius(const SizingRule& rule, double rho) {
    double h = 0;
    switch (rule.kind) {
        case SizingRule::Kind::Proportional:
            h = rule.value * rho;
            break;
        case SizingRule::Kind::RelativeChordError:
            h = 2 * rho * std::sqrt(rule.value * (2 - rule.value));
            break;
        // A circle smaller than the error allowed is spanned by its diameter.
        case SizingRule::Kind::ChordError:
            h = rho > rule.value ? 2 * std::sqrt(rule.value * (2 * rho - rule.value)) : 2 * rho;
            break;
        case SizingRule::Kind::NormalAngle:
            h = 2 * rho * std::sin(rule.value / 2);
            break;
    }
    if (rule.most_turn < std::numbers::pi) h = std::min(h, 2 * rho * std::sin(rule.most_turn / 2));
    return std::clamp(h, rule.hmin, rule.hmax);
}

std::size_t nearest_point(std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& to) {
    const auto nearest =
        std::min_element(points.begin(), points.end(), [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
            return (a - to).squaredNorm() < (b - to).squaredNorm();
        });
    return static_cast<std::size_t>(nearest - points.begin());
}

void lower_to_prescribed(std::span<const SizingRule::At> prescribed, std::span<const Eigen::Vector3d> points,
                         std::vector<double>& sizes) {
    for (const SizingRule::At& at : prescribed) {
        double& h = sizes[nearest_point(points, at.point)];
        h = std::min(h, at.size);
    }
}

}  // namespace gradus

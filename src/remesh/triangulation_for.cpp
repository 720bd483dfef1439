#include "gradus/remesh/triangulation_for.hpp"

#include <algorithm>

#include "gradus/control/crowded_creases.hpp"
#include "gradus/remesh/chord_error.hpp"

namespace gradus {

namespace {

constexpr double kLargestNoise =
    0.001;  // of the diagonal: creases that stand out by more are meant, however large a chord error is asked for
constexpr int kMostRounds = 4;  // of taking away creases that leave no room
constexpr double kLargestSag =
    3;  // chord errors, of a round over its facets: more asks for elements a third as large as these
constexpr double kNearFaults = 3;  // chord errors, or of what creases stand out by

}  // namespace

std::unique_ptr<Triangulation> triangulation_for(TriangleSoup soup, const SizingRule& rule,
                                                 TriangulationOptions options,
                                                 std::span<const Eigen::Vector3d> places) {
    const bool has_limit = rule.kind == SizingRule::Kind::ChordError;
    const double most = kLargestNoise * diagonal_of(soup);
    options.features.scale = has_limit ? std::min(rule.value, most) : most;
    options.features.places.assign(places.begin(), places.end());
    options.features.reach = kNearFaults * (has_limit ? rule.value : most);
    options.finest = rule.hmin_by_part && has_limit ? kFinestSize * rule.hmin : rule.hmin;
    options.finest_by_part = rule.hmin_by_part;
    if (has_limit) {
        options.features.largest_sag = kLargestSag * rule.value;
        options.negligible_height = rule.value;
        // Curvatures that ask for elements larger than any allowed need no precision.
        options.least_curvature = 8 * rule.value / (rule.hmax * rule.hmax);
    }
    const SizingRule sizes = has_limit ? rule_within(rule.value, rule) : rule;
    for (int round = 1;; ++round) {
        auto surface = std::make_unique<Triangulation>(std::move(soup), options);
        const std::vector<std::array<int, 2>> crowded = crowded_creases(*surface, sizes);
        if (crowded.empty() || round == kMostRounds) return surface;
        options.features.no_creases.insert(options.features.no_creases.end(), crowded.begin(), crowded.end());
        soup = surface->soup();
    }
}

}  // namespace gradus

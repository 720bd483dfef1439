/// Creases that leave no room for good elements, where nothing but the angles between facets speaks for them.
#pragma once

#include "gradus/control/sizing.hpp"
#include "gradus/control/triangulation.hpp"

#include <array>
#include <vector>

namespace gradus {

/// Of two feature curves that leave a corner at less than 30 degrees, seen from a size away, the shorter one that is
/// not certain (see FeatureChain), from the corner to where it is a size away from the other; and curves that are not
/// certain, with a free end or between others, that are shorter than a size. Sizes are those of the rule for the
/// curvature.
/// @returns edges by their ends, for FeatureOptions::no_creases
std::vector<std::array<int, 2>> crowded_creases(const Triangulation& surface, const SizingRule& rule);

}  // namespace gradus

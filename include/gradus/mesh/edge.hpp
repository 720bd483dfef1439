/// Edges by their ends.
#pragma once

#include <algorithm>
#include <array>

namespace gradus {

/// The edge between two vertices, whichever way it runs: the smaller one first.
inline std::array<int, 2> edge_between(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

}  // namespace gradus

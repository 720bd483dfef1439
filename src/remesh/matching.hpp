// Matchings of graphs. C++17: the library behind it is not made for C++20.
#pragma once

#include <array>
#include <vector>

namespace gradus::detail {

// The matching of largest weight. @param weights  > 0, one per edge, of at most a few million
// @returns for each node the one that it is matched with, or -1
std::vector<int> heaviest_matching(int nodes, const std::vector<std::array<int, 2>>& edges,
                                   const std::vector<long>& weights);

}  // namespace gradus::detail

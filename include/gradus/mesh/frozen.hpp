/// Which parts of a mesh are to stay as they are.
#pragma once

#include "gradus/mesh/connectivity.hpp"
#include "gradus/mesh/soup.hpp"

#include <Eigen/Core>
#include <span>
#include <vector>

namespace gradus {

/// Required elements with all they are made of. Empty vectors where nothing is required.
struct Frozen {
    std::vector<char> vertex;     ///< per vertex
    std::vector<char> half_edge;  ///< per half-edge, the same on both halves of an edge
    std::vector<char> triangle;   ///< per triangle

    bool empty() const { return vertex.empty(); }
    bool has_vertex(int v) const { return !empty() && vertex[v]; }
    bool has_edge(int h) const { return !empty() && half_edge[h]; }
};

/// Edges that no operation may touch have tags from here on: this plus one plus their own.
inline constexpr int kFrozenTag = 1 << 30;
inline bool is_frozen_tag(int tag) { return tag >= kFrozenTag; }
inline int frozen_tag(int tag) { return kFrozenTag + 1 + tag; }
inline int thawed_tag(int tag) { return is_frozen_tag(tag) ? tag - kFrozenTag - 1 : tag; }

/// @throws std::invalid_argument naming the first that cannot be kept, with its place: an index out of range, a vertex
/// in no
///         triangle, an edge that is no side of a triangle, an edge without length, a triangle without area
Frozen frozen_elements(std::span<const Eigen::Vector3d> points, const Connectivity& mesh,
                       const RequiredElements& required);

/// Mean length of the frozen edges at each vertex; 0 where there is none. Empty where nothing is frozen.
std::vector<double> frozen_edge_lengths(std::span<const Eigen::Vector3d> points, const Connectivity& mesh,
                                        const Frozen& frozen);

}  // namespace gradus

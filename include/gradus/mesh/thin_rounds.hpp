/// Rounds between flat faces that a mesh is to pass over.
///
/// Where the elements cannot follow a round, because it leaves the planes beside it by less than these may leave the
/// surface, or because it is narrower than the smallest of them, its middle is a ridge, and nothing of it asks for a
/// size. Where such rounds meet at a corner, their ridges meet in one of its vertices.
#pragma once

#include "gradus/mesh/flats.hpp"

#include <array>
#include <vector>

namespace gradus {

struct ThinRounds {
    std::vector<std::array<int, 2>> ridges;  ///< edges in the middle of each, by their ends
    std::vector<std::array<int, 2>> others;  ///< those along it beside the middle: no features
    std::vector<char> has_triangle;          ///< whether a triangle is part of one; empty where there are none at all

    bool has(int triangle) const { return !has_triangle.empty() && has_triangle[triangle]; }
};

/// Strips of planes between two flat faces, across which the surface turns one way, no more than a round from strip to
/// strip.
/// @param height    a round is thin if its middle leaves the planes beside it by no more, unit of length, >= 0
/// @param width     or if it is no wider than this, from flat face to flat face over its strips; one for each vertex
ThinRounds find_thin_rounds(std::span<const Eigen::Vector3d> points, const Connectivity& mesh,
                            const PlanarRegions& regions, const FlatFaces& flats, double height,
                            std::span<const double> width);

}  // namespace gradus

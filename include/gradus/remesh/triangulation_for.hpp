/// A triangulation as meshes of certain sizes are to keep it.
#pragma once

#include "gradus/control/sizing.hpp"
#include "gradus/control/triangulation.hpp"

#include <memory>
#include <span>

namespace gradus {

/// The surface of a soup with the features that elements of the rule's sizes can follow: creases that stand out from
/// the noise, rounds that would take elements far smaller than a chord error as ridges, none that leave no room for
/// elements where only angles speak for them (crowded_creases), and nothing that is negligible (see
/// TriangulationOptions). With a rule of another kind than ChordError there is no chord error, and the smallest size
/// alone says what is negligible.
/// @param options  what is left to the caller: angles, labels; the rest follows from the rule
/// @param places   near which all folds are features, as where a mesh was too far from the surface or touched itself
/// @throws std::invalid_argument as Triangulation does
std::unique_ptr<Triangulation> triangulation_for(TriangleSoup soup, const SizingRule& rule,
                                                 TriangulationOptions options = {},
                                                 std::span<const Eigen::Vector3d> places = {});

}  // namespace gradus

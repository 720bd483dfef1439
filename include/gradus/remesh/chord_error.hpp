/// Meshes a triangulated surface so that mesh and surface stay within a chord error of each other, everywhere and both
/// ways. The one header of this room that sees quality, since what is measured drives it.
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "gradus/control/triangulation.hpp"
#include "gradus/gradation/grade.hpp"
#include "gradus/quality/deviation.hpp"
#include "gradus/quality/new_contacts.hpp"
#include "gradus/remesh/triangulated.hpp"

namespace gradus {

/// A rule for the sizes to begin with. Triangles are farther from the surface than their edges are, so edges are to
/// keep a part of the chord error only; and they are to turn little where a round is smaller than it.
/// @param chord_error  unit of length, > 0
/// @param rule         what else holds: hmin, hmax and so on; its kind, value and most_turn are replaced
SizingRule rule_within(double chord_error, SizingRule rule = {});

/// The least chord error that distances between points can be held to in double precision: 1e-10 of their largest
/// coordinate.
double least_chord_error(std::span<const Eigen::Vector3d> points);

struct ChordErrorOptions {
    std::optional<GradationOptions> gradation =
        {};           ///< that sizes have, and have again once they were lowered; without required sizes
    double hmin = 0;  ///< sizes are lowered no farther, unit of length, >= 0
    std::vector<SizingRule::At> prescribed = {};  ///< sizes at points, which no mesh on the way is to lose
    RemeshOptions remesh = {};
    std::function<void(const SurfaceMesh&)> on_check =
        {};  ///< called with each mesh that is going to be checked, with some twice
};

/// A size map with the mesh it is on.
struct LoweredMap {
    std::vector<Eigen::Vector3d> points;
    std::vector<Triangle> triangles;
    std::vector<double> sizes;
};

struct ChordErrorResult {
    RemeshResult result;
    Deviation deviation;  ///< of result.mesh, as proved by DeviationProof
    bool kept = false;    ///< no point of either surface is farther than the chord error from the other
    /// Places of the triangulation where it is not kept, and where sizes had to be lowered several times on the way. As
    /// features folds there may help (see FeatureOptions::places).
    std::vector<Eigen::Vector3d> faults, stubborn;
    NewContacts contacts;  ///< of the mesh, where sizes could not be lowered far enough
    int lowerings = 0;     ///< how often sizes were lowered
    /// The map that the mesh was made by, graded; sizes beside frozen edges were raised from there. Only where it is
    /// graded.
    std::optional<LoweredMap> map;
};

/// Meshes with the sizes of a map, proves the deviation, lowers sizes where it is above the chord error, and so on
/// until it is nowhere. It gives up, with `kept` false, where sizes are at hmin, beside frozen edges, or where lower
/// ones broke the mesh or were of no use. Where the mesh touches or passes through itself and the surface does not,
/// sizes are lowered too. In the end, at faults that are left, or where elements fall short (see OffenderLimits)
/// without a cause, it lowers sizes and meshes again, and takes what is better. The smooth surface that is meshed is
/// kept close to the triangulation. Distances are measured on all threads there are; the result is the same for any
/// number.
/// @param map          moved in, it is freed early; sizes to begin with, best by rule_within, graded, and raised beside
/// frozen edges (see raise_to_held)
/// @param chord_error  unit of length, > 0, at least least_chord_error; infinite: any, then the deviation is not
///                     measured, and the map is left only around elements that fall short
/// @throws std::invalid_argument if the chord error is not positive or too small, if hmin is negative, and for the
/// gradation as grade does or where
///         sizes are required
/// @throws std::length_error as remesh does
ChordErrorResult remesh_within(const Triangulation& surface, TriangulationBackground map, double chord_error,
                               const ChordErrorOptions& options = {});

/// The deviation of a mesh of the surface, as remesh makes them, without a limit.
Deviation measure_deviation(const Triangulation& surface, const SurfaceMesh& mesh);

}  // namespace gradus

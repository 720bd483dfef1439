/// Closest points on a surface of patches, across the curves they share.
#pragma once

#include "gradus/surface/patch_model.hpp"

#include <span>
#include <vector>

namespace gradus {

/// The same point of the surface on every patch that has it: `at` itself first, then its places across shared curves
/// and at corners. At a pole: the corners of every patch that meets there.
std::vector<SurfacePoint> places_of(const PatchModel& model, const SurfacePoint& at);

/// True where `at` lies on a collapsed side of its patch; `along` is then the parameter (0: u, 1: v) that means nothing
/// there.
bool on_pole(const PatchModel& model, const SurfacePoint& at, int& along);

struct Projection {
    SurfacePoint at;
    double distance = 0;
};

/// Local closest point, by Newton's method within the patch of `start` and on from there across shared curves. The
/// distance is that of a point of the surface, so it is never below the true one.
/// @param start  place to descend from; clamped to its domain
Projection project(const PatchModel& model, const Eigen::Vector3d& point, const SurfacePoint& start);

struct LocateOptions {
    int intervals = 24;  ///< samples in each direction of each patch, less one
    int patches = 4;     ///< nearest patches to descend on
};

/// Places of points that come without, as from a file: the closest point from the nearest samples of the nearest
/// patches. Where parts of a model run through each other a point may be placed on either.
/// @returns one per point; patch -1 for a point that is not finite
/// @throws std::invalid_argument for options below 1
std::vector<SurfacePoint> locate(const PatchModel& model, std::span<const Eigen::Vector3d> points,
                                 const LocateOptions& options = {});

}  // namespace gradus

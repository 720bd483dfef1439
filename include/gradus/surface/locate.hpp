/// Closest points on a surface of patches, across the curves they share.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "gradus/surface/surface_model.hpp"

namespace gradus {

/// The same point of the surface on every patch that has it: `at` itself first, then its places across shared curves
/// and at vertices. At a pole: the corners of every patch that meets there.
std::vector<SurfacePoint> places_of(const SurfaceModel& model, const SurfacePoint& at);

/// True where `at` lies on a pole of its patch; `along` is then the parameter (0: u, 1: v) that means nothing there.
bool on_pole(const SurfaceModel& model, const SurfacePoint& at, int& along);

struct Projection {
    SurfacePoint at;
    double distance = 0;
    bool arrived = true;  ///< false where the steps ran out before they were short
};

/// Local closest point, by Newton's method within the loops of the patch of `start` and on from there across shared
/// curves. The distance is that of a point of the surface, so it is never below the true one.
/// @param start  place to descend from, inside its loops
Projection project(const SurfaceModel& model, const Eigen::Vector3d& point, const SurfacePoint& start);

/// The same on the patch of `start` alone.
Projection project_within(const SurfaceModel& model, const Eigen::Vector3d& point, const SurfacePoint& start);

/// The same on a surface that is continued as far as it can be evaluated. @returns patch -1
Projection project_beyond(const ParametricSurface& surface, const Eigen::Vector3d& point, const Eigen::Vector2d& start);

struct LocateOptions {
    int intervals = 24;  ///< samples in each direction of each patch, less one; fewer of more patches than kMany
    int patches = 4;     ///< nearest patches to descend on
};

/// Places of points that come without, as from a file: the closest point from the nearest samples of the nearest
/// patches. Where parts of a model run through each other a point may be placed on either.
class Locator {
  public:
    /// @throws std::invalid_argument for options below 1
    explicit Locator(const SurfaceModel& model, const LocateOptions& options = {});
    ~Locator();

    /// Patch -1 and an infinite distance for a point that is not finite.
    Projection find(const Eigen::Vector3d& point) const;
    /// On one patch.
    Projection find_on(int patch, const Eigen::Vector3d& point) const;

  private:
    class Samples;
    const SurfaceModel& model_;
    int patches_;
    std::unique_ptr<const Samples> samples_;
};

/// The places of some points. @returns one per point; patch -1 for a point that is not finite
std::vector<SurfacePoint> locate(const SurfaceModel& model, std::span<const Eigen::Vector3d> points,
                                 const LocateOptions& options = {});

}  // namespace gradus

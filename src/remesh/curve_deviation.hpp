/// How far the feature edges of a mesh are from the feature curves of the triangulation they stand for.
#pragma once

#include <map>
#include <vector>

#include "gradus/control/triangulation.hpp"
#include "gradus/quality/hausdorff.hpp"
#include "gradus/remesh/surface_mesh.hpp"

namespace gradus {

/// Each feature edge of a mesh is held against the stretch of its curve between its ends: the two are nowhere farther
/// from each other than the farthest vertex of the stretch is from the edge, either way.
class CurveDeviation {
  public:
    /// @param surface  must outlive this
    explicit CurveDeviation(const Triangulation& surface);

    /// @param mesh   made over the surface, its places triangles of it
    /// @param limit  edges farther than this are listed
    /// @returns the largest distance, and in `beyond` those that are too far: a triangle of the mesh at each, the
    /// farthest vertex of the stretch, and a triangle of the surface at that
    OneSidedDistance measure(const SurfaceMesh& mesh, double limit) const;

  private:
    struct Position {
        int chain;
        double at;  // edge i from i to i + 1
    };
    struct Farthest {
        double distance = 0;
        int vertex = -1;  // of the surface
    };
    Eigen::Vector3d foot_of(const SurfaceMesh& mesh, int v) const;
    std::vector<Position> positions_of(const SurfaceMesh& mesh, int v) const;
    Farthest farthest_between(const Eigen::Vector3d& p, const Eigen::Vector3d& q, int chain, double from,
                              double to) const;
    Farthest farthest_of(const SurfaceMesh& mesh, const std::array<int, 2>& edge, double limit) const;

    const Triangulation& surface_;
    std::map<std::array<int, 2>, int> number_;  // of each feature edge of the surface in its chain
};

}  // namespace gradus

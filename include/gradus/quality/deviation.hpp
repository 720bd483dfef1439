/// The two-sided distance between a surface and meshes made over it: measured, or proved to keep a limit for one mesh
/// after the other.
#pragma once

#include "gradus/mesh/connectivity.hpp"
#include "gradus/quality/hausdorff.hpp"

#include <algorithm>
#include <span>
#include <vector>

namespace gradus {

/// Two-sided (Hausdorff) distance between a mesh and the surface it stands for, unit of length.
struct Deviation {
    OneSidedDistance from_mesh, from_reference;

    double largest() const { return std::max(from_mesh.largest, from_reference.largest); }  ///< attained
    double bound() const { return std::max(from_mesh.bound, from_reference.bound); }        ///< no point is farther
};

/// A surface that meshes are made over, as what they are measured against. All it refers to must outlive it.
struct ReferenceView {
    MeshView surface;
    const Connectivity& connectivity;  ///< of the surface, an oriented manifold
};

/// Without a limit.
/// @param under      for each vertex of the mesh a triangle of the reference near it, or -1, which costs time
/// @param precision  see OneSidedOptions
/// @throws std::invalid_argument for a surface or a mesh without triangles, or if `under` is not one per vertex
Deviation measure_deviation(const ReferenceView& reference, const MeshView& mesh, std::span<const int> under,
                            double precision = 0.01);

/// What was proved of a mesh.
struct ProvedDeviation {
    /// On either side `beyond` names the triangles that are not proved to keep the limit, `largest` is attained there
    /// or 0, and `bound` holds for all triangles: it is above the limit where any is beyond, and at most the limit
    /// where none is. A triangle of the reference that is much larger than those of the mesh is named once for each of
    /// its pieces that is beyond.
    Deviation deviation;
    /// Triangles of the mesh to divide where it does not keep the limit: those beyond it, then for each triangle of the
    /// reference, or piece of one, that is beyond it those that are almost closest there (`nearest` is that triangle of
    /// the reference then). May name one more than once.
    std::vector<TooFar> at_fault;
};

/// Proves of one mesh after the other that it and a surface stay within a limit of each other. What was proved of a
/// triangle holds while it and the triangles it was held against stay in the mesh, corners bit for bit, so only the
/// others are looked at again. A mesh that has nothing in common with the last one is proved as if it were the first.
class DeviationProof {
  public:
    /// @param limit  > 0, unit of length
    /// @throws std::invalid_argument if limit <= 0 or the surface has no triangles
    DeviationProof(const ReferenceView& reference, double limit);

    /// The next mesh. @param under  as for measure_deviation @throws std::invalid_argument as measure_deviation
    ProvedDeviation prove(const MeshView& mesh, std::span<const int> under);

    /// Whether a part of a mesh, a disk about, keeps the limit as far as can be told without the rest: its first
    /// triangles everywhere, and the surface at its vertices and along its edges where one of those is the closest of
    /// the part.
    /// @param changed  number of the first triangles  @param under  a triangle of the surface near each vertex
    /// @param also     a point of the surface that is to be within the limit of the part too
    bool is_kept_by(const MeshView& part, int changed, std::span<const int> under,
                    const std::optional<Eigen::Vector3d>& also = std::nullopt);

    const DistanceTarget& target() const { return target_; }  ///< the surface

  private:
    OneSidedDistance prove_from_mesh(const MeshView& mesh, std::span<const int> under, const std::vector<int>& now);
    OneSidedDistance prove_from_reference(const MeshView& mesh, const DistanceTarget& target,
                                          std::span<const int> under, const std::vector<int>& now);
    void include_proved_before(OneSidedDistance& found);

    void cut_large(std::span<const int> under);
    void cut_into(int number, const Triangle& corners, int triangle);

    ReferenceView reference_;
    // The surface with its large triangles in pieces, so that little is looked at again where the mesh changes; empty
    // where none is large.
    struct Pieces {
        std::vector<Eigen::Vector3d> points;  // those of the surface, and others
        std::vector<Triangle> triangles;
        std::vector<int> of;      // the triangle of the surface of each
        std::vector<int> beside;  // for each of the other points a vertex of the triangle it is on
    } pieces_;
    double limit_;
    DistanceTarget target_;
    std::vector<int> seen_;  // triangles of the surface, by the last part they were looked at for
    int parts_ = 0;
    // Of the last mesh:
    std::vector<Eigen::Vector3d> points_;
    std::vector<Triangle> triangles_;
    std::vector<char> kept_;  // triangles that were proved
    std::vector<Witnesses>
        witnesses_;  // triangles that those of the surface, or their pieces, were held against; empty before the first
    double bound_of_proved_ = 0;  // no triangle that was ever proved, of either side, has points farther
};

}  // namespace gradus

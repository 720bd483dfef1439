/// A mesh against a triangulated surface it stands for: how far they are from each other, how its facets lean, what
/// became of the pieces, holes and handles.
#pragma once

#include <optional>
#include <vector>

#include "gradus/quality/deviation.hpp"
#include "gradus/quality/distance.hpp"
#include "gradus/quality/topology.hpp"

namespace gradus {

/// Two-sided (Hausdorff) distance between two surfaces.
struct HausdorffReport : Deviation {
    double diagonal = 0;  ///< of the box around the reference: unit of length

    double relative_bound() const { return diagonal > 0 ? bound() / diagonal : bound(); }  ///< over the diagonal
    /// Where the largest distance is: a point of the surface that is that far from the other one.
    const Eigen::Vector3d& point() const {
        return from_mesh.largest >= from_reference.largest ? from_mesh.point : from_reference.point;
    }
};

struct ReferenceReport {
    HausdorffReport hausdorff;
    TopologyReport topology;  ///< of the reference
};

/// A number of the topology of both surfaces.
struct TopologyComparison {
    const char* name;
    std::optional<long long> mesh, reference;  ///< nothing: not defined
    bool same() const { return mesh == reference; }
};
/// Components, boundary loops, Euler characteristic, genus.
std::vector<TopologyComparison> compare(const TopologyReport& mesh, const TopologyReport& reference);

/// What both surfaces are measured with. The views must outlive it.
class Reference {
  public:
    /// @throws std::invalid_argument for a surface without triangles, with an index out of range or a corner that is
    /// not finite
    explicit Reference(const MeshView& surface);

    /// The distance is proved both ways, the largest known to a hundredth.
    /// @throws std::invalid_argument for such a mesh
    ReferenceReport measure(const MeshView& mesh) const;

    /// To the closest point of the reference, whatever sheet it is on; relative to its diagonal. @param edges
    /// edges_of(mesh)
    DistanceReport measure_distance(const MeshView& mesh, const MeshEdges& edges,
                                    const DistanceOptions& options = {}) const;

    /// The angle between the normal of a triangle and that of the reference's facet under it: the facet closest to its
    /// centroid, and of several that are equally close (to a millionth of the diagonal) the one that leans least. Where
    /// the reference is thin, the closest facet may be of the sheet across: where it faces away (by more than 90
    /// degrees) while at each corner of the triangle one of the closest facets does not, the facet is sought among
    /// those at the corners. A triangle that is turned round keeps its angle: then the facets at its corners face away
    /// too. Facets and triangles of no area are passed over.
    NormalReport measure_normals(const MeshView& mesh, const DistanceOptions& options = {}) const;

    double diagonal() const { return diagonal_; }

  private:
    MeshView surface_;
    double diagonal_;
    std::vector<Eigen::Vector3d> normals_;   // of facets, unit; zero where there is none
    std::optional<ClosestTriangle> facing_;  // of those that have a normal
    DistanceTarget target_;
};

}  // namespace gradus

/// The elements of a mesh that fall short of good ones, by place, each with what of the mesh's features forces it.
#pragma once

#include "gradus/mesh/features.hpp"
#include "gradus/mesh/soup.hpp"
#include "gradus/quality/mesh_edges.hpp"

#include <limits>
#include <string>
#include <vector>

namespace gradus {

/// What leaves no room for a good element.
struct OffenderCause {
    enum class Kind {
        None,    ///< nothing was found that forces it
        Frozen,  ///< it has a frozen edge, or a frozen vertex near a corner or a curve
        /// the angles of the mesh around a vertex off the features add up to less than four times the smallest angle;
        /// value: degrees, ids: the vertex
        SharpPoint,
        NarrowCorner,  ///< features meet at less than the smallest angle; value: degrees, ids: the vertex
        /// two corners; value: their distance over the size there, ids: their vertices. Also of elements nearer to them
        /// than the size less that distance: from the one to the other they grow
        NearCorners,
        NearCurves,  ///< two feature curves; value: their distance over the size there, ids: their numbers, from 0
        /// three edges once around a tube, a hole or a patch of the surface that is narrower than elements; value:
        /// their length over the size there. Also of elements nearer to them than the size less a third of that length
        NarrowLoop,
        SizeJump,   ///< sizes of neighbours; value: their ratio
        SharpTurn,  ///< an edge beside it where the surface turns by more than 60 degrees, though no feature: edges of
                    ///< plates and tips that are finer than hmin; value: degrees
    };
    Kind kind = Kind::None;
    double value = 0;
    std::array<int, 2> ids{-1, -1};
};

/// "none found", "frozen element", "sharp point: 80 degrees all around", "narrow corner of the features: 14 degrees",
/// "two corners 0.3 sizes apart" ...
std::string to_text(const OffenderCause& cause);
/// "none", "frozen", "sharp_point", "narrow_corner", "near_corners", "near_curves", "narrow_loop", "size_jump",
/// "sharp_turn"
std::string name_of(OffenderCause::Kind kind);

/// How many elements are beyond a limit, and the value that is farthest beyond it.
struct Shortfall {
    std::size_t count = 0;
    double worst = std::numeric_limits<double>::quiet_NaN();
};

/// Offenders that hang together and have one cause.
struct OffenderGroup {
    OffenderCause cause;                   ///< the tightest place of it
    Eigen::Vector3d point;                 ///< the worst element's centroid or vertex
    Shortfall quality, angle, edge_ratio;  ///< triangles, triangles, vertices
};

/// What good elements keep.
struct OffenderLimits {
    double quality = 0.60;    ///< smallest area-length of a triangle, in [0, 1]
    double angle = 30;        ///< smallest angle, degrees
    double edge_ratio = 2.8;  ///< largest ratio of two edges at a vertex
};

struct OffenderReport {
    OffenderLimits limits;
    bool features_known = true;            ///< false: the mesh is no oriented manifold, and no cause was looked for
    Shortfall quality, angle, edge_ratio;  ///< in all
    Shortfall unexplained_quality, unexplained_angle, unexplained_edge_ratio;  ///< those without a cause
    std::size_t num_groups = 0;
    std::vector<OffenderGroup>
        groups;  ///< those without a cause first, then sharp turns, then by the worst quality; no more than asked for
};

struct OffenderOptions {
    OffenderLimits limits = {};
    std::span<const double> sizes{};             ///< asked for, one per vertex; empty: the mean edge at each vertex
    const KnownFeatures* features = nullptr;     ///< the curves and corners that the mesh keeps; null: found by angle
    const RequiredElements* required = nullptr;  ///< what it was not to touch
    std::size_t most = 100;                      ///< groups to list
};

/// Curves and corners are those of the mesh: known edges, boundaries and borders of known labels, cut where they meet
/// or turn. A cause holds where it leaves too little room: corners narrower than the angle, corners or curves nearer
/// than about half a size, loops of three edges that are about as short, sizes that differ by more than the edge ratio
/// around a vertex, by 2 in a triangle, or where the surface turns as it does between elements of no round.
/// @throws std::invalid_argument as edges_of does, and for sizes that are not one per vertex
OffenderReport find_offenders(const MeshView& mesh, const OffenderOptions& options = {});

/// A table of what falls short, and two lines for each of the first places; at most 110 columns.
std::string to_text(const OffenderReport& report, std::size_t places = 20);

}  // namespace gradus

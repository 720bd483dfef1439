/// Bounds the gradient of an isotropic size map over the triangles of its background mesh. Sizes only ever go down; an
/// infinite size means "not set".
#pragma once

#include "gradus/mesh/tri_mesh.hpp"

#include <span>
#include <vector>

namespace gradus {

/// What a gradient limit did, and what it could not do.
struct GradientReduction {
    int lowered = 0;            ///< vertices whose size went down
    double largest_factor = 1;  ///< largest size before / after; infinite where an unset size was set
    double gradient_max = 0;    ///< of the result: largest norm of the gradient of a triangle (or slope, see below)
    int gradient_triangle = -1;
    int above_bound = 0;    ///< triangles whose gradient exceeds the bound by more than 1e-9, relative
    bool converged = true;  ///< false: stopped at the largest number of visits (kGradientVisits per vertex or triangle)
    long visits = 0;        ///< updates of vertices and triangles
    std::vector<int> conflicts;  ///< triangles that required sizes keep above the bound, by index
};

/// Largest number of visits per vertex or triangle before a limiter gives up.
inline constexpr long kGradientVisits = 500;

/// Sizes that grow at most by `bound` per unit of distance *on the surface*, within triangles as well as along edges:
/// the Eikonal equation |grad h| = bound by fast marching, where a size reaches a vertex across the triangle from the
/// best point of the opposite edge. Vertices lowered later, behind obtuse angles, are queued again. Such sizes are the
/// least upper bound of what limit_gradient can return, but their linear interpolant may be steeper than the bound (by
/// up to 1 / cos(theta/2) at an angle theta): above_bound counts where. [Persson, Mesh size functions for implicit
/// geometries and PDE-based gradient limiting, 2006; Kimmel and Sethian 1998]
/// @param bound     largest growth per length, dimensionless, > 0
/// @param size      one size h > 0 per vertex; lowered in place
/// @param required  vertices whose size may not be lowered
/// @throws std::invalid_argument if bound <= 0, a size is not positive, or a required size is unset
GradientReduction march_gradient(const TriMesh& mesh, double bound, std::span<double> size,
                                 std::span<const int> required = {});

/// Sizes whose linear interpolant has |grad h| <= bound in every triangle, to 1e-9 (relative): march_gradient, then
/// each triangle that is still too steep keeps its smallest corner and takes the nearest sizes that meet the bound at
/// the other two, measured by what they cost in elements (h^-2 per area); from small sizes to large ones, until none is
/// left; then sizes for which that left room rise again, one by one. Needles that are corrected again and again become
/// flatter than they have to be, by a tenth of the bound at most, so that this ends. Sizes never fall below the
/// smallest input size of their component, so the corrections converge. A bound on triangles holds on their edges too,
/// so the H-variation is at most `bound` and the H-shock at most e^bound. Triangles without area are bounded by the
/// slopes of their edges. There is no largest such map: the maximum of two is not always one. On random maps this one
/// asked for 6 to 8 % more elements than the convex optimum. Parameters and errors as above.
GradientReduction limit_gradient(const TriMesh& mesh, double bound, std::span<double> size,
                                 std::span<const int> required = {});
/// The same for any triangles, manifold or not.
GradientReduction limit_gradient(std::span<const Eigen::Vector3d> points, std::span<const Triangle> triangles,
                                 double bound, std::span<double> size);

}  // namespace gradus

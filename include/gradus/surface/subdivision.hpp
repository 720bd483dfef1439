/// Limit surfaces of subdivision, from the cage that controls them. [Catmull, Clark 1978; Loop 1987]
#pragma once

#include <array>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "gradus/surface/surface_model.hpp"

namespace gradus {

enum class SubdivisionScheme { CatmullClark, Loop };

/// "catmull-clark", "loop"
std::string_view name_of(SubdivisionScheme scheme);

/// Faces of three corners and more, counter-clockwise seen from outside, with the tags of subdivision.
struct Cage {
    std::vector<Eigen::Vector3d> points;
    std::vector<std::vector<int>> faces;
    std::vector<int> labels = {};  ///< one per face, or empty

    static constexpr double kSharp = 10;  ///< a sharpness from here on is infinite
    struct Crease {
        std::array<int, 2> edge;
        double sharpness;
    };
    struct Corner {
        int vertex;
        double sharpness;
    };
    std::vector<Crease> creases = {};
    std::vector<Corner> corners = {};
    std::vector<int> holes = {};  ///< faces that are there for the surface around them only

    /// What becomes of boundaries: faces at them have no surface; the surface ends in their curves, round at corners of
    /// one face or sharp.
    enum class Boundary { None, Edges, EdgesAndCorners };
    Boundary boundary = Boundary::EdgesAndCorners;
    bool chaikin = false;           ///< sharpness is averaged along creases
    bool smooth_triangles = false;  ///< weights of their own for triangles
};

/// What keeps a cage from having a limit surface, on one line that names the face, edge or vertex (from 1 on); empty if
/// nothing does: points that are not finite, indices out of range, faces of fewer than three corners or with one twice,
/// edges of three faces and more or with two that run along it in the same direction, vertices where only vertices join
/// the faces, tags of what is not there; for Loop's scheme faces that are no triangles.
std::string why_no_limit_surface(const Cage& cage, SubdivisionScheme scheme = SubdivisionScheme::CatmullClark);

/// Edges at which faces meet at an angle of this or more, radians, become infinitely sharp.
/// @pre why_no_limit_surface(cage) is empty
void sharpen(Cage& cage, double angle);

/// The limit surface, a patch with the domain [0, 1]^2 for each face, or for each corner of the faces if not all are
/// quadrilaterals. Patches meet along the edges of the cage: creases where these are infinitely sharp
/// or the faces have different labels, smooth elsewhere, however large the angle is that the caps of extraordinary
/// vertices leave. Infinitely sharp corners are tips.
struct LimitSurface {
    Topology topology;
    std::vector<int> face;  ///< of the cage, per patch
};

/// The corners of a face are the quadrilaterals between a vertex, the middles of two edges and the middle of the face,
/// in its parameters. Positions and derivatives are exact but around extraordinary vertices, where a cap of one tangent
/// plane takes the place of the infinitely many rings of patches beyond the tenth. Evaluation is safe from several
/// threads, and patches hold what they need.
/// @throws std::invalid_argument with why_no_limit_surface()
LimitSurface limit_surface(const Cage& cage, SubdivisionScheme scheme = SubdivisionScheme::CatmullClark);

}  // namespace gradus

/// Models that tests share: surfaces of patches with known shape, topology and orientation.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "gradus/io/patch_files.hpp"
#include "gradus/surface/analytic.hpp"
#include "gradus/surface/bezier_patch.hpp"
#include "gradus/surface/glue.hpp"
#include "gradus/surface/surface_model.hpp"

namespace gradus::models {

using Patch = std::unique_ptr<const ParametricSurface>;
using Nets = std::vector<BezierNet>;

// -- From one thing to another
// -------------------------------------------------------------------------------------------------

SurfaceModel model_of(const Nets& nets, const ModelOptions& options = {});
SurfaceModel model_of(Patch patch);

/// Each control point moved.
Nets mapped(Nets nets, const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& move);
Nets scaled(const Nets& nets, double factor);

BezierNet flip_u(const BezierNet& net);   ///< S'(u, v) = S(1 - u, v)
BezierNet flip_v(const BezierNet& net);   ///< S'(u, v) = S(u, 1 - v)
BezierNet swap_uv(const BezierNet& net);  ///< S'(u, v) = S(v, u)
/// The same surface, one degree higher along u. Polynomial nets only.
BezierNet raise_u(const BezierNet& net);
/// Variant k mod 8 of the parametrisations got by flips and swap; variant 0 is the net itself.
BezierNet turned(const BezierNet& net, int k);
/// Every patch in another of the eight parametrisations: same surface, orientations and directions mixed.
Nets shuffled(const Nets& nets);

// -- Open models
// ---------------------------------------------------------------------------------------------------------------

Nets teapot_nets();
SurfaceModel teapot();

/// The unit square in z = 0 as a bicubic patch with uniform parametrisation.
BezierNet flat_square();
/// Bicubic over the unit square, inner control points at z = height (heights up to 0.56 height).
BezierNet bump(double height = 0.5);
/// The unit square with S_u at the left side `stretch` times as short as elsewhere: a strongly uneven parametrisation
/// of the plane.
BezierNet uneven_square(double stretch = 1000);
/// The square [0, length] x [0, length / aspect], bent a little (height length / 20 in the middle of the long way).
BezierNet sliver(double aspect = 1e4, double length = 1);
/// n x n bicubic patches of a smooth graph z = amplitude sin sin over the unit square (C1 by construction: Hermite data
/// of the graph).
Nets wavy_sheet(int n, double amplitude = 0.1);
/// Two flat unit squares hinged on the y axis, meeting at `angle` (0: coplanar) radians between their normals.
Nets hinge(double angle);
/// A bicubic patch over [0, 1]^2 and a patch of degree (5, 1) over [-1, 0] x [0, 1]: they share the curve x = 0, a
/// cubic whose control points the second has raised to degree 5 (and runs along it as its u).
Nets mixed_degrees();
/// Two squares sharing the straight side x = 0, on which their parametrisations differ (uniform and y = v^2-like).
Nets differing_parameters();
/// Six patches of the unit cube: twelve creases of 90 degrees.
Nets cube();
/// Two bumps back to back, glued along all four sides.
Nets cushion(double height = 0.5);

// -- Closed and smooth, exact in rational form
// ---------------------------------------------------------------------------------

/// Eight biquadratic octants, with two poles.
Nets sphere_octants(double radius = 1);
/// Six patches of degree 4 x 4, without poles.
Nets sphere_cube(double radius = 1);
/// Sixteen biquadratic patches around the z axis.
Nets torus(double major = 2, double minor = 0.5);
/// Four biquadratic-by-linear patches, open at both ends.
Nets cylinder(double radius = 1, double height = 2);
/// Four biquadratic-by-linear patches from a circle to the apex at (0, 0, height), a pole without a normal.
Nets cone(double radius = 1, double height = 1);

// -- One analytic patch glued to itself
// ----------------------------------------------------------------------------------------

SurfaceModel sphere_with_seam(double radius = 1);                       ///< one seam, two poles
SurfaceModel torus_with_seams(double major = 2, double minor = 0.5);    ///< two seams, one vertex, no boundary
SurfaceModel cylinder_with_seam(double radius = 1, double height = 2);  ///< one seam, two closed boundaries
SurfaceModel two_hemispheres(double radius = 1);                        ///< east and west: two curves between two poles
/// A sphere whose parameter u is 1 / stretch of the longitude, so that |S_u| / |S_v| = stretch on the equator.
Patch stretched_sphere(double stretch = 1000, double radius = 1);

// -- Trimmed patches
// ---------------------------------------------------------------------------------------------------------------

SurfaceModel plate_with_hole(double radius = 0.2);  ///< the unit square with a round hole
SurfaceModel disc_in_square(double radius = 0.2);   ///< the hole filled: a smooth circle in the plane
/// The unit sphere without a disc of its parameters.
SurfaceModel sphere_with_hole(double latitude = 0.3, double radius = 0.5);
/// A block over the unit square with a cylindrical bore.
SurfaceModel bored_block(double radius = 0.2, double height = 0.4);

}  // namespace gradus::models

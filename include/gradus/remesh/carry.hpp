/// Carries fields of a triangulation to the mesh that was made of it. The mesh knows where its vertices are on the
/// triangulation, so nothing is searched for in space: values come from the same sheet and component, however near
/// another one is.
#pragma once

#include <span>
#include <vector>

#include "gradus/control/triangulation.hpp"
#include "gradus/remesh/surface_mesh.hpp"

namespace gradus {

/// Fields on points: linear in the triangle of the input that a vertex is on, so exact for linear fields where that is
/// flat and of second order elsewhere; never beyond the values at its corners, and theirs at vertices that stayed. Not
/// a number where one of the corners that count has none. Integers are rounded to integers.
/// @param mesh  its places are triangles of the surface, with the barycentric coordinates of corners 1 and 2
/// @throws std::invalid_argument naming the field that has not its components for each point of the surface; for a
/// place that is not on it
std::vector<Field> carry_point_fields(const Triangulation& surface, std::span<const Field> fields,
                                      const SurfaceMesh& mesh);

/// Fields on triangles: the value of the triangle of the input under the centroid, bit by bit, see triangles_of_input.
/// @throws std::invalid_argument as above, for each triangle
std::vector<Field> carry_cell_fields(const Triangulation& surface, std::span<const Field> fields,
                                     const SurfaceMesh& mesh);

/// For each triangle of the mesh the one of the input under it: the closest to its centroid among those reached from
/// its vertices by ever closer ones without crossing a feature. So what features bound, as they do regions of one
/// label, gets nothing from beyond.
/// @throws std::invalid_argument for a place that is not on the surface
std::vector<int> triangles_of_input(const Triangulation& surface, const SurfaceMesh& mesh);

}  // namespace gradus

/// Triangle meshes and size maps in files. The format is chosen by the extension, in upper or lower case:
///
/// | extension | format | carries |
/// |---|---|---|
/// | .mesh .meshb | Medit: text, binary of libMeshb (1 to 4 read, 2 written, 3 beyond 2 GB) | everything but fields |
/// | .msh | Gmsh: 2.2 and 4.1, text and binary read, text of 4.1 written | triangles, labels, edges, fields |
/// | .obj | Wavefront | points, triangles |
/// | .off | Geomview: text, with NOFF, COFF and STOFF | points, triangles |
/// | .ply | Stanford: text, binary, little endian written | points, triangles, labels, fields |
/// | .poly | Triangle's planar domains, with the `.node` file beside; only read | triangles, labels, edges |
/// | .stl | text, or binary in *single* precision, the format having no other | points welded where equal, triangles |
/// | .vtu .vtp | VTK in XML: text, binary, appended, zlib; binary .vtu written | triangles, labels, edges, fields |
///
/// Binary files are read in both byte orders. Points are doubles: text is written with the fewest digits that read back
/// to the same bits, and read exactly rounded. Polygons are split into fans from their first corner. Vertices without
/// triangles are kept. Topology is not looked at here, see mesh/diagnose.hpp.
///
/// Medit: the reference of a triangle is its label (all zero: no labels). Every entry of `Edges` is a feature edge,
/// written as a ridge too, but for those that `RequiredEdges` numbers and `Ridges` does not. What `RequiredVertices`,
/// `RequiredEdges` and `RequiredTriangles` number are the required elements, which remeshing does not touch; a ridge
/// that is not required may be divided anew. `Corners` are corners. `VerticesOnGeometricTriangles` holds
/// TriangleSoup::parameters, an entry per vertex and patch: vertex, patch (from 1 in the file), u, v, distance (written
/// as 0, not read). Text files are written with that section as comments behind `End`, each line with a leading `#`, as
/// readers elsewhere stop at a keyword that they do not know; it is read there and as a section. The reference of an
/// edge is its label. Planar files (Dimension 2) get z = 0 and are written as such again; one that has edges and no
/// triangles is a planar domain. Other sections are passed over.
/// Planar domains are triangulated on reading, see plane/planar_graph.hpp. `.poly`: holes are those it lists, the
/// attributes of regions are their labels, the markers of segments those of edges; attributes and markers of points,
/// and areas of regions, are passed over.
///
/// Gmsh and VTK: of triangles and quadrilaterals of second and higher order the corners are used only; the other nodes
/// go. Lines are feature edges, points are passed over, files with volume elements are refused. Gmsh: the label of a
/// face is its physical group (the first one), else the entity it is on; no labels if all faces are on one entity and
/// in no group; the label of a line is its group. Written are a surface and a group for each label, so that triangles
/// come in the order of labels, and a curve for each label of edges, with a group if they have labels. VTK: an integer
/// cell array `label` is the labels of faces and lines. PLY: an integer property `label` of faces is the labels;
/// write_mesh leaves it away, write_mesh_data does not. Properties being single numbers, a field of several components
/// is one property for each, `velocity_0`, `velocity_1` ...; the comment `gradus field 3 velocity` before them says
/// that they are one. Integers are bytes where they are in [0, 255], as colours are to be.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gradus/control/tensor.hpp"
#include "gradus/mesh/soup.hpp"

namespace gradus {

/// @throws IoError naming the file and the line (in binary files the byte) if it cannot be read, is truncated, holds a
/// bad
///         word, a number that is not finite, an index out of range or a wrong count, or if its extension is unknown
TriangleSoup read_mesh(const std::string& path);

/// The same with the fields of a file: arrays of VTK, scalar properties of vertices and faces in PLY, `$NodeData` and
/// `$ElementData` of Gmsh (of several steps the last). Values of lines are left away; integers are exact up to 2^53.
/// Empty in the other formats.
MeshData read_mesh_data(const std::string& path);

/// Fields of a Medit solution, `.sol` or `.solb`: all that is under `SolAtVertices`, scalars, vectors, symmetric and
/// full matrices, their components in the order of the file. They have the name of the file, without folder and
/// extension; several are numbered, "flow_1".
/// @param expected_count  number of vertices of the mesh they are for; none: any number
/// @throws IoError as read_mesh does, and if there are not as many values as expected
std::vector<Field> read_solution(const std::string& path, std::optional<std::size_t> expected_count = {});

struct WriteOptions {
    bool ascii = false;  ///< .ply and .stl as text; the other formats are either text or binary
};

/// @throws IoError if the file cannot be written, or its extension is unknown or of a format that is only read
/// @throws std::invalid_argument if the soup has an index out of range, a coordinate that is not finite (in binary STL:
/// in
///         single precision), or labels that are not one per triangle
void write_mesh(const std::string& path, const TriangleSoup& soup, const WriteOptions& options = {});

/// The formats that hold fields and are written: .msh .ply .vtu. By extension.
bool holds_fields(const std::string& path);
/// Whether the format of a file, by its extension, keeps labels of triangles.
bool holds_labels(const std::string& path);

/// The formats that hold required elements: .mesh .meshb. By extension.
bool marks_required(const std::string& path);

/// The same with fields, whose names and components read_mesh_data gives back, with all values. A cell field `label`
/// gives way to the labels of the soup. `.msh` holds up to 64 components, of which Gmsh shows 1, 3 and 9.
/// @throws std::invalid_argument also for a field that has no name, one given before, or values that are not one per
/// component and thing
/// @throws IoError also if there are fields and the format does not hold them, or not so many components
void write_mesh_data(const std::string& path, const MeshData& data, const WriteOptions& options = {});

/// Sizes of a `.sol` (text) or `.solb` (binary) file: one scalar per vertex under `SolAtVertices`.
/// @param expected_count  number of vertices of the mesh the sizes are for; none: any number
/// @returns sizes, > 0, unit of length; +inf where unset (`inf` in text)
/// @throws IoError as read_mesh does, for a size that is not > 0, and if the number of sizes is not the expected one
std::vector<double> read_sizes(const std::string& path, std::optional<std::size_t> expected_count = {});

/// @param dimension  of the mesh they are for: 2 for planar ones, see TriangleSoup
/// @throws IoError if the file cannot be written or its extension is unknown
/// @throws std::invalid_argument if a size is not > 0
void write_sizes(const std::string& path, std::span<const double> sizes, int dimension = 3);

/// Metrics of a `.sol` or `.solb` file: one symmetric matrix per vertex, in the plane m11 m12 m22, in space m11 m12 m22
/// m13 m23 m33; of one size h per vertex those of 1 / h^2.
/// @throws IoError as read_sizes does, for a metric that is not positive definite, and one with sizes of which one is
/// more than 1e6 times another
std::vector<Tensor> read_metrics(const std::string& path, std::optional<std::size_t> expected_count = {});

/// @param dimension  2: of the plane, entries across it are left away
/// @throws as write_sizes, for a metric that is not positive definite
void write_metrics(const std::string& path, std::span<const Tensor> metrics, int dimension = 3);

}  // namespace gradus

/// Files a command reads and writes: what kind they are, and whether they can be written, asked before anything is
/// computed.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "cages.hpp"
#include "gradus/control/background.hpp"
#include "gradus/mesh/repair.hpp"
#include "session.hpp"

namespace gradus::app {

enum class FileKind {
    Patches,    ///< .bpt .bez
    Mesh,       ///< .obj .off .ply .stl .mesh .meshb .msh .vtu
    ReadMesh,   ///< .vtp, only read
    Sizes,      ///< .sol .solb
    SizeView,   ///< .pos, only written
    SizedMesh,  ///< .msh .vtu .ply, a mesh that holds sizes: only written, and a Mesh by its name
    Report,     ///< .html .json, only written
    Unknown
};

/// By extension, in upper or lower case.
FileKind kind_of(const std::string& path);
/// A triangle mesh to read.
inline bool is_mesh(const std::string& path) {
    return kind_of(path) == FileKind::Mesh || kind_of(path) == FileKind::ReadMesh;
}
/// Whether a surface is given as triangles, or as a planar domain, which is cut into some.
inline bool is_triangulation(const std::string& path, const CageChoice& cage) {
    return is_mesh(path) && !cage.is_given();
}
/// In lower case, with the dot.
std::string extension_of(const std::string& path);
/// "a.bpt" with ".mesh" is "a.mesh".
std::string with_extension(const std::string& path, const std::string& extension);

/// @throws Failure if a file of one of these kinds cannot be written there
void check_output(const std::string& path, const std::vector<FileKind>& kinds);
/// Makes a folder, its parents too, unless it is there. @throws Failure if it cannot, or cannot be written into
void make_folder(const std::string& path);
/// @throws UsageError if two of the paths are one file
void check_distinct(const std::vector<std::string>& outputs);

/// The patches of a file, glued, or the limit surface of a cage. @throws IoError, Failure naming the file
LoadedModel load_model(const std::string& path, const CageChoice& cage = {}, bool keeps_label_borders = true);
/// The triangle mesh of a file as it is, if it is an oriented manifold; else repaired, if that is asked for, with each
/// change said.
/// @throws Failure naming the file, its first faults and the cure
/// The vertices of an STL that are a rounding apart as one, said.
void weld_read(const std::string& path, TriangleSoup& soup, const Session& session);
TriangleSoup sound(const std::string& path, TriangleSoup soup, bool repair, const Session& session);
/// A line for each thing done, below one that names the file.
std::string text_of(const std::string& path, const Repaired& repaired);

/// "3 vertices at open edges lie on others (cracks), 2 vertices lie within open edges (T-junctions)"
std::string text_of(const Cracks& cracks);
/// @throws Failure naming the file if its triangles are no oriented manifold
TriMesh manifold_of(const std::string& path, const TriangleSoup& soup);
/// The background with places on the patches. @throws Failure naming the file
Background load_background(const std::string& path, const SurfaceModel& model);
/// Of FileKind::SizedMesh. By extension.
bool holds_mesh(const std::string& size_map);
/// Sizes on the vertices of a mesh, in the format of the extension: .sol .solb, .pos and .msh as Gmsh takes them for a
/// background, .vtu with a point field `size`, .ply with the same and colours.
void write_size_map(const std::string& path, const TriangleSoup& soup, const std::vector<double>& sizes);
/// @throws Failure naming a file to be written if its format cannot hold the mesh: single precision would turn or
/// flatten triangles
void check_holds(const std::string& path, std::span<const Eigen::Vector3d> points, std::span<const Triangle> triangles);
/// A line for each output that cannot hold the labels of the input, if that has some.
std::vector<std::string> labels_left_behind(bool has_labels, const std::vector<std::string>& outputs);
/// @throws Failure naming the size map if grading it has left vertices without a size
void require_reached(const std::string& size_map, std::span<const double> graded);
/// Where the background mesh of a size map is, unless it is named: beside it.
std::string background_beside(const std::string& sizes);

}  // namespace gradus::app

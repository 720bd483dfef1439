/// Triangulations of files: how they are taken, and what is said of them and of their meshes.
#pragma once

#include <memory>
#include <optional>

#include "gradus/control/triangulation.hpp"
#include "gradus/gradation/grade.hpp"
#include "gradus/remesh/mesh_triangulation.hpp"
#include "json.hpp"
#include "options.hpp"
#include "session.hpp"

namespace gradus::app {

/// How a triangulation is taken, as given.
struct TriangulationChoice {
    std::optional<double> feature_angle = {};  ///< degrees
    bool no_label_borders = false;
    bool repair = false;
    std::vector<int> freeze;  ///< labels
    std::string freeze_list;
};
void add_triangulation(CLI::App& app, TriangulationChoice& choice);
/// @throws UsageError naming an option that says what to keep of a triangulation
void check_for_patches(const TriangulationChoice& choice);

/// @throws UsageError for an angle that is none
TriangulationOptions triangulation_options(const TriangulationChoice& choice);
/// The triangulation of a file, sound and oriented, with what it and the options require to be kept. @throws IoError,
/// Failure naming the file and what is wrong with it
std::unique_ptr<Triangulation> load_triangulation(const std::string& path, const TriangulationChoice& choice,
                                                  const SizingOptions& sizing, const Session& session);
/// The same in an order that is faster to work on, except where the file or the options name elements by number, as
/// messages then do too.
struct OrderedTriangulation {
    std::unique_ptr<Triangulation> surface;
    std::vector<int> point_source,
        triangle_source;  ///< for each vertex and triangle its number in the file, as repaired
};
OrderedTriangulation load_ordered(const std::string& path, const TriangulationChoice& choice,
                                  const SizingOptions& sizing, const Session& session);

/// Sizes instead of those by a rule.
struct GivenSizes {
    std::vector<double> sizes = {};
    std::optional<TriangleSoup> background = {};  ///< at whose vertices they are; else at those of the triangulation
    std::string path = {}, background_path = {};
};
/// As the command line names them. @throws Failure naming the file
GivenSizes read_given_sizes(const std::string& sizes, const std::string& background, const Triangulation& surface);

/// @throws Failure naming the file of the background if it is none of the surface
TriangulationBackground given_background(const Triangulation& surface, const GivenSizes& given);

/// Of a mesh that does not keep its chord error: ", at 1 2 3, where ...", the likely cause.
std::string why_not_kept(const Triangulation& surface, const TriangulationMesh& mesh);
/// What is to be noticed: a mesh without a chord error that is farther from the input than its elements explain, parts
/// below the least size.
std::vector<std::string> notes_on(const Triangulation& surface, const TriangulationMesh& mesh);

/// "bunny.off: 75 408 triangles ..., diagonal 1.6; 3 feature curves, 4 corners"
std::string text_of(const std::string& path, const Triangulation& surface);
/// The distance between the mesh and the triangulation, against the chord error where one was asked for.
std::string text_of(const TriangulationMesh& mesh, double diagonal);
/// A line on the required elements and the outputs that mark them; empty where there are none.
std::string text_of(const RequiredElements& required, const std::vector<std::string>& outputs);
Json json_of(const Triangulation& surface);
Json json_of(const TriangulationMesh& mesh);

MeshReport measure_surface_mesh(const TriangulationMesh& mesh);

}  // namespace gradus::app

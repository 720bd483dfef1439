/// From a triangulation to its mesh, stage by stage.
#pragma once

#include <memory>
#include <optional>

#include "gradus/control/triangulation.hpp"
#include "gradus/gradation/grade.hpp"
#include "gradus/remesh/chord_error.hpp"
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

struct TriangulatedMesh {
    RemeshResult result;
    std::size_t background_vertices = 0;
    std::optional<GradationResult> gradation;  ///< of the map that was meshed in the end
    Deviation deviation;
    int refinements = 0;                            ///< how often sizes were lowered where the chord error was not kept
    std::optional<double> chord_error;              ///< asked for
    bool kept = true;                               ///< the chord error, where one was asked for
    std::vector<Eigen::Vector3d> faults, stubborn;  ///< see ChordErrorResult
    std::optional<double> least_size;               ///< below which sizes were not to go, if that was given
    NewContacts contacts;                           ///< of the mesh with itself that the triangulation does not have
    /// Sizes prescribed at points that were moved by more than the size, to the vertex of the background where they
    /// hold, and how far.
    std::vector<std::pair<SizingRule::At, double>> moved;
};

/// Sizes instead of those by a rule.
struct GivenSizes {
    std::vector<double> sizes = {};
    std::optional<TriangleSoup> background = {};  ///< at whose vertices they are; else at those of the triangulation
    std::string path = {}, background_path = {};
};
/// As the command line names them. @throws Failure naming the file
GivenSizes read_given_sizes(const std::string& sizes, const std::string& background, const Triangulation& surface);

/// Sizes by the rule, graded, meshed; with a rule by chord error both surfaces stay within it of each other, else kept
/// is false.
/// @param given  in place of the rule's, where there are any
TriangulatedMesh mesh_triangulation(const Triangulation& surface, const SizingRule& rule, const GivenSizes& given,
                                    const std::optional<GradationOptions>& gradation, const RemeshOptions& options,
                                    bool hmin_given, Stages& stages);

/// The triangulation again, with all folds near some places as features; null where it has no more features so.
std::unique_ptr<Triangulation> with_features_at(std::span<const Eigen::Vector3d> places, const std::string& path,
                                                const Triangulation& surface, const TriangulationChoice& choice,
                                                const SizingOptions& sizing);

/// Of a mesh that does not keep its chord error: ", at 1 2 3, where ...", the likely cause.
std::string why_not_kept(const Triangulation& surface, const TriangulatedMesh& mesh);
/// What is to be noticed: a mesh without a chord error that is farther from the input than its elements explain, parts
/// below the least size.
std::vector<std::string> notes_on(const Triangulation& surface, const TriangulatedMesh& mesh);

/// "bunny.off: 75 408 triangles ..., diagonal 1.6; 3 feature curves, 4 corners"
std::string text_of(const std::string& path, const Triangulation& surface);
/// The distance between the mesh and the triangulation, against the chord error where one was asked for.
std::string text_of(const TriangulatedMesh& mesh, double diagonal);
/// A line on the required elements and the outputs that mark them; empty where there are none.
std::string text_of(const RequiredElements& required, const std::vector<std::string>& outputs);
Json json_of(const Triangulation& surface);
Json json_of(const TriangulatedMesh& mesh);

MeshReport measure_surface_mesh(const TriangulatedMesh& mesh);

}  // namespace gradus::app

/// From a triangulation to its mesh in one call, as the command line does it: sizes, gradation, meshing, and more
/// features where the mesh needs them.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "gradus/control/triangulation.hpp"
#include "gradus/gradation/grade.hpp"
#include "gradus/remesh/chord_error.hpp"
#include "gradus/remesh/parametric.hpp"

namespace gradus {

struct TriangulationMeshOptions {
    std::optional<GradationOptions> gradation = {};  ///< none: sizes change as they will
    bool keeps_hmin = false;  ///< sizes are never below the rule's hmin; else they go down to a tenth of it, in the
                              ///< smallest part, where a chord error or elements that fall short ask for that
    TriangulationOptions triangulation = {};  ///< with which the surface was made by triangulation_for
    /// Sizes instead of those by the rule, on a background of the surface.
    std::function<TriangulationBackground(const Triangulation&)> sizes = {};
    RemeshOptions remesh = {};
    /// Runs each stage: background, gradation, meshing, distance, features. Not given: they are just run.
    std::function<void(std::string_view name, const std::function<void()>& stage)> run_stage = {};
    std::function<void(const SurfaceMesh&)> on_check = {};  ///< see ChordErrorOptions
};

struct TriangulationMesh {
    RemeshResult result;
    std::size_t background_vertices = 0;
    std::optional<GradationResult> gradation;  ///< of the map that was meshed in the end
    Deviation deviation;
    int refinements = 0;                            ///< how often sizes were lowered where a fault was found
    std::optional<double> chord_error;              ///< asked for by the rule
    bool kept = true;                               ///< the chord error, where one was asked for
    std::vector<Eigen::Vector3d> faults, stubborn;  ///< see ChordErrorResult
    std::optional<double> least_size;               ///< below which sizes were not to go, with keeps_hmin
    NewContacts contacts;                           ///< of the mesh with itself that the triangulation does not have
    /// Sizes prescribed at points that were moved by more than the size, to the vertex of the background where they
    /// hold, and how far.
    std::vector<std::pair<SizingRule::At, double>> moved;
};

struct MeshedTriangulation {
    std::shared_ptr<const Triangulation> surface;  ///< as it was meshed, with more features if the mesh needed them
    TriangulationMesh mesh;
};

/// Meshes with sizes by the rule, or those given, graded. With a rule by chord error both surfaces stay within it of
/// each other, else `kept` is false. Where the mesh does not keep the chord error or touches itself, folds that were
/// taken for noise, or for coarse rounds, may have to be features after all: it is tried again with those, up to six
/// times, and the best mesh is taken.
/// @param surface  from triangulation_for with the rule
/// @throws std::invalid_argument as remesh_within and grade do, and where sizes are given and some vertices have none
/// once they are graded
/// @throws std::length_error as remesh does
MeshedTriangulation mesh_triangulation(std::shared_ptr<const Triangulation> surface, const SizingRule& rule,
                                       const TriangulationMeshOptions& options = {});

}  // namespace gradus

/// Cages of subdivision surfaces: the options that say how they are meant, and their limit surfaces.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "gradus/surface/surface_model.hpp"

namespace gradus::app {

struct CageChoice {
    std::string scheme = {};                  ///< "catmull-clark"; empty: files hold what their names say
    std::optional<double> crease_angle = {};  ///< degrees
    std::string boundary = {};                ///< "none", "edges" or "corners"; empty: as the file says

    bool is_given() const { return !scheme.empty(); }
};
void add_cages(CLI::App& app, CageChoice& choice);
/// @throws UsageError for options of cages without --subdivision
void check(const CageChoice& choice);

/// A surface of patches, and their labels, if the file has some.
struct LoadedModel {
    SurfaceModel model;
    std::vector<int> labels = {};
};

/// The limit surface of the cage in a file, with the labels of its faces, whose borders are features or not.
/// @throws IoError, Failure naming the file and what is wrong with it
LoadedModel load_limit_surface(const std::string& path, const CageChoice& choice, bool keeps_label_borders);

}  // namespace gradus::app

/// A surface to be meshed, whatever it is given as: Bezier patches, a cage, a planar domain, a triangulation. Commands
/// know surfaces through this only, so that a further kind is a further Source.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cages.hpp"
#include "gradus/control/background.hpp"
#include "gradus/gradation/grade.hpp"
#include "gradus/quality/report.hpp"
#include "gradus/remesh/parametric.hpp"
#include "json.hpp"
#include "options.hpp"
#include "pictures.hpp"
#include "triangulated.hpp"

namespace gradus::app {

/// What is to be meshed and how it is taken, as given.
struct SourceChoice {
    std::string in;
    SizingOptions sizing;
    TriangulationChoice surface;
    CageChoice cage;
};
/// All but IN.
void add_source(CLI::App& app, SourceChoice& choice);

/// How a mesh is asked for.
struct MeshRequest {
    std::vector<std::string> out, fields;
    std::string sizes, background;  ///< a size map in place of the curvature; or empty
    std::optional<GradationOptions> gradation;
    bool anisotropic = false;  ///< elements as long as the surface lets them be
    RemeshOptions remesh;
};

/// A mesh with what is known of how it came about.
struct Made {
    RemeshResult result;
    std::optional<SizingRule> rule;  ///< where sizes come from curvature
    std::size_t background_vertices = 0;
    std::optional<GradationResult> gradation;
    std::string surface;             ///< a line on the input
    std::string note;                ///< lines on what else was asked and whether it was met
    std::vector<std::string> notes;  ///< to be noticed
    bool met = true;                 ///< the chord error
    std::string where;               ///< it is not kept, and why
    std::size_t contacts = 0;        ///< see NewContacts
    Json json;                       ///< keys of the input's kind
    std::function<MeshReport()> measure;
    std::function<void(const std::string& path)> write;
    std::function<std::vector<Picture>()> draw;
};

/// How a size map is asked for.
struct MapRequest {
    std::string background;  ///< the mesh to give sizes to; empty: it is made
    bool refines = false;    ///< a triangulation, so that it shows small sizes; else it is its own background
    int max_triangles = 0;   ///< of the background
};

/// A size map with what is said of it.
struct Mapped {
    Background background = {};
    TriangleSoup soup = {};  ///< the background as files hold it
    std::vector<double> sizes = {};
    SizingRule rule = {};
    std::string surface = {};   ///< a line on the input
    std::string accuracy = {};  ///< how well the sizes are represented
    Json json = {};             ///< keys of the input's kind
};

class Source {
  public:
    virtual ~Source() = default;
    /// @throws UsageError naming an option that makes no sense for this kind of surface, before anything is read
    virtual void check(const MeshRequest&) const {}
    virtual Made mesh(const MeshRequest& request, Stages& stages) const = 0;
    virtual Mapped map(const MapRequest& request, Stages& stages) const = 0;
};

/// @throws UsageError naming an option that makes no sense
std::unique_ptr<Source> source_of(const SourceChoice& choice, const Session& session);
/// Patches of a file, or the limit surface of a cage.
std::unique_ptr<Source> model_source(const SourceChoice& choice);
/// Triangles, and planar domains, which are cut into some.
std::unique_ptr<Source> triangle_source(const SourceChoice& choice, const Session& session);

/// @throws Failure naming the size map if a vertex has no size
void require_finite(const std::string& path, std::span<const double> sizes);

}  // namespace gradus::app

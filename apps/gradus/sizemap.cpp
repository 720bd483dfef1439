// gradus sizemap: from the curvature of a surface to sizes on a background mesh.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "commands.hpp"
#include "files.hpp"
#include "gradus/control/control_space.hpp"
#include "gradus/io/mesh_files.hpp"
#include "json.hpp"
#include "show.hpp"
#include "source.hpp"

namespace gradus::app {

namespace {

struct Options {
    Session session;
    SourceChoice source;
    std::string out, background;
    int max_triangles = 20'000'000;
};

// Where the background of a map is read or written.
struct Place {
    std::string path;
    bool exists = false;  // and is read
    bool writes = false;
};

// @throws UsageError, Failure where it would take the place of another file
Place place_of_background(const Options& options) {
    const bool is_named = !options.background.empty();
    Place place{.path = is_named ? options.background : background_beside(options.out)};
    place.exists = is_named && std::filesystem::exists(options.background);
    // The mesh that is read need not be written beside its sizes: its vertices are theirs, unless it is repaired.
    std::error_code unknown;
    const bool is_input = !is_named && std::filesystem::equivalent(place.path, options.source.in, unknown);
    if (is_input && options.source.surface.repair)
        throw UsageError(fmt::format(
            "{}: the background would take the place of the input; name another with --background", place.path));
    place.writes = !place.exists && !is_input && (is_named || !holds_mesh(options.out));
    if (!place.writes) return place;
    check_output(place.path, {FileKind::Mesh});
    check_distinct({options.out, place.path});
    // Beside sizes that are written anew, a mesh of that name is another one.
    if (!is_named && std::filesystem::exists(place.path) && !std::filesystem::exists(options.out))
        throw UsageError(
            fmt::format("{}: exists, and the background would take its place; name another with "
                        "--background",
                        place.path));
    return place;
}

void tell(const Session& session, const Mapped& map, const GradationReport& measures, const Stages& stages,
          const std::vector<std::string>& files) {
    const auto [smallest, largest] = std::minmax_element(map.sizes.begin(), map.sizes.end());
    const double predicted = ControlSpace(map.background, map.sizes).predicted_triangles();
    session.say(map.surface);
    session.say(fmt::format("sizes: {}; {:.4g} to {:.4g} on the surface, {} triangles expected\n", to_text(map.rule),
                            *smallest, *largest, about(predicted)));
    session.say(fmt::format("background: {} vertices, {} triangles, {}\n", grouped(map.sizes.size()),
                            grouped(map.soup.triangles.size()), map.accuracy));
    session.say(fmt::format("H-shock {} at most, 99.9 % below {}; H-variation {:.4g} at most\n",
                            shock_text(measures.shock_max), shock_text(measures.shock_p999), measures.variation_max));
    session.say(fmt::format("wrote {}\n", fmt::join(files, " ")));
    Json json = map.json;
    json.update({{"sizing", json_of(map.rule)},
                 {"vertices", map.sizes.size()},
                 {"triangles", map.soup.triangles.size()},
                 {"size_min", *smallest},
                 {"size_max", *largest},
                 {"predicted_triangles", predicted},
                 {"gradation", json_of(measures)},
                 {"stages", json_of(stages.times())},
                 {"files", files}});
    print(session, json);
}

int run_sizemap(const Options& options) {
    check_output(options.out, {FileKind::Sizes, FileKind::SizeView, FileKind::SizedMesh});
    const std::unique_ptr<Source> source = source_of(options.source, options.session);
    const Place place = place_of_background(options);
    Stages stages(options.session);
    const Mapped map = source->map({.background = place.exists ? place.path : "",
                                    .refines = !options.background.empty(),
                                    .max_triangles = options.max_triangles},
                                   stages);
    const GradationReport measures =
        stages.run("measures", [&] { return measure_gradation(map.background.mesh, map.sizes); });
    std::vector<std::string> files{options.out};
    stages.run("writing", [&] {
        if (place.writes) write_mesh(files.emplace_back(place.path), map.soup);
        write_size_map(options.out, map.soup, map.sizes);
    });
    tell(options.session, map, measures, stages, files);
    return kMet;
}

}  // namespace

void add_sizemap(CLI::App& app, Run& run) {
    CLI::App& command = *app.add_subcommand("sizemap", "Sizes from the curvature of a surface");
    const auto options = std::make_shared<Options>();
    command.add_option("IN", options->source.in, "Surface: Bezier patches, .bpt .bez, or a triangle mesh")->required();
    command
        .add_option("-o,--output", options->out,
                    "One size per vertex of the background mesh; .pos or .msh for Gmsh, .vtu, .ply with colours")
        ->required()
        ->type_name("MAP.sol");
    command
        .add_option(
            "--background", options->background,
            "Background mesh: read where this file exists, else made and written there (default: made, and written "
            "beside MAP.sol unless that "
            "holds it; for a triangulation IN itself, which shows no sizes that are smaller than its triangles)")
        ->type_name("BG.mesh");
    add_source(command, options->source);
    command.add_option("--max-triangles", options->max_triangles, "Refuse a larger background")
        ->type_name("N")
        ->check(CLI::Range(100, 1'000'000'000).description(""));
    add_session(command, options->session);
    run_with(command, run, options, run_sizemap);
}

}  // namespace gradus::app

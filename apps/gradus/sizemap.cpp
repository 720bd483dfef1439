// gradus sizemap: from the curvature of a surface to sizes on a background mesh.
#include <fmt/format.h>

#include <filesystem>

#include "commands.hpp"
#include "files.hpp"
#include "gradus/control/control_space.hpp"
#include "gradus/io/mesh_files.hpp"
#include "json.hpp"
#include "show.hpp"
#include "sized.hpp"
#include "triangulated.hpp"

namespace gradus::app {

namespace {

struct Options {
    Session session;
    std::string in, out, background;
    SizingOptions sizing;
    TriangulationChoice surface;
    CageChoice cage;
    int max_triangles = 20'000'000;
};

// A size map with what is said of it.
struct Mapped {
    Background background = {};
    TriangleSoup soup = {};  // the background as files hold it
    std::vector<double> sizes = {};
    SizingRule rule = {};
    std::string surface = {};   // a line on the input
    std::string accuracy = {};  // how well the sizes are represented
    Json json = {};             // keys of the input's kind
};

Mapped map_patches(const Options& options, const std::string& given, Stages& stages) {
    const SurfaceModel model =
        stages.run("reading", [&] { return std::move(load_model(options.in, options.cage).model); });
    Mapped map{.rule = rule_of(options.sizing, limits_for(model.diagonal())),
               .surface = text_of(options.in, model),
               .json = {{"patches", model.num_patches()}}};
    SizedBackground sized;
    if (given.empty()) {
        sized = background_for(model, map.rule, stages, options.max_triangles);
        map.accuracy = fmt::format("sizes within {:.1f} %", 100 * std::expm1(sized.largest_error));
        map.json["largest_error"] = sized.largest_error;
    } else {
        stages.run("background", [&] {
            sized.background = load_background(given, model);
            sized.sizes = geometric_sizes(model, sized.background, map.rule);
        });
        map.accuracy = "as given";
        map.json["largest_error"] = nullptr;
    }
    map.background = std::move(sized.background);
    map.sizes = std::move(sized.sizes);
    map.soup = soup_from_background(map.background);
    return map;
}

// The background of a triangulation is itself, unless a finer or another one is asked for.
Mapped map_triangles(const Options& options, const std::string& given, Stages& stages) {
    const auto surface = stages.run(
        "reading", [&] { return load_triangulation(options.in, options.surface, options.sizing, options.session); });
    Mapped map{.rule = rule_of(options.sizing, limits_for(surface->diagonal())),
               .surface = text_of(options.in, *surface),
               .json = json_of(*surface)};
    stages.run("background", [&] {
        if (options.background.empty()) {
            map.soup = surface->soup();
            map.sizes = geometric_sizes(*surface, map.rule);
            map.background.mesh = make_mesh(map.soup.points, map.soup.triangles);
            map.accuracy = "those of the input";
            return;
        }
        TriangulationBackground refined = make_background(*surface, map.rule, options.max_triangles);
        const std::size_t triangles = refined.background.mesh.n_faces();
        if (triangles >= static_cast<std::size_t>(options.max_triangles))
            throw std::length_error("the background mesh needs more than " + grouped(options.max_triangles) +
                                    " triangles");
        if (given.empty()) {
            map.sizes = std::move(refined.sizes);
            map.background = std::move(refined.background);
            const auto points = points_of(map.background.mesh);
            map.soup = {.points = {points.begin(), points.end()}, .triangles = triangles_of(map.background.mesh)};
            map.accuracy = triangles == surface->soup().triangles.size() ? "those of the input, which are fine enough"
                                                                         : "the input refined";
            return;
        }
        map.soup = read_mesh(given);
        map.background.mesh = manifold_of(given, map.soup);
        try {
            map.sizes = sizes_at(refined, map.soup);
        } catch (const std::invalid_argument& error) {
            throw Failure(given + ": " + error.what());
        }
        lower_to_prescribed(map.rule.at, map.soup.points, map.sizes);
        map.accuracy = "as given";
    });
    return map;
}

int run_sizemap(const Options& options) {
    check(options.sizing);
    check_output(options.out, {FileKind::Sizes, FileKind::SizeView, FileKind::SizedMesh});
    check(options.cage);
    const bool triangles = is_mesh(options.in) && !options.cage.is_given();
    if (!triangles) {
        check_for_patches(options.sizing);
        check_for_patches(options.surface);
    }
    const bool given = !options.background.empty() && std::filesystem::exists(options.background);
    const std::string mesh_path = options.background.empty() ? background_beside(options.out) : options.background;
    // The mesh that is read need not be written beside its sizes: its vertices are theirs, unless it is repaired.
    std::error_code unknown;
    const bool is_input = options.background.empty() && std::filesystem::equivalent(mesh_path, options.in, unknown);
    if (is_input && options.surface.repair)
        throw UsageError(fmt::format(
            "{}: the background would take the place of the input; name another with --background", mesh_path));
    const bool writes_mesh = !given && !is_input && !(options.background.empty() && holds_mesh(options.out));
    if (writes_mesh) {
        check_output(mesh_path, {FileKind::Mesh});
        check_distinct({options.out, mesh_path});
        // Beside sizes that are written anew, a mesh of that name is another one.
        if (options.background.empty() && std::filesystem::exists(mesh_path) && !std::filesystem::exists(options.out))
            throw UsageError(fmt::format(
                "{}: exists, and the background would take its place; name another with --background", mesh_path));
    }

    Stages stages(options.session);
    const Mapped map = triangles ? map_triangles(options, given ? mesh_path : "", stages)
                                 : map_patches(options, given ? mesh_path : "", stages);
    const auto [smallest, largest] = std::minmax_element(map.sizes.begin(), map.sizes.end());
    const double predicted = ControlSpace(map.background, map.sizes).predicted_triangles();
    const GradationReport measures =
        stages.run("measures", [&] { return measure_gradation(map.background.mesh, map.sizes); });
    stages.run("writing", [&] {
        if (writes_mesh) write_mesh(mesh_path, map.soup);
        write_size_map(options.out, map.soup, map.sizes);
    });

    const Session& session = options.session;
    session.say(map.surface);
    session.say(fmt::format("sizes: {}; {:.4g} to {:.4g} on the surface, {} triangles expected\n", to_text(map.rule),
                            *smallest, *largest, about(predicted)));
    session.say(fmt::format("background: {} vertices, {} triangles, {}\n", grouped(map.sizes.size()),
                            grouped(map.soup.triangles.size()), map.accuracy));
    session.say(fmt::format("H-shock {:.4g} at most, 99.9 % below {:.4g}; H-variation {:.4g} at most\n",
                            measures.shock_max, measures.shock_p999, measures.variation_max));
    session.say(writes_mesh ? fmt::format("wrote {} {}\n", options.out, mesh_path)
                            : fmt::format("wrote {}\n", options.out));

    Json files{options.out};
    if (writes_mesh) files.push_back(mesh_path);
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
    return kMet;
}

}  // namespace

void add_sizemap(CLI::App& app, Run& run) {
    CLI::App& command = *app.add_subcommand("sizemap", "Sizes from the curvature of a surface");
    const auto options = std::make_shared<Options>();
    command.add_option("IN", options->in, "Surface: Bezier patches, .bpt .bez, or a triangle mesh")->required();
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
    add_sizing(command, options->sizing);
    add_clearances(command, options->sizing);
    add_triangulation(command, options->surface);
    add_cages(command, options->cage);
    command.add_option("--max-triangles", options->max_triangles, "Refuse a larger background")
        ->type_name("N")
        ->check(CLI::Range(100, 1'000'000'000).description(""));
    add_session(command, options->session);
    run_with(command, run, options, run_sizemap);
}

}  // namespace gradus::app

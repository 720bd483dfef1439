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

namespace gradus::app {

namespace {

struct Options {
    Session session;
    std::string in, out, background;
    SizingOptions sizing;
    int max_triangles = 20'000'000;
};

SizedBackground on_given_background(const PatchModel& model, const SizingRule& rule, const std::string& path, Stages& stages) {
    return stages.run("background", [&] {
        SizedBackground sized{load_background(path, model), {}};
        sized.sizes = geometric_sizes(model, sized.background, rule);
        return sized;
    });
}

int run_sizemap(const Options& options) {
    check(options.sizing);
    check_output(options.out, {FileKind::Sizes, FileKind::SizeView});
    const bool given = !options.background.empty() && std::filesystem::exists(options.background);
    const std::string mesh_path = options.background.empty() ? background_beside(options.out) : options.background;
    if (!given) check_output(mesh_path, {FileKind::Mesh});

    Stages stages(options.session);
    const PatchModel model = stages.run("reading", [&] { return load_model(options.in); });
    const SizingRule rule = rule_of(options.sizing, limits_for(model.diagonal()));
    const SizedBackground sized =
        given ? on_given_background(model, rule, mesh_path, stages) : background_for(model, rule, stages, options.max_triangles);
    const auto [smallest, largest] = std::minmax_element(sized.sizes.begin(), sized.sizes.end());
    const double predicted = ControlSpace(sized.background, sized.sizes).predicted_triangles();
    const GradationReport measures = stages.run("measures", [&] { return measure_gradation(sized.background.mesh, sized.sizes); });
    stages.run("writing", [&] {
        const TriangleSoup soup = soup_from_background(sized.background);
        if (!given) write_mesh(mesh_path, soup);
        write_size_map(options.out, soup, sized.sizes);
    });

    const Session& session = options.session;
    session.say(text_of(options.in, model));
    session.say(fmt::format("sizes: {}; {:.4g} to {:.4g} on the surface, {} triangles expected\n", to_text(rule), *smallest, *largest,
                            grouped(std::llround(predicted))));
    session.say(fmt::format("background: {} vertices, {} triangles, {}\n", grouped(sized.sizes.size()),
                            grouped(sized.background.patch.size()),
                            given ? "as given" : fmt::format("sizes within {:.1f} %", 100 * std::expm1(sized.largest_error))));
    session.say(fmt::format("H-shock {:.4g} at most, 99.9 % below {:.4g}; H-variation {:.4g} at most\n", measures.shock_max,
                            measures.shock_p999, measures.variation_max));
    session.say(given ? fmt::format("wrote {}\n", options.out) : fmt::format("wrote {} {}\n", options.out, mesh_path));

    Json files{options.out};
    if (!given) files.push_back(mesh_path);
    print(session, {{"patches", model.num_patches()},
                    {"sizing", json_of(rule)},
                    {"vertices", sized.sizes.size()},
                    {"triangles", sized.background.patch.size()},
                    {"size_min", *smallest},
                    {"size_max", *largest},
                    {"predicted_triangles", predicted},
                    {"largest_error", given ? Json(nullptr) : Json(sized.largest_error)},
                    {"gradation", json_of(measures)},
                    {"stages", json_of(stages.times())},
                    {"files", files}});
    return kMet;
}

}  // namespace

void add_sizemap(CLI::App& app, Run& run) {
    CLI::App& command = *app.add_subcommand("sizemap", "Sizes from the curvature of a surface");
    const auto options = std::make_shared<Options>();
    command.add_option("IN", options->in, "Surface: Bezier patches, .bpt .bez")->required();
    command.add_option("-o,--output", options->out, "One size per vertex of the background mesh; .pos for Gmsh")
        ->required()
        ->type_name("MAP.sol");
    command
        .add_option("--background", options->background,
                    "Background mesh: read where this file exists, else made and written there (default: made, and written beside MAP.sol)")
        ->type_name("BG.mesh");
    add_sizing(command, options->sizing);
    command.add_option("--max-triangles", options->max_triangles, "Refuse a larger background")
        ->type_name("N")
        ->check(CLI::Range(100, 1'000'000'000).description(""));
    add_session(command, options->session);
    run_with(command, run, options, run_sizemap);
}

}  // namespace gradus::app

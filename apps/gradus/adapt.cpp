// gradus adapt: meshes a planar domain for sizes or a metric given by formula, again until the mesh satisfies them.
#include <fmt/format.h>

#include "adaption.hpp"
#include "commands.hpp"
#include "files.hpp"
#include "gradus/io/mesh_files.hpp"
#include "gradus/remesh/triangulation_for.hpp"
#include "show.hpp"
#include "triangulated.hpp"

namespace gradus::app {

namespace {

struct Options {
    Session session;
    std::string in, map;
    Wanted wanted;
    std::vector<std::string> out;
    std::string pictures;
    GradationChoice gradation;
    int iterations = 20, max_triangles = 20'000'000;
    bool fast = false;
};

constexpr double kDefaultShock = 2;

void check(const Options& options) {
    if (options.wanted.size.empty() == options.wanted.metric.empty())
        throw UsageError("give what is wanted, by --size \"...\" or by --metric \"...\"");
    if (!is_mesh(options.in) && extension_of(options.in) != ".poly")
        throw UsageError(fmt::format("{}: not a planar domain; use a .poly or a .mesh of dimension 2", options.in));
    for (const std::string& path : options.out) check_output(path, {FileKind::Mesh});
    std::vector<std::string> outputs = options.out;
    if (!options.map.empty()) {
        check_output(options.map, {FileKind::Sizes});
        outputs.push_back(options.map);
        outputs.push_back(with_extension(options.map, ".mesh"));
    }
    check_distinct(outputs);
}

PlanarAdaptOptions adapt_options(const Options& options, Stages& stages) {
    PlanarAdaptOptions adapt;
    if (options.wanted.is_metric())
        adapt.tensor_gradation = tensor_gradation_of(options.gradation, kDefaultShock);
    else
        adapt.gradation = gradation_of(options.gradation, kDefaultShock);
    adapt.max_iterations = options.iterations;
    adapt.remesh = {.fast = options.fast,
                    .max_triangles = static_cast<double>(options.max_triangles),
                    .threads = options.session.threads};
    adapt.progress = [&](int iteration) { stages.detail("iteration " + std::to_string(iteration)); };
    return adapt;
}

void tell(const Options& options, const PlanarAdaptOptions& adapt, const Adaption& adaption, const Stages& stages,
          const std::vector<std::string>& files) {
    const Session& session = options.session;
    session.say(fmt::format("{}: {} \"{}\"\n", options.in, options.wanted.is_metric() ? "metric" : "size",
                            options.wanted.is_metric() ? options.wanted.metric : options.wanted.size));
    session.say(adapt.tensor_gradation ? "gradation: " + to_text(*adapt.tensor_gradation) + "\n"
                : adapt.gradation      ? "gradation: " + to_text(*adapt.gradation) + "\n"
                                       : "gradation: none\n");
    session.say(aligned(rows_of(adaption)));
    session.say(outcome_of(adaption) + "\n");
    session.say("time: " + text_of(stages.times()));
    session.say(fmt::format("wrote {}\n", fmt::join(files, " ")));
}

int run_adapt(const Options& options) {
    check(options);
    Stages stages(options.session);
    Wanted wanted = options.wanted;
    if (wanted.background.empty()) wanted.background = options.in;
    const PlanarAdaptOptions adapt = adapt_options(options, stages);
    if (!options.pictures.empty()) make_folder(options.pictures);
    const auto domain = stages.run("reading", [&] {
        const TriangleSoup soup = sound(options.in, read_mesh(options.in), false, options.session);
        for (const Eigen::Vector3d& p : soup.points)
            if (p.z() != 0) throw Failure(options.in + ": not in the plane z = 0");
        return std::make_unique<Triangulation>(soup);
    });
    const Adaption adaption = stages.run("adaption", [&] {
        try {
            return adapt_to(*domain, wanted, adapt);
        } catch (const std::length_error& error) {
            throw Failure(options.in + ": " + error.what());
        }
    });
    std::vector<std::string> files = options.out;
    stages.run("writing", [&] {
        for (const std::string& path : options.out) {
            check_holds(path, adaption.mesh.points, adaption.mesh.triangles);
            write_adapted(path, adaption);
        }
        if (options.map.empty()) return;
        write_map(files.emplace_back(options.map), adaption.corrected);
        write_mesh(files.emplace_back(with_extension(options.map, ".mesh")), adaption.background);
    });
    if (!options.pictures.empty()) {
        files.push_back(options.pictures + "/mesh.png");
        stages.run("pictures", [&] { write_png(files.back(), draw_from_above(adaption.mesh)); });
    }
    tell(options, adapt, adaption, stages, files);
    Json json = json_of(adaption);
    json["stages"] = json_of(stages.times());
    json["files"] = files;
    print(options.session, json);
    if (!adaption.graded)
        throw Failure(options.in + ": the mesh is written, but its map changes faster than asked for");
    if (!adaption.converged)
        throw Failure(
            fmt::format("{}: the last mesh is written, but {}; a correction of the map (--shock 2), or more "
                        "--iterations, may help",
                        options.in, outcome_of(adaption)));
    return kMet;
}

}  // namespace

void add_adapt(CLI::App& app, Run& run) {
    CLI::App& command = *app.add_subcommand(
        "adapt", "Mesh a planar domain for sizes or a metric given by formula, until it satisfies them");
    const auto options = std::make_shared<Options>();
    command.add_option("DOMAIN", options->in, "Planar domain: .poly, .mesh of dimension 2, or triangles in z = 0")
        ->required();
    command
        .add_option(
            "--size", options->wanted.size,
            "Size at (x, y): a formula, with helper variables before it, \"r = sqrt(x^2+y^2); r < 1 ? .01 : .1\"")
        ->type_name("FORMULA|MAP.sol");
    command
        .add_option(
            "--metric", options->wanted.metric,
            "Metric at (x, y): \"m11, m12, m22\", or a direction, the size along it and the size across, \"dx, dy, "
            "h1, h2\"")
        ->type_name("FORMULA|MAP.sol");
    command
        .add_option("--background", options->wanted.background,
                    "Mesh at whose vertices MAP.sol gives sizes or metrics (default: DOMAIN)")
        ->type_name("BG.mesh");
    command
        .add_option("-o,--output", options->out,
                    "Mesh, in the format of the extension: .mesh .meshb .msh .vtu .obj .off .ply .stl; may be repeated")
        ->required()
        ->type_name("OUT")
        ->type_size(1)
        ->allow_extra_args(false)
        ->take_all();
    command
        .add_option("--map", options->map,
                    "The map that the last mesh was made with; its background goes beside it, .mesh")
        ->type_name("MAP.sol");
    add_gradation(command, options->gradation, GradationNeeded::No);
    command.get_option("--shock")->description("Largest H-shock, > 1 (default: 2)");
    command.get_option("--method")
        ->description(
            "Of sizes: full (default), exact, gradient, paper; of metrics: shape (default), paper, metric, physical, "
            "mixed");
    command.add_option("--iterations", options->iterations, "Most iterations (default: 20)")
        ->type_name("N")
        ->check(CLI::Range(1, 1000).description(""));
    command.add_flag("--fast", options->fast, "Smooth shapes only, do not search for better ones");
    command.add_option("--max-triangles", options->max_triangles, "Refuse to make more")
        ->type_name("N")
        ->check(CLI::Range(100, 700'000'000).description(""));
    command.add_option("--pictures", options->pictures, "Draw the mesh into this folder")->type_name("DIR");
    add_session(command, options->session);
    run_with(command, run, options, run_adapt);
}

}  // namespace gradus::app

// gradus quad: triangles to quadrilaterals.
#include <fmt/format.h>

#include <map>

#include "commands.hpp"
#include "files.hpp"
#include "gradus/io/mesh_files.hpp"
#include "gradus/io/quad_files.hpp"
#include "quadrilaterals.hpp"
#include "show.hpp"

namespace gradus::app {

namespace {

struct Options {
    Session session;
    std::string in, metrics, pictures;
    std::vector<std::string> out;
    bool all = false, refine = false, no_label_borders = false;
};

void check(const Options& options) {
    if (!is_mesh(options.in))
        throw UsageError(
            fmt::format("{}: not a triangle mesh; use .mesh .meshb .msh .obj .off .ply .stl .vtu .vtp", options.in));
    for (const std::string& path : options.out) {
        if (!holds_quads(path))
            throw UsageError(fmt::format("{}: no format for quadrilaterals; use .mesh .vtu .obj .off", path));
        check_output(path, {FileKind::Mesh});
    }
    check_distinct(options.out);
}

int run_quad(const Options& options) {
    check(options);
    Stages stages(options.session);
    if (!options.pictures.empty()) make_folder(options.pictures);
    TriangleSoup soup =
        stages.run("reading", [&] { return sound(options.in, read_mesh(options.in), false, options.session); });
    // Labels go with their borders.
    if (options.no_label_borders) soup.labels.clear();
    std::vector<Tensor> metrics;
    if (!options.metrics.empty()) metrics = read_metrics(options.metrics, soup.points.size());
    QuadStatistics statistics;
    QuadOptions quad{.metrics = metrics};
    if (options.all) quad.mode = QuadOptions::Mode::All;
    if (options.refine) quad.mode = QuadOptions::Mode::Refined;
    const QuadMesh mesh = stages.run("quadrilaterals", [&] { return to_quads(soup, quad, &statistics); });
    const QuadReport report = measure_quads(mesh);
    std::vector<std::string> files = options.out;
    stages.run("writing", [&] {
        for (const std::string& path : options.out) write_quads(path, mesh);
    });
    if (!options.pictures.empty()) {
        files.push_back(options.pictures + "/quads.png");
        stages.run("pictures", [&] { write_png(files.back(), draw_quads(mesh)); });
    }
    options.session.say(fmt::format("{}: {} triangles\n", options.in, grouped(soup.triangles.size())));
    options.session.say(text_of(report));
    options.session.say(fmt::format("made: {} pairs, {} triangles led to others, {} collapses, {} rotations\n",
                                    grouped(statistics.paired), statistics.led, grouped(statistics.collapses),
                                    grouped(statistics.rotations)));
    options.session.say("time: " + text_of(stages.times()));
    options.session.say(fmt::format("wrote {}\n", fmt::join(files, " ")));
    Json json = json_of(report);
    json["odd_parts"] = statistics.odd_parts;
    json["stages"] = json_of(stages.times());
    json["files"] = files;
    print(options.session, json);
    if (options.all && !mesh.triangles.empty())
        throw Failure(fmt::format(
            "{}: the mesh is written, but {} triangles are left; {}", options.in, mesh.triangles.size(),
            statistics.odd_parts > 0 ? fmt::format("{} of its parts, as features and labels bound them, have an odd "
                                                   "number of boundary edges; --refine leaves none",
                                                   statistics.odd_parts)
                                     : "no way leads from one to another; --refine leaves none"));
    return kMet;
}

}  // namespace

void add_quad(CLI::App& app, Run& run) {
    CLI::App& command = *app.add_subcommand("quad", "Make quadrilaterals of triangles");
    const auto options = std::make_shared<Options>();
    command.add_option("MESH", options->in, "Triangle mesh: .mesh .meshb .msh .obj .off .ply .stl .vtu .vtp")
        ->required();
    command.add_option("-o,--output", options->out, "Mesh: .mesh .vtu .obj .off; may be repeated")
        ->required()
        ->type_name("OUT")
        ->type_size(1)
        ->allow_extra_args(false)
        ->take_all();
    auto* all =
        command.add_flag("--all", options->all,
                         "Leave no triangle, without new vertices on boundaries and features: where each part has "
                         "an even number of them");
    auto* refine =
        command.add_flag("--refine", options->refine, "Halve every edge, so that there are quadrilaterals only");
    all->excludes(refine);
    command.add_flag("--no-label-borders", options->no_label_borders,
                     "Quadrilaterals across borders of labels, as of patches; the labels are left behind");
    command
        .add_option("--metric", options->metrics,
                    "Sizes or metrics at the vertices of MESH, in which shapes are judged")
        ->type_name("MAP.sol");
    command.add_option("--pictures", options->pictures, "Draw the mesh into this folder")->type_name("DIR");
    add_session(command, options->session);
    run_with(command, run, options, run_quad);
}

}  // namespace gradus::app

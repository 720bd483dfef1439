// gradus example: the paper's planar experiments, with their figures and a table beside other figures.
#include <fmt/format.h>

#include <array>

#include "adaption.hpp"
#include "commands.hpp"
#include "files.hpp"
#include "gradus/io/figure.hpp"
#include "gradus/io/mesh_files.hpp"
#include "gradus/io/quad_files.hpp"
#include "gradus/plane/planar_graph.hpp"
#include "quadrilaterals.hpp"
#include "show.hpp"

namespace gradus::app {

namespace {

struct Options {
    Session session;
    std::string folder;
    double shock = 2;
};

// What others reached: no figure is -1. Of mmg2d 5.8 and BAMG 4.11 measured in the exact metric, each in 10 to 20
// iterations.
struct Published {
    std::string who;
    std::array<int, 2> triangles;
    std::array<double, 2> worst, mean;
    std::array<int, 2> iterations;
};

struct Experiment {
    std::string name, title;
    Wanted wanted;
    double zoom;  // width of what the enlargements show, around (1, 0) turned by 45 degrees
    std::vector<Published> published;
    int ideal;  // triangles of the map as it is wanted
};

const Experiment kRing{"ring",
                       "example 1: three sizes with jumps between them",
                       {"r2 = x^2+y^2; (r2 >= .99 && r2 <= 1.01) ? .005 : (r2 > 1.01 ? 1 : .1)", ""},
                       0.25,
                       {{"the paper", {10976, 28844}, {.008, .5}, {.8, .9}, {20, 8}},
                        {"mmg2d", {970, 2416}, {.11, .39}, {.84, .86}, {12, 10}},
                        {"BAMG", {730, 6233}, {.09, .46}, {.90, .90}, {20, 12}}},
                       6552};
const Experiment kAnisotropicRing{"anisotropic-ring",
                                  "example 2: sizes of .1 along a circle and .0005 across",
                                  {"", "r = sqrt(x^2+y^2); d = abs(1-r); x, y, .0005+1.5*d, .1*r+1.5*d"},
                                  0.25,
                                  {{"the paper", {1312, 3082}, {.015, .1}, {.5, .75}, {10, 5}},
                                   {"mmg2d", {936, 1176}, {.07, .04}, {.56, .60}, {10, 8}},
                                   {"BAMG", {950, 5474}, {.02, .06}, {.55, .63}, {10, 8}}},
                                  1019};

// One of the two ways.
struct Side {
    std::string name;
    Adaption adaption;
    QuadMesh quads;
    QuadReport quad_report;
};

std::unique_ptr<Triangulation> square() {
    PlanarGraph graph;
    graph.points = {{-2, -2}, {2, -2}, {2, 2}, {-2, 2}};
    graph.segments = {{0, 1}, {1, 2}, {2, 3}, {3, 0}};
    return std::make_unique<Triangulation>(triangulate(graph, InnerPoints::Added));
}

Side run_side(const std::string& name, const Experiment& experiment, const Options& options, Stages& stages) {
    PlanarAdaptOptions adapt;
    adapt.remesh.threads = options.session.threads;
    if (name == "corrected") {
        adapt.gradation = GradationOptions{.shock = options.shock};
        adapt.tensor_gradation =
            TensorGradationOptions{.method = TensorGradationMethod::Metric, .shock = options.shock};
    }
    adapt.progress = [&](int iteration) { stages.detail("iteration " + std::to_string(iteration)); };
    const auto domain = square();
    Side side{
        name, stages.run("adaption, " + name, [&] { return adapt_to(*domain, experiment.wanted, adapt); }), {}, {}};
    stages.run("quadrilaterals, " + name, [&] {
        side.quads = to_quads(side.adaption.mesh, {.mode = QuadOptions::Mode::All, .metrics = side.adaption.metrics});
        side.quad_report = measure_quads(side.quads);
    });
    return side;
}

std::vector<std::vector<std::string>> table_of(const Experiment& experiment, const Side& raw, const Side& corrected) {
    std::vector<std::vector<std::string>> rows{
        {"", "iterations", "triangles", "worst", "mean", "|  corrected: iterations", "triangles", "worst", "mean"}};
    const auto figures = [](std::vector<std::string>& row, int iterations, long long triangles, double worst,
                            double mean) {
        row.insert(row.end(), {fmt::format("{}", iterations), grouped(triangles), fmt::format("{:.3f}", worst),
                               fmt::format("{:.3f}", mean)});
    };
    std::vector<std::string> ours{"gradus"};
    for (const Side* side : {&raw, &corrected}) {
        const PlanarAdaptIteration& last = side->adaption.iterations.back();
        figures(ours, static_cast<int>(side->adaption.iterations.size()), last.triangles, last.own.worst,
                last.own.mean);
    }
    rows.push_back(ours);
    for (const Published& other : experiment.published) {
        std::vector<std::string> row{other.who};
        for (const int k : {0, 1}) figures(row, other.iterations[k], other.triangles[k], other.worst[k], other.mean[k]);
        rows.push_back(row);
    }
    return rows;
}

std::string text_of(const Experiment& experiment, const Options& options, const Side& raw, const Side& corrected) {
    std::string text = fmt::format("{}: {}\n", experiment.name, experiment.title);
    for (const Side* side : {&raw, &corrected}) {
        text += fmt::format("{}\n", side == &raw ? "without correction"
                                                 : fmt::format("with correction, H-shock at most {:g}", options.shock));
        text += aligned(rows_of(side->adaption)) + "  " + outcome_of(side->adaption) + "\n";
    }
    for (const Side* side : {&raw, &corrected})
        text += fmt::format("{}, as quadrilaterals{}\n{}", side->name,
                            experiment.wanted.is_metric() ? ", in the metric" : "", app::text_of(side->quad_report));
    text += fmt::format("beside others (the map as it is wanted asks for {} triangles)\n", grouped(experiment.ideal));
    return text + aligned(table_of(experiment, raw, corrected));
}

std::vector<Picture> pictures_of(const Experiment& experiment, const Side& raw, const Side& corrected) {
    const Eigen::Vector2d on_circle = Eigen::Vector2d(1, 1).normalized();
    std::vector<Panel> panels;
    for (const double width : {0.0, experiment.zoom})
        for (const Side* side : {&raw, &corrected})
            panels.push_back({draw_from_above(side->adaption.mesh, on_circle, width),
                              width > 0 ? "around the circle"
                                        : fmt::format("{}: {} triangles", side->name,
                                                      grouped(side->adaption.mesh.triangles.size()))});
    std::vector<Panel> quads;
    for (const double width : {0.0, experiment.zoom})
        for (const Side* side : {&raw, &corrected})
            quads.push_back(
                {draw_quads(side->quads, on_circle, width),
                 width > 0 ? "around the circle"
                           : fmt::format("{}: {} quadrilaterals", side->name, grouped(side->quads.quads.size()))});
    return {{"triangles", "Triangles", compose(panels, {.columns = 2})},
            {"quads", "Quadrilaterals", compose(quads, {.columns = 2})}};
}

std::vector<std::string> write_files(const Experiment& experiment, const Options& options, const Side& raw,
                                     const Side& corrected) {
    std::vector<std::string> files;
    const auto file = [&](const std::string& name) { return files.emplace_back(options.folder + "/" + name); };
    for (const Side* side : {&raw, &corrected}) {
        write_adapted(file(side->name + ".mesh"), side->adaption);
        write_adapted(file(side->name + ".vtu"), side->adaption);
    }
    write_quads(file("quads.mesh"), corrected.quads);
    // Both maps on the background of the last one: what is wanted is the same everywhere.
    write_mesh(file("background.mesh"), corrected.adaption.background);
    write_map(file("raw.sol"), corrected.adaption.wanted);
    write_map(file("corrected.sol"), corrected.adaption.corrected);
    for (const Picture& picture : pictures_of(experiment, raw, corrected))
        write_png(file(picture.name + ".png"), picture.image);
    return files;
}

int run_example(const Experiment& experiment, const Options& options) {
    if (!options.folder.empty()) make_folder(options.folder);
    Stages stages(options.session);
    const Side raw = run_side("raw", experiment, options, stages),
               corrected = run_side("corrected", experiment, options, stages);
    std::vector<std::string> files;
    if (!options.folder.empty())
        files = stages.run("writing", [&] { return write_files(experiment, options, raw, corrected); });
    Json json{{"example", experiment.name},
              {"raw", json_of(raw.adaption)},
              {"corrected", json_of(corrected.adaption)},
              {"raw_quads", json_of(raw.quad_report)},
              {"quads", json_of(corrected.quad_report)},
              {"stages", json_of(stages.times())}};
    if (!options.folder.empty()) {
        files.push_back(options.folder + "/report.json");
        json["files"] = files;
        write(files.back(), json);
    }
    options.session.say(text_of(experiment, options, raw, corrected) + "time: " + app::text_of(stages.times()));
    if (!files.empty()) options.session.say(fmt::format("wrote {}\n", fmt::join(files, " ")));
    print(options.session, json);
    return corrected.adaption.converged && corrected.adaption.graded ? kMet : kFailed;
}

int run_ring(const Options& options) { return run_example(kRing, options); }
int run_anisotropic_ring(const Options& options) { return run_example(kAnisotropicRing, options); }

}  // namespace

void add_example(CLI::App& app, Run& run) {
    CLI::App& command = *app.add_subcommand("example", "The paper's planar experiments");
    command.require_subcommand(1);
    const auto add = [&](const Experiment& experiment, int (*work)(const Options&)) {
        CLI::App& example = *command.add_subcommand(experiment.name, experiment.title);
        const auto options = std::make_shared<Options>();
        example.add_option("--out", options->folder, "Write meshes, maps, pictures and a report into this folder")
            ->type_name("DIR");
        example.add_option("--shock", options->shock, "Largest H-shock of the corrected maps, > 1 (default: 2)")
            ->type_name("B")
            ->check(CLI::Range(1.0001, 1e6).description(""));
        add_session(example, options->session);
        run_with(example, run, options, work);
    };
    add(kRing, run_ring);
    add(kAnisotropicRing, run_anisotropic_ring);
}

}  // namespace gradus::app

// gradus teapot: the experiment of the paper's section on surfaces, with its figures and its table.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "commands.hpp"
#include "files.hpp"
#include "gradus/gradation/grade_refining.hpp"
#include "gradus/gradation/measures.hpp"
#include "gradus/io/figure.hpp"
#include "gradus/io/histogram.hpp"
#include "gradus/io/mesh_files.hpp"
#include "gradus/io/output_file.hpp"
#include "gradus/io/patch_files.hpp"
#include "gradus/quality/shape.hpp"
#include "gradus/remesh/adapt.hpp"
#include "json.hpp"
#include "output.hpp"
#include "page.hpp"
#include "pictures.hpp"
#include "show.hpp"
#include "sized.hpp"
#include "teapot_data.hpp"

namespace gradus::app {

namespace {

struct Options {
    Session session;
    std::string folder;
    SizingOptions sizing;
    GradationChoice gradation;
    bool fast = false;
    int iterations = 10;
    int max_triangles = 20'000'000;
};

constexpr SizeLimits kLimits{0.01, 0.5};  // in the units of the 1975 data; the teapot is 6.5 long
constexpr double kPaperShock = 1.5;

// What the paper says of its two meshes of the teapot; it does not say which measure of quality it uses.
struct Published {
    double worst, mean;
};
constexpr Published kPaperRaw{0.2, 0.85}, kPaperGraded{0.6, 0.94};

// One of the two ways: sizes as they come, or graded.
struct Side {
    std::string name;
    std::vector<double> sizes = {};  // on the background
    RemeshResult meshed = {};
    MeshReport report = {};
    AdaptResult adaption = {};
};

struct Experiment {
    SizingRule rule;
    GradationOptions gradation;
    SizedBackground sized;
    GradationResult graded;
    Side raw{.name = "raw"}, corrected{.name = "graded"};
};

void mesh_side(const Options& options, const SurfaceModel& model, const Experiment& experiment, Side& side,
               Stages& stages) {
    const ControlSpace control(experiment.sized.background, side.sizes);
    RemeshOptions remesh_options{.fast = options.fast,
                                 .max_triangles = static_cast<double>(options.max_triangles),
                                 .threads = options.session.threads};
    side.meshed = stages.run("mesh, " + side.name, [&] { return remesh(model, control, remesh_options); });
    side.report =
        stages.run("report, " + side.name, [&] { return measure_surface_mesh(model, side.meshed.mesh, control); });
    if (options.iterations == 0) return;
    stages.run("adaption, " + side.name, [&] {
        AdaptOptions adapt_options;
        adapt_options.rule = experiment.rule;
        if (&side == &experiment.corrected) adapt_options.gradation = experiment.gradation;
        adapt_options.remesh = remesh_options;
        adapt_options.max_iterations = options.iterations;
        adapt_options.progress = [&](int iteration) { stages.detail("iteration " + std::to_string(iteration)); };
        side.adaption = adapt(model, adapt_options);
    });
}

Experiment run_experiment(const Options& options, const SurfaceModel& model, Stages& stages) {
    Experiment experiment;
    experiment.rule = rule_of(options.sizing, kLimits);
    experiment.gradation = *gradation_of(options.gradation, kPaperShock);
    experiment.sized = background_for(model, experiment.rule, stages);
    RefinedGradation map = stages.run(
        "gradation", [&] { return grade_refining(model, experiment.rule, experiment.gradation, experiment.sized); });
    experiment.raw.sizes = experiment.sized.sizes;
    experiment.corrected.sizes = std::move(map.sizes);
    experiment.graded = std::move(map.result);
    mesh_side(options, model, experiment, experiment.raw, stages);
    mesh_side(options, model, experiment, experiment.corrected, stages);
    return experiment;
}

// --- the table ---

std::string number(double value) { return fmt::format("{:.3f}", value); }
std::string general(double value) { return fmt::format("{:.4g}", value); }

using Rows = std::vector<std::vector<std::string>>;

// Columns: what, raw, the paper's raw, graded, the paper's graded.
Rows table_of(const Experiment& experiment) {
    const MeshReport &raw = experiment.raw.report, &graded = experiment.corrected.report;
    Rows rows{{"triangles", grouped(raw.topology.triangles), "", grouped(graded.topology.triangles), ""}};
    const auto quality = [&](const std::string& name, Summary ShapeReport::*measure) {
        const Summary &a = raw.shape.*measure, &b = graded.shape.*measure;
        rows.push_back(
            {name + ", worst", number(a.min), general(kPaperRaw.worst), number(b.min), general(kPaperGraded.worst)});
        rows.push_back(
            {name + ", mean", number(a.mean), general(kPaperRaw.mean), number(b.mean), general(kPaperGraded.mean)});
    };
    quality("area-length", &ShapeReport::area_length);
    quality("inradius-edge", &ShapeReport::inradius_edge);
    quality("radius ratio", &ShapeReport::radius_ratio);
    const auto plain = [&](const std::string& name, const std::string& a, const std::string& b) {
        rows.push_back({name, a, "", b, ""});
    };
    plain("smallest angle, degrees", fmt::format("{:.1f}", raw.shape.smallest_angle.min),
          fmt::format("{:.1f}", graded.shape.smallest_angle.min));
    plain("adjacent edges, largest ratio", fmt::format("{:.2f}", raw.shape.adjacent_edge_ratio.max),
          fmt::format("{:.2f}", graded.shape.adjacent_edge_ratio.max));
    plain("edges within [0.71, 1.41]", fmt::format("{:.2f} %", 100 * raw.edges->unit_share),
          fmt::format("{:.2f} %", 100 * graded.edges->unit_share));
    plain("H-shock of the map, largest", general(experiment.graded.before.shock_max),
          general(experiment.graded.after.shock_max));
    plain("H-shock of the mesh, largest", general(raw.gradation.shock.max), general(graded.gradation.shock.max));
    const auto share = [](double value) { return fmt::format("{:.3f} %", 100 * value); };
    plain("edge middles off the surface*", share(raw.distance->midpoints.p999), share(graded.distance->midpoints.p999));
    return rows;
}

// One row per iteration of the adaption loop.
Rows adaption_rows(const Side& side) {
    Rows rows{{"iteration", "triangles", "worst", "mean", "unit edges", "in the next map", "s"}};
    int index = 0;
    for (const AdaptIteration& i : side.adaption.iterations)
        rows.push_back({fmt::format("{}", ++index), grouped(i.triangles), number(i.quality_min), number(i.quality_mean),
                        fmt::format("{:.2f} %", 100 * i.unit_share), fmt::format("{:.2f} %", 100 * i.next_unit_share),
                        fmt::format("{:.1f}", i.seconds)});
    return rows;
}

std::string adaption_line(const Side& side) {
    return fmt::format("{} after {} iteration{}",
                       side.adaption.converged ? "the mesh meets the next map" : "the mesh does NOT meet the next map",
                       side.adaption.iterations.size(), side.adaption.iterations.size() == 1 ? "" : "s");
}

std::string results_of(const Options& options, const Experiment& experiment) {
    std::string text = fmt::format("sizes: {}; background of {} vertices\n", to_text(experiment.rule),
                                   grouped(experiment.sized.sizes.size()));
    text += text_of(experiment.gradation, experiment.graded, experiment.sized.sizes.size());
    Rows rows{{"", "raw", "(paper)", "graded", "(paper)"}};
    for (auto& row : table_of(experiment)) rows.push_back(row);
    text += "meshes\n" + aligned(rows) + "  * 99.9 % of them, relative to the diagonal\n";
    if (options.iterations > 0)
        for (const Side* side : {&experiment.raw, &experiment.corrected})
            text += fmt::format("adaption, {}: {}\n", side->name, adaption_line(*side)) + aligned(adaption_rows(*side));
    return text;
}

// --- machines ---

Json side_json(const Side& side) {
    Json iterations = Json::array();
    for (const AdaptIteration& i : side.adaption.iterations)
        iterations.push_back({{"background_vertices", i.background_vertices},
                              {"predicted_triangles", i.predicted_triangles},
                              {"triangles", i.triangles},
                              {"unit_share", i.unit_share},
                              {"next_unit_share", i.next_unit_share},
                              {"area_length_min", i.quality_min},
                              {"area_length_mean", i.quality_mean},
                              {"seconds", i.seconds}});
    return {{"predicted_triangles", side.meshed.statistics.predicted_triangles},
            {"mesh", json_of(side.report)},
            {"adaption", {{"converged", side.adaption.converged}, {"iterations", iterations}}}};
}

Json experiment_json(const Experiment& experiment, const std::vector<StageTime>& stages,
                     const std::vector<std::string>& files) {
    const auto published = [](const Published& p) { return Json{{"worst", p.worst}, {"mean", p.mean}}; };
    return {{"sizing", json_of(experiment.rule)},
            {"background",
             {{"vertices", experiment.sized.sizes.size()}, {"triangles", experiment.sized.background.patch.size()}}},
            {"gradation", json_of(experiment.gradation, experiment.graded)},
            {"raw", side_json(experiment.raw)},
            {"graded", side_json(experiment.corrected)},
            {"paper", {{"raw", published(kPaperRaw)}, {"graded", published(kPaperGraded)}}},
            {"stages", json_of(stages)},
            {"files", files}};
}

// --- pictures ---

Image above(const Experiment& experiment, const Image& raw, const Image& graded) {
    const auto name = [](const Side& side, const std::string& what) {
        return fmt::format("{}: {} triangles", what, grouped(side.report.topology.triangles));
    };
    const GradationOptions& g = experiment.gradation;
    const std::string bound =
        g.shock ? fmt::format("H-shock {:g}", *g.shock) : fmt::format("H-variation {:g}", *g.variation);
    const Panel panels[]{{raw, name(experiment.raw, "raw")}, {graded, name(experiment.corrected, "graded, " + bound)}};
    return compose(panels);
}

std::vector<double> qualities_of(const SurfaceMesh& mesh) {
    std::vector<double> qualities;
    for (const Triangle& t : mesh.triangles)
        qualities.push_back(area_length(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]));
    return qualities;
}

// Both with the colours of one scale.
Range common_range(const std::vector<double>& a, const std::vector<double>& b) {
    const Range x = range_of(a, Scale::Logarithmic), y = range_of(b, Scale::Logarithmic);
    return {std::min(x.low, y.low), std::max(x.high, y.high)};
}

std::vector<Picture> pictures_of(const Experiment& experiment) {
    const SurfaceMesh &raw = experiment.raw.meshed.mesh, &graded = experiment.corrected.meshed.mesh;
    std::vector<Picture> pictures;
    pictures.push_back({"raw", "The teapot without gradation", draw(raw)});
    pictures.push_back({"graded", "The teapot graded", draw(graded)});
    int index = 0;
    for (const Camera& camera : enlargements(raw, 2)) {
        const std::string i = std::to_string(++index);
        pictures.push_back({"enlargement-" + i, "Where sizes change most, " + i,
                            above(experiment, draw(raw, camera), draw(graded, camera))});
    }
    // The maps on the background they are given on.
    const auto points = points_of(experiment.sized.background.mesh);
    const std::vector<Triangle> triangles = triangles_of(experiment.sized.background.mesh);
    const SizedTriangles raw_map{points, triangles, experiment.raw.sizes},
        graded_map{points, triangles, experiment.corrected.sizes};
    const Range sizes = common_range(experiment.raw.sizes, experiment.corrected.sizes);
    pictures.push_back(
        {"size", "Size maps",
         above(experiment, draw(raw_map, Quantity::Size, sizes), draw(graded_map, Quantity::Size, sizes))});
    // The raw map jumps without bound at some edges: colours beyond a shock of 10 would leave none for the others.
    const Range shocks{1, 10};
    pictures.push_back(
        {"shock", "H-shock of the size maps",
         above(experiment, draw(raw_map, Quantity::Shock, shocks), draw(graded_map, Quantity::Shock, shocks))});
    const HistogramData left = count_values(qualities_of(raw), 50, Range{0, 1}),
                        right = count_values(qualities_of(graded), 50, Range{0, 1});
    pictures.push_back({"quality", "Area-length quality",
                        draw_histograms(left, {.title = "raw", .x_label = "area-length quality"}, right,
                                        {.title = "graded", .x_label = "area-length quality"})});
    return pictures;
}

// --- files ---

void write_page(const std::string& path, const Experiment& experiment, const std::vector<Picture>& pictures,
                const std::vector<StageTime>& stages) {
    HtmlReport page("The teapot, raw and graded", to_text(experiment.rule) + "; " + to_text(experiment.gradation));
    page.section("Beside the paper");
    page.table({"", "raw", "paper", "graded", "paper"}, table_of(experiment),
               "The paper gives one worst and one mean quality for each mesh, and does not say of which measure. * "
               "99.9 % of them, "
               "relative to the diagonal.");
    page.section("Pictures");
    for (const Picture& picture : pictures) page.picture(picture.title, picture.image);
    page.section("Size map");
    add_gradation(page, experiment.gradation, experiment.graded, experiment.sized.sizes.size());
    for (const Side* side : {&experiment.raw, &experiment.corrected}) {
        page.section(side == &experiment.raw ? "Raw mesh" : "Graded mesh");
        add_mesh(page, side->report);
        if (side->adaption.iterations.empty()) continue;
        Rows rows = adaption_rows(*side);
        const std::vector<std::string> header = rows.front();
        rows.erase(rows.begin());
        page.table(header, rows, adaption_line(*side));
    }
    page.section("Time");
    add_stages(page, stages);
    write_file(path, page.html());
}

std::vector<std::string> write_files(const Options& options, const SurfaceModel& model, const Experiment& experiment,
                                     Stages& stages) {
    std::vector<std::string> files;
    const auto file = [&](const std::string& name) { return files.emplace_back(options.folder + "/" + name); };
    stages.run("writing", [&] {
        write_mesh(file("background.mesh"), soup_from_background(experiment.sized.background));
        for (const Side* side : {&experiment.raw, &experiment.corrected}) {
            write_sizes(file(side->name + ".sol"), side->sizes);
            for (const char* extension : {".obj", ".mesh", ".vtu"})
                write_surface_mesh(file(side->name + extension), model, side->meshed.mesh);
        }
    });
    const std::vector<Picture> pictures = stages.run("pictures", [&] { return pictures_of(experiment); });
    for (const Picture& picture : pictures) write_png(file(picture.name + ".png"), picture.image);
    write_page(file("report.html"), experiment, pictures, stages.times());
    const std::string json = file("report.json");
    write(json, experiment_json(experiment, stages.times(), files));
    return files;
}

int run_teapot(const Options& options) {
    check(options.sizing);
    gradation_of(options.gradation, kPaperShock);
    if (!options.folder.empty()) make_folder(options.folder);
    Stages stages(options.session);
    const SurfaceModel model = stages.run("teapot", [] { return make_model(parse_patches(kTeapot, "teapot.bpt")); });
    const Experiment experiment = run_experiment(options, model, stages);
    std::vector<std::string> files;
    if (!options.folder.empty()) files = write_files(options, model, experiment, stages);

    options.session.say(text_of("teapot", model) + results_of(options, experiment) +
                        "time: " + text_of(stages.times()));
    if (!files.empty()) {
        std::string names;
        for (const std::string& path : files) names += " " + path.substr(options.folder.size() + 1);
        options.session.say(fmt::format("wrote into {}:{}\n", options.folder, names));
    }
    print(options.session, experiment_json(experiment, stages.times(), files));
    return experiment.graded.met ? kMet : kFailed;
}

}  // namespace

void add_teapot(CLI::App& app, Run& run) {
    CLI::App& command = *app.add_subcommand(
        "teapot", "The paper's experiment: the teapot meshed raw and graded, beside the paper's figures");
    const auto options = std::make_shared<Options>();
    command.add_option("--out", options->folder, "Write meshes, size maps, pictures and reports into this folder")
        ->type_name("DIR");
    add_sizing(command, options->sizing, kLimits);
    add_gradation(command, options->gradation, GradationNeeded::WithDefault);
    command.add_flag("--fast", options->fast, "Smooth shapes only, do not search for better ones");
    command
        .add_option("--iterations", options->iterations,
                    "Most iterations of the adaption loops; 0 leaves them out (default: 10)")
        ->type_name("N")
        ->check(CLI::Range(0, 1000).description(""));
    command.add_option("--max-triangles", options->max_triangles, "Refuse to make more")
        ->type_name("N")
        ->check(CLI::Range(100, 1'000'000'000).description(""));
    add_session(command, options->session);
    run_with(command, run, options, run_teapot);
}

}  // namespace gradus::app

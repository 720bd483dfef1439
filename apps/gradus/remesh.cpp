// gradus remesh: meshes a surface with sizes from its curvature, or from a size map.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "commands.hpp"
#include "files.hpp"
#include "gradus/io/mesh_files.hpp"
#include "gradus/io/output_file.hpp"
#include "gradus/remesh/parametric.hpp"
#include "json.hpp"
#include "output.hpp"
#include "page.hpp"
#include "pictures.hpp"
#include "show.hpp"
#include "sized.hpp"

namespace gradus::app {

namespace {

struct Options {
    Session session;
    std::string in;
    std::vector<std::string> out;
    std::string sizes, background, report, pictures;
    SizingOptions sizing;
    GradationChoice gradation;
    bool fast = false;
    int max_triangles = 20'000'000;
};

constexpr double kDefaultShock = 1.5;

// The size map a mesh is made for, and how it came about.
struct Map {
    SizedBackground sized;
    std::optional<SizingRule> rule;  // where sizes come from curvature
    std::optional<GradationResult> gradation;
};

void check_options(const Options& options) {
    check(options.sizing);
    for (const std::string& path : options.out) check_output(path, {FileKind::Mesh});
    if (!options.report.empty()) check_output(options.report, {FileKind::Report});
    std::vector<std::string> outputs = options.out;
    if (!options.report.empty()) outputs.push_back(options.report);
    check_distinct(outputs);
    if (!options.background.empty() && options.sizes.empty()) throw UsageError("--background needs --size, the sizes at its vertices");
    const SizingOptions& s = options.sizing;
    if (!options.sizes.empty() &&
        (s.alpha || s.relative_chord_error || s.chord_error || s.normal_angle || s.hmin || s.hmax || !s.at.empty()))
        throw UsageError(
            "--size gives all sizes; leave out --alpha, --hmin, --hmax, --size-at and the like, or use them in gradus sizemap");
    if (!options.pictures.empty()) make_folder(options.pictures);
}

SizedBackground read_map(const Options& options, const PatchModel& model) {
    SizedBackground sized{load_background(options.background.empty() ? background_beside(options.sizes) : options.background, model), {}};
    sized.sizes = read_sizes(options.sizes, sized.background.mesh.n_vertices());
    return sized;
}

void require_finite(const std::string& path, std::span<const double> sizes) {
    const auto unset = std::find_if(sizes.begin(), sizes.end(), [](double h) { return !std::isfinite(h); });
    if (unset != sizes.end())
        throw Failure(
            fmt::format("{}: vertex {} has no size; leave out --no-gradation, or grade the map first", path, unset - sizes.begin() + 1));
}

Map make_map(const Options& options, const PatchModel& model, const std::optional<GradationOptions>& gradation, Stages& stages) {
    Map map;
    if (options.sizes.empty()) {
        map.rule = rule_of(options.sizing, limits_for(model.diagonal()));
        map.sized = background_for(model, *map.rule, stages);
        if (!gradation) return map;
        GradedMap graded = grade_refining(model, *map.rule, *gradation, map.sized, stages);
        map.sized.sizes = std::move(graded.sizes);
        map.gradation = std::move(graded.result);
        return map;
    }
    map.sized = stages.run("size map", [&] { return read_map(options, model); });
    if (gradation) map.gradation = stages.run("gradation", [&] { return grade(map.sized.background.mesh, map.sized.sizes, *gradation); });
    require_finite(options.sizes, map.sized.sizes);
    return map;
}

// One line: what became of the sizes.
std::string gradation_line(const GradationOptions& options, const Map& map) {
    return fmt::format("gradation: {}; {:.4g} before, {:.1f} % of the vertices lowered{}\n", to_text(options),
                       options.shock ? map.gradation->before.shock_max : map.gradation->before.variation_max,
                       100.0 * map.gradation->lowered / static_cast<double>(map.sized.sizes.size()), map.gradation->met ? "" : ", NOT met");
}

void write_report(const Options& options, const std::optional<GradationOptions>& gradation, const Map& map, const MeshReport& report,
                  const std::vector<Picture>& pictures) {
    if (extension_of(options.report) == ".json") return write(options.report, json_of(report));
    HtmlReport page("Mesh of " + options.in, map.rule ? to_text(*map.rule) : "sizes of " + options.sizes);
    page.section("Mesh");
    add_mesh(page, report);
    if (map.gradation) {
        page.section("Size map");
        add_gradation(page, *gradation, *map.gradation, map.sized.sizes.size());
    }
    if (!pictures.empty()) page.section("Pictures");
    for (const Picture& picture : pictures) page.picture(picture.title, picture.image);
    page.section("Time");
    add_stages(page, report.stages);
    write_file(options.report, page.html());
}

int run_remesh(const Options& options) {
    const std::optional<GradationOptions> gradation = gradation_of(options.gradation, kDefaultShock);
    check_options(options);
    const Session& session = options.session;
    Stages stages(session);
    const PatchModel model = stages.run("reading", [&] { return load_model(options.in); });
    Map map = make_map(options, model, gradation, stages);
    const ControlSpace control = stages.run("control space", [&] { return ControlSpace(map.sized.background, map.sized.sizes); });
    RemeshOptions remesh_options{
        .fast = options.fast, .max_triangles = static_cast<double>(options.max_triangles), .threads = session.threads};
    const RemeshResult result = stages.run("meshing", [&] { return remesh(model, control, remesh_options); });
    const SurfaceMesh& mesh = result.mesh;
    stages.run("writing", [&] {
        for (const std::string& path : options.out) write_surface_mesh(path, model, mesh);
    });

    std::vector<std::string> files = options.out;
    std::optional<MeshReport> report;
    std::vector<Picture> pictures;
    if (!options.pictures.empty()) {
        pictures = stages.run("pictures", [&] { return pictures_of(mesh); });
        for (const Picture& picture : pictures) {
            files.push_back(options.pictures + "/" + picture.name + ".png");
            write_png(files.back(), picture.image);
        }
    }
    if (!options.report.empty()) {
        report = stages.run("report", [&] { return measure_surface_mesh(model, mesh, control); });
        report->stages = stages.times();
        write_report(options, gradation, map, *report, pictures);
        files.push_back(options.report);
    }

    const Shape shape = shape_of(mesh);
    const bool met = !map.gradation || map.gradation->met;
    if (session.talks()) {
        session.say(text_of(options.in, model));
        session.say(map.rule ? fmt::format("sizes: {}; background of {} vertices\n", to_text(*map.rule), grouped(map.sized.sizes.size()))
                             : fmt::format("sizes: {}, {} vertices\n", options.sizes, grouped(map.sized.sizes.size())));
        if (gradation) session.say(gradation_line(*gradation, map));
        session.say(fmt::format("mesh: {} triangles ({} expected), {} vertices; area-length worst {:.3f}, mean {:.4f}\n",
                                grouped(mesh.triangles.size()), grouped(std::llround(result.statistics.predicted_triangles)),
                                grouped(mesh.points.size()), shape.worst, shape.mean));
        session.say("time: " + text_of(stages.times()));
        session.say(fmt::format("wrote {}\n", fmt::join(files, " ")));
    }
    if (session.json) {
        Json json{{"patches", model.num_patches()},
                  {"sizing", map.rule ? json_of(*map.rule) : Json(nullptr)},
                  {"background_vertices", map.sized.sizes.size()},
                  {"gradation", gradation ? json_of(*gradation, *map.gradation) : Json(nullptr)},
                  {"triangles", mesh.triangles.size()},
                  {"vertices", mesh.points.size()},
                  {"predicted_triangles", result.statistics.predicted_triangles},
                  {"area_length", {{"min", shape.worst}, {"mean", shape.mean}}},
                  {"report", report ? json_of(*report) : Json(nullptr)},
                  {"stages", json_of(stages.times())},
                  {"meshing", Json::array()},
                  {"files", files}};
        for (const auto& [name, seconds] : result.statistics.seconds)
            json["meshing"].push_back({{"name", name.substr(name.find_first_not_of(' '))}, {"seconds", seconds}});
        print(session, json);
    }
    return met ? kMet : kFailed;
}

}  // namespace

void add_remesh(CLI::App& app, Run& run) {
    CLI::App& command = *app.add_subcommand("remesh", "Mesh a surface");
    const auto options = std::make_shared<Options>();
    command.add_option("IN", options->in, "Surface: Bezier patches, .bpt .bez")->required();
    command
        .add_option("-o,--output", options->out,
                    "Mesh, in the format of the extension: .obj .off .ply .stl .mesh .meshb .msh .vtu; may be repeated")
        ->required()
        ->type_name("OUT")
        ->type_size(1)
        ->allow_extra_args(false)
        ->take_all();
    command.add_option("--size", options->sizes, "Size map, one size per vertex of the background; without it sizes follow from curvature")
        ->type_name("MAP.sol");
    command.add_option("--background", options->background, "Background mesh of the size map (default: the .mesh beside MAP.sol)")
        ->type_name("BG.mesh");
    add_sizing(command, options->sizing);
    add_gradation(command, options->gradation, GradationNeeded::No);
    command.add_flag("--fast", options->fast, "Smooth shapes only, do not search for better ones");
    command.add_option("--max-triangles", options->max_triangles, "Refuse to make more")
        ->type_name("N")
        ->check(CLI::Range(100, 1'000'000'000).description(""));
    command.add_option("--report", options->report, "Measure the mesh and write a report")->type_name("R.html|R.json");
    command.add_option("--pictures", options->pictures, "Draw pictures into this folder")->type_name("DIR");
    add_session(command, options->session);
    run_with(command, run, options, run_remesh);
}

}  // namespace gradus::app

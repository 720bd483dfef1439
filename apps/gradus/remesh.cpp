// gradus remesh: meshes a surface with sizes from its curvature, or from a size map.
#include <fmt/format.h>

#include <memory>
#include <sstream>

#include "commands.hpp"
#include "files.hpp"
#include "gradus/io/output_file.hpp"
#include "json.hpp"
#include "output.hpp"
#include "page.hpp"
#include "show.hpp"
#include "source.hpp"

namespace gradus::app {

namespace {

struct Options {
    Session session;
    SourceChoice source;
    MeshRequest request;
    GradationChoice gradation;
    std::string report, pictures;
    int max_triangles = 20'000'000;
};

constexpr double kDefaultShock = 1.5;
constexpr std::size_t kPlacesTold = 5;  // of offenders; reports list more

void check_outputs(const Options& options) {
    const MeshRequest& request = options.request;
    for (const std::string& path : request.out) check_output(path, {FileKind::Mesh});
    if (!options.report.empty()) check_output(options.report, {FileKind::Report});
    std::vector<std::string> outputs = request.out;
    if (!options.report.empty()) outputs.push_back(options.report);
    check_distinct(outputs);
}

void check_sizes(const Options& options) {
    const MeshRequest& request = options.request;
    if (!request.background.empty() && request.sizes.empty())
        throw UsageError("--background needs --size, the sizes at its vertices");
    const SizingOptions& s = options.source.sizing;
    if (!request.sizes.empty() && (s.alpha || s.relative_chord_error || s.chord_error || s.normal_angle || s.hmin ||
                                   s.hmax || !s.at.empty() || s.feature_gap || s.gap || !s.regions.empty()))
        throw UsageError(
            "--size gives all sizes; leave out --alpha, --hmin, --hmax, --size-at and the like, or use them in gradus "
            "sizemap");
}

// One line: what became of the sizes.
std::string gradation_line(const GradationOptions& options, const GradationResult& result, std::size_t vertices) {
    const std::string before =
        options.shock ? shock_text(result.before.shock_max) : fmt::format("{:.4g}", result.before.variation_max);
    return fmt::format("gradation: {}; {} before, {:.1f} % of the vertices lowered{}\n", to_text(options), before,
                       100.0 * result.lowered / static_cast<double>(vertices), result.met ? "" : ", NOT met");
}

void write_report(const Options& options, const Made& made, const MeshReport& report,
                  const std::vector<Picture>& pictures) {
    if (extension_of(options.report) == ".json") {
        Json json = json_of(report);
        if (made.json.contains("chord_error"))
            json["deviation"] = {{"distance", made.json["distance"]},
                                 {"chord_error", made.json["chord_error"]},
                                 {"kept", made.json["chord_error_kept"]},
                                 {"new_contacts", made.json["new_contacts"]}};
        return write(options.report, json);
    }
    HtmlReport page("Mesh of " + options.source.in,
                    made.rule ? to_text(*made.rule) : "sizes of " + options.request.sizes);
    if (!made.note.empty()) {
        page.section("Surface");
        std::istringstream lines(made.surface + made.note);
        for (std::string line; std::getline(lines, line);) page.text(line);
        for (const std::string& note : made.notes) page.text(note);
    }
    page.section("Mesh");
    add_mesh(page, report);
    if (made.gradation) {
        page.section("Size map");
        add_gradation(page, *options.request.gradation, *made.gradation, made.background_vertices);
    }
    if (!pictures.empty()) page.section("Pictures");
    for (const Picture& picture : pictures) page.picture(picture.title, picture.image);
    page.section("Time");
    add_stages(page, report.stages);
    write_file(options.report, page.html());
}

// What was made and measured, to be told.
struct Outcome {
    Made made;
    std::vector<std::string> files;
    std::vector<Picture> pictures;
    std::optional<MeshReport> report;
    OffenderReport offenders;
};

void write_files(const Options& options, Outcome& outcome, Stages& stages) {
    const Made& made = outcome.made;
    const SurfaceMesh& mesh = made.result.mesh;
    stages.run("writing", [&] {
        for (const std::string& path : options.request.out) check_holds(path, mesh.points, mesh.triangles);
        for (const std::string& path : options.request.out) made.write(path);
    });
    outcome.files = options.request.out;
    if (!options.pictures.empty()) {
        outcome.pictures = stages.run("pictures", made.draw);
        for (const Picture& picture : outcome.pictures) {
            outcome.files.push_back(options.pictures + "/" + picture.name + ".png");
            write_png(outcome.files.back(), picture.image);
        }
    }
    if (!options.report.empty()) {
        outcome.report = stages.run("report", [&] { return made.measure(); });
        outcome.report->stages = stages.times();
        write_report(options, made, *outcome.report, outcome.pictures);
        outcome.files.push_back(options.report);
    }
    outcome.offenders =
        outcome.report ? outcome.report->offenders : stages.run("offenders", [&] { return offenders_of(mesh); });
}

void tell(const Options& options, const Outcome& outcome, const Stages& stages) {
    const Session& session = options.session;
    const Made& made = outcome.made;
    for (const std::string& note : made.notes) session.warn(options.source.in + ": " + note);
    if (!session.talks()) return;
    const Shape shape = shape_of(made.result.mesh);
    session.say(made.surface);
    session.say(
        made.rule ? fmt::format("sizes: {}; background of {} vertices\n", to_text(*made.rule),
                                grouped(made.background_vertices))
                  : fmt::format("sizes: {}, {} vertices\n", options.request.sizes, grouped(made.background_vertices)));
    if (options.request.gradation)
        session.say(gradation_line(*options.request.gradation, *made.gradation, made.background_vertices));
    session.say(fmt::format("mesh: {} triangles ({} expected), {} vertices; area-length worst {:.3f}, mean {:.4f}\n",
                            grouped(made.result.mesh.triangles.size()),
                            about(made.result.statistics.predicted_triangles), grouped(made.result.mesh.points.size()),
                            shape.worst, shape.mean));
    session.say(made.note);
    if (outcome.offenders.num_groups > 0) session.say(to_text(outcome.offenders, kPlacesTold));
    session.say("time: " + text_of(stages.times()));
    session.say(fmt::format("wrote {}\n", fmt::join(outcome.files, " ")));
}

Json summary_json(const Options& options, const Outcome& outcome, const Stages& stages) {
    const Made& made = outcome.made;
    const std::optional<GradationOptions>& gradation = options.request.gradation;
    const Shape shape = shape_of(made.result.mesh);
    Json json = made.json;
    json.update({{"sizing", made.rule ? json_of(*made.rule) : Json(nullptr)},
                 {"background_vertices", made.background_vertices},
                 {"gradation", gradation ? json_of(*gradation, *made.gradation) : Json(nullptr)},
                 {"triangles", made.result.mesh.triangles.size()},
                 {"vertices", made.result.mesh.points.size()},
                 {"predicted_triangles", made.result.statistics.predicted_triangles},
                 {"area_length", {{"min", shape.worst}, {"mean", shape.mean}}},
                 {"offenders", json_of(outcome.offenders)},
                 {"report", outcome.report ? json_of(*outcome.report) : Json(nullptr)},
                 {"stages", json_of(stages.times())},
                 {"meshing", Json::array()},
                 {"files", outcome.files}});
    for (const auto& [name, seconds] : made.result.statistics.seconds)
        json["meshing"].push_back({{"name", name}, {"seconds", seconds}});
    return json;
}

// @throws Failure where the mesh is not what was asked for
void require_met(const std::string& in, const Made& made) {
    if (made.contacts > 0)
        throw Failure(
            fmt::format("{}: the mesh is written, but {} pairs of its triangles touch or intersect; smaller sizes "
                        "there, or a smaller --hmin, may help",
                        in, grouped(made.contacts)));
    if (!made.met)
        throw Failure(in + ": the mesh is written, but farther from it than the chord error asked for" + made.where);
    if (made.gradation && !made.gradation->met)
        throw Failure(in + ": the mesh is written, but its sizes change faster than asked for");
}

int run_remesh(const Options& given) {
    Options options = given;
    MeshRequest& request = options.request;
    request.gradation = gradation_of(options.gradation, kDefaultShock);
    request.remesh.threads = options.session.threads;
    request.remesh.max_triangles = options.max_triangles;
    const std::unique_ptr<Source> source = source_of(options.source, options.session);
    check_outputs(options);
    source->check(request);
    check_sizes(options);
    if (!options.pictures.empty()) make_folder(options.pictures);

    Stages stages(options.session);
    Outcome outcome;
    outcome.made = source->mesh(request, stages);
    write_files(options, outcome, stages);
    tell(options, outcome, stages);
    if (options.session.json) print(options.session, summary_json(options, outcome, stages));
    require_met(options.source.in, outcome.made);
    return kMet;
}

}  // namespace

void add_remesh(CLI::App& app, Run& run) {
    CLI::App& command = *app.add_subcommand("remesh", "Mesh a surface");
    const auto options = std::make_shared<Options>();
    command
        .add_option("IN", options->source.in,
                    "Surface: Bezier patches, .bpt .bez, or a triangle mesh, .obj .off .ply .stl .mesh .meshb .msh "
                    ".vtu .vtp, or a planar domain, .poly .mesh")
        ->required();
    command
        .add_option("-o,--output", options->request.out,
                    "Mesh, in the format of the extension: .obj .off .ply .stl .mesh .meshb .msh .vtu; may be repeated")
        ->required()
        ->type_name("OUT")
        ->type_size(1)
        ->allow_extra_args(false)
        ->take_all();
    command
        .add_option("--size", options->request.sizes,
                    "Size map, one size per vertex of the background; without it sizes follow from curvature")
        ->type_name("MAP.sol");
    command
        .add_option(
            "--background", options->request.background,
            "Background mesh of the size map (default: the .mesh beside MAP.sol; for a triangulation IN itself)")
        ->type_name("BG.mesh");
    add_source(command, options->source);
    add_gradation(command, options->gradation, GradationNeeded::No);
    command
        .add_option("--field", options->request.fields,
                    "Fields at the vertices of IN, carried to the mesh as those of IN are; may be repeated")
        ->type_name("F.sol")
        ->type_size(1)
        ->allow_extra_args(false)
        ->take_all()
        ->group("Triangulations");
    command
        .add_flag("--anisotropic", options->request.anisotropic,
                  "Elements as long as --chord-error lets them be: of patches and cages")
        ->group("Sizes");
    command.add_flag("--fast", options->request.remesh.fast, "Smooth shapes only, do not search for better ones");
    command.add_option("--max-triangles", options->max_triangles, "Refuse to make more")
        ->type_name("N")
        ->check(CLI::Range(100, 700'000'000).description(""));
    command.add_option("--report", options->report, "Measure the mesh and write a report")->type_name("R.html|R.json");
    command
        .add_option(
            "--pictures", options->pictures,
            "Draw pictures into this folder: the mesh, its sizes, enlargements; of triangulations the input too")
        ->type_name("DIR");
    add_session(command, options->session);
    run_with(command, run, options, run_remesh);
}

}  // namespace gradus::app

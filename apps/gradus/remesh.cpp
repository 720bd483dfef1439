// gradus remesh: meshes a surface with sizes from its curvature, or from a size map.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <sstream>
#include <tuple>

#include "commands.hpp"
#include "fields.hpp"
#include "files.hpp"
#include "gradus/io/mesh_files.hpp"
#include "gradus/io/output_file.hpp"
#include "gradus/mesh/order.hpp"
#include "gradus/mesh/repair.hpp"
#include "gradus/remesh/chord_error.hpp"
#include "gradus/remesh/parametric.hpp"
#include "gradus/remesh/patch_chord_error.hpp"
#include "json.hpp"
#include "output.hpp"
#include "page.hpp"
#include "pictures.hpp"
#include "show.hpp"
#include "sized.hpp"
#include "triangulated.hpp"

namespace gradus::app {

namespace {

struct Options {
    Session session;
    std::string in;
    std::vector<std::string> out, fields;
    std::string sizes, background, report, pictures;
    SizingOptions sizing;
    GradationChoice gradation;
    TriangulationChoice surface;
    CageChoice cage;
    bool fast = false;
    int max_triangles = 20'000'000;
};

constexpr double kDefaultShock = 1.5;
constexpr int kMostAttempts = 6;  // to mend a mesh with more features
constexpr std::size_t
    kFewFaults = 4,
    kMostFaults = 20'000;  // few: what was hard on the way is left alone; too many: it is not for want of features
constexpr std::size_t kPlacesTold = 5;  // of offenders; reports list more

// A mesh with what is known of how it came about.
struct Made {
    RemeshResult result;
    std::optional<SizingRule> rule;  // where sizes come from curvature
    std::size_t background_vertices = 0;
    std::optional<GradationResult> gradation;
    std::string surface;  // a line on the input
    std::string note;     // lines on what else was asked and whether it was met
    bool met = true;
    std::string where;               // the chord error is not kept, and why
    std::vector<std::string> notes;  // to be noticed
    std::size_t contacts = 0;        // see NewContacts
    Json json;                       // keys of the input's kind
    std::function<MeshReport()> measure;
    std::function<void(const std::string& path)> write;
    std::function<std::vector<Picture>()> draw;
};

bool is_triangulation(const Options& options) { return is_mesh(options.in) && !options.cage.is_given(); }

void check_options(const Options& options) {
    check(options.sizing);
    check(options.cage);
    if (!is_triangulation(options)) {
        check_for_patches(options.sizing);
        check_for_patches(options.surface);
    }
    for (const std::string& path : options.out) check_output(path, {FileKind::Mesh});
    if (!options.report.empty()) check_output(options.report, {FileKind::Report});
    std::vector<std::string> outputs = options.out;
    if (!options.report.empty()) outputs.push_back(options.report);
    check_distinct(outputs);
    if (!options.background.empty() && options.sizes.empty())
        throw UsageError("--background needs --size, the sizes at its vertices");
    if (!options.fields.empty() && !is_triangulation(options))
        throw UsageError("--field is for triangle meshes, not for " + options.in);
    const SizingOptions& s = options.sizing;
    if (!options.sizes.empty() && (s.alpha || s.relative_chord_error || s.chord_error || s.normal_angle || s.hmin ||
                                   s.hmax || !s.at.empty() || s.feature_gap || s.gap || !s.regions.empty()))
        throw UsageError(
            "--size gives all sizes; leave out --alpha, --hmin, --hmax, --size-at and the like, or use them in gradus "
            "sizemap");
    if (!options.pictures.empty()) make_folder(options.pictures);
}

// The size map that patches are meshed for, and how it came about.
struct Map {
    SizedBackground sized;
    std::optional<SizingRule> rule;  // as asked for
    double hmin = 0;                 // of the sizes; a default one gives way to a chord error
    std::optional<GradationResult> gradation;
};

SizedBackground read_map(const Options& options, const SurfaceModel& model) {
    SizedBackground sized{
        load_background(options.background.empty() ? background_beside(options.sizes) : options.background, model), {}};
    sized.sizes = read_sizes(options.sizes, sized.background.mesh.n_vertices());
    return sized;
}

void require_finite(const std::string& path, std::span<const double> sizes) {
    const auto unset = std::find_if(sizes.begin(), sizes.end(), [](double h) { return !std::isfinite(h); });
    if (unset != sizes.end())
        throw Failure(fmt::format("{}: vertex {} has no size; leave out --no-gradation, or grade the map first", path,
                                  unset - sizes.begin() + 1));
}

Map make_map(const Options& options, const SurfaceModel& model, const std::optional<GradationOptions>& gradation,
             Stages& stages) {
    Map map;
    if (options.sizes.empty()) {
        map.rule = rule_of(options.sizing, limits_for(model.diagonal()));
        SizingRule rule = *map.rule;
        if (options.sizing.chord_error) {
            if (!options.sizing.hmin) rule.hmin *= kFinestSize;
            rule = rule_within(*options.sizing.chord_error, rule);
        }
        map.hmin = rule.hmin;
        map.sized = background_for(model, rule, stages);
        if (!gradation) return map;
        GradedMap graded = grade_refining(model, rule, *gradation, map.sized, stages);
        map.sized.sizes = std::move(graded.sizes);
        map.gradation = std::move(graded.result);
        return map;
    }
    map.sized = stages.run("size map", [&] { return read_map(options, model); });
    if (gradation)
        map.gradation =
            stages.run("gradation", [&] { return grade(map.sized.background.mesh, map.sized.sizes, *gradation); });
    gradation ? require_reached(options.sizes, map.sized.sizes) : require_finite(options.sizes, map.sized.sizes);
    return map;
}

RemeshOptions remesh_options(const Options& options) {
    return {.fast = options.fast,
            .max_triangles = static_cast<double>(options.max_triangles),
            .threads = options.session.threads};
}

// Meshes, measures, lowers sizes, until mesh and surface are within the chord error of each other.
void mesh_within(const Options& options, const std::optional<GradationOptions>& gradation, const SurfaceModel& model,
                 Map& map, Made& made, Stages& stages) {
    const double wanted = *options.sizing.chord_error;
    PatchChordErrorResult within = stages.run("meshing", [&] {
        return remesh_within(model, map.sized, wanted,
                             {.gradation = gradation, .hmin = map.hmin, .remesh = remesh_options(options)});
    });
    made.result = std::move(within.result);
    made.met = within.kept;
    const Deviation& d = within.deviation;
    made.note = fmt::format(
        "distance: at most {:.4g} from the surface to the mesh, {:.4g} back, {:.2g} of it for facets that stand for "
        "the surface; {:.4g} asked for, {}, sizes lowered {} times\n",
        d.from_reference.bound, d.from_mesh.bound, within.facets, wanted, within.kept ? "kept" : "NOT kept",
        within.lowerings);
    made.json = {{"distance",
                  {{"from_input", {{"bound", d.from_reference.bound}}},
                   {"from_mesh", {{"bound", d.from_mesh.bound}}},
                   {"facets", within.facets}}},
                 {"new_contacts", nullptr},
                 {"chord_error", wanted},
                 {"chord_error_kept", within.kept},
                 {"refinements", within.lowerings}};
    if (within.kept) return;
    const OneSidedDistance& side = d.from_mesh.largest >= d.from_reference.largest ? d.from_mesh : d.from_reference;
    made.where = fmt::format(", by {:.3g} at {:.6g} {:.6g} {:.6g}", side.largest, side.point.x(), side.point.y(),
                             side.point.z());
    if (options.sizing.hmin)
        made.where += fmt::format("; --hmin {:g} may allow no smaller elements", *options.sizing.hmin);
}

Made mesh_patches(const Options& options, const std::optional<GradationOptions>& gradation, Stages& stages) {
    LoadedModel loaded = stages.run("reading", [&] { return load_model(options.in, options.cage); });
    const auto model = std::make_shared<const SurfaceModel>(std::move(loaded.model));
    const auto map = std::make_shared<Map>(make_map(options, *model, gradation, stages));
    Made made;
    if (options.sizing.chord_error) mesh_within(options, gradation, *model, *map, made, stages);
    const auto control = stages.run(
        "control space", [&] { return std::make_shared<const ControlSpace>(map->sized.background, map->sized.sizes); });
    if (!options.sizing.chord_error)
        made.result = stages.run("meshing", [&] { return remesh(*model, *control, remesh_options(options)); });
    made.rule = map->rule;
    made.background_vertices = map->sized.sizes.size();
    made.gradation = map->gradation;
    made.surface = text_of(options.in, *model);
    made.json["patches"] = model->num_patches();
    // The mesh itself is the caller's when these are called.
    const SurfaceMesh mesh = made.result.mesh;
    made.measure = [model, map, control, mesh] {
        return measure_surface_mesh(*model, mesh, *control);
    };  // control is a view of the map
    made.write = [=, labels = loaded.labels](const std::string& path) {
        write_surface_mesh(path, *model, mesh, labels);
    };
    made.draw = [=] { return pictures_of(mesh); };
    return made;
}

using Meshed = std::pair<std::shared_ptr<const Triangulation>, std::shared_ptr<const TriangulatedMesh>>;

// Where a mesh does not keep the chord error or touches itself: folds that were taken for noise, or for coarse rounds,
// may have to be features after all. @returns the best mesh, with what it is a mesh of
template <class MeshIt>
Meshed mend_by_features(Meshed best, const Options& options, const MeshIt& mesh_it, Stages& stages) {
    Meshed last = best;
    auto& [surface, mesh] = last;
    std::vector<Eigen::Vector3d> faults;
    const auto what_is_wrong = [](const TriangulatedMesh& of) {
        return std::tuple(!of.kept, of.contacts.count, of.deviation.bound());
    };
    for (int attempt = 1; (!mesh->kept || mesh->contacts.count > 0) && attempt <= kMostAttempts; ++attempt) {
        faults.insert(faults.end(), mesh->faults.begin(), mesh->faults.end());
        for (const NewContact& contact : mesh->contacts.listed) faults.push_back(contact.point);
        if (attempt > 1 || mesh->faults.size() > kFewFaults)
            faults.insert(faults.end(), mesh->stubborn.begin(), mesh->stubborn.end());
        if (faults.size() > kMostFaults) break;
        surface = stages.run("features", [&, &before = *surface] {
            return with_features_at(faults, options.in, before, options.surface, options.sizing);
        });
        if (!surface) break;
        try {
            mesh = mesh_it(*surface);
        } catch (const std::length_error&) {
            break;  // more triangles than there may be
        }
        if (what_is_wrong(*mesh) < what_is_wrong(*best.second)) best = last;
    }
    return best;
}

Made mesh_triangles(const Options& options, const std::optional<GradationOptions>& gradation, Stages& stages) {
    OrderedTriangulation ordered = stages.run(
        "reading", [&] { return load_ordered(options.in, options.surface, options.sizing, options.session); });
    std::shared_ptr<const Triangulation> surface = std::move(ordered.surface);
    GivenSizes given;
    if (!options.sizes.empty()) {
        given = stages.run("size map", [&] { return read_given_sizes(options.sizes, options.background, *surface); });
        if (!gradation) require_finite(options.sizes, given.sizes);
        if (!given.background) reorder(given.sizes, ordered.point_source);
    }
    const Fields fields = stages.run("reading fields", [&] {
        Fields read = load_fields(options.in, options.surface.repair, options.fields);
        read.points = follow(read.points, ordered.point_source);
        read.cells = follow(read.cells, ordered.triangle_source);
        return read;
    });
    ordered = {};
    const SizingRule rule = rule_of(options.sizing, limits_for(surface->diagonal()));
    const auto mesh_it = [&](const Triangulation& triangles) {
        return std::make_shared<const TriangulatedMesh>(mesh_triangulation(
            triangles, rule, given, gradation, remesh_options(options), options.sizing.hmin.has_value(), stages));
    };
    auto mesh = mesh_it(*surface);
    const auto features_before = std::ssize(surface->features().edges());
    std::tie(surface, mesh) = mend_by_features({surface, mesh}, options, mesh_it, stages);
    const auto features_added = std::ssize(surface->features().edges()) - features_before;
    const auto carried = std::make_shared<const Fields>(
        stages.run("fields", [&] { return carry(*surface, fields, mesh->result.mesh, options.out); }));
    Made made;
    made.result = mesh->result;
    if (options.sizes.empty()) made.rule = rule;
    made.background_vertices = mesh->background_vertices;
    made.gradation = mesh->gradation;
    made.surface = text_of(options.in, *surface);
    if (features_added != 0)
        made.note = fmt::format(
            "features: {} edges more than their angles ask for, where the mesh was too far from the input or touched "
            "itself\n",
            grouped(static_cast<long long>(features_added)));
    made.note += text_of(mesh->result.mesh.required, options.out) + text_of(*mesh, surface->diagonal()) +
                 text_of(fields, options.out);
    made.met = mesh->kept;
    if (!mesh->kept) made.where = why_not_kept(*surface, *mesh);
    made.notes = notes_on(*surface, *mesh);
    for (const std::string& path : options.out)
        if (!surface->soup().labels.empty() && !holds_labels(path))
            made.notes.push_back(
                fmt::format("its labels are left behind, {} can hold none; .mesh .msh .ply .vtu can", path));
    made.contacts = mesh->contacts.count;
    made.json = json_of(*surface);
    made.json.update(json_of(*mesh));
    made.json["features_added"] = features_added;
    made.json["fields"] = json_of(fields, options.out);
    made.measure = [=] { return measure_surface_mesh(*mesh); };
    made.write = [=](const std::string& path) {
        write_surface_mesh(path, mesh->result.mesh, !surface->soup().labels.empty(), carried->points, carried->cells);
    };
    made.draw = [=] {
        const std::vector<std::array<int, 2>> features = surface->features().edges();
        return pictures_of(
            mesh->result.mesh,
            DrawnMesh{.points = surface->soup().points, .triangles = surface->soup().triangles, .features = features});
    };
    return made;
}

// One line: what became of the sizes.
std::string gradation_line(const GradationOptions& options, const GradationResult& result, std::size_t vertices) {
    constexpr double kBeyondTelling = 1000;
    const double before = options.shock ? result.before.shock_max : result.before.variation_max;
    return fmt::format("gradation: {}; {} before, {:.1f} % of the vertices lowered{}\n", to_text(options),
                       before < kBeyondTelling ? fmt::format("{:.4g}", before) : fmt::format("> {:g}", kBeyondTelling),
                       100.0 * result.lowered / static_cast<double>(vertices), result.met ? "" : ", NOT met");
}

void write_report(const Options& options, const std::optional<GradationOptions>& gradation, const Made& made,
                  const MeshReport& report, const std::vector<Picture>& pictures) {
    if (extension_of(options.report) == ".json") {
        Json json = json_of(report);
        if (made.json.contains("chord_error"))
            json["deviation"] = {{"distance", made.json["distance"]},
                                 {"chord_error", made.json["chord_error"]},
                                 {"kept", made.json["chord_error_kept"]},
                                 {"new_contacts", made.json["new_contacts"]}};
        return write(options.report, json);
    }
    HtmlReport page("Mesh of " + options.in, made.rule ? to_text(*made.rule) : "sizes of " + options.sizes);
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
        add_gradation(page, *gradation, *made.gradation, made.background_vertices);
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
    const Made made = is_triangulation(options) ? mesh_triangles(options, gradation, stages)
                                                : mesh_patches(options, gradation, stages);
    const SurfaceMesh& mesh = made.result.mesh;
    stages.run("writing", [&] {
        for (const std::string& path : options.out) check_holds(path, mesh.points, mesh.triangles);
        for (const std::string& path : options.out) made.write(path);
    });

    std::vector<std::string> files = options.out;
    std::optional<MeshReport> report;
    std::vector<Picture> pictures;
    if (!options.pictures.empty()) {
        pictures = stages.run("pictures", made.draw);
        for (const Picture& picture : pictures) {
            files.push_back(options.pictures + "/" + picture.name + ".png");
            write_png(files.back(), picture.image);
        }
    }
    if (!options.report.empty()) {
        report = stages.run("report", [&] { return made.measure(); });
        report->stages = stages.times();
        write_report(options, gradation, made, *report, pictures);
        files.push_back(options.report);
    }

    const Shape shape = shape_of(mesh);
    const OffenderReport offenders =
        report ? report->offenders : stages.run("offenders", [&] { return offenders_of(mesh); });
    const bool met = made.met && (!made.gradation || made.gradation->met);
    for (const std::string& note : made.notes) session.warn(options.in + ": " + note);
    if (session.talks()) {
        session.say(made.surface);
        session.say(made.rule
                        ? fmt::format("sizes: {}; background of {} vertices\n", to_text(*made.rule),
                                      grouped(made.background_vertices))
                        : fmt::format("sizes: {}, {} vertices\n", options.sizes, grouped(made.background_vertices)));
        if (gradation) session.say(gradation_line(*gradation, *made.gradation, made.background_vertices));
        session.say(
            fmt::format("mesh: {} triangles ({} expected), {} vertices; area-length worst {:.3f}, mean {:.4f}\n",
                        grouped(mesh.triangles.size()), about(made.result.statistics.predicted_triangles),
                        grouped(mesh.points.size()), shape.worst, shape.mean));
        session.say(made.note);
        if (offenders.num_groups > 0) session.say(to_text(offenders, kPlacesTold));
        session.say("time: " + text_of(stages.times()));
        session.say(fmt::format("wrote {}\n", fmt::join(files, " ")));
    }
    if (session.json) {
        Json json = made.json;
        json.update({{"sizing", made.rule ? json_of(*made.rule) : Json(nullptr)},
                     {"background_vertices", made.background_vertices},
                     {"gradation", gradation ? json_of(*gradation, *made.gradation) : Json(nullptr)},
                     {"triangles", mesh.triangles.size()},
                     {"vertices", mesh.points.size()},
                     {"predicted_triangles", made.result.statistics.predicted_triangles},
                     {"area_length", {{"min", shape.worst}, {"mean", shape.mean}}},
                     {"offenders", json_of(offenders)},
                     {"report", report ? json_of(*report) : Json(nullptr)},
                     {"stages", json_of(stages.times())},
                     {"meshing", Json::array()},
                     {"files", files}});
        for (const auto& [name, seconds] : made.result.statistics.seconds)
            json["meshing"].push_back({{"name", name}, {"seconds", seconds}});
        print(session, json);
    }
    if (made.contacts > 0)
        throw Failure(
            fmt::format("{}: the mesh is written, but {} pairs of its triangles touch or intersect; smaller sizes "
                        "there, or a smaller --hmin, may help",
                        options.in, grouped(made.contacts)));
    if (!made.met)
        throw Failure(options.in + ": the mesh is written, but farther from it than the chord error asked for" +
                      made.where);
    if (!met) throw Failure(options.in + ": the mesh is written, but its sizes change faster than asked for");
    return kMet;
}

}  // namespace

void add_remesh(CLI::App& app, Run& run) {
    CLI::App& command = *app.add_subcommand("remesh", "Mesh a surface");
    const auto options = std::make_shared<Options>();
    command
        .add_option("IN", options->in,
                    "Surface: Bezier patches, .bpt .bez, or a triangle mesh, .obj .off .ply .stl .mesh .meshb .msh "
                    ".vtu .vtp, or a planar domain, .poly .mesh")
        ->required();
    command
        .add_option("-o,--output", options->out,
                    "Mesh, in the format of the extension: .obj .off .ply .stl .mesh .meshb .msh .vtu; may be repeated")
        ->required()
        ->type_name("OUT")
        ->type_size(1)
        ->allow_extra_args(false)
        ->take_all();
    command
        .add_option("--size", options->sizes,
                    "Size map, one size per vertex of the background; without it sizes follow from curvature")
        ->type_name("MAP.sol");
    command
        .add_option(
            "--background", options->background,
            "Background mesh of the size map (default: the .mesh beside MAP.sol; for a triangulation IN itself)")
        ->type_name("BG.mesh");
    add_sizing(command, options->sizing);
    add_clearances(command, options->sizing);
    add_gradation(command, options->gradation, GradationNeeded::No);
    add_triangulation(command, options->surface);
    add_cages(command, options->cage);
    command
        .add_option("--field", options->fields,
                    "Fields at the vertices of IN, carried to the mesh as those of IN are; may be repeated")
        ->type_name("F.sol")
        ->type_size(1)
        ->allow_extra_args(false)
        ->take_all()
        ->group("Triangulations");
    command.add_flag("--fast", options->fast, "Smooth shapes only, do not search for better ones");
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

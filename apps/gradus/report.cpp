// gradus report: measures any triangle mesh, against a surface and a size map where they are given.
#include <fmt/format.h>

#include <map>

#include "commands.hpp"
#include "files.hpp"
#include "gradus/control/control_space.hpp"
#include "gradus/control/triangles_under.hpp"
#include "gradus/io/mesh_files.hpp"
#include "gradus/io/output_file.hpp"
#include "gradus/mesh/parts.hpp"
#include "gradus/surface/locate.hpp"
#include "json.hpp"
#include "page.hpp"

namespace gradus::app {

namespace {

struct Options {
    Session session;
    std::string mesh, reference, sizes, background, out;
    CageChoice cage;
};

// Where the vertices of a mesh lie on a surface.
struct Placing {
    std::vector<SurfacePoint> places;
    std::vector<int> patches;  // of triangles; empty where the file does not know
    std::size_t from_file = 0;
};

// Where parts of a surface run through each other the closest point may be on either: each connected part of the mesh
// keeps to the component that most of its vertices are on, and strays are found again from a neighbour.
void keep_to_components(const SurfaceModel& model, const TriangleSoup& soup, std::vector<SurfacePoint>& places) {
    const std::vector<int> part = connected_parts(soup.points.size(), soup.triangles);
    std::map<int, std::map<int, int>> votes;  // of each part, for each component
    for (std::size_t v = 0; v < places.size(); ++v)
        if (places[v].patch >= 0) ++votes[part[v]][model.component(places[v].patch)];
    const auto strays = [&](int v) {
        const auto& vote = votes[part[v]];
        const auto winner = std::max_element(vote.begin(), vote.end(),
                                             [](const auto& a, const auto& b) { return a.second < b.second; });
        return winner != vote.end() && places[v].patch >= 0 && model.component(places[v].patch) != winner->first;
    };
    for (bool found = true; found;) {
        found = false;
        for (const Triangle& t : soup.triangles)
            for (int k = 0; k < 3; ++k) {
                const int v = t[k], from = t[(k + 1) % 3];
                if (!strays(v) || strays(from) || places[from].patch < 0) continue;
                places[v] = project(model, soup.points[v], places[from]).at;
                found = true;
            }
    }
}

// Parameters of the file where they hold good, else the closest point.
Placing place(const SurfaceModel& model, const TriangleSoup& soup) {
    constexpr double kHolds =
        1e-6;  // of the diagonal: a file of another surface, or of another numbering, is farther off
    Placing placing;
    placing.places.resize(soup.points.size());
    for (const TriangleSoup::Parameters& p : soup.parameters) {
        SurfacePoint& at = placing.places[p.vertex];
        if (at.patch >= 0 || p.at.patch < 0 || p.at.patch >= model.num_patches()) continue;
        const Domain domain = model.patch(p.at.patch).domain();
        const bool inside =
            (p.at.uv.array() >= domain.min.array()).all() && (p.at.uv.array() <= domain.max.array()).all();
        if (inside && (model.position(p.at) - soup.points[p.vertex]).norm() <= kHolds * model.diagonal())
            at = p.at, ++placing.from_file;
    }
    std::vector<int> homeless;
    std::vector<Eigen::Vector3d> points;
    for (std::size_t v = 0; v < soup.points.size(); ++v)
        if (placing.places[v].patch < 0) homeless.push_back(static_cast<int>(v)), points.push_back(soup.points[v]);
    const std::vector<SurfacePoint> found = locate(model, points);
    for (std::size_t i = 0; i < homeless.size(); ++i) placing.places[homeless[i]] = found[i];
    if (!homeless.empty()) keep_to_components(model, soup, placing.places);
    // Labels are patches only in files that speak of places on them.
    if (!homeless.empty() || soup.labels.empty()) return placing;
    for (const int label : soup.labels) {
        if (label < 1 || label > model.num_patches()) {
            placing.patches.clear();
            return placing;
        }
        placing.patches.push_back(label - 1);
    }
    return placing;
}

// The size map, and where to start looking in it for each vertex.
struct Map {
    Background background;
    std::optional<ControlSpace> space;
    std::vector<int> cells;
};

void read_map(const Options& options, const TriangleSoup& mesh, Map& map) {
    const std::string path = options.background.empty() ? background_beside(options.sizes) : options.background;
    const TriangleSoup soup = read_mesh(path);
    map.background.mesh = manifold_of(path, soup);
    map.space.emplace(map.background, read_sizes(options.sizes, soup.points.size()));
    map.cells = triangles_under(map.background.mesh, mesh.points, mesh.triangles);
}

// The surface a mesh stands for, of either kind, or none. The options of a measurement point into it.
struct Against {
    std::optional<SurfaceModel> model;
    Placing placing;
    TriangleSoup surface;
    std::optional<Reference> reference;
};

void require_triangles(const std::string& path, const TriangleSoup& soup) {
    if (soup.triangles.empty()) throw Failure(path + ": holds no triangles");
}

void read_reference(const Options& options, const TriangleSoup& mesh, Against& against, MeasureOptions& measures,
                    Stages& stages) {
    if (options.reference.empty()) return;
    if (is_triangulation(options.reference, options.cage)) {
        stages.run("reference", [&] {
            against.surface = read_mesh(options.reference);
            require_triangles(options.mesh, mesh);
            require_triangles(options.reference, against.surface);
            against.reference.emplace(MeshView{against.surface.points, against.surface.triangles});
        });
        measures.reference = &*against.reference;
        return;
    }
    against.model.emplace(
        stages.run("reference", [&] { return std::move(load_model(options.reference, options.cage).model); }));
    against.placing = stages.run("placing", [&] { return place(*against.model, mesh); });
    measures.model = &*against.model;
    measures.places = against.placing.places;
    measures.patches = against.placing.patches;
}

void write_page(const Options& options, const MeshReport& report) {
    HtmlReport page(options.mesh, options.reference.empty() ? "" : "on " + options.reference);
    page.section("Mesh");
    add_mesh(page, report);
    page.section("Time");
    add_stages(page, report.stages);
    write_file(options.out, page.html());
}

int run_report(const Options& options) {
    if (!options.out.empty()) check_output(options.out, {FileKind::Report});
    if (!options.background.empty() && options.sizes.empty())
        throw UsageError("--background needs --size, the sizes at its vertices");
    check(options.cage);
    if (options.cage.is_given() && options.reference.empty())
        throw UsageError("--subdivision says how the reference is meant; give --reference too");
    Stages stages(options.session);
    const TriangleSoup soup = stages.run("reading", [&] { return read_mesh(options.mesh); });
    MeasureOptions measure_options;
    Against against;
    read_reference(options, soup, against, measure_options, stages);
    Map map;
    if (!options.sizes.empty()) {
        stages.run("size map", [&] { read_map(options, soup, map); });
        measure_options.size = [&](const Eigen::Vector3d& p, int& cell) { return map.space->size(p, cell); };
        measure_options.size_hints = map.cells;
    }
    // Formats that hold no features leave them to be found by angle.
    const KnownFeatures features{.edges = soup.edges, .corners = soup.corners, .labels = soup.labels};
    if (!soup.edges.empty()) measure_options.features = &features;
    measure_options.required = &soup.required;
    MeshReport report = stages.run("measures", [&] {
        try {
            return measure({soup.points, soup.triangles}, measure_options);
        } catch (const std::invalid_argument& error) {
            throw Failure(options.mesh + ": " + error.what());
        }
    });
    report.stages = stages.times();

    if (!options.out.empty()) {
        if (extension_of(options.out) == ".json")
            write(options.out, json_of(report));
        else
            write_page(options, report);
    }
    options.session.say(options.mesh + "\n" + to_text(report));
    if (against.model)
        options.session.say(fmt::format("\nplaces on {}: {} vertices from the file, {} found\n", options.reference,
                                        grouped(against.placing.from_file),
                                        grouped(soup.points.size() - against.placing.from_file)));
    if (!options.out.empty()) options.session.say(fmt::format("wrote {}\n", options.out));
    print(options.session, json_of(report));
    return kMet;
}

}  // namespace

void add_report(CLI::App& app, Run& run) {
    CLI::App& command =
        *app.add_subcommand("report", "Measure a mesh: shape, gradation, lengths in a size map, distance to a surface");
    const auto options = std::make_shared<Options>();
    command.add_option("MESH", options->mesh, "Triangle mesh: .mesh .meshb .msh .obj .off .ply .stl .vtu .vtp .poly")
        ->required();
    command
        .add_option("--reference", options->reference, "The surface it stands for: Bezier patches, or a triangle mesh")
        ->type_name("IN");
    command.add_option("--size", options->sizes, "Size map it was made for")->type_name("MAP.sol");
    command
        .add_option("--background", options->background,
                    "Background mesh of the size map (default: the .mesh beside MAP.sol)")
        ->type_name("BG.mesh");
    command.add_option("-o,--output", options->out, "Write the report to a file as well")->type_name("R.html|R.json");
    add_cages(command, options->cage);
    add_session(command, options->session);
    run_with(command, run, options, run_report);
}

}  // namespace gradus::app

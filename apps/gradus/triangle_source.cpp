// Triangulations, and planar domains as triangles.
#include <fmt/format.h>

#include <stdexcept>

#include "fields.hpp"
#include "files.hpp"
#include "gradus/io/mesh_files.hpp"
#include "gradus/mesh/order.hpp"
#include "output.hpp"
#include "source.hpp"

namespace gradus::app {

namespace {

class TriangleSource final : public Source {
  public:
    TriangleSource(const SourceChoice& choice, const Session& session) : choice_(choice), session_(session) {}

    void check(const MeshRequest& request) const override {
        if (request.anisotropic) throw UsageError("--anisotropic is for patches and cages, not for " + choice_.in);
    }
    Made mesh(const MeshRequest& request, Stages& stages) const override;
    Mapped map(const MapRequest& request, Stages& stages) const override;

  private:
    SizingRule rule_for(const Triangulation& surface) const {
        return rule_of(choice_.sizing, limits_for(surface.diagonal()));
    }
    GivenSizes read_sizes_of(const MeshRequest& request, const OrderedTriangulation& ordered, Stages& stages) const;
    MeshedTriangulation meshed(std::shared_ptr<const Triangulation> surface, const GivenSizes& given,
                               const MeshRequest& request, Stages& stages) const;
    void map_refined(const MapRequest& request, const Triangulation& surface, Mapped& map) const;

    SourceChoice choice_;
    Session session_;
};

GivenSizes TriangleSource::read_sizes_of(const MeshRequest& request, const OrderedTriangulation& ordered,
                                         Stages& stages) const {
    if (request.sizes.empty()) return {};
    GivenSizes given =
        stages.run("size map", [&] { return read_given_sizes(request.sizes, request.background, *ordered.surface); });
    if (!request.gradation) require_finite(request.sizes, given.sizes);
    if (!given.background) reorder(given.sizes, ordered.point_source);
    return given;
}

MeshedTriangulation TriangleSource::meshed(std::shared_ptr<const Triangulation> surface, const GivenSizes& given,
                                           const MeshRequest& request, Stages& stages) const {
    const SizingRule rule = rule_for(*surface);
    const double least = least_chord_error(surface->soup().points);
    if (rule.kind == SizingRule::Kind::ChordError && rule.value < least)
        throw Failure(fmt::format(
            "--chord-error {:g}: below {:.3g}, what distances are rounded to with coordinates as large as these",
            rule.value, least));
    TriangulationMeshOptions options{
        .gradation = request.gradation,
        .keeps_hmin = choice_.sizing.hmin.has_value(),
        .triangulation = triangulation_options(choice_.surface),
        .remesh = request.remesh,
        .run_stage = [&](std::string_view name,
                         const std::function<void()>& stage) { stages.run(std::string(name), stage); },
        .on_check =
            [&](const SurfaceMesh& draft) {
                stages.detail(fmt::format("{} triangles", grouped(draft.triangles.size())));
            }};
    if (given.sizes.empty()) return mesh_triangulation(std::move(surface), rule, options);
    options.sizes = [&](const Triangulation& of) { return given_background(of, given); };
    try {
        return mesh_triangulation(std::move(surface), rule, options);
    } catch (const std::invalid_argument& error) {
        throw Failure(given.path + ": " + error.what());
    }
}

Made TriangleSource::mesh(const MeshRequest& request, Stages& stages) const {
    OrderedTriangulation ordered =
        stages.run("reading", [&] { return load_ordered(choice_.in, choice_.surface, choice_.sizing, session_); });
    const GivenSizes given = read_sizes_of(request, ordered, stages);
    const Fields fields = stages.run("reading fields", [&] {
        Fields read = load_fields(choice_.in, choice_.surface.repair, request.fields);
        read.points = follow(read.points, ordered.point_source);
        read.cells = follow(read.cells, ordered.triangle_source);
        return read;
    });
    std::shared_ptr<const Triangulation> surface = std::move(ordered.surface);
    ordered = {};
    const auto features_before = std::ssize(surface->features().edges());
    MeshedTriangulation of = meshed(surface, given, request, stages);
    surface = of.surface;
    const auto mesh = std::make_shared<const TriangulationMesh>(std::move(of.mesh));
    const auto features_added = std::ssize(surface->features().edges()) - features_before;
    const auto carried = std::make_shared<const Fields>(
        stages.run("fields", [&] { return carry(*surface, fields, mesh->result.mesh, request.out); }));
    Made made;
    made.result = mesh->result;
    if (request.sizes.empty()) made.rule = rule_for(*surface);
    made.background_vertices = mesh->background_vertices;
    made.gradation = mesh->gradation;
    made.surface = text_of(choice_.in, *surface);
    if (features_added != 0)
        made.note = fmt::format(
            "features: {} edges more than their angles ask for, where the mesh was too far from the input or touched "
            "itself\n",
            grouped(static_cast<long long>(features_added)));
    made.note += text_of(mesh->result.mesh.required, request.out) + text_of(*mesh, surface->diagonal()) +
                 text_of(fields, request.out);
    made.met = mesh->kept;
    if (!mesh->kept) made.where = why_not_kept(*surface, *mesh);
    const bool has_labels = !surface->soup().labels.empty();
    made.notes = notes_on(*surface, *mesh);
    for (std::string& note : labels_left_behind(has_labels, request.out)) made.notes.push_back(std::move(note));
    made.contacts = mesh->contacts.count;
    made.json = json_of(*surface);
    made.json.update(json_of(*mesh));
    made.json["features_added"] = features_added;
    made.json["fields"] = json_of(fields, request.out);
    made.measure = [=] { return measure_surface_mesh(*mesh); };
    made.write = [=](const std::string& path) {
        write_surface_mesh(path, mesh->result.mesh, has_labels, carried->points, carried->cells);
    };
    made.draw = [=] {
        const std::vector<std::array<int, 2>> features = surface->features().edges();
        return pictures_of(
            mesh->result.mesh,
            DrawnMesh{.points = surface->soup().points, .triangles = surface->soup().triangles, .features = features});
    };
    return made;
}

// Sizes on a refinement of the triangulation, or with them on a given background.
void TriangleSource::map_refined(const MapRequest& request, const Triangulation& surface, Mapped& map) const {
    TriangulationBackground refined = make_background(surface, map.rule, request.max_triangles);
    const std::size_t triangles = refined.background.mesh.n_faces();
    if (triangles >= static_cast<std::size_t>(request.max_triangles))
        throw std::length_error("the background mesh needs more than " + grouped(request.max_triangles) + " triangles");
    if (request.background.empty()) {
        map.sizes = std::move(refined.sizes);
        map.background = std::move(refined.background);
        const auto points = points_of(map.background.mesh);
        map.soup = {.points = {points.begin(), points.end()}, .triangles = triangles_of(map.background.mesh)};
        map.soup.dimension = surface.soup().dimension;
        map.accuracy = triangles == surface.soup().triangles.size() ? "those of the input, which are fine enough"
                                                                    : "the input refined";
        return;
    }
    map.soup = read_mesh(request.background);
    map.background.mesh = manifold_of(request.background, map.soup);
    try {
        map.sizes = sizes_at(refined, map.soup);
    } catch (const std::invalid_argument& error) {
        throw Failure(request.background + ": " + error.what());
    }
    lower_to_prescribed(map.rule.at, map.soup.points, map.sizes);
    map.accuracy = "as given";
}

// The background of a triangulation is itself, unless a finer or another one is asked for.
Mapped TriangleSource::map(const MapRequest& request, Stages& stages) const {
    const auto surface = stages.run(
        "reading", [&] { return load_triangulation(choice_.in, choice_.surface, choice_.sizing, session_); });
    Mapped map{.rule = rule_for(*surface), .surface = text_of(choice_.in, *surface), .json = json_of(*surface)};
    stages.run("background", [&] {
        if (request.refines) return map_refined(request, *surface, map);
        map.soup = surface->soup();
        map.sizes = geometric_sizes(*surface, map.rule);
        map.background.mesh = make_mesh(map.soup.points, map.soup.triangles);
        map.accuracy = "those of the input";
    });
    return map;
}

}  // namespace

std::unique_ptr<Source> triangle_source(const SourceChoice& choice, const Session& session) {
    return std::make_unique<TriangleSource>(choice, session);
}

}  // namespace gradus::app

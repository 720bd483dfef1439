// Surfaces of patches: Bezier patches, and limit surfaces of cages.
#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "files.hpp"
#include "gradus/control/control_space.hpp"
#include "gradus/gradation/grade_refining.hpp"
#include "gradus/io/mesh_files.hpp"
#include "gradus/remesh/chord_error.hpp"
#include "gradus/remesh/patch_chord_error.hpp"
#include "output.hpp"
#include "show.hpp"
#include "sized.hpp"
#include "source.hpp"

namespace gradus::app {

namespace {

constexpr double kMostAspect = 1000;  // of anisotropic elements

// The size map that patches are meshed for, and how it came about.
struct Map {
    SizedBackground sized;
    std::optional<SizingRule> rule;  // as asked for
    double hmin = 0;                 // of the sizes; a default one gives way to a chord error
    std::optional<GradationResult> gradation;
};

class ModelSource final : public Source {
  public:
    explicit ModelSource(const SourceChoice& choice) : choice_(choice) {}

    void check(const MeshRequest& request) const override {
        if (!request.fields.empty()) throw UsageError("--field is for triangle meshes, not for " + choice_.in);
        if (request.anisotropic && !choice_.sizing.chord_error)
            throw UsageError("--anisotropic needs --chord-error E, which its elements keep");
    }
    Made mesh(const MeshRequest& request, Stages& stages) const override;
    Mapped map(const MapRequest& request, Stages& stages) const override;

  private:
    LoadedModel load(Stages& stages) const {
        return stages.run("reading",
                          [&] { return load_model(choice_.in, choice_.cage, !choice_.surface.no_label_borders); });
    }
    Map map_by_rule(const MeshRequest& request, const SurfaceModel& model, Stages& stages) const;
    Map map_given(const MeshRequest& request, const SurfaceModel& model, Stages& stages) const;
    void mesh_within(const MeshRequest& request, const SurfaceModel& model, Map& map, Made& made, Stages& stages) const;

    SourceChoice choice_;
};

Map ModelSource::map_by_rule(const MeshRequest& request, const SurfaceModel& model, Stages& stages) const {
    Map map;
    map.rule = rule_of(choice_.sizing, limits_for(model.diagonal()));
    SizingRule rule = *map.rule;
    if (choice_.sizing.chord_error) {
        if (!choice_.sizing.hmin) rule.hmin *= kFinestSize;
        rule = rule_within(*choice_.sizing.chord_error, rule);
    }
    map.hmin = rule.hmin;
    map.sized = background_for(model, rule, stages);
    if (!request.gradation) return map;
    RefinedGradation graded =
        stages.run("gradation", [&] { return grade_refining(model, rule, *request.gradation, map.sized); });
    map.sized.sizes = std::move(graded.sizes);
    map.gradation = std::move(graded.result);
    return map;
}

Map ModelSource::map_given(const MeshRequest& request, const SurfaceModel& model, Stages& stages) const {
    Map map;
    SizedBackground& sized = map.sized;
    stages.run("size map", [&] {
        sized.background =
            load_background(request.background.empty() ? background_beside(request.sizes) : request.background, model);
        sized.sizes = read_sizes(request.sizes, sized.background.mesh.n_vertices());
    });
    if (!request.gradation) {
        require_finite(request.sizes, sized.sizes);
        return map;
    }
    map.gradation =
        stages.run("gradation", [&] { return grade(sized.background.mesh, sized.sizes, *request.gradation); });
    require_reached(request.sizes, sized.sizes);
    return map;
}

// Meshes, measures, lowers sizes, until mesh and surface are within the chord error of each other.
void ModelSource::mesh_within(const MeshRequest& request, const SurfaceModel& model, Map& map, Made& made,
                              Stages& stages) const {
    const double wanted = *choice_.sizing.chord_error;
    PatchChordErrorResult within = stages.run("meshing", [&] {
        return remesh_within(model, map.sized, wanted,
                             {.gradation = request.gradation, .hmin = map.hmin, .remesh = request.remesh});
    });
    if (request.anisotropic) {
        const std::size_t isotropic = within.result.mesh.triangles.size();
        within = stages.run("stretching", [&] {
            return stretch_within(
                model, map.sized, wanted,
                {.gradation = request.gradation && request.gradation->shock
                                  ? std::optional(TensorGradationOptions{.shock = request.gradation->shock})
                                  : std::nullopt,
                 .bounds = {map.rule ? map.rule->hmin : map.hmin, map.rule ? map.rule->hmax : model.diagonal(),
                            kMostAspect},
                 .remesh = request.remesh});
        });
        made.json["isotropic_triangles"] = isotropic;
        made.note = fmt::format(
            "elements as long as the surface lets them be: {} triangles, {:.2f} times as many as "
            "with sizes alone\n",
            grouped(within.result.mesh.triangles.size()),
            static_cast<double>(within.result.mesh.triangles.size()) / static_cast<double>(isotropic));
    }
    made.result = std::move(within.result);
    made.met = within.kept;
    const Deviation& d = within.deviation;
    made.note += fmt::format(
        "distance: at most {:.4g} from the surface to the mesh, {:.4g} back, {:.2g} of it for facets that stand for "
        "the surface; {:.4g} asked for, {}, sizes lowered {} times\n",
        d.from_reference.bound, d.from_mesh.bound, within.facets, wanted, within.kept ? "kept" : "NOT kept",
        within.lowerings);
    made.json.update({{"distance",
                       {{"from_input", {{"bound", d.from_reference.bound}}},
                        {"from_mesh", {{"bound", d.from_mesh.bound}}},
                        {"facets", within.facets}}},
                      {"new_contacts", nullptr},
                      {"chord_error", wanted},
                      {"chord_error_kept", within.kept},
                      {"refinements", within.lowerings}});
    if (within.kept) return;
    const OneSidedDistance& side = d.from_mesh.largest >= d.from_reference.largest ? d.from_mesh : d.from_reference;
    made.where = fmt::format(", by {:.3g} at {:.6g} {:.6g} {:.6g}", side.largest, side.point.x(), side.point.y(),
                             side.point.z());
    if (choice_.sizing.hmin)
        made.where += fmt::format("; --hmin {:g} may allow no smaller elements", *choice_.sizing.hmin);
}

Made ModelSource::mesh(const MeshRequest& request, Stages& stages) const {
    LoadedModel loaded = load(stages);
    const auto model = std::make_shared<const SurfaceModel>(std::move(loaded.model));
    const auto map = std::make_shared<Map>(request.sizes.empty() ? map_by_rule(request, *model, stages)
                                                                 : map_given(request, *model, stages));
    Made made;
    if (choice_.sizing.chord_error) mesh_within(request, *model, *map, made, stages);
    const auto control = stages.run(
        "control space", [&] { return std::make_shared<const ControlSpace>(map->sized.background, map->sized.sizes); });
    if (!choice_.sizing.chord_error)
        made.result = stages.run("meshing", [&] { return remesh(*model, *control, request.remesh); });
    made.rule = map->rule;
    made.background_vertices = map->sized.sizes.size();
    made.gradation = map->gradation;
    made.surface = text_of(choice_.in, *model);
    made.notes = labels_left_behind(!loaded.labels.empty(), request.out);
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

Mapped ModelSource::map(const MapRequest& request, Stages& stages) const {
    const SurfaceModel model = std::move(load(stages).model);
    Mapped map{.rule = rule_of(choice_.sizing, limits_for(model.diagonal())),
               .surface = text_of(choice_.in, model),
               .json = {{"patches", model.num_patches()}}};
    SizedBackground sized;
    if (request.background.empty()) {
        sized = background_for(model, map.rule, stages, request.max_triangles);
        map.accuracy = fmt::format("sizes within {:.1f} %", 100 * std::expm1(sized.largest_error));
        map.json["largest_error"] = sized.largest_error;
    } else {
        stages.run("background", [&] {
            sized.background = load_background(request.background, model);
            sized.sizes = geometric_sizes(model, sized.background, map.rule);
        });
        map.accuracy = "as given";
        map.json["largest_error"] = nullptr;
    }
    map.background = std::move(sized.background);
    map.sizes = std::move(sized.sizes);
    map.soup = soup_from_background(map.background);
    return map;
}

}  // namespace

std::unique_ptr<Source> model_source(const SourceChoice& choice) { return std::make_unique<ModelSource>(choice); }

}  // namespace gradus::app

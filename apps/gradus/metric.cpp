// gradus metric: the metric that a solution asks for, by the error of its linear interpolation.
#include <fmt/format.h>

#include "commands.hpp"
#include "files.hpp"
#include "gradus/control/hessian.hpp"
#include "gradus/io/mesh_files.hpp"
#include "json.hpp"
#include "show.hpp"

namespace gradus::app {

namespace {

struct Options {
    Session session;
    std::string in, mesh, out;
    std::vector<std::string> fields;
    std::optional<double> error, vertices, hmin, hmax;
    double norm = 2, aspect = 1e6;
};

void require_positive(const std::optional<double>& value, const std::string& name) {
    if (value && !(*value > 0 && std::isfinite(*value)))
        throw UsageError(fmt::format("{} {:g}: must be more than 0", name, *value));
}

void check(const Options& options) {
    if (options.error.has_value() == options.vertices.has_value())
        throw UsageError("give --error E, the largest error in an element, or --vertices N, how many there are to be");
    require_positive(options.error, "--error");
    require_positive(options.vertices, "--vertices");
    require_positive(options.hmin, "--hmin");
    require_positive(options.hmax, "--hmax");
    if (options.hmin && options.hmax && *options.hmin > *options.hmax)
        throw UsageError(fmt::format("--hmin {:g} is more than --hmax {:g}", *options.hmin, *options.hmax));
    if (!(options.norm >= 1)) throw UsageError(fmt::format("--norm {:g}: must be at least 1", options.norm));
    if (!(options.aspect >= 1)) throw UsageError(fmt::format("--aspect {:g}: must be at least 1", options.aspect));
    if (kind_of(options.in) == FileKind::Sizes && options.mesh.empty())
        throw UsageError(options.in + " has values only; name the mesh too: gradus metric F.sol MESH");
    check_output(options.out, {FileKind::Sizes, FileKind::SizedMesh});
}

MeshData read_data(const Options& options) {
    if (kind_of(options.in) != FileKind::Sizes) return read_mesh_data(options.in);
    MeshData data{read_mesh(options.mesh)};
    data.point_fields = read_solution(options.in, data.soup.points.size());
    return data;
}

// Those that are named, else the only scalar one.
std::vector<const Field*> chosen_fields(const Options& options, const MeshData& data) {
    std::vector<const Field*> scalars, chosen;
    std::string names;
    for (const Field& field : data.point_fields)
        if (field.components == 1) scalars.push_back(&field), names += (names.empty() ? "" : ", ") + field.name;
    if (scalars.empty()) throw Failure(options.in + ": no field with one number per point");
    if (options.fields.empty()) {
        if (scalars.size() > 1)
            throw Failure(fmt::format("{}: several fields, {}; choose with --field NAME", options.in, names));
        return scalars;
    }
    for (const std::string& name : options.fields) {
        const auto found =
            std::find_if(scalars.begin(), scalars.end(), [&](const Field* f) { return f->name == name; });
        if (found == scalars.end())
            throw Failure(
                fmt::format("{}: no field \"{}\" with one number per point; there are {}", options.in, name, names));
        chosen.push_back(*found);
    }
    return chosen;
}

void write_out(const Options& options, const MeshData& data, const HessianMetrics& result) {
    if (kind_of(options.out) == FileKind::Sizes) return write_metrics(options.out, result.metrics, data.soup.dimension);
    MeshData with{data.soup};
    Field metric{"metric", 9}, smallest{"h_min", 1}, largest{"h_max", 1};
    for (const Tensor& m : result.metrics) {
        for (const int k : {0, 1, 3, 1, 2, 4, 3, 4, 5}) metric.values.push_back(m.v[k]);
        const Eigen::Vector3d h = axes_of(size_tensor(m)).values;
        smallest.values.push_back(h[0]);
        largest.values.push_back(h[2]);
    }
    with.point_fields = {std::move(metric), std::move(smallest), std::move(largest)};
    write_mesh_data(options.out, with);
}

int run_metric(const Options& options) {
    check(options);
    Stages stages(options.session);
    const MeshData data = stages.run("reading", [&] { return read_data(options); });
    const std::string& mesh_path = options.mesh.empty() ? options.in : options.mesh;
    const TriMesh mesh = manifold_of(mesh_path, data.soup);
    const double diagonal = diagonal_of(data.soup);
    HessianMetricOptions metric{.error = options.error, .vertices = options.vertices, .norm = options.norm};
    metric.bounds = {options.hmin.value_or(diagonal / 1e5), options.hmax.value_or(diagonal / 10), options.aspect};
    const std::vector<const Field*> fields = chosen_fields(options, data);
    const HessianMetrics result = stages.run("metric", [&] {
        try {
            std::vector<std::vector<Tensor>> hessians;
            for (const Field* field : fields) hessians.push_back(recovered_hessians(mesh, field->values));
            return metrics_of_hessians(mesh, hessians, metric);
        } catch (const std::invalid_argument& error) {
            throw Failure(options.in + ": " + error.what());
        }
    });
    write_out(options, data, result);

    double least = std::numeric_limits<double>::infinity(), most = 0, aspect = 1;
    for (const Tensor& m : result.metrics) {
        const Eigen::Vector3d h = axes_of(size_tensor(m)).values;
        least = std::min(least, h[0]);
        most = std::max(most, h[2]);
        aspect = std::max(aspect, h[2] / h[0]);
    }
    std::string names;
    for (const Field* field : fields) names += (names.empty() ? "" : ", ") + field->name;
    options.session.say(fmt::format("{}: {} of {} vertices, {} triangles\n", options.in, names,
                                    grouped(data.soup.points.size()), grouped(data.soup.triangles.size())));
    options.session.say(
        fmt::format("metric: sizes {:.4g} to {:.4g}, aspect up to {:.4g}; a unit mesh has about {} "
                    "vertices, {} triangles\n",
                    least, most, aspect, about(result.expected_vertices), about(result.expected_triangles)));
    options.session.say(fmt::format("bounds: {} vertices at hmin {:.4g}, {} at hmax {:.4g}, {} at the aspect {:g}\n",
                                    grouped(result.at_smallest), metric.bounds.smallest, grouped(result.at_largest),
                                    metric.bounds.largest, grouped(result.at_aspect), metric.bounds.aspect));
    options.session.say("time: " + text_of(stages.times()));
    options.session.say(fmt::format("wrote {}\n", options.out));
    print(options.session, Json{{"fields", names},
                                {"smallest", least},
                                {"largest", most},
                                {"aspect", aspect},
                                {"expected_vertices", result.expected_vertices},
                                {"expected_triangles", result.expected_triangles},
                                {"at_hmin", result.at_smallest},
                                {"at_hmax", result.at_largest},
                                {"at_aspect", result.at_aspect},
                                {"stages", json_of(stages.times())},
                                {"files", {options.out}}});
    return kMet;
}

}  // namespace

void add_metric(CLI::App& app, Run& run) {
    CLI::App& command = *app.add_subcommand("metric", "The metric that a solution asks for");
    const auto options = std::make_shared<Options>();
    command.add_option("FIELD", options->in, "Solution: .vtu .vtp .msh .ply with fields at points, or .sol .solb")
        ->required();
    command.add_option("MESH", options->mesh, "Mesh of a .sol");
    command
        .add_option("-o,--output", options->out, "Metrics, one per vertex: .sol .solb; .vtu .msh .ply with the mesh")
        ->required()
        ->type_name("OUT");
    command
        .add_option("--field", options->fields,
                    "Field, where there are several; of more than one the metrics are intersected")
        ->type_name("NAME")
        ->type_size(1)
        ->allow_extra_args(false)
        ->take_all();
    command
        .add_option("--error", options->error, "Largest error of linear interpolation in an element, unit of the field")
        ->type_name("E");
    command.add_option("--vertices", options->vertices, "Number of vertices, for the least error in the L^p norm")
        ->type_name("N");
    command.add_option("--norm", options->norm, "p of that norm, >= 1 (default: 2)")->type_name("P");
    command.add_option("--hmin", options->hmin, "Smallest size (default: diagonal / 100 000)")->type_name("H");
    command.add_option("--hmax", options->hmax, "Largest size (default: diagonal / 10)")->type_name("H");
    command.add_option("--aspect", options->aspect, "Largest ratio of sizes at a place (default: 1e6)")->type_name("A");
    add_session(command, options->session);
    run_with(command, run, options, run_metric);
}

}  // namespace gradus::app

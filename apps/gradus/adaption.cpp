#include "adaption.hpp"

#include <fmt/format.h>

#include <cmath>
#include <map>

#include "files.hpp"
#include "gradus/control/expression.hpp"
#include "gradus/io/mesh_files.hpp"
#include "show.hpp"

namespace gradus::app {

namespace {

const std::map<std::string, TensorGradationMethod> kMethods{{"shape", TensorGradationMethod::Shape},
                                                            {"paper", TensorGradationMethod::Paper},
                                                            {"metric", TensorGradationMethod::Metric},
                                                            {"physical", TensorGradationMethod::Physical},
                                                            {"mixed", TensorGradationMethod::Mixed}};

template <class M>
Adaption common(PlanarAdaptResult<M>& result) {
    Adaption adaption;
    adaption.mesh = std::move(result.mesh);
    adaption.background.points = std::move(result.background.points);
    adaption.background.dimension = 2;
    for (int t = 0; t < result.background.mesh.num_triangles(); ++t)
        adaption.background.triangles.push_back(result.background.mesh.triangle(t));
    adaption.iterations = std::move(result.iterations);
    adaption.statistics = std::move(result.statistics);
    adaption.converged = result.converged;
    adaption.graded = result.graded;
    return adaption;
}

std::vector<double> mean_sizes(std::span<const Tensor> size_tensors) {
    std::vector<double> sizes;
    for (const Tensor& h : size_tensors) sizes.push_back(std::sqrt(mean_square_size(h, Eigen::Vector3d::UnitZ())));
    return sizes;
}

std::vector<Tensor> metrics_of(std::span<const Tensor> size_tensors) {
    std::vector<Tensor> metrics;
    for (const Tensor& h : size_tensors) metrics.push_back(metric_of(h));
    return metrics;
}

// Sizes or size tensors of a file, interpolated on its background; outside of that those of the closest place on it.
template <class M>
SizeFunction<M> on_background(std::span<const typename M::Value> sizes, const TriangleSoup& background,
                              const std::string& background_path) {
    manifold_of(background_path, background);
    const Connectivity mesh(static_cast<int>(background.points.size()), background.triangles);
    const auto field = std::make_shared<const InterpolatedField<M>>(background.points, mesh, sizes);
    return [field, hint = 0](const Eigen::Vector3d& p) mutable { return field->size(p, hint); };
}

SizeFunction<Size> wanted_sizes(const Wanted& wanted) {
    if (kind_of(wanted.size) != FileKind::Sizes) return size_function(Expression(wanted.size));
    const TriangleSoup background = read_mesh(wanted.background);
    const std::vector<double> sizes = read_sizes(wanted.size, background.points.size());
    for (std::size_t v = 0; v < sizes.size(); ++v)
        if (!std::isfinite(sizes[v])) throw Failure(fmt::format("{}: vertex {} has no size", wanted.size, v + 1));
    return on_background<Size>(sizes, background, wanted.background);
}

SizeFunction<SizeTensor> wanted_metrics(const Wanted& wanted) {
    if (kind_of(wanted.metric) != FileKind::Sizes) return metric_function(Expression(wanted.metric));
    const TriangleSoup background = read_mesh(wanted.background);
    std::vector<Tensor> sizes;
    for (const Tensor& metric : read_metrics(wanted.metric, background.points.size()))
        sizes.push_back(size_tensor(metric));
    return on_background<SizeTensor>(sizes, background, wanted.background);
}

}  // namespace

Adaption adapt_to(const Triangulation& domain, const Wanted& wanted, const PlanarAdaptOptions& options) {
    if (!wanted.is_metric()) {
        auto result = adapt_planar<Size>(domain, wanted_sizes(wanted), options);
        Adaption adaption = common(result);
        adaption.sizes = std::move(result.sizes);
        adaption.wanted.sizes = std::move(result.wanted);
        adaption.corrected.sizes = std::move(result.background.sizes);
        return adaption;
    }
    auto result = adapt_planar<SizeTensor>(domain, wanted_metrics(wanted), options);
    Adaption adaption = common(result);
    adaption.sizes = mean_sizes(result.sizes);
    adaption.metrics = metrics_of(result.sizes);
    adaption.wanted.metrics = metrics_of(result.wanted);
    adaption.corrected.metrics = metrics_of(result.background.sizes);
    return adaption;
}

std::optional<TensorGradationOptions> tensor_gradation_of(const GradationChoice& choice,
                                                          std::optional<double> default_shock) {
    if (choice.none) return std::nullopt;
    GradationChoice bounds = choice;
    bounds.method = "full";
    const GradationOptions given = *gradation_of(bounds, default_shock);
    TensorGradationOptions options{.shock = given.shock, .variation = given.variation};
    // What is not asked for is the method of sizes.
    if (choice.method == "full") return options;
    const auto method = kMethods.find(choice.method);
    if (method == kMethods.end())
        throw UsageError(fmt::format(
            "--method {}: metrics are corrected by one of shape, paper, metric, physical, mixed", choice.method));
    options.method = method->second;
    return options;
}

std::string to_text(const TensorGradationOptions& options) {
    std::string bound;
    if (options.shock) bound = fmt::format("H-shock at most {:g}", *options.shock);
    if (options.variation)
        bound += fmt::format("{}H-variation at most {:g}", bound.empty() ? "" : ", ", *options.variation);
    for (const auto& [name, method] : kMethods)
        if (method == options.method) bound += ", method " + name;
    return bound;
}

std::string text_of(const TensorGradationOptions& options, const TensorGradationResult& result, std::size_t vertices) {
    const auto row = [](const std::string& name, const GradationReport& report) {
        return std::vector<std::string>{name, shock_text(report.shock_max), shock_text(report.shock_p999),
                                        fmt::format("{:.4g}", report.variation_max)};
    };
    std::string text = "gradation: " + to_text(options) + "\n";
    text += aligned({{"along edges", "H-shock, largest", "99.9 %", "H-variation, largest"},
                     row("before", result.before),
                     row("after", result.after)});
    return text + fmt::format("  {} of {} metrics changed, sizes by up to {:.3g}; {} visits; largest excess {:.2g}{}\n",
                              grouped(result.lowered), grouped(vertices), result.largest_factor,
                              grouped(static_cast<long long>(result.visits)), result.residual,
                              result.met ? "" : ", NOT met");
}

Json json_of(const TensorGradationOptions& options, const TensorGradationResult& result) {
    const auto report = [](const GradationReport& of) {
        return Json{{"shock_max", of.shock_max}, {"shock_p999", of.shock_p999}, {"variation_max", of.variation_max}};
    };
    return {{"bound", to_text(options)},
            {"lowered", result.lowered},
            {"largest_factor", result.largest_factor},
            {"converged", result.converged},
            {"visits", result.visits},
            {"residual", result.residual},
            {"met", result.met},
            {"before", report(result.before)},
            {"after", report(result.after)}};
}

std::vector<std::vector<std::string>> rows_of(const Adaption& adaption) {
    std::vector<std::vector<std::string>> rows{{"iteration", "background", "triangles", "expected", "worst", "mean",
                                                "unit edges", "not longer than wanted", "longest", "H-shock", "s"}};
    int number = 0;
    for (const PlanarAdaptIteration& i : adaption.iterations)
        rows.push_back({fmt::format("{}", ++number), grouped(i.background_vertices), grouped(i.triangles),
                        about(i.predicted_triangles), fmt::format("{:.3f}", i.own.worst),
                        fmt::format("{:.3f}", i.own.mean), fmt::format("{:.2f} %", 100 * i.own.unit_share),
                        fmt::format("{:.2f} %", 100 * i.wanted.not_long), fmt::format("{:.2f}", i.own.longest),
                        i.shock > 1e3 ? "> 1000" : fmt::format("{:.4g}", i.shock), fmt::format("{:.1f}", i.seconds)});
    return rows;
}

std::string outcome_of(const Adaption& adaption) {
    return fmt::format(
        "{} after {} iteration{}",
        adaption.converged ? "the mesh satisfies what is wanted" : "the mesh does NOT satisfy what is wanted",
        adaption.iterations.size(), adaption.iterations.size() == 1 ? "" : "s");
}

namespace {

Json json_of(const MetricFit& fit) {
    return {{"worst", fit.worst},       {"mean", fit.mean},         {"unit_share", fit.unit_share},
            {"not_long", fit.not_long}, {"shortest", fit.shortest}, {"longest", fit.longest}};
}

}  // namespace

Json json_of(const Adaption& adaption) {
    Json iterations = Json::array();
    for (const PlanarAdaptIteration& i : adaption.iterations)
        iterations.push_back({{"background_vertices", i.background_vertices},
                              {"predicted_triangles", i.predicted_triangles},
                              {"triangles", i.triangles},
                              {"own", json_of(i.own)},
                              {"wanted", json_of(i.wanted)},
                              {"next", json_of(i.next)},
                              {"shock_before", i.shock_before},
                              {"shock", i.shock},
                              {"seconds", i.seconds}});
    return {{"converged", adaption.converged},
            {"graded", adaption.graded},
            {"triangles", adaption.mesh.triangles.size()},
            {"vertices", adaption.mesh.points.size()},
            {"iterations", iterations}};
}

namespace {

// As a full matrix, which viewers take for a tensor.
Field tensor_field(const std::vector<Tensor>& metrics) {
    Field field{"metric", 9};
    for (const Tensor& m : metrics)
        for (const int k : {0, 1, 3, 1, 2, 4, 3, 4, 5}) field.values.push_back(m.v[k]);
    return field;
}

}  // namespace

void write_adapted(const std::string& path, const Adaption& adaption) {
    MeshData data{adaption.mesh};
    if (holds_fields(path)) {
        data.point_fields.push_back({"size", 1, adaption.sizes});
        if (adaption.is_metric()) data.point_fields.push_back(tensor_field(adaption.metrics));
    }
    write_mesh_data(path, data);
}

void write_map(const std::string& path, const Adaption::Map& map) {
    if (!map.metrics.empty())
        write_metrics(path, map.metrics, 2);
    else
        write_sizes(path, map.sizes, 2);
}

Image draw_from_above(const TriangleSoup& mesh, const Eigen::Vector2d& middle, double width) {
    Camera camera{.direction = {0, 0, 1}, .up = {0, 1, 0}};
    if (width > 0) {
        camera.target = Eigen::Vector3d(middle.x(), middle.y(), 0);
        camera.width = width;
    }
    return render({.points = mesh.points, .triangles = mesh.triangles, .features = mesh.edges}, camera,
                  {.width = 1000, .height = 1000, .shading = Shading::None, .edge_width = 0.8, .feature_width = 1.6});
}

}  // namespace gradus::app

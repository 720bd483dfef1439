#include "gradus/remesh/parametric.hpp"

#include "editor.hpp"
#include "gradus/curvature/principal.hpp"
#include "gradus/remesh/curves.hpp"
#include "optimise.hpp"
#include "place_vertices.hpp"

#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

namespace gradus {

namespace {

// True where the surface has several normals at a pole, as at the tip of a cone.
bool is_tip(const SurfaceModel& model, int pole) {
    constexpr double kCosine = 0.966;  // of 15 degrees, from which curves are creases
    const Eigen::Vector3d first = model.normal(model.on_curve(pole, 0, 0));
    for (const double t : {0.25, 0.5, 0.75, 1.0})
        if (model.normal(model.on_curve(pole, 0, t)).dot(first) < kCosine) return true;
    return false;
}

void tag_features(const SurfaceModel& model, const PatchSupport& support, const CutCurves& curves, Connectivity& mesh) {
    for (int c = 0; c < static_cast<int>(model.curves().size()); ++c) {
        if (!is_feature(model.curves()[c].kind)) continue;
        for (int i = 0; i + 1 < static_cast<int>(curves.t[c].size()); ++i) {
            const int edge = mesh.find_edge(curves.number(model, c, i), curves.number(model, c, i + 1));
            if (edge < 0)
                throw std::logic_error("remesh: a piece of curve " + std::to_string(c) + " is not in the mesh");
            mesh.set_tag(edge, support.chain_of(c));
        }
    }
}

// Every place of a vertex on a feature: one per side or corner that has it.
template <class M>
std::vector<SurfacePoint> places_of(const SurfaceModel& model, const VertexOf<M>& v) {
    std::vector<SurfacePoint> places;
    if (v.bound == Bound::Curve) {
        const ModelCurve& curve = model.curves()[v.place.curve];
        if (v.place.t == 0 || v.place.t == 1) return model.vertices()[curve.ends[v.place.t == 1]].places;
        for (int use = 0; use < static_cast<int>(curve.uses.size()); ++use)
            places.push_back(model.on_curve(v.place.curve, use, v.place.t));
    }
    if (v.bound == Bound::Fixed) places = model.vertices()[v.place.vertex].places;
    return places;
}

// The patch that all corners of a triangle lie on, all of them on features; of several the one that faces as the
// triangle does.
template <class M>
int common_patch(const SurfaceModel& model, const VertexOf<M>& a, const VertexOf<M>& b, const VertexOf<M>& c) {
    const Eigen::Vector3d facing = (b.p - a.p).cross(c.p - a.p);
    const std::array<std::vector<SurfacePoint>, 3> places{places_of(model, a), places_of(model, b),
                                                          places_of(model, c)};
    int best = a.place.at.patch;
    double most = -std::numeric_limits<double>::infinity();
    for (const SurfacePoint& first : places[0]) {
        double agreement = 0;
        for (const auto& of_corner : places) {
            const auto there = std::find_if(of_corner.begin(), of_corner.end(),
                                            [&](const SurfacePoint& at) { return at.patch == first.patch; });
            agreement +=
                there != of_corner.end() ? model.normal(*there).dot(facing) : -std::numeric_limits<double>::infinity();
        }
        if (agreement > most) most = agreement, best = first.patch;
    }
    return best;
}

// The patch under a triangle: that of all its corners, or the one its middle falls on.
template <class M>
int patch_under(const SurfaceModel& model, const Support& support, const VertexOf<M>& a, const VertexOf<M>& b,
                const VertexOf<M>& c) {
    const auto inside = [](const VertexOf<M>& v) { return v.bound == Bound::Free; };
    if (inside(a) && inside(b) && inside(c) && a.place.at.patch == b.place.at.patch &&
        b.place.at.patch == c.place.at.patch)
        return a.place.at.patch;
    const Eigen::Vector3d middle = (a.p + b.p + c.p) / 3;
    for (const VertexOf<M>* v : {&a, &b, &c}) {
        if (!inside(*v)) continue;
        if (const auto foot = support.move(v->place, v->p, middle)) return foot->place.at.patch;
    }
    for (const VertexOf<M>* v : {&a, &b, &c})
        if (inside(*v)) return v->place.at.patch;
    return common_patch(model, a, b, c);
}

template <class M>
SurfaceMesh export_mesh(const SurfaceModel& model, const Support& support, const EditorOf<M>& editor) {
    SurfaceMesh result;
    const Connectivity& mesh = editor.mesh();
    for (const VertexOf<M>& v : editor.vertices()) {
        result.points.push_back(model.position(v.place.at));
        result.places.push_back(v.place.at);
        result.sizes.push_back(v.h);
    }
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const Triangle v = mesh.triangle(t);
        result.triangles.push_back(v);
        result.patches.push_back(
            patch_under(model, support, editor.vertex(v[0]), editor.vertex(v[1]), editor.vertex(v[2])));
        for (int h = 3 * t; h < 3 * t + 3; ++h)
            if (mesh.tag(h) >= 0 && mesh.twin(h) < h) result.features.push_back({mesh.origin(h), mesh.target(h)});
    }
    return result;
}

}  // namespace

std::vector<Vertex> place_vertices(const SurfaceModel& model, const PatchSupport& support, const ControlSpace& control,
                                   const CutCurves& curves, const PatchMeshes& assembly) {
    std::vector<Vertex> vertices(assembly.num_vertices());
    const int corners = static_cast<int>(model.vertices().size());
    std::vector<char> on_feature(corners, 0), on_crease(corners, 0);
    for (int c = 0; c < static_cast<int>(model.curves().size()); ++c) {
        const CurveKind kind = model.curves()[c].kind;
        const bool several_normals = kind == CurveKind::Crease || (kind == CurveKind::Pole && is_tip(model, c));
        for (const int end : model.curves()[c].ends) {
            if (is_feature(kind) || kind == CurveKind::Pole) on_feature[end] = 1;
            if (several_normals) on_crease[end] = 1;
        }
    }
    for (int v = 0; v < corners; ++v) {
        const SurfacePoint at = model.vertices()[v].places.front();
        const bool fixed = on_feature[v] || model.vertices()[v].tip;
        stand(vertices[v], support.foot({at, -1, 0, control.locate(at), fixed ? v : -1}), support, control);
        vertices[v].bound = fixed ? Bound::Fixed : Bound::Free;
        if (const auto junction = support.junction(v)) {
            Place place = *junction;
            place.cell = control.locate(place.at);
            stand(vertices[v], support.foot(place), support, control);
            vertices[v].bound = Bound::Curve;
        }
        if ((on_crease[v] || model.vertices()[v].tip) && vertices[v].bound == Bound::Fixed)
            vertices[v].lean = kAnyNormal;
    }
    for (int c = 0; c < static_cast<int>(model.curves().size()); ++c) {
        const bool feature = is_feature(model.curves()[c].kind);
        for (int i = 1; i + 1 < static_cast<int>(curves.t[c].size()); ++i) {
            const SurfacePoint at = model.on_curve(c, 0, curves.t[c][i]);
            Vertex& v = vertices[curves.number(model, c, i)];
            stand(v, support.foot({at, feature ? c : -1, curves.t[c][i], control.locate(at)}), support, control);
            v.bound = feature ? Bound::Curve : Bound::Free;
        }
    }
    for (int p = 0; p < model.num_patches(); ++p) {
        const PatchMesh& mesh = assembly.patches()[p];
        for (std::size_t i = 0; i < mesh.uv.size(); ++i)
            if (mesh.number[i] >= curves.count)
                stand(vertices[mesh.number[i]], support.foot({{p, mesh.uv[i]}, -1, 0, mesh.cell[i]}), support, control);
    }
    return vertices;
}

namespace {

// The mesh of a control space, which `finish` is given with the statistics and the clock so far.
template <class Finish>
void generate(const SurfaceModel& model, const ControlSpace& control, const RemeshOptions& options,
              RemeshStatistics& statistics, const Finish& finish) {
    statistics.predicted_triangles = check_estimate(control, options);
    std::optional<tbb::global_control> limit;
    if (options.threads > 0) limit.emplace(tbb::global_control::max_allowed_parallelism, options.threads);

    StageClock clock(statistics.seconds);
    const CutCurves curves(model, discretise_curves(model, control));
    clock.done("curves");
    const auto size = [&](const SurfacePoint& at, const Eigen::Vector3d& point, int& hint) {
        if (hint < 0) hint = control.locate(at);
        return control.size(point, hint);
    };
    // Where parameters run into a cusp, more and more points fit between those there are.
    constexpr double kManyMore = 4, kFew = 1e5;
    const double most_points = std::max(kFew, kManyMore * statistics.predicted_triangles);
    const PatchMeshes assembly(model, curves, size, static_cast<std::size_t>(std::min(most_points, 5e7)));
    clock.done("generation");
    const PatchSupport support(model);
    Connectivity mesh(assembly.num_vertices(), assembly.triangles());
    tag_features(model, support, curves, mesh);
    Editor editor(support, control, place_vertices(model, support, control, curves, assembly), std::move(mesh));
    statistics.generated_triangles = editor.mesh().num_live_triangles();
    clock.done("assembly");

    finish(support, editor, clock);
    clock.done("export");
}

// The vertices of a mesh with other sizes, on a background that is the mesh itself.
std::vector<VertexOf<SizeTensor>> with_metrics(const Editor& editor, std::span<const Tensor> size_tensors) {
    std::vector<VertexOf<SizeTensor>> vertices(size_tensors.size());
    for (std::size_t v = 0; v < vertices.size(); ++v) {
        const Vertex& from = editor.vertex(static_cast<int>(v));
        VertexOf<SizeTensor>& x = vertices[v];
        x.p = from.p;
        x.n = from.n;
        x.place = from.place;
        x.place.cell = editor.mesh().outgoing(static_cast<int>(v)) / 3;
        x.bound = from.bound;
        x.lean = from.lean;
        take_size(x, size_tensors[v]);
    }
    return vertices;
}

}  // namespace

RemeshResult remesh(const SurfaceModel& model, const ControlSpace& control, const RemeshOptions& options) {
    RemeshResult result;
    generate(model, control, options, result.statistics,
             [&](const PatchSupport& support, Editor& editor, StageClock& clock) {
                 take_report(optimise(editor, {.fast = options.fast, .goal = options.goal}, clock), result.statistics);
                 result.mesh = export_mesh(model, support, editor);
             });
    return result;
}

RemeshResult remesh(const SurfaceModel& model, const ControlSpace& control, const SurfaceMetric& metric,
                    const std::optional<TensorGradationOptions>& gradation, const RemeshOptions& options) {
    RemeshResult result;
    generate(model, control, options, result.statistics,
             [&](const PatchSupport& support, Editor& editor, StageClock& clock) {
                 take_report(optimise(editor, {.fast = true}, clock), result.statistics);
                 editor.renumber();
                 std::vector<Eigen::Vector3d> points;
                 std::vector<Tensor> metrics;
                 for (const Vertex& v : editor.vertices()) {
                     points.push_back(v.p);
                     metrics.push_back(metric(v.place.at));
                 }
                 std::vector<Triangle> triangles;
                 for (int t = 0; t < editor.mesh().num_triangles(); ++t) triangles.push_back(editor.mesh().triangle(t));
                 if (gradation) grade(make_mesh(points, triangles), metrics, *gradation);
                 for (Tensor& m : metrics) m = size_tensor(m);
                 const TensorSpace field(points, editor.mesh(), metrics);
                 result.statistics.predicted_triangles = check_estimate(field, options);
                 clock.done("metric");
                 EditorOf<SizeTensor> stretched(support, field, with_metrics(editor, metrics), editor.mesh());
                 for (const bool given : {true, false})
                     take_report(
                         optimise(stretched, {.fast = options.fast, .goal = options.goal, .given = given}, clock),
                         result.statistics);
                 result.mesh = export_mesh(model, support, stretched);
             });
    return result;
}

Tensor chord_error_metric(const SurfaceModel& model, const SurfacePoint& at, double error, const TensorBounds& bounds) {
    const PrincipalCurvatures k = principal_curvatures(model.patch(at.patch), at.uv);
    const auto size = [&](double curvature) {
        const double rho = 1 / std::max(std::abs(curvature), 1e-300);
        const double h = std::sqrt(3 * error * std::max(2 * rho - error, error));
        return std::clamp(h, bounds.smallest, bounds.largest);
    };
    Eigen::Matrix3d axes;
    axes << k.d1, k.d2, k.normal;
    const double h1 = size(k.k1), h2 = size(k.k2);
    // Across the surface nothing counts: neither small nor large.
    return bounded(metric_along(axes, {h1, h2, std::sqrt(h1 * h2)}), bounds);
}

}  // namespace gradus

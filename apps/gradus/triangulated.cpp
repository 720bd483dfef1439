#include "triangulated.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "files.hpp"
#include "gradus/io/mesh_files.hpp"
#include "gradus/mesh/diagnose.hpp"

namespace gradus::app {

namespace {

constexpr double kChordShare = 0.4;    // of the chord error that sizes ask of edges: triangles are farther off than their edges
constexpr double kBulgeShare = 0.2;    // that the smooth surface may be off the triangulation
constexpr int kMostDrafts = 2, kMostRefinements = 16;
constexpr double kDraftShare = 0.85;   // of it that drafts keep
constexpr int kMostInVain = 3;
constexpr double kProgress = 0.95;
constexpr double kGoal = 0.8;          // of the chord error, aimed at where it was not kept
constexpr double kSteepest = 0.35, kLeast = 0.85;  // change of sizes there
constexpr double kCoarsePrecision = 0.1;  // of those that tell how far to lower sizes
constexpr double kPrecision = 0.01;    // of the distances reported
constexpr double kFinest = 0.1;        // of the default hmin, down to which sizes go to keep a chord error

// Measures meshes against the triangulation, and lowers their sizes where they are too far from it.
class Keeper {
  public:
    Keeper(const Triangulation& surface, const SmoothSupport& support, const std::optional<GradationOptions>& gradation, double hmin, TriangulatedMesh& mesh)
        : surface_(surface), support_(support), gradation_(gradation), hmin_(hmin), mesh_(mesh), target_({surface.soup().points, surface.soup().triangles}) {}

    void measure(const SurfaceMesh& mesh, double limit, double precision) {
        const MeshView input{surface_.soup().points, surface_.soup().triangles}, output{mesh.points, mesh.triangles};
        std::vector<int> near;
        for (const SurfacePoint& at : mesh.places) near.push_back(at.patch);
        mesh_.deviation.from_mesh = target_.measure_from(output, {.limit = limit, .precision = precision, .near = near});
        mesh_.deviation.from_input = DistanceTarget(output).measure_from(input, {.limit = limit, .precision = precision});
    }

    // Sizes at the vertices of a draft to go on with, by samples; nothing where they all keep the chord error.
    std::optional<std::vector<double>> refine_draft(const SurfaceMesh& mesh, double chord_error) {
        if (mesh_.refinements == kMostDrafts) return std::nullopt;
        std::vector<std::pair<int, double>> far(mesh.triangles.size(), {-1, 0.0});
        tbb::parallel_for(tbb::blocked_range<int>(0, static_cast<int>(far.size()), 512), [&](const auto& range) {
            for (int t = range.begin(); t < range.end(); ++t)
                if (const double d = sampled_distance(mesh, mesh.triangles[t], chord_error); d > chord_error) far[t] = {t, d};
        });
        std::erase_if(far, [](const auto& f) { return f.first < 0; });
        return lowered(mesh, far, chord_error);
    }

    // The same for a mesh that may be the last, proved.
    std::optional<std::vector<double>> refine(const SurfaceMesh& mesh, double chord_error) {
        measure(mesh, chord_error, kCoarsePrecision);
        if (mesh_.deviation.bound() <= chord_error) return std::nullopt;
        std::vector<std::pair<int, double>> far;
        for (const TooFar& f : mesh_.deviation.from_mesh.beyond) far.emplace_back(f.triangle, f.distance);
        for (const TooFar& f : mesh_.deviation.from_input.beyond) far.emplace_back(f.nearest, f.distance);
        // Where neither their number nor their distance falls, smaller elements do not help.
        const bool better = far.size() < fewest_ || mesh_.deviation.bound() < kProgress * nearest_;
        fewest_ = std::min(fewest_, far.size());
        nearest_ = std::min(nearest_, mesh_.deviation.bound());
        in_vain_ = better ? 0 : in_vain_ + 1;
        if (in_vain_ == kMostInVain) return std::nullopt;
        return lowered(mesh, far, chord_error);
    }

  private:
    // Largest distance to the input of the middles of a triangle and its sides.
    double sampled_distance(const SurfaceMesh& mesh, const Triangle& t, double limit) const {
        const Eigen::Vector3d &a = mesh.points[t[0]], &b = mesh.points[t[1]], &c = mesh.points[t[2]];
        double largest = 0;
        const int start = mesh.places[t[0]].patch;
        for (const Eigen::Vector3d& p : {Eigen::Vector3d((a + b + c) / 3), Eigen::Vector3d((a + b) / 2), Eigen::Vector3d((b + c) / 2), Eigen::Vector3d((c + a) / 2)}) {
            const SmoothSupport::Foot foot = support_.walk(start, p);
            const Triangle& v = surface_.soup().triangles[foot.triangle];
            const auto& points = surface_.soup().points;
            double distance = (p - ((1 - foot.b - foot.c) * points[v[0]] + foot.b * points[v[1]] + foot.c * points[v[2]])).norm();
            // The walk may have ended at a feature.
            if (distance > limit) distance = target_.distance(p, foot.triangle);
            largest = std::max(largest, distance);
        }
        return largest;
    }

    // Sizes of a mesh, lower at the triangles that are too far off; nothing where none can be.
    std::optional<std::vector<double>> lowered(const SurfaceMesh& mesh, const std::vector<std::pair<int, double>>& far, double chord_error) {
        if (far.empty() || mesh_.refinements == kMostRefinements) return std::nullopt;
        std::vector<double> sizes = mesh.sizes;
        bool any = false;
        // Gaps fall with the square of the size on smooth parts, and with the size itself on sharp ones.
        const double power = mesh_.refinements < kMostDrafts ? 0.5 : 1;
        for (const auto& [triangle, distance] : far) {
            const double factor = std::clamp(std::pow(kGoal * chord_error / std::max(distance, chord_error), power), kSteepest, kLeast);
            for (const int v : mesh.triangles[triangle]) {
                const double size = std::max(factor * mesh.sizes[v], hmin_);
                if (size < sizes[v]) sizes[v] = size, any = true;
            }
        }
        if (!any) return std::nullopt;
        ++mesh_.refinements;
        if (gradation_) mesh_.gradation = grade(make_mesh(mesh.points, mesh.triangles), sizes, *gradation_);
        return sizes;
    }

    const Triangulation& surface_;
    const SmoothSupport& support_;
    const std::optional<GradationOptions>& gradation_;
    double hmin_;
    TriangulatedMesh& mesh_;
    DistanceTarget target_;
    std::size_t fewest_ = std::numeric_limits<std::size_t>::max();  // triangles that were too far
    double nearest_ = std::numeric_limits<double>::infinity();      // largest distance
    int in_vain_ = 0;                                               // rounds since either fell
};

}  // namespace

void add_triangulation(CLI::App& app, TriangulationChoice& choice) {
    const std::string group = "Triangulations";
    app.add_option("--feature-angle", choice.feature_angle, "Angle between facets from which their edge is a crease, degrees")
        ->type_name("DEG")
        ->capture_default_str()
        ->check(CLI::Range(1.0, 180.0).description(""))
        ->group(group);
    app.add_flag("--no-label-borders", choice.no_label_borders, "Borders between labels are no features")->group(group);
    app.add_flag("--repair", choice.repair, "Repair what is no oriented manifold, and say each change")->group(group);
}

std::unique_ptr<Triangulation> load_triangulation(const std::string& path, const TriangulationChoice& choice, const SizingOptions& sizing, const Session& session) {
    TriangleSoup soup = load_soup(path, choice.repair, session);
    if (soup.triangles.empty()) throw Failure(path + ": holds no triangles");
    TriangulationOptions options;
    options.features.angle = choice.feature_angle * std::numbers::pi / 180;
    options.features.weak_angle = std::min(options.features.weak_angle, 0.6 * options.features.angle);
    options.features.sharp_angle = std::max(options.features.sharp_angle, options.features.angle);
    options.label_borders = !choice.no_label_borders;
    if (sizing.chord_error) {
        options.features.scale = *sizing.chord_error;
        // Curvatures that ask for elements larger than any allowed need no precision.
        Eigen::AlignedBox3d box;
        for (const Eigen::Vector3d& p : soup.points) box.extend(p);
        const double hmax = sizing.hmax.value_or(limits_for(box.diagonal().norm()).hmax);
        options.least_curvature = 8 * *sizing.chord_error / (hmax * hmax);
    }
    try {
        return std::make_unique<Triangulation>(std::move(soup), options);
    } catch (const std::invalid_argument& error) {
        throw Failure(path + ": " + error.what());
    }
}

TriangulatedMesh mesh_triangulation(const Triangulation& surface, const SizingRule& rule, std::span<const double> sizes,
                                    const std::optional<GradationOptions>& gradation, const RemeshOptions& options, bool hmin_given, Stages& stages) {
    TriangulatedMesh mesh;
    if (rule.kind == SizingRule::Kind::ChordError) mesh.chord_error = rule.value;
    SizingRule asked = rule;
    if (mesh.chord_error) asked.value *= kChordShare;
    TriangulationBackground map = stages.run("background", [&] {
        return sizes.empty() ? make_background(surface, asked, static_cast<int>(options.max_triangles)) : make_background(surface, sizes);
    });
    mesh.background_vertices = map.sizes.size();
    if (gradation) stages.run("gradation", [&] { mesh.gradation = grade(map.background.mesh, map.sizes, *gradation); });
    const ControlSpace control(map.background, map.sizes);
    const SmoothSupport support = surface.support(
        {.largest_bulge = mesh.chord_error ? kBulgeShare * *mesh.chord_error : std::numeric_limits<double>::infinity()});
    const TriangulatedSurface whole{support, surface.features(), surface.soup().labels};
    const double finest = hmin_given ? rule.hmin : kFinest * rule.hmin;
    Keeper keeper = stages.run("distance tree", [&] { return Keeper(surface, support, gradation, finest, mesh); });
    Recheck recheck;
    if (mesh.chord_error)
        recheck = [&](const SurfaceMesh& draft, MeshStage stage) {
            stages.detail(fmt::format("{} triangles", grouped(draft.triangles.size())));
            // Drafts keep a margin for what the rest of the schedule moves.
            return stage == MeshStage::Draft ? keeper.refine_draft(draft, kDraftShare * *mesh.chord_error) : keeper.refine(draft, *mesh.chord_error);
        };
    mesh.result = stages.run("meshing", [&] { return remesh(whole, control, map.cells, options, recheck); });
    // With a chord error the last check has measured it.
    if (!mesh.chord_error) stages.run("distance", [&] { keeper.measure(mesh.result.mesh, 0, kPrecision); });
    return mesh;
}

std::string text_of(const std::string& path, const Triangulation& surface) {
    std::size_t edges = 0;
    for (const FeatureChain& chain : surface.features().chains) edges += chain.num_edges();
    const auto corners = std::count(surface.features().corner.begin(), surface.features().corner.end(), 1);
    return fmt::format("{}: {} triangles, {} vertices, diagonal {:.4g}; {} feature curves of {} edges, {} corners\n", path,
                       grouped(surface.soup().triangles.size()), grouped(surface.soup().points.size()), surface.diagonal(),
                       grouped(surface.features().chains.size()), grouped(edges), grouped(static_cast<long long>(corners)));
}

std::string text_of(const TriangulatedMesh& mesh, double diagonal) {
    const Deviation& d = mesh.deviation;
    std::string text = fmt::format("distance: at most {:.4g} from the input to the mesh, {:.4g} back ({:.3g} of the diagonal)", d.from_input.bound,
                                   d.from_mesh.bound, d.bound() / diagonal);
    if (mesh.chord_error)
        text += fmt::format("; {:.4g} asked for, {}, sizes lowered {} times", *mesh.chord_error, mesh.kept() ? "kept" : "NOT kept", mesh.refinements);
    return text + "\n";
}

Json json_of(const Triangulation& surface) {
    return {{"input_triangles", surface.soup().triangles.size()},
            {"input_vertices", surface.soup().points.size()},
            {"diagonal", surface.diagonal()},
            {"feature_curves", surface.features().chains.size()},
            {"corners", std::count(surface.features().corner.begin(), surface.features().corner.end(), 1)}};
}

Json json_of(const TriangulatedMesh& mesh) {
    const auto side = [](const OneSidedDistance& d) { return Json{{"largest", d.largest}, {"bound", d.bound}, {"at", {d.point.x(), d.point.y(), d.point.z()}}}; };
    return {{"distance", {{"from_input", side(mesh.deviation.from_input)}, {"from_mesh", side(mesh.deviation.from_mesh)}}},
            {"chord_error", mesh.chord_error ? Json(*mesh.chord_error) : Json(nullptr)},
            {"chord_error_kept", mesh.chord_error ? Json(mesh.kept()) : Json(nullptr)},
            {"refinements", mesh.refinements}};
}

MeshReport measure_surface_mesh(const TriangulatedMesh& mesh) {
    const SurfaceMesh& m = mesh.result.mesh;
    return measure({m.points, m.triangles}, {.sizes = m.sizes});
}

}  // namespace gradus::app

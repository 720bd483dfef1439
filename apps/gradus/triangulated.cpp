#include "triangulated.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "files.hpp"
#include "gradus/io/mesh_files.hpp"
#include "gradus/mesh/diagnose.hpp"

namespace gradus::app {

namespace {

constexpr double kChordShare = 0.5;    // of the chord error that sizes ask of edges: triangles are farther off than their edges
constexpr double kBulgeShare = 0.2;    // that the smooth surface may be off the triangulation
constexpr int kMostRefinements = 12;
constexpr double kDraftShare = 0.85;   // of it that drafts keep
constexpr double kGoal = 0.7;          // of the chord error, aimed at where it was not kept
constexpr double kSteepest = 0.35, kLeast = 0.85;  // change of sizes there
constexpr double kCoarsePrecision = 0.1;  // of those that tell how far to lower sizes
constexpr double kPrecision = 1e-3;    // of the distances reported
constexpr double kFinest = 0.1;        // of the default hmin, down to which sizes go to keep a chord error

// Measures meshes against the triangulation, and lowers their sizes where they are too far from it.
class Keeper {
  public:
    Keeper(const Triangulation& surface, const std::optional<GradationOptions>& gradation, double hmin, TriangulatedMesh& mesh)
        : surface_(surface), gradation_(gradation), hmin_(hmin), mesh_(mesh), target_({surface.soup().points, surface.soup().triangles}) {}

    void measure(const SurfaceMesh& mesh, double limit, double precision) {
        const MeshView input{surface_.soup().points, surface_.soup().triangles}, output{mesh.points, mesh.triangles};
        std::vector<int> near;
        for (const SurfacePoint& at : mesh.places) near.push_back(at.patch);
        mesh_.deviation.from_mesh = target_.measure_from(output, {.limit = limit, .precision = precision, .near = near});
        mesh_.deviation.from_input = DistanceTarget(output).measure_from(input, {.limit = limit, .precision = precision});
    }

    // Sizes at the vertices of the mesh to go on with; nothing where the chord error is kept, or cannot be.
    std::optional<std::vector<double>> refine(const SurfaceMesh& mesh, double chord_error) {
        measure(mesh, chord_error, kCoarsePrecision);
        const Deviation& deviation = mesh_.deviation;
        if (deviation.bound() <= chord_error || mesh_.refinements == kMostRefinements) return std::nullopt;
        std::vector<double> sizes = mesh.sizes;
        bool lowered = false;
        // Gaps fall with the square of the size on smooth parts, and with the size itself on sharp ones.
        const double power = mesh_.refinements == 0 ? 0.5 : 1;
        const auto lower = [&](int triangle, double distance) {
            const double factor = std::clamp(std::pow(kGoal * chord_error / std::max(distance, chord_error), power), kSteepest, kLeast);
            for (const int v : mesh.triangles[triangle]) {
                const double size = std::max(factor * mesh.sizes[v], hmin_);
                if (size < sizes[v]) sizes[v] = size, lowered = true;
            }
        };
        for (const TooFar& far : deviation.from_mesh.beyond) lower(far.triangle, far.distance);
        for (const TooFar& far : deviation.from_input.beyond) lower(far.nearest, far.distance);
        if (!lowered) return std::nullopt;
        ++mesh_.refinements;
        if (gradation_) mesh_.gradation = grade(make_mesh(mesh.points, mesh.triangles), sizes, *gradation_);
        return sizes;
    }

  private:
    const Triangulation& surface_;
    const std::optional<GradationOptions>& gradation_;
    double hmin_;
    TriangulatedMesh& mesh_;
    DistanceTarget target_;
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
    Keeper keeper = stages.run("distance tree", [&] { return Keeper(surface, gradation, finest, mesh); });
    Recheck recheck;
    if (mesh.chord_error)
        recheck = [&](const SurfaceMesh& draft, MeshStage stage) {
            stages.detail(fmt::format("{} triangles", grouped(draft.triangles.size())));
            // Drafts keep a margin for what the rest of the schedule moves.
            return keeper.refine(draft, (stage == MeshStage::Draft ? kDraftShare : 1) * *mesh.chord_error);
        };
    mesh.result = stages.run("meshing", [&] { return remesh(whole, control, map.cells, options, recheck); });
    stages.run("distance", [&] { keeper.measure(mesh.result.mesh, 0, kPrecision); });
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
    std::string text = fmt::format("distance: {:.4g} from the input to the mesh, {:.4g} back ({:.3g} of the diagonal)", d.from_input.largest, d.from_mesh.largest,
                                   d.largest() / diagonal);
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

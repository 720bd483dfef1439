#include "triangulated.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <set>

#include "files.hpp"
#include "gradus/gradation/gradient.hpp"
#include "gradus/gradation/hold.hpp"
#include "gradus/io/mesh_files.hpp"
#include "gradus/io/required_file.hpp"
#include "gradus/mesh/diagnose.hpp"

namespace gradus::app {

namespace {

constexpr double kChordShare = 0.4;    // of the chord error that sizes ask of edges: triangles are farther off than their edges
constexpr double kMostTurn = std::numbers::pi / 3;  // of a curve no larger than the chord error, within one edge
constexpr double kBulgeShare = 0.2;    // that the smooth surface may be off the triangulation
constexpr int kMostDrafts = 3, kMostRefinements = 24;
constexpr int kMostAtOnePlace = 8;     // times that sizes are lowered there
constexpr double kPlace = 4;           // width of a place over the chord error
constexpr int kMostInVain = 4;
constexpr double kAlmostClosest = 1.3;
constexpr double kAround = 3;          // sizes
constexpr double kSampleShare = 0.9;  // of the chord error, that samples keep of triangles that keep it
constexpr double kFewFar = 0.01;      // of the triangles, too far off in a draft that is good enough
constexpr double kProgress = 0.95;
constexpr double kGoal = 0.8;          // of the chord error, aimed at where it was not kept
constexpr double kSteepest = 0.35, kLeastInDrafts = 0.85, kLeast = 0.75;  // change of sizes there
constexpr double kCoarsePrecision = 0.1;  // of those that tell how far to lower sizes
constexpr double kPrecision = 0.01;    // of the distances reported
// Of the length of frozen edges, and slope from there, down to which sizes go to keep a chord error: edges of half that length still count
// as unit beside them.
constexpr double kLeastHeld = 0.6;
constexpr double kFinest = 0.1;        // of the default hmin, down to which sizes go to keep a chord error

// Measures meshes against the triangulation, and lowers their sizes where they are too far from it.
class Keeper {
  public:
    Keeper(const Triangulation& surface, const std::optional<GradationOptions>& gradation, double hmin, TriangulatedMesh& mesh)
        : surface_(surface), gradation_(gradation), hmin_(hmin), mesh_(mesh) {}

    // Two-sided, without a limit.
    void measure(const SurfaceMesh& mesh) {
        const MeshView input{surface_.soup().points, surface_.soup().triangles}, output{mesh.points, mesh.triangles};
        mesh_.deviation.from_mesh = target().measure_from(output, {.precision = kPrecision, .near = triangles_under(mesh)});
        mesh_.deviation.from_input = DistanceTarget(output).measure_from(input, {.precision = kPrecision, .near = triangles_over(mesh)});
    }

    // Sizes at the vertices of a draft to go on with; nothing where its triangles keep the chord error.
    std::optional<std::vector<double>> refine_draft(const SurfaceMesh& mesh, double chord_error) {
        if (mesh_.refinements == kMostDrafts) return std::nullopt;
        const std::vector<TooFar> far = target().sample_from({mesh.points, mesh.triangles}, kSampleShare * chord_error, triangles_under(mesh));
        if (static_cast<double>(far.size()) <= kFewFar * static_cast<double>(mesh.triangles.size())) return std::nullopt;
        return lowered(mesh, far, chord_error, kLeastInDrafts, {});
    }

    // The same for a mesh that may be the last.
    std::optional<std::vector<double>> refine(const SurfaceMesh& mesh, double chord_error, std::span<const Eigen::Vector3d> in_vain) {
        const std::vector<TooFar> far = prove(mesh, chord_error);
        if (far.empty()) return std::nullopt;
        // Where neither their number nor their distance falls, smaller elements do not help.
        const bool better = far.size() < fewest_ || mesh_.deviation.bound() < kProgress * nearest_;
        fewest_ = std::min(fewest_, far.size());
        nearest_ = std::min(nearest_, mesh_.deviation.bound());
        in_vain_ = better ? 0 : in_vain_ + 1;
        if (in_vain_ == kMostInVain) return std::nullopt;
        return lowered(mesh, far, chord_error, kLeast, in_vain);
    }

    // The gradation of the map that the mesh has at the end.
    void measure_map() {
        if (!last_map_.points.empty()) measure_graded(make_mesh(last_map_.points, last_map_.triangles), last_map_.sizes, *gradation_, *mesh_.gradation);
    }

  private:
    const DistanceTarget& target() {
        if (!target_) target_.emplace(MeshView{surface_.soup().points, surface_.soup().triangles});
        return *target_;
    }

    // For each vertex of a mesh the triangle of the input under it.
    static std::vector<int> triangles_under(const SurfaceMesh& mesh) {
        std::vector<int> under;
        under.reserve(mesh.places.size());
        for (const SurfacePoint& at : mesh.places) under.push_back(at.patch);
        return under;
    }

    // For each vertex of the input a triangle of the mesh near it: those at the mesh's vertices, spread over the input.
    std::vector<int> triangles_over(const SurfaceMesh& mesh) const {
        const Connectivity& input = surface_.mesh();
        std::vector<int> over(input.num_vertices(), -1), queue;
        queue.reserve(over.size());
        const auto reach = [&](int vertex, int triangle) {
            if (over[vertex] < 0) over[vertex] = triangle, queue.push_back(vertex);
        };
        for (int t = 0; t < std::ssize(mesh.triangles); ++t)
            for (const int v : mesh.triangles[t])
                for (const int corner : input.triangle(mesh.places[v].patch)) reach(corner, t);
        for (std::size_t i = 0; i < queue.size(); ++i)
            input.for_each_outgoing(queue[i], [&](int h) {
                reach(input.target(h), over[queue[i]]);
                reach(input.apex(h), over[queue[i]]);
            });
        return over;
    }

    // Proves that triangles of the mesh are within the limit of the input, those anew that were not proved before. @returns the others
    // @param now  for each triangle of the last mesh that was proved its number in this one, or -1
    std::vector<TooFar> prove_from_mesh(const SurfaceMesh& mesh, double limit, const std::vector<int>& now) {
        std::vector<char> kept(mesh.triangles.size(), 0);
        for (std::size_t t = 0; t < now.size(); ++t)
            if (now[t] >= 0 && proof_.kept[t]) kept[now[t]] = 1;
        OneSidedDistance& found = mesh_.deviation.from_mesh;
        found = target().measure_from({mesh.points, mesh.triangles}, {.limit = limit, .precision = kCoarsePrecision, .near = triangles_under(mesh), .skip = kept});
        proof_.kept.assign(mesh.triangles.size(), 1);
        for (const TooFar& f : found.beyond) proof_.kept[f.triangle] = 0;
        proof_.mesh = mesh;
        include_kept(found, limit);
        return found.beyond;
    }

    // The same both ways. @returns the triangles of the mesh that are too far off, or that too distant ones of the input are closest to
    std::vector<TooFar> prove(const SurfaceMesh& mesh, double limit) {
        const MeshView input{surface_.soup().points, surface_.soup().triangles};
        const std::vector<int> now = same_triangles(proof_.mesh, mesh);
        std::vector<TooFar> far = prove_from_mesh(mesh, limit, now);
        std::vector<char> kept(input.triangles.size(), 0);
        proof_.witnesses.resize(input.triangles.size());
        for (std::size_t t = 0; t < input.triangles.size(); ++t) {
            Witnesses& w = proof_.witnesses[t];
            for (int i = 0; i < w.size && w.proved; ++i) w.proved = (w[i] = now[w[i]]) >= 0;
            kept[t] = w.proved;
        }
        OneSidedDistance& found = mesh_.deviation.from_input;
        const DistanceTarget target({mesh.points, mesh.triangles});
        found = target.measure_from(input, {.limit = limit, .precision = kCoarsePrecision, .near = triangles_over(mesh), .skip = kept, .witnesses = proof_.witnesses});
        include_kept(found, limit);
        // The triangle that leaves a place out is not always the one closest to it.
        for (const TooFar& f : found.beyond)
            for (const int t : target.within(f.point, kAlmostClosest * f.distance)) far.push_back({t, f.distance, f.point, f.triangle});
        return far;
    }

    // What was proved before holds within the limit.
    void include_kept(OneSidedDistance& found, double limit) {
        proof_.bound_of_kept = std::max(proof_.bound_of_kept, std::min(limit, found.bound));
        found.bound = std::max(found.bound, proof_.bound_of_kept);
    }

    // For each triangle of one mesh that with the same corners in another, or -1.
    static std::vector<int> same_triangles(const SurfaceMesh& old, const SurfaceMesh& mesh) {
        std::vector<int> same(old.triangles.size(), -1);
        if (old.triangles.empty()) return same;
        const auto before = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
            return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
        };
        std::vector<int> sorted(mesh.points.size());
        std::iota(sorted.begin(), sorted.end(), 0);
        std::sort(sorted.begin(), sorted.end(), [&](int a, int b) { return before(mesh.points[a], mesh.points[b]); });
        std::vector<int> vertex(old.points.size(), -1);
        for (std::size_t v = 0; v < vertex.size(); ++v) {
            const auto at = std::lower_bound(sorted.begin(), sorted.end(), old.points[v], [&](int a, const Eigen::Vector3d& p) { return before(mesh.points[a], p); });
            if (at != sorted.end() && mesh.points[*at] == old.points[v]) vertex[v] = *at;
        }
        // A triangle is filed under its smallest vertex.
        std::vector<int> first(mesh.points.size() + 1, 0), filed(mesh.triangles.size());
        for (const Triangle& t : mesh.triangles) ++first[std::min({t[0], t[1], t[2]}) + 1];
        for (std::size_t v = 0; v + 1 < first.size(); ++v) first[v + 1] += first[v];
        std::vector<int> next(first.begin(), first.end() - 1);
        for (int t = 0; t < std::ssize(mesh.triangles); ++t) filed[next[std::min({mesh.triangles[t][0], mesh.triangles[t][1], mesh.triangles[t][2]})]++] = t;
        const auto from_smallest = [](Triangle t) {
            std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
            return t;
        };
        for (std::size_t i = 0; i < same.size(); ++i) {
            const auto& [a, b, c] = old.triangles[i];
            if (vertex[a] < 0 || vertex[b] < 0 || vertex[c] < 0) continue;
            const Triangle wanted = from_smallest({vertex[a], vertex[b], vertex[c]});
            for (int k = first[wanted[0]]; k < first[wanted[0] + 1]; ++k)
                if (from_smallest(mesh.triangles[filed[k]]) == wanted) same[i] = filed[k];
        }
        return same;
    }

    static std::array<long, 3> cell_of(const Eigen::Vector3d& p, double width) {
        return {std::lround(p.x() / width), std::lround(p.y() / width), std::lround(p.z() / width)};
    }

    // Sizes of a mesh, lower at the triangles that are too far off; nothing where none can be.
    std::optional<std::vector<double>> lowered(const SurfaceMesh& mesh, const std::vector<TooFar>& far, double chord_error, double least, std::span<const Eigen::Vector3d> in_vain) {
        if (far.empty() || mesh_.refinements == kMostRefinements) return std::nullopt;
        std::vector<double> sizes = mesh.sizes;
        bool any = false;
        for (const TooFar& f : far) {
            const auto& corners = mesh.triangles[f.triangle];
            const double reach = kAround * mesh.sizes[corners[0]];
            if (std::any_of(in_vain.begin(), in_vain.end(), [&](const Eigen::Vector3d& p) { return (p - mesh.points[corners[0]]).norm() < reach; })) continue;
            // Gaps fall with the square of the size on smooth parts, and with the size itself on sharp ones, where that did not do.
            Lowered& before = lowered_at_[cell_of(f.point, kPlace * chord_error)];
            if (before.round < mesh_.refinements) before = {mesh_.refinements, before.times + 1};
            if (before.times > kMostAtOnePlace) continue;
            const double power = before.times == 1 || mesh_.refinements < kMostDrafts ? 0.5 : 1;
            const double factor = std::clamp(std::pow(kGoal * chord_error / std::max(f.distance, chord_error), power), kSteepest, least);
            for (const int v : mesh.triangles[f.triangle]) {
                const double size = std::max(factor * mesh.sizes[v], hmin_);
                if (size < sizes[v]) sizes[v] = size, any = true;
            }
        }
        if (!any) return std::nullopt;
        if (gradation_) {
            if (gradation_->method == GradationMethod::Full) limit_gradient(mesh.points, mesh.triangles, gradient_bound(*gradation_), sizes);
            else grade(make_mesh(mesh.points, mesh.triangles), sizes, *gradation_);
        }
        std::vector<double> graded = sizes;
        if (!mesh.required.empty() && !hold(mesh, sizes)) return std::nullopt;
        if (gradation_) last_map_ = {mesh.points, mesh.triangles, std::move(graded)};
        ++mesh_.refinements;
        return sizes;
    }

    // Raises sizes beside frozen edges, where smaller elements are no way out. @returns whether any is still below that of the mesh
    static bool hold(const SurfaceMesh& mesh, std::vector<double>& sizes) {
        const Connectivity connectivity(static_cast<int>(mesh.points.size()), mesh.triangles);
        std::vector<double> held = frozen_edge_lengths(mesh.points, connectivity, frozen_elements(mesh.points, connectivity, mesh.required));
        for (double& length : held) length *= kLeastHeld;
        raise_to_held(make_mesh(mesh.points, mesh.triangles), held, kLeastHeld, sizes);
        return !std::equal(sizes.begin(), sizes.end(), mesh.sizes.begin(), [](double now, double before) { return now > (1 - 1e-6) * before; });
    }

    struct Proof {
        SurfaceMesh mesh;
        std::vector<char> kept;            // triangles of the mesh that keep the limit
        std::vector<Witnesses> witnesses;  // in the mesh, for the triangles of the input
        double bound_of_kept = 0;
    };

    const Triangulation& surface_;
    const std::optional<GradationOptions>& gradation_;
    double hmin_;
    TriangulatedMesh& mesh_;
    std::optional<DistanceTarget> target_;  // made when asked for: the mesh that begins with the input's triangles has fewer by then
    Proof proof_;
    struct Lowered {
        int round = -1, times = 0;  // the last in which sizes were lowered there, and how many there were
    };
    struct Map {
        std::vector<Eigen::Vector3d> points;
        std::vector<Triangle> triangles;
        std::vector<double> sizes;
    };
    Map last_map_;  // after sizes were lowered
    std::map<std::array<long, 3>, Lowered> lowered_at_;  // by place
    std::size_t fewest_ = std::numeric_limits<std::size_t>::max();  // triangles that were too far
    double nearest_ = std::numeric_limits<double>::infinity();      // largest distance
    int in_vain_ = 0;                                               // rounds since either fell
};

std::string labels_there(const TriangleSoup& soup) {
    constexpr int kMost = 20;
    const std::set<int> labels(soup.labels.begin(), soup.labels.end());
    if (labels.empty()) return "there are none";
    std::string text = "its labels are";
    int count = 0;
    for (const int label : labels)
        if (count++ < kMost) text += fmt::format("{}{}", count > 1 ? ", " : " ", label);
    return count > kMost ? fmt::format("{} and more, up to {}", text, *labels.rbegin()) : text;
}

template <class Item>
void append(std::vector<Item>& to, const std::vector<Item>& items) {
    to.insert(to.end(), items.begin(), items.end());
}

// What the options require besides the file itself.
void add_required(const std::string& path, const TriangulationChoice& choice, TriangleSoup& soup) {
    RequiredElements& required = soup.required;
    std::set<int> known(required.triangles.begin(), required.triangles.end());
    for (const int label : choice.freeze) {
        bool found = false;
        for (int t = 0; t < std::ssize(soup.labels); ++t) {
            if (soup.labels[t] != label) continue;
            found = true;
            if (known.insert(t).second) required.triangles.push_back(t);
        }
        if (!found) throw Failure(fmt::format("{}: --freeze {}: no triangle has that label; {}", path, label, labels_there(soup)));
    }
    if (choice.freeze_list.empty()) return;
    const RequiredElements list = read_required(choice.freeze_list, soup.points.size(), soup.triangles.size());
    append(required.vertices, list.vertices);
    append(required.edges, list.edges);
    for (const int t : list.triangles)
        if (known.insert(t).second) required.triangles.push_back(t);
}

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
    app.add_option("--freeze", choice.freeze,
                   "Keep the triangles of a label as they are, as RequiredTriangles of .mesh; may be repeated (RequiredVertices and "
                   "RequiredEdges are kept too; Ridges are divided anew)")
        ->type_name("LABEL")
        ->type_size(1)
        ->allow_extra_args(false)
        ->take_all()
        ->group(group);
    app.add_option("--freeze-list", choice.freeze_list, "Keep what the lines of a text name: \"vertex I\", \"edge I J\", \"triangle I\", from 1 on")
        ->type_name("LIST")
        ->group(group);
}

void check_for_patches(const TriangulationChoice& choice) {
    if (!choice.freeze.empty() || !choice.freeze_list.empty())
        throw UsageError(fmt::format("{} is for triangle meshes, not for patches", choice.freeze.empty() ? "--freeze-list" : "--freeze"));
}

std::unique_ptr<Triangulation> load_triangulation(const std::string& path, const TriangulationChoice& choice, const SizingOptions& sizing, const Session& session) {
    TriangleSoup soup = read_mesh(path);
    add_required(path, choice, soup);
    soup = sound(path, std::move(soup), choice.repair, session);
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

GivenSizes read_given_sizes(const std::string& sizes, const std::string& background, const Triangulation& surface) {
    if (background.empty()) return {read_sizes(sizes, surface.soup().points.size())};
    TriangleSoup mesh = read_mesh(background);
    if (const std::string reasons = why_not_manifold(diagnose(mesh)); !reasons.empty())
        throw Failure(background + ": not an oriented manifold: " + reasons);
    std::vector<double> read = read_sizes(sizes, mesh.points.size());
    return {std::move(read), std::move(mesh), background};
}

namespace {

TriangulationBackground given_background(const Triangulation& surface, const GivenSizes& given) {
    if (!given.background) return make_background(surface, given.sizes);
    try {
        return make_background(surface, *given.background, given.sizes);
    } catch (const std::invalid_argument& error) {
        throw Failure(given.path + ": " + error.what());
    }
}

}  // namespace

TriangulatedMesh mesh_triangulation(const Triangulation& surface, const SizingRule& rule, const GivenSizes& given,
                                    const std::optional<GradationOptions>& gradation, const RemeshOptions& options, bool hmin_given, Stages& stages) {
    TriangulatedMesh mesh;
    if (rule.kind == SizingRule::Kind::ChordError) mesh.chord_error = rule.value;
    SizingRule asked = rule;
    if (mesh.chord_error) {
        asked.value *= kChordShare;
        asked.most_turn = kMostTurn;
    }
    TriangulationBackground map = stages.run("background", [&] {
        return given.sizes.empty() ? make_background(surface, asked, static_cast<int>(options.max_triangles)) : given_background(surface, given);
    });
    mesh.background_vertices = map.sizes.size();
    if (gradation) stages.run("gradation", [&] { mesh.gradation = grade(map.background.mesh, map.sizes, *gradation); });
    raise_to_held(map.background.mesh, frozen_edge_lengths(surface.soup().points, surface.mesh(), surface.frozen()), kHoldSlope, map.sizes);
    auto control = std::make_unique<const ControlSpace>(map.background, map.sizes);
    // Of no use any more, and large: the mesh of the background, and its sizes once there are others.
    map.background.mesh = {};
    map.sizes = {};
    bool has_other_sizes = false;
    const SmoothSupport support = surface.support(
        {.largest_bulge = mesh.chord_error ? kBulgeShare * *mesh.chord_error : std::numeric_limits<double>::infinity()});
    const TriangulatedSurface whole{support, surface.features(), surface.soup().labels, &surface.soup().required};
    const double finest = hmin_given ? rule.hmin : kFinest * rule.hmin;
    Keeper keeper(surface, gradation, finest, mesh);
    Recheck recheck;
    if (mesh.chord_error)
        recheck = [&](const SurfaceMesh& draft, MeshStage stage, std::span<const Eigen::Vector3d> in_vain) {
            stages.detail(fmt::format("{} triangles", grouped(draft.triangles.size())));
            if (has_other_sizes) control.reset();
            auto sizes = stage == MeshStage::Draft ? keeper.refine_draft(draft, *mesh.chord_error) : keeper.refine(draft, *mesh.chord_error, in_vain);
            has_other_sizes = has_other_sizes || sizes;
            return sizes;
        };
    mesh.result = stages.run("meshing", [&] { return remesh(whole, *control, map.cells, options, recheck); });
    // With a chord error the last check has measured it.
    keeper.measure_map();
    if (!mesh.chord_error) stages.run("distance", [&] { keeper.measure(mesh.result.mesh); });
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

std::string text_of(const RequiredElements& required, const std::vector<std::string>& outputs) {
    if (required.empty()) return "";
    std::string text = fmt::format("frozen: {} vertices, {} edges, {} triangles are in the mesh as they were", grouped(required.vertices.size()),
                                   grouped(required.edges.size()), grouped(required.triangles.size()));
    for (const std::string& path : outputs)
        if (!marks_required(path)) text += fmt::format("; {} does not mark them, .mesh and .meshb do", path);
    return text + "\n";
}

Json json_of(const RequiredElements& required) {
    return {{"vertices", required.vertices.size()}, {"edges", required.edges.size()}, {"triangles", required.triangles.size()}};
}

Json json_of(const Triangulation& surface) {
    return {{"input_triangles", surface.soup().triangles.size()},
            {"input_vertices", surface.soup().points.size()},
            {"diagonal", surface.diagonal()},
            {"feature_curves", surface.features().chains.size()},
            {"required", json_of(surface.soup().required)},
            {"corners", std::count(surface.features().corner.begin(), surface.features().corner.end(), 1)}};
}

Json json_of(const TriangulatedMesh& mesh) {
    // With a chord error that is kept nothing farther was looked for, and no distance is known to be attained.
    const auto side = [](const OneSidedDistance& d) {
        const bool attained = d.largest > 0 || d.bound == 0;
        return Json{{"largest", attained ? Json(d.largest) : Json(nullptr)},
                    {"bound", d.bound},
                    {"at", attained ? Json{d.point.x(), d.point.y(), d.point.z()} : Json(nullptr)}};
    };
    return {{"distance", {{"from_input", side(mesh.deviation.from_input)}, {"from_mesh", side(mesh.deviation.from_mesh)}}},
            {"chord_error", mesh.chord_error ? Json(*mesh.chord_error) : Json(nullptr)},
            {"chord_error_kept", mesh.chord_error ? Json(mesh.kept()) : Json(nullptr)},
            {"refinements", mesh.refinements}};
}

MeshReport measure_surface_mesh(const TriangulatedMesh& mesh) {
    const SurfaceMesh& m = mesh.result.mesh;
    const KnownFeatures features{.edges = m.features};
    return measure({m.points, m.triangles}, {.sizes = m.sizes, .features = &features, .required = &m.required});
}

}  // namespace gradus::app

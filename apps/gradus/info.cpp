// gradus info: what is in a file, and what is wrong with it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <sstream>

#include "commands.hpp"
#include "fields.hpp"
#include "files.hpp"
#include "gradus/curvature/principal.hpp"
#include "gradus/io/mesh_files.hpp"
#include "gradus/io/patch_files.hpp"
#include "gradus/mesh/diagnose.hpp"
#include "gradus/mesh/self_contact.hpp"
#include "gradus/quality/shape.hpp"
#include "gradus/surface/t_junctions.hpp"
#include "json.hpp"
#include "show.hpp"

namespace gradus::app {

namespace {

struct Options {
    Session session;
    std::string file;
    bool repair = false;
    std::optional<double> weld;
    std::string out;
    CageChoice cage;
};

struct Extent {
    Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
    void add(const Eigen::Vector3d& p) { low = low.cwiseMin(p), high = high.cwiseMax(p); }
    double diagonal() const { return (high - low).stableNorm(); }
    std::string text() const {
        // As many digits as tell the ends apart far from the origin too.
        const double largest = std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
        const int digits =
            6 + (diagonal() > 0 ? static_cast<int>(std::clamp(std::log10(largest / diagonal()), 0.0, 11.0)) : 0);
        return fmt::format("from {:.{}g} {:.{}g} {:.{}g} to {:.{}g} {:.{}g} {:.{}g}, diagonal {:.6g}", low.x(), digits,
                           low.y(), digits, low.z(), digits, high.x(), digits, high.y(), digits, high.z(), digits,
                           diagonal());
    }
    Json json() const {
        return {
            {"low", {low.x(), low.y(), low.z()}}, {"high", {high.x(), high.y(), high.z()}}, {"diagonal", diagonal()}};
    }
};

constexpr double kSliver = 0.001;  // area-length of triangles that may hold gaps

std::string faults(const std::vector<std::string>& found) {
    if (found.empty()) return "nothing wrong found\n";
    std::string text;
    for (const std::string& line : found) text += "  " + line + "\n";
    return text;
}

// --- patches ---

// Samples of a patch: its extent, and the smallest radius of curvature with its place.
struct Samples {
    static constexpr int kIntervals = 64;
    Extent extent;
    double radius = std::numeric_limits<double>::infinity();
    SurfacePoint at;
};

Samples sample(const SurfaceModel& model) {
    Samples samples;
    for (int p = 0; p < model.num_patches(); ++p) {
        const std::vector<Eigen::Vector2d> uv = model.samples(p, Samples::kIntervals, Samples::kIntervals);
        std::vector<double> radii(uv.size());
        minimal_radii(model.patch(p), uv, radii);
        for (std::size_t i = 0; i < uv.size(); ++i) {
            samples.extent.add(model.patch(p).position(uv[i]));
            if (radii[i] < samples.radius) samples.radius = radii[i], samples.at = {p, uv[i]};
        }
    }
    return samples;
}

// Chains of boundary curves that share their ends.
int boundary_loops(const SurfaceModel& model) {
    std::vector<int> up(model.vertices().size());
    std::iota(up.begin(), up.end(), 0);
    const auto root = [&](int v) {
        while (up[v] != v) v = up[v];
        return v;
    };
    std::set<int> ends;
    for (const ModelCurve& curve : model.curves()) {
        if (curve.kind != CurveKind::Boundary) continue;
        ends.insert(curve.ends.begin(), curve.ends.end());
        up[root(curve.ends[0])] = root(curve.ends[1]);
    }
    std::set<int> loops;
    for (const int v : ends) loops.insert(root(v));
    return static_cast<int>(loops.size());
}

int info_of_patches(const Options& options) {
    const PatchFile file = read_patches(options.file);
    const SurfaceModel model = std::move(load_model(options.file).model);
    std::map<std::array<int, 2>, int> degrees;
    bool rational = false;
    for (const BezierNet& net : file.nets) {
        ++degrees[{net.degree_u, net.degree_v}];
        rational = rational || !net.weights.empty();
    }
    std::map<CurveKind, int> kinds;
    int seams = 0, flipped = 0;
    for (const ModelCurve& curve : model.curves()) {
        ++kinds[curve.kind];
        seams += curve.uses.size() == 2 && curve.uses[0].patch == curve.uses[1].patch;
    }
    for (int p = 0; p < model.num_patches(); ++p) flipped += model.flipped(p);
    const auto poles =
        std::count_if(model.vertices().begin(), model.vertices().end(), [](const ModelVertex& v) { return v.pole; });
    const int loops = boundary_loops(model);
    const Samples samples = sample(model);
    const std::vector<TJunction> junctions = find_t_junctions(model);

    std::string text = text_of(options.file, model);
    if (!file.origin.empty()) text += "  " + file.origin.substr(0, file.origin.find('\n')) + "\n";
    std::string list;
    Json degree_json = Json::array();
    for (const auto& [degree, count] : degrees) {
        list += fmt::format("{}{} of degree {} x {}", list.empty() ? "" : ", ", count, degree[0], degree[1]);
        degree_json.push_back({{"degree", degree}, {"patches", count}});
    }
    text += fmt::format("patches: {}{}; {} turned to agree with their neighbours\n", list,
                        rational ? ", some rational" : "", flipped);
    text += fmt::format(
        "curves: {} smooth, {} creases, {} boundary in {} loops, {} at poles, {} of them seams; {} pole{}\n",
        kinds[CurveKind::Smooth], kinds[CurveKind::Crease], kinds[CurveKind::Boundary], loops, kinds[CurveKind::Pole],
        seams, poles, poles == 1 ? "" : "s");
    text += fmt::format("extent: {}\n", samples.extent.text());
    const Eigen::Vector3d tip = samples.at.patch >= 0 ? model.position(samples.at) : Eigen::Vector3d::Zero().eval();
    if (samples.at.patch < 0)
        text += "curvature: none, all patches are flat\n";
    else
        text += fmt::format("smallest radius of curvature seen: {:.4g}, on patch {} at {:.4g} {:.4g} {:.4g}\n",
                            samples.radius, samples.at.patch + 1, tip.x(), tip.y(), tip.z());
    std::vector<std::string> found;
    for (const TJunction& t : junctions) {
        const Eigen::Vector3d& p = model.vertices()[t.vertex].point;
        found.push_back(fmt::format("T-junction at {:g} {:g} {:g}: the patches along that curve must be split there",
                                    p.x(), p.y(), p.z()));
    }
    options.session.say(text + faults(found));
    print(options.session, {{"kind", "patches"},
                            {"patches", model.num_patches()},
                            {"degrees", degree_json},
                            {"rational", rational},
                            {"components", model.num_components()},
                            {"flipped", flipped},
                            {"curves",
                             {{"smooth", kinds[CurveKind::Smooth]},
                              {"crease", kinds[CurveKind::Crease]},
                              {"boundary", kinds[CurveKind::Boundary]},
                              {"pole", kinds[CurveKind::Pole]}}},
                            {"seams", seams},
                            {"poles", poles},
                            {"boundary_loops", loops},
                            {"t_junctions", junctions.size()},
                            {"extent", samples.extent.json()},
                            {"smallest_radius", samples.radius},
                            {"sound", junctions.empty()}});
    return kMet;
}

// --- meshes ---

/// What is in a mesh, for people and for machines.
struct MeshInfo {
    std::string text;
    Json json;
};

std::string describe(const SelfContacts& contacts) {
    if (contacts.pairs.empty() && contacts.complete) return "";
    std::string text = fmt::format("{}{} pairs of triangles that touch or intersect beyond what they share:",
                                   contacts.complete ? "" : "at least ", grouped(contacts.pairs.count));
    constexpr std::size_t kNamed = 5;
    for (std::size_t i = 0; i < std::min(kNamed, contacts.pairs.first.size()); ++i)
        text += fmt::format(" {}-{}", contacts.pairs.first[i][0], contacts.pairs.first[i][1]);
    return text + (contacts.pairs.count > kNamed ? " ...\n" : "\n");
}

// What closed surfaces enclose; negative where they are inside out.
double volume_of(const TriangleSoup& soup) {
    double six = 0;
    const Eigen::Vector3d& origin = soup.points[soup.triangles[0][0]];
    for (const Triangle& t : soup.triangles)
        six += (soup.points[t[0]] - origin).dot((soup.points[t[1]] - origin).cross(soup.points[t[2]] - origin));
    return six / 6;
}

// Whether a mesh can be worked with as it is, and what mends it.
// @param worst  area-length of its triangles
std::string verdict(const TriangleSoup& soup, const Diagnosis& diagnosis, const SelfContacts& contacts, double worst) {
    if (soup.triangles.empty()) return "NOT usable: holds no triangles\n";
    const Cracks cracks = diagnosis.closed ? Cracks{} : find_cracks(soup);
    const bool touches = !contacts.pairs.empty() || !contacts.complete;
    const bool is_clean = is_clean_manifold(diagnosis) && cracks.empty() && !touches;
    if (is_clean && diagnosis.closed && volume_of(soup) < 0)
        return "usable, but inside out: its triangles face inwards\n";
    if (is_clean && worst > kSliver) return faults({});
    const Repaired mended = repair(soup, default_repair(soup));
    if (is_clean && mended.steps.empty()) return faults({});
    std::string text = is_manifold(diagnosis) ? "usable, but not sound:" : "NOT usable as it is, no oriented manifold:";
    if (!cracks.empty()) text += " " + text_of(cracks) + ";";
    if (touches) {
        const bool is_cured = !mended.steps.empty() && find_self_contacts(mended.soup).pairs.empty();
        text += is_cured
                    ? " its triangles touch or intersect;"
                    : " its triangles touch or intersect: mend that where it was made, a mesh of it does the same;";
    }
    if (mended.soup.triangles.empty()) return "NOT usable: no triangle has an area\n";
    if (!mended.steps.empty()) {
        text += " --repair would do this:\n";
        std::istringstream lines(summary(mended.steps));
        for (std::string line; std::getline(lines, line);) text += "  " + line + "\n";
        return text;
    }
    text.back() = '\n';
    return text;
}

MeshInfo describe(const std::string& name, const MeshData& data) {
    const TriangleSoup& soup = data.soup;
    const Diagnosis diagnosis = diagnose(soup);
    Extent extent;
    for (const Eigen::Vector3d& p : soup.points) extent.add(p);
    const std::set<int> labels(soup.labels.begin(), soup.labels.end());
    std::string text = name + ": triangle mesh\n" + summary(diagnosis);
    if (!soup.points.empty()) text += "extent: " + extent.text() + "\n";
    std::vector<std::string> extras;
    if (!labels.empty()) extras.push_back(fmt::format("{} labels", labels.size()));
    if (!soup.parameters.empty())
        extras.push_back(fmt::format("{} places on patches", grouped(soup.parameters.size())));
    if (!soup.edges.empty()) extras.push_back(fmt::format("{} feature edges", grouped(soup.edges.size())));
    if (!soup.corners.empty()) extras.push_back(fmt::format("{} corners", grouped(soup.corners.size())));
    if (!soup.required.empty())
        extras.push_back(fmt::format("{} vertices, {} edges and {} triangles required",
                                     grouped(soup.required.vertices.size()), grouped(soup.required.edges.size()),
                                     grouped(soup.required.triangles.size())));
    if (!extras.empty()) text += fmt::format("with {}\n", fmt::join(extras, ", "));
    if (!data.point_fields.empty()) text += "fields on points: " + names_of(data.point_fields) + "\n";
    if (!data.cell_fields.empty()) text += "fields on triangles: " + names_of(data.cell_fields) + "\n";

    const MeshView view{soup.points, soup.triangles};
    const MeshEdges edges = edges_of(view);
    const Summary lengths = summarise(edge_lengths(view, edges));
    const ShapeReport shape = measure_shape(view, edges);
    if (lengths.count > 0)
        text += fmt::format("edges from {:.4g} to {:.4g}, median {:.4g}; area-length worst {:.3f}, mean {:.3f}\n",
                            lengths.min, lengths.max, lengths.median, shape.area_length.min, shape.area_length.mean);
    const SelfContacts contacts = find_self_contacts(soup);
    text += describe(contacts);
    text += verdict(soup, diagnosis, contacts, shape.area_length.min);
    return {text,
            {{"kind", "mesh"},
             {"vertices", diagnosis.num_points},
             {"edges", diagnosis.num_edges},
             {"triangles", diagnosis.num_triangles},
             {"components", diagnosis.components},
             {"euler", diagnosis.euler_characteristic},
             {"closed", diagnosis.closed},
             {"boundary_loops", diagnosis.boundary_loops},
             {"boundary_edges", diagnosis.boundary_edges},
             {"repeated_index", diagnosis.repeated_index.count},
             {"zero_area", diagnosis.zero_area.count},
             {"duplicate_triangles", diagnosis.duplicate_triangles.count},
             {"duplicate_vertices", diagnosis.duplicate_vertices.count},
             {"unused_vertices", diagnosis.unused_vertices.count},
             {"nonmanifold_edges", diagnosis.non_manifold_edges.count},
             {"inconsistent_edges", diagnosis.inconsistent_edges.count},
             {"nonmanifold_vertices", diagnosis.non_manifold_vertices.count},
             {"labels", labels.size()},
             {"parameters", soup.parameters.size()},
             {"feature_edges", soup.edges.size()},
             {"required", json_of(soup.required)},
             {"point_fields", json_of(data.point_fields)},
             {"cell_fields", json_of(data.cell_fields)},
             {"extent", extent.json()},
             {"edge_length", {{"min", lengths.min}, {"median", lengths.median}, {"max", lengths.max}}},
             {"area_length", {{"min", shape.area_length.min}, {"mean", shape.area_length.mean}}},
             {"self_contacts",
              {{"count", contacts.pairs.count}, {"complete", contacts.complete}, {"first", contacts.pairs.first}}},
             {"manifold", is_manifold(diagnosis)},
             {"sound", is_clean_manifold(diagnosis)}}};
}

int info_of_mesh(const Options& options) {
    if (!options.out.empty()) check_output(options.out, {FileKind::Mesh});
    MeshData data = read_mesh_data(options.file);
    weld_read(options.file, data.soup, options.session);
    MeshInfo info = describe(options.file, data);
    options.session.say(info.text);
    if (options.repair) {
        const RepairOptions weld =
            options.weld ? RepairOptions{.weld_tolerance = *options.weld} : default_repair(data.soup);
        if (weld.weld_tolerance > 0 && weld.only_open)
            options.session.say(fmt::format("vertices at open edges within {:.3g} of the diagonal are taken for one\n",
                                            weld.weld_tolerance));
        const Repaired repaired = repair(data.soup, weld);
        const MeshData result{repaired.soup, follow(data.point_fields, repaired.point_source),
                              follow(data.cell_fields, repaired.triangle_source)};
        const MeshInfo after = repaired.steps.empty() ? info : describe("repaired", result);
        options.session.say(text_of(options.file, repaired) + (repaired.steps.empty() ? "" : after.text));
        info.json["repair"] = {{"steps", json_of(repaired.steps)}, {"result", after.json}};
        if (!options.out.empty()) {
            if (result.soup.triangles.empty()) throw Failure(options.file + ": nothing is left to write");
            const bool fields = !result.point_fields.empty() || !result.cell_fields.empty();
            check_holds(options.out, result.soup.points, result.soup.triangles);
            if (holds_fields(options.out))
                write_mesh_data(options.out, result);
            else
                write_mesh(options.out, result.soup);
            options.session.say(
                "wrote " + options.out +
                (fields && !holds_fields(options.out) ? " without the fields; .msh .ply .vtu can hold them\n" : "\n"));
        }
    }
    print(options.session, info.json);
    return kMet;
}

// --- sizes ---

int info_of_solution(const Options& options, const std::vector<Field>& fields) {
    const std::size_t count = fields[0].values.size() / static_cast<std::size_t>(fields[0].components);
    options.session.say(fmt::format("{}: fields at {} vertices: {}\n", options.file, grouped(count), names_of(fields)));
    print(options.session, {{"kind", "fields"}, {"count", count}, {"point_fields", json_of(fields)}});
    return kMet;
}

int info_of_sizes(const Options& options) {
    if (const std::vector<Field> fields = read_solution(options.file); fields.size() > 1 || fields[0].components > 1)
        return info_of_solution(options, fields);
    const std::vector<double> sizes = read_sizes(options.file);
    const auto unset = std::count_if(sizes.begin(), sizes.end(), [](double h) { return std::isinf(h); });
    std::vector<double> given;
    std::copy_if(sizes.begin(), sizes.end(), std::back_inserter(given), [](double h) { return std::isfinite(h); });
    const Summary s = summarise(given);
    options.session.say(fmt::format("{}: {} sizes", options.file, grouped(sizes.size())));
    if (s.count > 0) options.session.say(fmt::format(" from {:.4g} to {:.4g}, median {:.4g}", s.min, s.max, s.median));
    options.session.say(unset > 0 ? fmt::format("; {} not set\n", grouped(static_cast<long long>(unset))) : "\n");
    print(options.session, {{"kind", "sizes"},
                            {"count", sizes.size()},
                            {"unset", unset},
                            {"min", s.min},
                            {"median", s.median},
                            {"max", s.max}});
    return kMet;
}

int info_of_cage(const Options& options) {
    const CageInfo info = describe_cage(options.file, options.cage);
    options.session.say(info.text);
    print(options.session, info.json);
    return kMet;
}

int run_info(const Options& options) {
    if (options.repair && (kind_of(options.file) != FileKind::Mesh || options.cage.is_given()))
        throw UsageError("--repair is for triangle meshes, not for " + options.file);
    if (!options.repair && (!options.out.empty() || options.weld))
        throw UsageError(std::string(options.out.empty() ? "--weld" : "--output") +
                         " is for what is repaired; give --repair too");
    if (options.weld && !(*options.weld >= 0 && *options.weld <= 0.1))
        throw UsageError(fmt::format("--weld {}: must be from 0 to 0.1", *options.weld));
    check(options.cage);
    if (options.cage.is_given()) return info_of_cage(options);
    switch (kind_of(options.file)) {
        case FileKind::Patches:
            return info_of_patches(options);
        case FileKind::Mesh:
        case FileKind::ReadMesh:
            return info_of_mesh(options);
        case FileKind::Sizes:
            return info_of_sizes(options);
        case FileKind::SizeView:
        case FileKind::SizedMesh:
        case FileKind::Report:
        case FileKind::Unknown:
            break;
    }
    throw UsageError(options.file + ": unknown extension \"" + extension_of(options.file) +
                     "\"; known are .bpt .bez, .mesh .meshb .msh .obj .off .ply .stl .vtu .vtp .poly, .sol .solb");
}

}  // namespace

void add_info(CLI::App& app, Run& run) {
    CLI::App& command = *app.add_subcommand("info", "What is in a file, and what is wrong with it");
    const auto options = std::make_shared<Options>();
    command.add_option("FILE", options->file, "Bezier patches, a triangle mesh or a size map")->required();
    command.add_flag("--repair", options->repair, "Make an oriented manifold of a triangle mesh, and say what changes");
    command.add_option("--weld", options->weld,
                       "With --repair: weld vertices this close, as a fraction of the diagonal (default: those at open "
                       "edges, far below the edges)");
    command.add_option("-o,--output", options->out, "With --repair: the mesh to write")->type_name("OUT");
    add_cages(command, options->cage);
    add_session(command, options->session);
    run_with(command, run, options, run_info);
}

}  // namespace gradus::app

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "describe.hpp"
#include "files.hpp"
#include "gradus/curvature/principal.hpp"
#include "gradus/io/patch_files.hpp"
#include "gradus/surface/t_junctions.hpp"
#include "show.hpp"

namespace gradus::app {

std::string Extent::text() const {
    // As many digits as tell the ends apart far from the origin too.
    const double largest = std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
    const int digits =
        6 + (diagonal() > 0 ? static_cast<int>(std::clamp(std::log10(largest / diagonal()), 0.0, 11.0)) : 0);
    return fmt::format("from {:.{}g} {:.{}g} {:.{}g} to {:.{}g} {:.{}g} {:.{}g}, diagonal {:.6g}", low.x(), digits,
                       low.y(), digits, low.z(), digits, high.x(), digits, high.y(), digits, high.z(), digits,
                       diagonal());
}

Json Extent::json() const {
    return {{"low", {low.x(), low.y(), low.z()}}, {"high", {high.x(), high.y(), high.z()}}, {"diagonal", diagonal()}};
}

std::string text_of_faults(const std::vector<std::string>& found) {
    if (found.empty()) return "nothing wrong found\n";
    std::string text;
    for (const std::string& line : found) text += "  " + line + "\n";
    return text;
}

namespace {

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

Description describe_degrees(const PatchFile& file) {
    std::map<std::array<int, 2>, int> degrees;
    bool rational = false;
    for (const BezierNet& net : file.nets) {
        ++degrees[{net.degree_u, net.degree_v}];
        rational = rational || !net.weights.empty();
    }
    std::vector<std::string> list;
    Json json = Json::array();
    for (const auto& [degree, count] : degrees) {
        list.push_back(fmt::format("{} of degree {} x {}", count, degree[0], degree[1]));
        json.push_back({{"degree", degree}, {"patches", count}});
    }
    return {fmt::format("patches: {}{}", fmt::join(list, ", "), rational ? ", some rational" : ""),
            {{"degrees", json}, {"rational", rational}}};
}

Description describe_curves(const SurfaceModel& model) {
    std::map<CurveKind, int> kinds;
    int seams = 0;
    for (const ModelCurve& curve : model.curves()) {
        ++kinds[curve.kind];
        seams += curve.uses.size() == 2 && curve.uses[0].patch == curve.uses[1].patch;
    }
    const auto poles =
        std::count_if(model.vertices().begin(), model.vertices().end(), [](const ModelVertex& v) { return v.pole; });
    const int loops = boundary_loops(model);
    return {fmt::format(
                "curves: {} smooth, {} creases, {} boundary in {} loops, {} at poles, {} of them seams; {} pole{}\n",
                kinds[CurveKind::Smooth], kinds[CurveKind::Crease], kinds[CurveKind::Boundary], loops,
                kinds[CurveKind::Pole], seams, poles, poles == 1 ? "" : "s"),
            {{"curves",
              {{"smooth", kinds[CurveKind::Smooth]},
               {"crease", kinds[CurveKind::Crease]},
               {"boundary", kinds[CurveKind::Boundary]},
               {"pole", kinds[CurveKind::Pole]}}},
             {"seams", seams},
             {"poles", poles},
             {"boundary_loops", loops}}};
}

Description describe_extent(const SurfaceModel& model) {
    const Samples samples = sample(model);
    std::string text = fmt::format("extent: {}\n", samples.extent.text());
    if (samples.at.patch < 0) {
        text += "curvature: none, all patches are flat\n";
    } else {
        const Eigen::Vector3d tip = model.position(samples.at);
        text += fmt::format("smallest radius of curvature seen: {:.4g}, on patch {} at {:.4g} {:.4g} {:.4g}\n",
                            samples.radius, samples.at.patch + 1, tip.x(), tip.y(), tip.z());
    }
    return {text, {{"extent", samples.extent.json()}, {"smallest_radius", samples.radius}}};
}

}  // namespace

Description describe_patches(const std::string& path) {
    const PatchFile file = read_patches(path);
    const SurfaceModel model = std::move(load_model(path).model);
    int flipped = 0;
    for (int p = 0; p < model.num_patches(); ++p) flipped += model.flipped(p);
    const Description degrees = describe_degrees(file), curves = describe_curves(model),
                      extent = describe_extent(model);
    std::vector<std::string> found;
    for (const TJunction& t : find_t_junctions(model)) {
        const Eigen::Vector3d& p = model.vertices()[t.vertex].point;
        found.push_back(fmt::format("T-junction at {:g} {:g} {:g}: the patches along that curve must be split there",
                                    p.x(), p.y(), p.z()));
    }
    std::string text = text_of(path, model);
    if (!file.origin.empty()) text += "  " + file.origin.substr(0, file.origin.find('\n')) + "\n";
    text += fmt::format("{}; {} turned to agree with their neighbours\n", degrees.text, flipped);
    text += curves.text + extent.text + text_of_faults(found);
    Json json{{"kind", "patches"},  {"patches", model.num_patches()}, {"components", model.num_components()},
              {"flipped", flipped}, {"t_junctions", found.size()},    {"sound", found.empty()}};
    for (const Description* part : {&degrees, &curves, &extent}) json.update(part->json);
    return {text, json};
}

}  // namespace gradus::app

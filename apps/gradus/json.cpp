#include "json.hpp"

#include <cmath>
#include <cstdio>

#include "gradus/io/output_file.hpp"
#include "gradus/io/report_json.hpp"
#include "options.hpp"

namespace gradus::app {

namespace {

std::string name_of(SizingRule::Kind kind) {
    switch (kind) {
        case SizingRule::Kind::Proportional:
            return "alpha";
        case SizingRule::Kind::RelativeChordError:
            return "relative_chord_error";
        case SizingRule::Kind::ChordError:
            return "chord_error";
        case SizingRule::Kind::NormalAngle:
            return "normal_angle";
    }
    return "";
}

Json optional(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

}  // namespace

Json json_of(const SizingRule& rule) {
    Json at = Json::array();
    for (const SizingRule::At& point : rule.at)
        at.push_back({{"point", {point.point.x(), point.point.y(), point.point.z()}}, {"size", point.size}});
    Json regions = Json::array();
    for (const SizingRule::Region& region : rule.regions)
        regions.push_back({{"label", region.label}, {"size", region.size}});
    return {{"rule", name_of(rule.kind)},
            {"value", rule.value},
            {"hmin", rule.hmin},
            {"hmax", rule.hmax},
            {"at", at},
            {"feature_gap", rule.feature_clearance},
            {"gap", rule.sheet_clearance},
            {"regions", regions}};
}

Json json_of(const GradationReport& report) {
    return {{"shock_max", report.shock_max},
            {"shock_edge", report.shock_edge},
            {"shock_p999", report.shock_p999},
            {"variation_max", report.variation_max},
            {"variation_edge", report.variation_edge},
            {"gradient_max", report.gradient_max},
            {"gradient_triangle", report.gradient_triangle},
            {"gradient_p999", report.gradient_p999}};
}

Json json_of(const GradationOptions& options, const GradationResult& result) {
    return {{"method", name_of(options.method)},
            {"shock", optional(options.shock)},
            {"variation", optional(options.variation)},
            {"met", result.met},
            {"converged", result.converged},
            {"lowered", result.lowered},
            {"largest_factor", result.largest_factor},
            {"gradient_bound", result.gradient_bound},
            {"steep_triangles", result.steep_triangles},
            {"coarse_edges", result.coarse_edges},
            {"conflicts", result.conflicts.size()},
            {"before", json_of(result.before)},
            {"after", json_of(result.after)}};
}

Json json_of(const MeshReport& report) { return Json::parse(to_json(report, -1)); }

Json json_of(const OffenderReport& report) { return Json::parse(to_json(report, -1)); }

Json json_of(const RequiredElements& required) {
    return {{"vertices", required.vertices.size()},
            {"edges", required.edges.size()},
            {"triangles", required.triangles.size()}};
}

Json json_of(const std::vector<StageTime>& stages) {
    Json json = Json::array();
    for (const StageTime& stage : stages) json.push_back({{"name", stage.name}, {"seconds", stage.seconds}});
    return json;
}

Json json_of(const std::vector<RepairStep>& steps) {
    Json json = Json::array();
    for (const RepairStep& step : steps)
        json.push_back({{"kind", name_of(step.kind)}, {"count", step.items.count}, {"first", step.items.first}});
    return json;
}

void print(const Session& session, const Json& json) {
    if (session.json && !session.quiet) std::printf("%s\n", json.dump(2).c_str());
}

void write(const std::string& path, const Json& json) { write_file(path, json.dump(2) + "\n"); }

}  // namespace gradus::app

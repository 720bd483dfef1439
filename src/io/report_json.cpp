#include "gradus/io/report_json.hpp"

#include <nlohmann/json.hpp>

namespace gradus {

namespace {

using Json = nlohmann::ordered_json;

Json json_of(const Summary& s) {
    return {{"count", s.count}, {"min", s.min}, {"p001", s.p001}, {"p01", s.p01}, {"median", s.median},
            {"mean", s.mean},   {"p99", s.p99}, {"p999", s.p999}, {"max", s.max}};
}

Json json_of(const Histogram& h) { return {{"low", h.low}, {"high", h.high}, {"counts", h.counts}}; }

Json json_of(const std::vector<Offender>& list, const char* what) {
    Json json = Json::array();
    for (const Offender& offender : list) json.push_back(Json{{what, offender.index}, {"value", offender.value}});
    return json;
}

Json json_of(const std::vector<EdgeOffender>& list) {
    Json json = Json::array();
    for (const EdgeOffender& offender : list) json.push_back(Json{{"edge", offender.ends}, {"value", offender.value}});
    return json;
}

Json json_of(const TopologyReport& t) {
    return {{"triangles", t.triangles},
            {"vertices", t.vertices},
            {"edges", t.edges},
            {"components", t.components},
            {"boundary_loops", t.boundary_loops},
            {"boundary_edges", t.boundary_edges},
            {"euler", t.euler},
            {"genus", t.genus ? Json(*t.genus) : Json(nullptr)},
            {"oriented_manifold", t.oriented_manifold()},
            {"closed", t.closed()},
            {"nonmanifold_edges", t.nonmanifold_edges},
            {"nonmanifold_vertices", t.nonmanifold_vertices},
            {"misoriented_edges", t.misoriented_edges},
            {"unused_vertices", t.unused_vertices},
            {"duplicate_positions", t.duplicate_positions},
            {"repeated_corners", t.repeated_corners},
            {"bad_points", t.bad_points}};
}

Json json_of(const ShapeReport& s) {
    return {{"area_length", json_of(s.area_length)},
            {"inradius_edge", json_of(s.inradius_edge)},
            {"radius_ratio", json_of(s.radius_ratio)},
            {"smallest_angle", json_of(s.smallest_angle)},
            {"largest_angle", json_of(s.largest_angle)},
            {"adjacent_edge_ratio", json_of(s.adjacent_edge_ratio)},
            {"degenerate", s.degenerate},
            {"valence_6", s.valence_6},
            {"interior_valence_6", s.interior_valence_6},
            {"interior_valence", json_of(s.interior_valence)},
            {"boundary_valence", json_of(s.boundary_valence)},
            {"area_length_histogram", json_of(s.area_length_histogram)},
            {"inradius_edge_histogram", json_of(s.inradius_edge_histogram)},
            {"smallest_angle_histogram", json_of(s.smallest_angle_histogram)},
            {"valence_histogram", json_of(s.valence_histogram)},
            {"worst", json_of(s.worst, "triangle")}};
}

Json json_of(const EdgeReport& e) {
    return {{"length", json_of(e.length)},  {"unit_share", e.unit_share},
            {"short_share", e.short_share}, {"long_share", e.long_share},
            {"short", e.num_short},         {"long", e.num_long},
            {"efficiency", e.efficiency},   {"log2_histogram", json_of(e.log2_histogram)},
            {"worst", json_of(e.worst)}};
}

Json json_of(const Shortfall& s) {
    return {{"count", s.count}, {"worst", s.count > 0 ? Json(s.worst) : Json(nullptr)}};
}

Json json_of(const OffenderReport& o) {
    Json groups = Json::array();
    for (const OffenderGroup& g : o.groups)
        groups.push_back({{"at", {g.point.x(), g.point.y(), g.point.z()}},
                          {"area_length", json_of(g.quality)},
                          {"angle", json_of(g.angle)},
                          {"edge_ratio", json_of(g.edge_ratio)},
                          {"cause",
                           {{"kind", name_of(g.cause.kind)},
                            {"text", to_text(g.cause)},
                            {"value", g.cause.value},
                            {"ids", g.cause.ids}}}});
    return {
        {"limits", {{"area_length", o.limits.quality}, {"angle", o.limits.angle}, {"edge_ratio", o.limits.edge_ratio}}},
        {"features_known", o.features_known},
        {"area_length", json_of(o.quality)},
        {"angle", json_of(o.angle)},
        {"edge_ratio", json_of(o.edge_ratio)},
        {"unexplained",
         {{"area_length", json_of(o.unexplained_quality)},
          {"angle", json_of(o.unexplained_angle)},
          {"edge_ratio", json_of(o.unexplained_edge_ratio)}}},
        {"num_groups", o.num_groups},
        {"groups", groups}};
}

Json json_of(const RealisedGradation& g) {
    return {{"size", json_of(g.size)},
            {"shock", json_of(g.shock)},
            {"variation", json_of(g.variation)},
            {"neighbour_edges", json_of(g.neighbour_edges)},
            {"neighbour_areas", json_of(g.neighbour_areas)},
            {"worst", json_of(g.worst)}};
}

Json json_of(const DistanceReport& d) {
    return {{"diagonal", d.diagonal},
            {"vertices", json_of(d.vertices)},
            {"midpoints", json_of(d.midpoints)},
            {"centroids", json_of(d.centroids)},
            {"worst_vertices", json_of(d.worst_vertices, "vertex")},
            {"worst_edges", json_of(d.worst_edges)},
            {"worst_triangles", json_of(d.worst_triangles, "triangle")}};
}

Json json_of(const NormalReport& n) {
    return {{"angle", json_of(n.angle)},
            {"over_45", n.over_45},
            {"over_60", n.over_60},
            {"without_normal", n.without_normal},
            {"worst", json_of(n.worst, "triangle")}};
}

Json json_of(const OneSidedDistance& d) {
    return {{"largest", d.largest}, {"bound", d.bound}, {"at", {d.point.x(), d.point.y(), d.point.z()}}};
}

Json json_of(const HausdorffReport& h) {
    return {{"diagonal", h.diagonal},
            {"largest", h.largest()},
            {"bound", h.bound()},
            {"relative_bound", h.relative_bound()},
            {"at", {h.point().x(), h.point().y(), h.point().z()}},
            {"from_mesh", json_of(h.from_mesh)},
            {"from_reference", json_of(h.from_reference)}};
}

Json json_of(const ReferenceReport& r, const TopologyReport& mesh) {
    const auto number = [](const std::optional<long long>& n) { return n ? Json(*n) : Json(nullptr); };
    Json compared = Json::array();
    for (const TopologyComparison& c : compare(mesh, r.topology))
        compared.push_back(
            {{"name", c.name}, {"mesh", number(c.mesh)}, {"reference", number(c.reference)}, {"same", c.same()}});
    return {{"hausdorff", json_of(r.hausdorff)}, {"topology", json_of(r.topology)}, {"compared", compared}};
}

template <class Part>
Json json_of(const std::optional<Part>& part) {
    return part ? json_of(*part) : Json(nullptr);
}

}  // namespace

std::string to_json(const MeshReport& report, int indent) {
    Json stages = Json::array();
    for (const auto& [name, seconds] : report.stages) stages.push_back(Json{{"name", name}, {"seconds", seconds}});
    const Json json{{"topology", json_of(report.topology)},
                    {"shape", json_of(report.shape)},
                    {"edges", json_of(report.edges)},
                    {"offenders", json_of(report.offenders)},
                    {"gradation", json_of(report.gradation)},
                    {"distance", json_of(report.distance)},
                    {"normals", json_of(report.normals)},
                    {"reference", report.reference ? json_of(*report.reference, report.topology) : Json(nullptr)},
                    {"stages", stages}};
    return json.dump(indent);
}

std::string to_json(const OffenderReport& report, int indent) { return json_of(report).dump(indent); }

}  // namespace gradus

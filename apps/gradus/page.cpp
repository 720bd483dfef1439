#include "page.hpp"

#include <fmt/format.h>

#include "options.hpp"
#include "session.hpp"

namespace gradus::app {

namespace {

std::string number(double value) { return fmt::format("{:.4g}", value); }
std::string whole(const std::optional<long long>& value) { return value ? grouped(*value) : "-"; }
std::string percent(double share) { return fmt::format("{:.2f} %", 100 * share); }

std::vector<std::string> low_row(const std::string& name, const Summary& s) {
    return {name, number(s.min), number(s.p001), number(s.p01), number(s.median), number(s.mean)};
}

std::vector<std::string> high_row(const std::string& name, const Summary& s, double scale = 1) {
    return {name,
            number(scale * s.median),
            number(scale * s.mean),
            number(scale * s.p99),
            number(scale * s.p999),
            number(scale * s.max)};
}

void add_checks(HtmlReport& page, const MeshReport& report) {
    const TopologyReport& t = report.topology;
    std::vector<HtmlReport::Check> checks{
        {"oriented manifold", t.oriented_manifold() ? "yes" : "no", "yes", t.oriented_manifold()},
        {"triangles without area", grouped(report.shape.degenerate), "none", report.shape.degenerate == 0},
        {"area-length, worst", number(report.shape.area_length.min), {}, {}, report.shape.area_length.min},
        {"area-length, mean", number(report.shape.area_length.mean), {}, {}, report.shape.area_length.mean}};
    if (report.edges)
        checks.push_back({"edges within [0.71, 1.41] in the size map",
                          percent(report.edges->unit_share),
                          {},
                          {},
                          report.edges->unit_share});
    if (report.normals)
        checks.push_back({"triangles at more than 60 degrees to the surface", grouped(report.normals->over_60), "none",
                          report.normals->over_60 == 0});
    if (report.reference) {
        const HausdorffReport& h = report.reference->hausdorff;
        checks.push_back({"Hausdorff distance to the reference, at most", number(h.bound())});
        checks.push_back({"the same, of the diagonal of the reference", number(h.relative_bound())});
        for (const TopologyComparison& c : compare(t, report.reference->topology))
            checks.push_back({c.name + std::string(" of the reference: ") + (c.same() ? "same" : "differs"),
                              whole(c.mesh), whole(c.reference), c.same()});
    }
    page.checks(checks);
}

// Where the two surfaces are farthest from each other.
void add_hausdorff(HtmlReport& page, const HausdorffReport& h) {
    const auto row = [](const std::string& name, const OneSidedDistance& d) {
        return std::vector<std::string>{
            name, number(d.largest), number(d.bound), number(d.point.x()), number(d.point.y()), number(d.point.z())};
    };
    page.table({"Hausdorff distance", "largest", "nowhere above", "at x", "y", "z"},
               {row("from mesh to reference", h.from_mesh), row("from reference to mesh", h.from_reference)});
}

// Elements short of the limits, by place.
void add_offenders(HtmlReport& page, const OffenderReport& o) {
    constexpr std::size_t kListed = 100;
    const auto row = [](const std::string& name, const Shortfall& all, const Shortfall& unexplained) {
        return std::vector<std::string>{name, grouped(all.count), all.count > 0 ? number(all.worst) : "",
                                        grouped(unexplained.count)};
    };
    page.table({"elements short of the limits", "count", "worst", "without a cause"},
               {row(fmt::format("area-length below {:g}", o.limits.quality), o.quality, o.unexplained_quality),
                row(fmt::format("angle below {:g} degrees", o.limits.angle), o.angle, o.unexplained_angle),
                row(fmt::format("edges at a vertex, ratio above {:g}", o.limits.edge_ratio), o.edge_ratio,
                    o.unexplained_edge_ratio)},
               o.features_known ? "" : "causes are not known, as the mesh is no oriented manifold");
    if (o.groups.empty()) return;
    std::vector<std::vector<std::string>> rows;
    const auto cell = [](const Shortfall& s) {
        return s.count == 0 ? "" : s.count == 1 ? number(s.worst) : fmt::format("{} ({})", number(s.worst), s.count);
    };
    for (std::size_t i = 0; i < std::min(kListed, o.groups.size()); ++i) {
        const OffenderGroup& g = o.groups[i];
        rows.push_back({to_text(g.cause), number(g.point.x()), number(g.point.y()), number(g.point.z()),
                        cell(g.quality), cell(g.angle), cell(g.edge_ratio)});
    }
    page.table({"cause", "at x", "y", "z", "area-length", "angle", "edge ratio"}, rows,
               o.num_groups > rows.size()
                   ? fmt::format("the worst of {} places", grouped(o.num_groups))
                   : "the worst value at each place, with the number of elements where there are several");
}

}  // namespace

HistogramData chart_of(const Histogram& histogram) {
    HistogramData chart;
    chart.range = {histogram.low, histogram.high};
    chart.counts = histogram.counts;
    return chart;
}

void add_mesh(HtmlReport& page, const MeshReport& report) {
    const TopologyReport& t = report.topology;
    page.text(
        fmt::format("{} triangles, {} vertices, {} edges; {} components, {} boundary loops, Euler characteristic {}{}.",
                    grouped(t.triangles), grouped(t.vertices), grouped(t.edges), t.components, t.boundary_loops,
                    t.euler, t.genus ? fmt::format(", genus {}", *t.genus) : ""));
    add_checks(page, report);
    const ShapeReport& s = report.shape;
    page.table({"shape", "min", ".1 %", "1 %", "median", "mean"},
               {low_row("area-length", s.area_length), low_row("inradius-edge", s.inradius_edge),
                low_row("radius ratio", s.radius_ratio), low_row("smallest angle, degrees", s.smallest_angle)},
               "1 is equilateral, 0 degenerate");
    const RealisedGradation& g = report.gradation;
    std::vector<std::vector<std::string>> rows{high_row("largest angle, degrees", s.largest_angle),
                                               high_row("edges at a vertex, longest / shortest", s.adjacent_edge_ratio),
                                               high_row("H-shock of realised sizes", g.shock),
                                               high_row("H-variation of realised sizes", g.variation),
                                               high_row("neighbours, longest / shortest edge", g.neighbour_edges),
                                               high_row("neighbours, larger / smaller area", g.neighbour_areas)};
    if (report.edges) rows.push_back(high_row("edge length in the size map", report.edges->length));
    if (report.normals) rows.push_back(high_row("angle to the surface, degrees", report.normals->angle));
    if (const auto& d = report.distance) {
        rows.push_back(high_row("vertices off the surface, 1e-6 of the diagonal", d->vertices, 1e6));
        rows.push_back(high_row("edge middles off the surface, 1e-6", d->midpoints, 1e6));
        rows.push_back(high_row("triangle middles off the surface, 1e-6", d->centroids, 1e6));
    }
    page.table({"spread", "median", "mean", "99 %", "99.9 %", "max"}, rows);
    add_offenders(page, report.offenders);
    if (report.reference) add_hausdorff(page, report.reference->hausdorff);
    page.histogram(chart_of(s.area_length_histogram), {.title = "Area-length quality", .x_label = "quality"});
    page.histogram(chart_of(s.smallest_angle_histogram), {.title = "Smallest angle", .x_label = "degrees"});
    if (report.edges)
        page.histogram(chart_of(report.edges->log2_histogram),
                       {.title = "Edge lengths in the size map", .x_label = "log2 of the metric length"});
}

void add_gradation(HtmlReport& page, const GradationOptions& options, const GradationResult& result,
                   std::size_t vertices) {
    const GradationReport &before = result.before, &after = result.after;
    page.text(fmt::format("{}: {} of {} vertices of the background lowered.", to_text(options), grouped(result.lowered),
                          grouped(vertices)));
    std::vector<HtmlReport::Check> checks;
    if (options.shock)
        checks.push_back({"H-shock of the graded map", fmt::format("{:.6g}", after.shock_max),
                          fmt::format("{:g}", *options.shock), after.shock_max <= *options.shock * (1 + 1e-9)});
    if (options.variation)
        checks.push_back({"H-variation of the graded map", fmt::format("{:.6g}", after.variation_max),
                          fmt::format("{:g}", *options.variation),
                          after.variation_max <= *options.variation * (1 + 1e-9)});
    if (options.method == GradationMethod::Full)
        checks.push_back({"gradient on triangles", fmt::format("{:.6g}", after.gradient_max),
                          fmt::format("{:.6g}", result.gradient_bound),
                          after.gradient_max <= result.gradient_bound * (1 + 1e-6)});
    page.checks(checks);
    page.table({"size map", "before", "after"},
               {{"H-shock, largest", number(before.shock_max), number(after.shock_max)},
                {"H-shock, 99.9 %", number(before.shock_p999), number(after.shock_p999)},
                {"H-variation, largest", number(before.variation_max), number(after.variation_max)},
                {"gradient, largest", number(before.gradient_max), number(after.gradient_max)}});
}

void add_stages(HtmlReport& page, const std::vector<StageTime>& stages) {
    std::vector<HtmlReport::Stage> rows;
    for (const StageTime& stage : stages) rows.push_back({stage.name, stage.seconds});
    page.stages(rows);
}

}  // namespace gradus::app

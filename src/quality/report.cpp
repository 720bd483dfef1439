#include "gradus/quality/report.hpp"

#include <fmt/format.h>
#include <algorithm>

namespace gradus {

namespace {

using Lines = std::vector<std::string>;

struct Row {
    const char* name;
    const Summary* summary;
    double scale = 1;
};

/// Quantities whose small values are the bad ones.
void append_low_table(std::string& text, const std::vector<Row>& rows) {
    text += fmt::format("{:<22}{:>11}{:>11}{:>11}{:>11}{:>11}\n", "", "min", ".1 %", "1 %", "median", "mean");
    for (const auto& [name, s, scale] : rows)
        text += fmt::format("  {:<20}{:>11.4g}{:>11.4g}{:>11.4g}{:>11.4g}{:>11.4g}\n", name, scale * s->min,
                            scale * s->p001, scale * s->p01, scale * s->median, scale * s->mean);
}

/// Quantities whose large values are the bad ones.
void append_high_table(std::string& text, const std::vector<Row>& rows) {
    text += fmt::format("{:<22}{:>11}{:>11}{:>11}{:>11}{:>11}\n", "", "median", "mean", "99 %", "99.9 %", "max");
    for (const auto& [name, s, scale] : rows)
        text += fmt::format("  {:<20}{:>11.4g}{:>11.4g}{:>11.4g}{:>11.4g}{:>11.4g}\n", name, scale * s->median,
                            scale * s->mean, scale * s->p99, scale * s->p999, scale * s->max);
}

void append_problem(std::string& text, std::size_t count, const char* what) {
    if (count > 0) text += fmt::format("  {:>10} {}\n", count, what);
}

void append_topology(std::string& text, const TopologyReport& t) {
    text += fmt::format("topology: {} triangles, {} vertices, {} edges\n", t.triangles, t.vertices, t.edges);
    text += fmt::format("  {}, {}: components {}, boundary loops {} ({} edges), genus {}, Euler characteristic {}\n",
                        t.oriented_manifold() ? "oriented manifold" : "NOT an oriented manifold",
                        t.closed() ? "closed" : "open", t.components, t.boundary_loops, t.boundary_edges,
                        t.genus ? std::to_string(*t.genus) : "-", t.euler);
    append_problem(text, t.nonmanifold_edges, "non-manifold edges");
    append_problem(text, t.nonmanifold_vertices, "non-manifold vertices");
    append_problem(text, t.misoriented_edges, "edges between triangles of opposite orientation");
    append_problem(text, t.repeated_corners, "triangles that name a vertex twice");
    append_problem(text, t.unused_vertices, "unused vertices");
    append_problem(text, t.duplicate_positions, "vertices on top of another");
    append_problem(text, t.bad_points, "vertices with coordinates that are not finite");
}

/// One line per bin, as wide as every other.
template <class Label>
Lines histogram_lines(const char* title, const Histogram& h, const Label& label) {
    constexpr int kBar = 30;
    const std::size_t total = std::max<std::size_t>(h.total(), 1),
                      tallest = std::max<std::size_t>(*std::max_element(h.counts.begin(), h.counts.end()), 1);
    Lines lines{fmt::format("  {:<{}}", title, kBar + 22)};
    const int bins = static_cast<int>(h.counts.size());
    for (int i = 0; i < bins; ++i) {
        // A bin that is not empty shows at least one mark.
        const std::size_t bar = (h.counts[i] * kBar + tallest - 1) / tallest;
        const double share = 100 * static_cast<double>(h.counts[i]) / static_cast<double>(total);
        lines.push_back(fmt::format("  {:>11} {:>6.2f} % |{:<{}}", label(i), share, std::string(bar, '#'), kBar));
    }
    return lines;
}

Lines range_lines(const char* title, const Histogram& h) {
    const double width = (h.high - h.low) / static_cast<double>(h.counts.size());
    return histogram_lines(
        title, h, [&](int i) { return fmt::format("{:.3g} - {:.3g}", h.low + i * width, h.low + (i + 1) * width); });
}

Lines log2_lines(const char* title, const Histogram& h) {
    const double width = (h.high - h.low) / static_cast<double>(h.counts.size());
    const int last = static_cast<int>(h.counts.size()) - 1;
    return histogram_lines(title, h, [&](int i) {
        const double low = std::exp2(h.low + i * width), high = std::exp2(h.low + (i + 1) * width);
        if (i == 0) return fmt::format("< {:.2f}", high);
        return i == last ? fmt::format("> {:.2f}", low) : fmt::format("{:.2f} - {:.2f}", low, high);
    });
}

Lines integer_lines(const char* title, const Histogram& h) {
    const int last = static_cast<int>(h.counts.size()) - 1, first = static_cast<int>(std::ceil(h.low));
    return histogram_lines(title, h, [&](int i) { return fmt::format("{}{}", first + i, i == last ? "+" : ""); });
}

void append_side_by_side(std::string& text, const Lines& left, const Lines& right) {
    for (std::size_t i = 0; i < std::max(left.size(), right.size()); ++i) {
        std::string line = i < left.size() ? left[i] : std::string(left.empty() ? 0 : left[0].size(), ' ');
        if (i < right.size()) line += right[i];
        text += line.substr(0, line.find_last_not_of(' ') + 1) + '\n';
    }
}

void append_shape(std::string& text, const ShapeReport& s) {
    text += "shape\n";
    append_low_table(text, {{"area-length", &s.area_length},
                            {"inradius-edge", &s.inradius_edge},
                            {"radius ratio", &s.radius_ratio},
                            {"smallest angle, deg", &s.smallest_angle}});
    append_high_table(text,
                      {{"largest angle, deg", &s.largest_angle}, {"adjacent edges, ratio", &s.adjacent_edge_ratio}});
    text += fmt::format("  six edges at {:.1f} % of the vertices, {:.1f} % of those inside\n", 100 * s.valence_6,
                        100 * s.interior_valence_6);
    append_problem(text, s.degenerate, "triangles without area");
}

void append_edges(std::string& text, const EdgeReport& e) {
    text += fmt::format(
        "edges in the size map: {:.2f} % in [.71, 1.41], {} ({:.2f} %) shorter, {} ({:.2f} %) longer; efficiency "
        "{:.4f}\n",
        100 * e.unit_share, e.num_short, 100 * e.short_share, e.num_long, 100 * e.long_share, e.efficiency);
    append_low_table(text, {{"metric length", &e.length}});
    append_high_table(text, {{"", &e.length}});
}

void append_gradation(std::string& text, const RealisedGradation& g) {
    text += fmt::format("gradation of the mesh: sizes from {:.4g} to {:.4g}\n", g.size.min, g.size.max);
    append_high_table(text, {{"H-shock", &g.shock},
                             {"H-variation", &g.variation},
                             {"neighbours: edges", &g.neighbour_edges},
                             {"neighbours: areas", &g.neighbour_areas}});
}

void append_surface(std::string& text, const MeshReport& report) {
    if (const auto& d = report.distance) {
        text += fmt::format("distance to the surface, in millionths of its diagonal {:.6g}\n", d->diagonal);
        append_high_table(text, {{"vertices", &d->vertices, 1e6},
                                 {"edge midpoints", &d->midpoints, 1e6},
                                 {"centroids", &d->centroids, 1e6}});
    }
    if (const auto& n = report.normals) {
        text += fmt::format("angle to the normal of the surface: {} triangles above 45 degrees, {} above 60\n",
                            n->over_45, n->over_60);
        append_high_table(text, {{"degrees", &n->angle}});
    }
}

void append_reference(std::string& text, const MeshReport& report) {
    if (!report.reference) return;
    const HausdorffReport& h = report.reference->hausdorff;
    const auto side = [&](const char* name, const OneSidedDistance& d) {
        text += fmt::format("  {:<22}{:>11.4g} at {:.6g} {:.6g} {:.6g}, nowhere above {:.4g}\n", name, d.largest,
                            d.point.x(), d.point.y(), d.point.z(), d.bound);
    };
    text += fmt::format("Hausdorff distance to the reference: {:.4g} at most, {:.3g} of its diagonal\n", h.bound(),
                        h.relative_bound());
    side("from mesh to reference", h.from_mesh);
    side("from reference to mesh", h.from_reference);
    text += fmt::format("topology against the reference{}\n",
                        report.reference->topology.oriented_manifold() ? "" : ", which is NOT an oriented manifold");
    const auto number = [](const std::optional<long long>& n) { return n ? std::to_string(*n) : "-"; };
    for (const TopologyComparison& c : compare(report.topology, report.reference->topology))
        text += fmt::format("  {:<22}{:>11} {:<7} ({} in the reference)\n", c.name, number(c.mesh),
                            c.same() ? "same" : "differs", number(c.reference));
}

void append_histograms(std::string& text, const MeshReport& report) {
    const ShapeReport& s = report.shape;
    text += '\n';
    append_side_by_side(text, range_lines("area-length", s.area_length_histogram),
                        range_lines("inradius-edge", s.inradius_edge_histogram));
    text += '\n';
    append_side_by_side(text, range_lines("smallest angle, degrees", s.smallest_angle_histogram),
                        report.edges ? log2_lines("metric length", report.edges->log2_histogram) : Lines{});
    text += '\n';
    append_side_by_side(text, integer_lines("valence, vertices inside", s.valence_histogram), {});
}

}  // namespace

MeshReport measure(const MeshView& mesh, const MeasureOptions& options) {
    const MeshEdges edges = edges_of(mesh);
    MeshReport report;
    report.topology = measure_topology(mesh, edges);
    report.shape = measure_shape(mesh, edges, {.worst = options.worst});
    report.gradation = measure_realised_gradation(mesh, edges, {.worst = options.worst});
    report.offenders =
        find_offenders(mesh, {.sizes = options.sizes, .features = options.features, .required = options.required});
    if (options.size)
        report.edges = measure_edges(edges, metric_lengths(mesh, edges, options.size, options.size_hints),
                                     {.worst = options.worst});
    else if (!options.sizes.empty())
        report.edges = measure_edges(edges, metric_lengths(mesh, edges, options.sizes), {.worst = options.worst});
    if (options.model) {
        const PlacedMesh placed{mesh, options.places, options.patches};
        report.distance = measure_distance(*options.model, placed, edges, {.worst = options.worst});
        report.normals = measure_normals(*options.model, placed, {.worst = options.worst});
    } else if (options.reference) {
        report.distance = options.reference->measure_distance(mesh, edges, {.worst = options.worst});
        report.normals = options.reference->measure_normals(mesh, {.worst = options.worst});
        report.reference = options.reference->measure(mesh);
    }
    return report;
}

std::string to_text(const MeshReport& report) {
    std::string text;
    append_topology(text, report.topology);
    append_shape(text, report.shape);
    if (report.edges) append_edges(text, *report.edges);
    text += to_text(report.offenders);
    append_gradation(text, report.gradation);
    append_surface(text, report);
    append_reference(text, report);
    append_histograms(text, report);
    if (!report.stages.empty()) text += "\ntime\n";
    for (const auto& [name, seconds] : report.stages) text += fmt::format("  {:<30}{:>9.3f} s\n", name, seconds);
    return text;
}

}  // namespace gradus

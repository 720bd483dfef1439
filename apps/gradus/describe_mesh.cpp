#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <sstream>

#include "describe.hpp"
#include "fields.hpp"
#include "files.hpp"
#include "gradus/mesh/diagnose.hpp"
#include "gradus/mesh/edge.hpp"
#include "gradus/mesh/self_contact.hpp"
#include "gradus/quality/mesh_edges.hpp"
#include "gradus/quality/shape.hpp"

namespace gradus::app {

namespace {

constexpr double kSliver = 0.001;  // area-length of triangles that may hold gaps
constexpr std::size_t kNamed = 5;  // pairs of triangles
constexpr std::size_t kMostRegions = 20;

std::string describe(const SelfContacts& contacts) {
    if (contacts.pairs.empty() && contacts.complete) return "";
    std::string text = fmt::format("{}{} pairs of triangles that touch or intersect beyond what they share:",
                                   contacts.complete ? "" : "at least ", grouped(contacts.pairs.count));
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
    const Cracks cracks = diagnosis.closed || soup.dimension == 2 ? Cracks{} : find_cracks(soup);
    const bool touches = !contacts.pairs.empty() || !contacts.complete;
    const bool is_clean = is_clean_manifold(diagnosis) && cracks.empty() && !touches;
    if (is_clean && diagnosis.closed && volume_of(soup) < 0)
        return "usable, but inside out: its triangles face inwards\n";
    if (is_clean && worst > kSliver) return text_of_faults({});
    const Repaired mended = repair(soup, default_repair(soup));
    if (is_clean && mended.steps.empty()) return text_of_faults({});
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

// What came along with the triangles.
std::string text_of_extras(const MeshData& data, std::size_t labels) {
    const TriangleSoup& soup = data.soup;
    std::vector<std::string> extras;
    if (labels > 0) extras.push_back(fmt::format("{} labels", labels));
    if (!soup.parameters.empty())
        extras.push_back(fmt::format("{} places on patches", grouped(soup.parameters.size())));
    if (!soup.edges.empty()) extras.push_back(fmt::format("{} feature edges", grouped(soup.edges.size())));
    if (!soup.corners.empty()) extras.push_back(fmt::format("{} corners", grouped(soup.corners.size())));
    if (!soup.required.empty())
        extras.push_back(fmt::format("{} vertices, {} edges and {} triangles required",
                                     grouped(soup.required.vertices.size()), grouped(soup.required.edges.size()),
                                     grouped(soup.required.triangles.size())));
    std::string text = extras.empty() ? "" : fmt::format("with {}\n", fmt::join(extras, ", "));
    if (!data.point_fields.empty()) text += "fields on points: " + names_of(data.point_fields) + "\n";
    if (!data.cell_fields.empty()) text += "fields on triangles: " + names_of(data.cell_fields) + "\n";
    return text;
}

// How many there are of something, and how large they are together.
struct Amount {
    std::size_t count = 0;
    double size = 0;
    void add(double more) { ++count, size += more; }
};

// Lists the amounts of labels: "1: 12.5 in 40 triangles, 2: ...".
std::string listed(const std::map<int, Amount>& amounts, const char* what) {
    std::vector<std::string> list;
    for (const auto& [label, amount] : amounts) {
        if (list.size() == kMostRegions) {
            list.push_back("...");
            break;
        }
        list.push_back(fmt::format("{}: {:.6g} in {} {}", label, amount.size, grouped(amount.count), what));
    }
    return fmt::format("{}", fmt::join(list, ", "));
}

Json json_of(const std::map<int, Amount>& amounts, const char* size) {
    Json json = Json::array();
    for (const auto& [label, amount] : amounts)
        json.push_back({{"label", label}, {"count", amount.count}, {size, amount.size}});
    return json;
}

// The regions and lines of a planar domain. Triangles of its file, or those it was cut into, are counter-clockwise.
Description describe_domain(const TriangleSoup& soup, const Diagnosis& diagnosis) {
    std::map<int, Amount> regions, lines;
    double area = 0;
    std::map<std::array<int, 2>, int> sides;
    for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
        const auto& [a, b, c] = soup.triangles[t];
        const double triangle = (soup.points[b] - soup.points[a]).cross(soup.points[c] - soup.points[a]).z() / 2;
        area += triangle;
        regions[soup.labels.empty() ? 0 : soup.labels[t]].add(triangle);
        for (const std::array<int, 2>& side : {edge_between(a, b), edge_between(b, c), edge_between(c, a)})
            ++sides[side];
    }
    std::size_t inside = 0;
    for (std::size_t e = 0; e < soup.edges.size(); ++e) {
        const auto& [a, b] = soup.edges[e];
        lines[soup.edge_labels.empty() ? 0 : soup.edge_labels[e]].add((soup.points[b] - soup.points[a]).norm());
        inside += sides[edge_between(a, b)] == 2;
    }
    const std::size_t holes = diagnosis.boundary_loops - std::min(diagnosis.boundary_loops, diagnosis.components);
    std::string text = fmt::format("planar, area {:.6g}; {} boundary loops, {} of them holes\n", area,
                                   diagnosis.boundary_loops, holes);
    if (!soup.labels.empty()) text += "areas by label: " + listed(regions, "triangles") + "\n";
    if (!soup.edges.empty())
        text += fmt::format("lines by label: {}; {} edges inside\n", listed(lines, "edges"), grouped(inside));
    return {text,
            {{"planar",
              {{"area", area},
               {"holes", holes},
               {"regions", json_of(regions, "area")},
               {"lines", json_of(lines, "length")},
               {"edges_inside", inside}}}}};
}

Json json_of(const Diagnosis& diagnosis) {
    return {{"vertices", diagnosis.num_points},
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
            {"manifold", is_manifold(diagnosis)},
            {"sound", is_clean_manifold(diagnosis)}};
}

}  // namespace

Description describe_mesh(const std::string& name, const MeshData& data) {
    const TriangleSoup& soup = data.soup;
    const Diagnosis diagnosis = diagnose(soup);
    Extent extent;
    for (const Eigen::Vector3d& p : soup.points) extent.add(p);
    const std::set<int> labels(soup.labels.begin(), soup.labels.end());
    const MeshView view{soup.points, soup.triangles};
    const MeshEdges edges = edges_of(view);
    const Summary lengths = summarise(edge_lengths(view, edges));
    const ShapeReport shape = measure_shape(view, edges);
    const SelfContacts contacts = find_self_contacts(soup);
    const bool is_planar = soup.dimension == 2 && is_manifold(diagnosis);
    const Description domain = is_planar ? describe_domain(soup, diagnosis) : Description{};

    std::string text = name + (is_planar ? ": planar mesh\n" : ": triangle mesh\n") + summary(diagnosis);
    if (!soup.points.empty()) text += "extent: " + extent.text() + "\n";
    text += domain.text + text_of_extras(data, labels.size());
    if (lengths.count > 0)
        text += fmt::format("edges from {:.4g} to {:.4g}, median {:.4g}; area-length worst {:.3f}, mean {:.3f}\n",
                            lengths.min, lengths.max, lengths.median, shape.area_length.min, shape.area_length.mean);
    text += describe(contacts) + verdict(soup, diagnosis, contacts, shape.area_length.min);

    Json json = json_of(diagnosis);
    if (is_planar) json.update(domain.json);
    json.update(
        {{"kind", "mesh"},
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
          {{"count", contacts.pairs.count}, {"complete", contacts.complete}, {"first", contacts.pairs.first}}}});
    return {text, json};
}

}  // namespace gradus::app

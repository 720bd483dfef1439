#include "support/hostile_file.hpp"

#include <cmath>
#include <stdexcept>

#include "gradus/control/triangulation.hpp"
#include "gradus/io/error.hpp"
#include "gradus/io/mesh_files.hpp"
#include "gradus/mesh/repair.hpp"
#include "gradus/mesh/self_contact.hpp"
#include "gradus/quality/shape.hpp"

namespace support {
namespace {

using namespace gradus;

constexpr std::size_t kMostTriangles = 500;  // for which surfaces are made

bool is_one_line(const std::string& text) { return !text.empty() && text.find('\n') == std::string::npos; }

bool are_of(const std::vector<Field>& fields, std::size_t items) {
    for (const Field& field : fields)
        if (field.components < 1 || field.values.size() != items * static_cast<std::size_t>(field.components))
            return false;
    return true;
}

std::string fault_of(const MeshData& data) {
    const TriangleSoup& soup = data.soup;
    const Diagnosis d = diagnose(soup);
    if (!d.out_of_range.empty()) return "a triangle has an index out of range";
    if (!d.bad_numbers.empty()) return "a coordinate is not finite";
    if (!soup.labels.empty() && soup.labels.size() != soup.triangles.size()) return "labels are not one per triangle";
    const auto is_vertex = [&](int v) { return v >= 0 && static_cast<std::size_t>(v) < soup.points.size(); };
    for (const auto& [a, b] : soup.edges)
        if (!is_vertex(a) || !is_vertex(b)) return "an edge has an index out of range";
    for (const int corner : soup.corners)
        if (!is_vertex(corner)) return "a corner is out of range";
    for (const int v : soup.required.vertices)
        if (!is_vertex(v)) return "a required vertex is out of range";
    for (const auto& [a, b] : soup.required.edges)
        if (!is_vertex(a) || !is_vertex(b)) return "a required edge has an index out of range";
    for (const int t : soup.required.triangles)
        if (t < 0 || static_cast<std::size_t>(t) >= soup.triangles.size()) return "a required triangle is out of range";
    for (const auto& [vertex, at] : soup.parameters)
        if (!is_vertex(vertex) || at.patch < 0 || !at.uv.allFinite()) return "parameters are out of range";
    if (!are_of(data.point_fields, soup.points.size()) || !are_of(data.cell_fields, soup.triangles.size()))
        return "a field has gaps";
    return "";
}

std::string fault_of_surface(const TriangleSoup& soup) {
    try {
        const Triangulation surface(soup);
        if (!(surface.diagonal() > 0) || !std::isfinite(surface.diagonal())) return "a surface without extent";
        for (const WedgeCurvature& c : surface.curvature())
            if (!c.normal.allFinite() || !std::isfinite(c.k1) || !std::isfinite(c.k2))
                return "a curvature is not finite";
    } catch (const std::invalid_argument& refusal) {
        if (!is_one_line(refusal.what())) return std::string("not one line: ") + refusal.what();
    }
    return "";
}

std::string fault_of_sizes(const std::vector<double>& sizes) {
    for (const double size : sizes)
        if (!(size > 0)) return "a size is not > 0";
    return "";
}

}  // namespace

std::string fault_of_use(const TriangleSoup& soup) {
    find_self_contacts(soup);
    const MeshView view{soup.points, soup.triangles};
    measure_shape(view, edges_of(view));
    const Repaired repaired = repair(soup);
    const Diagnosis d = diagnose(repaired.soup);
    if (!is_manifold(d)) return "after repair: " + why_not_manifold(d);
    const Repaired again = repair(repaired.soup);
    if (!again.steps.empty()) return "a second repair finds: " + summary(again.steps);
    return soup.triangles.size() <= kMostTriangles ? fault_of_surface(repaired.soup) : "";
}

Attempt read_and_use(const std::string& path) {
    try {
        if (path.ends_with(".sol") || path.ends_with(".solb")) return {false, fault_of_sizes(read_sizes(path))};
        const MeshData data = read_mesh_data(path);
        const std::string fault = fault_of(data);
        return {false, fault.empty() ? fault_of_use(data.soup) : fault};
    } catch (const IoError& refusal) {
        const std::string what = refusal.what();
        if (refusal.path() != path || !what.starts_with(path + ":") || !is_one_line(what))
            return {true, "does not name the file in one line: " + what};
        return {true, ""};
    } catch (const std::exception& error) {
        return {false, std::string("throws ") + error.what()};
    }
}

}  // namespace support

#include "gradus/quality/shape.hpp"

namespace gradus {

namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

int smallest_of(const std::array<double, 3>& x) { return x[0] <= x[1] && x[0] <= x[2] ? 0 : x[1] <= x[2] ? 1 : 2; }
int largest_of(const std::array<double, 3>& x) { return x[0] >= x[1] && x[0] >= x[2] ? 0 : x[1] >= x[2] ? 1 : 2; }

void measure_triangles(const MeshView& mesh, const ShapeOptions& options, ShapeReport& report) {
    const std::size_t n = mesh.triangles.size();
    std::vector<double> q1(n), q2(n), q3(n), smallest(n), largest(n);
    Worst worst(options.worst);
    for (std::size_t t = 0; t < n; ++t) {
        const auto& [a, b, c] = mesh.triangles[t];
        const TriangleSides sides = sides_of(mesh.points[a], mesh.points[b], mesh.points[c]);
        q1[t] = area_length(sides);
        q2[t] = inradius_edge(sides);
        q3[t] = radius_ratio(sides);
        // The smallest angle is opposite the shortest side.
        smallest[t] = kDegrees * corner_angle(sides, smallest_of(sides.squared));
        largest[t] = kDegrees * corner_angle(sides, largest_of(sides.squared));
        report.degenerate += sides.degenerate;
        report.area_length_histogram.add(q1[t]);
        report.inradius_edge_histogram.add(q2[t]);
        report.smallest_angle_histogram.add(smallest[t]);
        worst.add(static_cast<int>(t), -q1[t]);
    }
    report.worst = worst.sorted();
    for (Offender& triangle : report.worst) triangle.value = q1[triangle.index];
    report.area_length = summarise(std::move(q1));
    report.inradius_edge = summarise(std::move(q2));
    report.radius_ratio = summarise(std::move(q3));
    report.smallest_angle = summarise(std::move(smallest));
    report.largest_angle = summarise(std::move(largest));
}

/// True for the vertices on an edge that has not exactly two triangles.
std::vector<char> boundary_vertices(const MeshView& mesh, const MeshEdges& edges) {
    std::vector<char> boundary(mesh.points.size(), 0);
    for (int e = 0; e < edges.size(); ++e)
        if (edges.num_uses(e) != 2)
            for (const int v : edges.ends[e]) boundary[v] = 1;
    return boundary;
}

void measure_valences(const MeshView& mesh, const MeshEdges& edges, ShapeReport& report) {
    const std::vector<int> valence = valences(mesh, edges);
    const std::vector<char> boundary = boundary_vertices(mesh, edges);
    std::vector<double> interior_valence, boundary_valence;
    std::size_t regular = 0, interior_regular = 0;
    for (std::size_t v = 0; v < valence.size(); ++v) {
        if (valence[v] == 0) continue;
        regular += valence[v] == 6;
        if (boundary[v]) {
            boundary_valence.push_back(valence[v]);
        } else {
            interior_valence.push_back(valence[v]);
            interior_regular += valence[v] == 6;
            report.valence_histogram.add(valence[v]);
        }
    }
    const auto share = [](std::size_t part, std::size_t whole) {
        return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
    };
    report.valence_6 = share(regular, interior_valence.size() + boundary_valence.size());
    report.interior_valence_6 = share(interior_regular, interior_valence.size());
    report.interior_valence = summarise(std::move(interior_valence));
    report.boundary_valence = summarise(std::move(boundary_valence));
}

}  // namespace

ShapeReport measure_shape(const MeshView& mesh, const MeshEdges& edges, const ShapeOptions& options) {
    ShapeReport report;
    measure_triangles(mesh, options, report);
    measure_valences(mesh, edges, report);
    report.adjacent_edge_ratio = summarise(adjacent_edge_ratios(mesh, edges));
    return report;
}

std::vector<double> edge_lengths(const MeshView& mesh, const MeshEdges& edges) {
    std::vector<double> lengths(edges.size());
    for (int e = 0; e < edges.size(); ++e) {
        const auto& [a, b] = edges.ends[e];
        lengths[e] = (mesh.points[b] - mesh.points[a]).stableNorm();
    }
    return lengths;
}

std::vector<int> valences(const MeshView& mesh, const MeshEdges& edges) {
    std::vector<int> valence(mesh.points.size(), 0);
    for (const auto& [a, b] : edges.ends) ++valence[a], ++valence[b];
    return valence;
}

std::vector<double> adjacent_edge_ratios(const MeshView& mesh, const MeshEdges& edges) {
    std::vector<double> shortest(mesh.points.size(), std::numeric_limits<double>::infinity()),
        longest(mesh.points.size(), 0);
    const std::vector<double> lengths = edge_lengths(mesh, edges);
    for (int e = 0; e < edges.size(); ++e)
        for (const int v : edges.ends[e]) {
            shortest[v] = std::min(shortest[v], lengths[e]);
            longest[v] = std::max(longest[v], lengths[e]);
        }
    std::vector<double> ratios(mesh.points.size(), std::numeric_limits<double>::quiet_NaN());
    for (std::size_t v = 0; v < ratios.size(); ++v) {
        if (shortest[v] == 0)
            ratios[v] = std::numeric_limits<double>::infinity();
        else if (std::isfinite(shortest[v]))
            ratios[v] = longest[v] / shortest[v];
    }
    return ratios;
}

}  // namespace gradus

#include "vertex_graph.hpp"

#include <cmath>
#include <stdexcept>

namespace gradus::detail {

VertexGraph make_vertex_graph(const TriMesh& mesh) {
    const int n = static_cast<int>(mesh.n_vertices()), edges = static_cast<int>(mesh.n_edges());
    VertexGraph graph;
    graph.first.assign(n + 2, 0);
    for (int h = 0; h < 2 * edges; ++h) ++graph.first[mesh.to_vertex_handle(OpenMesh::HalfedgeHandle(h)).idx() + 2];
    for (int v = 0; v < n; ++v) graph.first[v + 2] += graph.first[v + 1];

    // first[v + 1] runs through the arcs of v while they are filled in, and ends where those of v + 1 begin.
    graph.arcs.resize(2 * static_cast<std::size_t>(edges));
    for_each_edge(mesh, [&](int e, int a, int b, double length) {
        graph.arcs[graph.first[a + 1]++] = {length, b, e};
        graph.arcs[graph.first[b + 1]++] = {length, a, e};
    });
    graph.first.pop_back();
    return graph;
}

void require_sizes(std::size_t vertices, std::span<const double> size, const char* function) {
    if (size.size() != vertices)
        throw std::invalid_argument(std::string(function) + ": " + std::to_string(size.size()) + " sizes for " +
                                    std::to_string(vertices) + " vertices");
    for (std::size_t v = 0; v < size.size(); ++v)
        if (!(size[v] > 0))
            throw std::invalid_argument(std::string(function) + ": the size at vertex " + std::to_string(v) + " is " +
                                        std::to_string(size[v]) + ", not positive");
}

void require_above(double value, double above, const char* what, const char* function) {
    if (!(value > above) || std::isinf(value))
        throw std::invalid_argument(std::string(function) + ": the " + what + " is " + std::to_string(value) +
                                    ", it must be finite and greater than " + std::to_string(static_cast<int>(above)));
}

std::vector<char> required_flags(const TriMesh& mesh, std::span<const double> size, std::span<const int> required,
                                 const char* function) {
    if (required.empty()) return {};
    std::vector<char> flags(mesh.n_vertices(), 0);
    for (const int v : required) {
        if (v < 0 || v >= static_cast<int>(mesh.n_vertices()))
            throw std::invalid_argument(std::string(function) + ": required vertex " + std::to_string(v) +
                                        " does not exist");
        if (std::isinf(size[v]))
            throw std::invalid_argument(std::string(function) + ": the size at required vertex " + std::to_string(v) +
                                        " is not set");
        flags[v] = 1;
    }
    return flags;
}

}  // namespace gradus::detail

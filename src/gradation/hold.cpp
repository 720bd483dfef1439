#include "gradus/gradation/hold.hpp"

#include <algorithm>
#include <queue>
#include <stdexcept>
#include <utility>

#include "vertex_graph.hpp"

namespace gradus {

int raise_to_held(const TriMesh& mesh, std::span<const double> held, double slope, std::span<double> size) {
    detail::require_sizes(mesh, size, "raise_to_held");
    detail::require_above(slope, 0, "slope", "raise_to_held");
    if (held.size() > size.size()) throw std::invalid_argument("raise_to_held: more held sizes than vertices");
    std::vector<char> raised(size.size(), 0);
    std::priority_queue<std::pair<double, int>> queue;
    const auto raise = [&](int v, double to) {
        if (!(to > size[v])) return;
        size[v] = to;
        raised[v] = 1;
        queue.emplace(to, v);
    };
    for (int v = 0; v < static_cast<int>(held.size()); ++v) {
        if (!(held[v] > 0)) continue;
        if (held[v] > size[v])
            raise(v, held[v]);
        else if (held[v] == size[v])
            queue.emplace(held[v], v);
    }
    if (queue.empty()) return 0;
    // Sizes spread from large to small, so a popped vertex is final (Dijkstra).
    const detail::VertexGraph graph = detail::make_vertex_graph(mesh);
    while (!queue.empty()) {
        const auto [top, v] = queue.top();
        queue.pop();
        if (top < size[v]) continue;
        for (const detail::Arc& arc : graph.at(v)) raise(arc.to, top - slope * arc.length);
    }
    return static_cast<int>(std::count(raised.begin(), raised.end(), 1));
}

}  // namespace gradus

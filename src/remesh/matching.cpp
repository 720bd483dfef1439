#include "matching.hpp"

#include <lemon/matching.h>
#include <lemon/smart_graph.h>

namespace gradus::detail {

std::vector<int> heaviest_matching(int nodes, const std::vector<std::array<int, 2>>& edges,
                                   const std::vector<long>& weights) {
    lemon::SmartGraph graph;
    graph.reserveNode(nodes);
    graph.reserveEdge(static_cast<int>(edges.size()));
    for (int i = 0; i < nodes; ++i) graph.addNode();
    for (const auto& [a, b] : edges) graph.addEdge(graph.nodeFromId(a), graph.nodeFromId(b));
    lemon::SmartGraph::EdgeMap<long> weight(graph);
    for (std::size_t e = 0; e < edges.size(); ++e) weight[graph.edgeFromId(static_cast<int>(e))] = weights[e];
    lemon::MaxWeightedMatching<lemon::SmartGraph, lemon::SmartGraph::EdgeMap<long>> matching(graph, weight);
    matching.run();
    std::vector<int> mate(nodes, -1);
    for (int i = 0; i < nodes; ++i)
        if (const auto other = matching.mate(graph.nodeFromId(i)); other != lemon::INVALID) mate[i] = graph.id(other);
    return mate;
}

}  // namespace gradus::detail

#include "junctions.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>

#include <Eigen/Geometry>

#include "cells.hpp"
#include "gradus/mesh/edge.hpp"

namespace gradus {
namespace {

using Edge = std::array<int, 2>;

class JunctionFinder {
  public:
    JunctionFinder(const Points& points, const std::vector<Triangle>& triangles, double distance)
        : points_(points), distance_(distance) {
        std::vector<int> itself(points.size());
        std::iota(itself.begin(), itself.end(), 0);
        edges_ = open_edges(triangles, itself);
        for (const OpenEdge& e : edges_) {
            neighbours_[e.ends[0]].push_back(e.ends[1]);
            neighbours_[e.ends[1]].push_back(e.ends[0]);
        }
    }

    std::vector<Junctions> find() {
        if (edges_.empty()) return {};
        fill_grid();
        std::vector<Junctions> result;
        for (const auto& [e, across] : edges_) {
            Junctions found{e, {}};
            for (const int v : near(e))
                if (v != across && is_junction(e, v)) found.vertices.push_back(v);
            if (found.vertices.empty()) continue;
            const Eigen::Vector3d d = points_[e[1]] - points_[e[0]];
            std::stable_sort(found.vertices.begin(), found.vertices.end(),
                             [&](int a, int b) { return points_[a].dot(d) < points_[b].dot(d); });
            result.push_back(std::move(found));
        }
        return result;
    }

  private:
    bool is_on(const Edge& e, int v) const {
        const Eigen::Vector3d d = points_[e[1]] - points_[e[0]], to = points_[v] - points_[e[0]];
        const double t = std::clamp(to.dot(d) / d.squaredNorm(), 0., 1.);
        return (to - t * d).norm() <= distance_;
    }
    bool is_junction(const Edge& e, int v) const {
        if (v == e[0] || v == e[1] || !is_on(e, v)) return false;
        for (const int end : e)
            if ((points_[v] - points_[end]).norm() <= distance_) return false;
        const std::vector<int>& others = neighbours_.at(v);
        return std::any_of(others.begin(), others.end(), [&](int n) {
            return is_on(e, n) || is_on({v, n}, e[0]) || is_on({v, n}, e[1]);
        });
    }

    // Cells as wide as the mean edge, so that all edges together pass through as many as there are edges.
    void fill_grid() {
        double length = 0;
        Eigen::AlignedBox3d box;
        for (const auto& [e, across] : edges_) {
            length += (points_[e[1]] - points_[e[0]]).norm();
            box.extend(points_[e[0]]).extend(points_[e[1]]);
        }
        width_ =
            std::max({length / static_cast<double>(edges_.size()), 2 * distance_, box.sizes().maxCoeff() / (1 << 20)});
        cells_.emplace(box.min(), width_);
        for (const auto& [v, others] : neighbours_) cells_->insert(points_[v], v);
    }
    // Vertices around points of an edge that are a cell apart.
    std::vector<int> near(const Edge& e) const {
        const Eigen::Vector3d d = points_[e[1]] - points_[e[0]];
        const int steps = static_cast<int>(std::ceil(d.norm() / width_));
        std::vector<int> result;
        for (int i = 0; i <= steps; ++i)
            cells_->for_each_near(points_[e[0]] + d * (static_cast<double>(i) / std::max(steps, 1)),
                                  [&](int v) { result.push_back(v); });
        std::sort(result.begin(), result.end());
        result.erase(std::unique(result.begin(), result.end()), result.end());
        return result;
    }

    const Points& points_;
    double distance_;
    std::vector<OpenEdge> edges_;
    std::map<int, std::vector<int>> neighbours_;  // along open edges
    double width_ = 0;                            // of the cells
    std::optional<Cells> cells_;
};

}  // namespace

std::vector<OpenEdge> open_edges(const std::vector<Triangle>& triangles, const std::vector<int>& place) {
    std::vector<OpenEdge> edges, open;
    for (const Triangle& t : triangles)
        for (int k = 0; k < 3; ++k) {
            const int a = place[t[k]], b = place[t[(k + 1) % 3]];
            if (a >= 0 && b >= 0 && a != b) edges.push_back({edge_between(a, b), place[t[(k + 2) % 3]]});
        }
    std::sort(edges.begin(), edges.end(), [](const OpenEdge& a, const OpenEdge& b) { return a.ends < b.ends; });
    for (std::size_t i = 0; i < edges.size(); ++i)
        if ((i == 0 || edges[i - 1].ends != edges[i].ends) &&
            (i + 1 == edges.size() || edges[i + 1].ends != edges[i].ends))
            open.push_back(edges[i]);
    return open;
}

std::vector<Junctions> find_junctions(const Points& points, const std::vector<Triangle>& triangles, double distance) {
    return JunctionFinder(points, triangles, distance).find();
}

}  // namespace gradus

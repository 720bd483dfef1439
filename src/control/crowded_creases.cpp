#include "gradus/control/crowded_creases.hpp"

#include "gradus/mesh/closest.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace gradus {

namespace {

using Eigen::Vector3d;

constexpr double kLeastCosine =
    0.866;  // of the angle between two curves at a corner, 30 degrees: elements are to have no smaller ones

// A chain as it is seen from one of its ends.
struct Branch {
    int chain;
    bool reversed;
};

class Finder {
  public:
    Finder(const Triangulation& surface, const SizingRule& rule)
        : surface_(surface), rule_(rule), points_(surface.soup().points) {}

    std::vector<std::array<int, 2>> run() {
        const std::vector<FeatureChain>& chains = surface_.features().chains;
        std::map<int, std::vector<Branch>> at_corner;
        for (int c = 0; c < static_cast<int>(chains.size()); ++c) {
            if (chains[c].closed) continue;
            at_corner[chains[c].vertices.front()].push_back({c, false});
            at_corner[chains[c].vertices.back()].push_back({c, true});
        }
        for (const auto& [corner, branches] : at_corner)
            for (std::size_t i = 0; i < branches.size(); ++i)
                for (std::size_t j = i + 1; j < branches.size(); ++j) part(corner, branches[i], branches[j]);
        for (const FeatureChain& chain : chains)
            if (!chain.certain && length_of(chain) < size_at(chain.vertex(chain.num_edges() / 2)))
                drop(chain, 0, chain.num_edges());
        return std::move(dropped_);
    }

  private:
    double size_at(int v) const { return size_from_radius(rule_, 1 / std::max(surface_.largest_curvature(v), 1e-300)); }

    double length_of(const FeatureChain& chain) const {
        double length = 0;
        for (int i = 0; i < chain.num_edges(); ++i)
            length += (points_[chain.vertex(i + 1)] - points_[chain.vertex(i)]).norm();
        return length;
    }

    int vertex(const Branch& branch, int i) const {
        const std::vector<int>& vertices = surface_.features().chains[branch.chain].vertices;
        return branch.reversed ? vertices[vertices.size() - 1 - i] : vertices[i];
    }
    int num_edges(const Branch& branch) const { return surface_.features().chains[branch.chain].num_edges(); }
    bool is_certain(const Branch& branch) const { return surface_.features().chains[branch.chain].certain; }

    // The direction to the point some way along a branch.
    Vector3d direction(const Branch& branch, double way) const {
        const Vector3d& start = points_[vertex(branch, 0)];
        for (int i = 0; i < num_edges(branch); ++i) {
            const Vector3d &a = points_[vertex(branch, i)], &b = points_[vertex(branch, i + 1)];
            const double length = (b - a).norm();
            if (length >= way && length > 0) return (a + way / length * (b - a) - start).stableNormalized();
            way -= length;
        }
        return (points_[vertex(branch, num_edges(branch))] - start).stableNormalized();
    }

    double distance(const Vector3d& p, const Branch& branch) const {
        double least = std::numeric_limits<double>::infinity();
        for (int i = 0; i < num_edges(branch); ++i) {
            const Vector3d &a = points_[vertex(branch, i)], &b = points_[vertex(branch, i + 1)];
            least = std::min(least, (closest_point(p, a, b, b) - p).norm());
        }
        return least;
    }

    // Takes the weaker of two branches away where they are too close.
    void part(int corner, const Branch& one, const Branch& other) {
        if ((is_certain(one) && is_certain(other)) || one.chain == other.chain) return;
        const double size = size_at(corner);
        if (direction(one, size).dot(direction(other, size)) < kLeastCosine) return;
        const auto length = [&](const Branch& branch) { return length_of(surface_.features().chains[branch.chain]); };
        const bool first = !is_certain(one) && (is_certain(other) || length(one) < length(other));
        const Branch &weaker = first ? one : other, &stronger = first ? other : one;
        const auto is_close = [&](int i) {
            return distance(points_[vertex(weaker, i)], stronger) < size_at(vertex(weaker, i));
        };
        int end = 0;
        while (end < num_edges(weaker) && is_close(end + 1)) ++end;
        const FeatureChain& chain = surface_.features().chains[weaker.chain];
        if (weaker.reversed)
            drop(chain, chain.num_edges() - end, chain.num_edges());
        else
            drop(chain, 0, end);
    }

    void drop(const FeatureChain& chain, int from, int to) {
        for (int i = from; i < to; ++i) dropped_.push_back({chain.vertex(i), chain.vertex(i + 1)});
    }

    const Triangulation& surface_;
    const SizingRule& rule_;
    const std::vector<Vector3d>& points_;
    std::vector<std::array<int, 2>> dropped_;
};

}  // namespace

std::vector<std::array<int, 2>> crowded_creases(const Triangulation& surface, const SizingRule& rule) {
    return Finder(surface, rule).run();
}

}  // namespace gradus

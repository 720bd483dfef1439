/// Distance between two triangulated surfaces, as a bound that holds everywhere on them and not at samples only.
#pragma once

#include "gradus/mesh/closest.hpp"
#include "gradus/quality/mesh_edges.hpp"

#include <memory>
#include <mutex>
#include <optional>

namespace gradus {

/// Triangles of the target that a triangle was held against: while they stay, what was proved of it holds.
struct Witnesses {
    bool proved = false;
    int size = 0;
    std::array<int, 3> first;                ///< those that are few, which is usual: there may be millions of these
    std::unique_ptr<std::vector<int>> more;  ///< null where there never were any

    void clear() {
        proved = false;
        size = 0;
        if (more) more->clear();
    }
    void add(int triangle) {
        if (size < static_cast<int>(first.size()))
            first[size] = triangle;
        else if (more)
            more->push_back(triangle);
        else
            more = std::make_unique<std::vector<int>>(1, triangle);
        ++size;
    }
    int& operator[](int i) { return i < static_cast<int>(first.size()) ? first[i] : (*more)[i - first.size()]; }
};

struct OneSidedOptions {
    double limit = 0;         ///< distances proved to be at most this need no closer look; 0: all do
    double precision = 0.02;  ///< of the largest distance, or a billionth of the extent: its bounds are this close
                              ///< together, if the work allows
    std::span<const int>
        near{};  ///< for each vertex a triangle of the target that is near it, or -1, which saves time; or empty
    std::span<const char> skip{};      ///< triangles that need no look, or empty
    std::span<Witnesses> witnesses{};  ///< with a limit: filled in for each triangle that was looked at; or empty
};

/// A triangle with points that are too far.
struct TooFar {
    int triangle = -1;
    double distance = 0;             ///< largest seen
    Eigen::Vector3d point{0, 0, 0};  ///< where
    int nearest = -1;                ///< triangle of the target that is closest to it
};

/// How far the points of a surface are from another one.
struct OneSidedDistance {
    double largest = 0;  ///< attained at `point`; with a limit, only what is above it is looked for
    double bound = 0;    ///< no point that was looked at is farther
    Eigen::Vector3d point{0, 0, 0};
    std::vector<TooFar> beyond;  ///< triangles with points farther than a limit > 0, in their order
};

/// A surface that distances are measured to. The view must outlive it.
class DistanceTarget {
  public:
    /// @throws std::invalid_argument for a surface without triangles
    explicit DistanceTarget(const MeshView& mesh);

    /// The distance to one triangle is convex: over a convex piece of the surface it is largest at a corner. So each
    /// triangle is cut along the planes between the target's triangles under it, and each piece is held against one of
    /// them; where that says too little, it is cut on and held against the closest ones. Parallel; the same for any
    /// number of threads. Without a limit the work is bounded (seconds, and what is in proportion to the triangles):
    /// the largest parts come first, and the bound holds for what is left. With a limit and near triangles known, those
    /// that keep it are mostly found without any search.
    OneSidedDistance measure_from(const MeshView& from, const OneSidedOptions& options = {}) const;

    /// Triangles of a surface of which the middle, or that of a side, is farther than a limit: fast, and no proof.
    /// Parallel.
    /// @param near  for each vertex a triangle of the target near it
    std::vector<TooFar> sample_from(const MeshView& from, double limit, std::span<const int> near) const;

    /// Of one point. @param near  a triangle that is near it, or -1
    double distance(const Eigen::Vector3d& p, int near = -1) const { return closest(p, near).distance; }
    ClosestTriangle::Hit closest(const Eigen::Vector3d& p, int near = -1) const { return tree().closest(p, near); }

    /// The triangle that is reached from one by ever closer neighbours: the closest, where the surface is about flat.
    ClosestTriangle::Hit descend(const Eigen::Vector3d& p, int from) const;
    /// Whether the foot of p in the plane of a triangle is inside.
    bool is_over(const Eigen::Vector3d& p, int triangle) const { return facets_[triangle].is_under(p); }

    /// Triangles within a distance of a point, by index.
    std::vector<int> within(const Eigen::Vector3d& p, double distance) const { return tree().within(p, distance); }

  private:
    friend class DistanceSearch;
    const ClosestTriangle& tree() const;

    struct Tree {
        std::once_flag planted;
        std::optional<ClosestTriangle> tree;
    };
    MeshView mesh_;
    std::unique_ptr<Tree> tree_;  // made when it is asked for
    std::vector<std::array<int, 3>>
        neighbours_;  // across side k of each triangle, -1 where there is none or more than one
    struct Facet {
        Eigen::Vector3d corner, normal;  // unit, or zero
        Eigen::Vector3d to_b, to_c;      // products with p - corner are p's coordinates over the triangle

        std::pair<double, double> coordinates(const Eigen::Vector3d& p) const {
            return {to_b.dot(p - corner), to_c.dot(p - corner)};
        }
        bool is_under(const Eigen::Vector3d& p) const {
            const auto [b, c] = coordinates(p);
            return b >= 0 && c >= 0 && b + c <= 1;
        }
    };
    std::vector<Facet> facets_;
};

}  // namespace gradus

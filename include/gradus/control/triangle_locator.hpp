/// Finds the triangle of a background under a point of the surface, or under a place of a patch.
#pragma once

#include "gradus/control/background.hpp"
#include "gradus/mesh/connectivity.hpp"

#include <array>
#include <memory>
#include <span>
#include <vector>

namespace gradus {

/// A point near the mesh is taken to the triangle it projects into, found by walking from a triangle that is known to
/// be near: so parts that touch or intersect are not confused.
class TriangleLocator {
  public:
    /// The background must outlive this.
    explicit TriangleLocator(const Background& background);
    /// The same of a mesh without parameters, of which all triangles live; nothing of it is kept.
    TriangleLocator(std::span<const Eigen::Vector3d> points, const Connectivity& mesh);
    ~TriangleLocator();
    TriangleLocator(TriangleLocator&&) noexcept;

    /// Where a point is: barycentric coordinates 1 - a - b, a, b in a triangle, negative beyond its sides.
    struct Position {
        int triangle = -1;
        double a = 0, b = 0;
    };
    /// Where a walk ends, and the square of how far the point is from there: over the triangle, or beyond its sides.
    /// Always 0 on a background with parameters, whose patches are resolved finely, and may touch other parts.
    struct Walk {
        Position at;
        double distance2 = 0;
    };
    /// Walks to p from a triangle near it.
    Walk walk(const Eigen::Vector3d& p, int from) const;
    /// In the triangle closest to p of all that have an area; `otherwise` where none has. The first call plants a tree.
    Position closest(const Eigen::Vector3d& p, int otherwise) const;
    /// The triangle of the background that holds the parameters, or the nearest there is on that patch. Only of a
    /// background with parameters.
    Position locate(const SurfacePoint& at) const;

    int num_triangles() const { return static_cast<int>(cells_.size()); }
    std::array<Eigen::Vector3d, 3> corners(int triangle) const;
    /// Twice the area; 0 where it is lost in rounding.
    double twice_area(int triangle) const;

  private:
    // What a step of the walk reads, in one place: a = ga.(p - p0), b = gb.(p - p0).
    struct Cell {
        Eigen::Vector3d p0, ga, gb;
        std::array<int, 3> neighbour;  // across the edge opposite to corner k, -1 on the boundary
    };
    struct Grid {
        Domain domain;
        int cells = 0;
        std::vector<int> first, triangles;  // those whose boxes overlap cell k: triangles[first[k]] to first[k + 1]

        int index(const Eigen::Vector2d& uv, int axis) const;
    };
    void add_cell(const std::array<Eigen::Vector3d, 3>& corner, const std::array<int, 3>& neighbour);
    void make_grids(const Background& background);
    // Squared height of a point over the plane of a cell times `normal2`, the squared length of the normal that it is a
    // multiple of: 0 without area.
    struct Height {
        double squared_times, normal2;
    };
    static Height height_over(const Cell& cell, const Eigen::Vector3d& d);
    static double distance2_from(const Cell& cell, double a, double b, const Height& height);
    int beyond_fold(const Eigen::Vector3d& p, int triangle, double a, double b, const Height& height) const;

    std::vector<Cell> cells_;
    struct Tree;
    std::unique_ptr<Tree> tree_;  // over the cells, planted when it is needed
    const Background* background_ = nullptr;
    std::vector<Grid> grids_;  // one per patch
};

}  // namespace gradus

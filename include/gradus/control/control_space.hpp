/// The continuous control space: the size map of a background mesh, interpolated between its vertices.
#pragma once

#include "gradus/control/background.hpp"
#include "gradus/mesh/connectivity.hpp"

#include <memory>
#include <span>
#include <vector>

namespace gradus {

/// Sizes are linear over each triangle, so that their gradient is that of the triangle everywhere on it: a bound that
/// holds on the triangles of the background holds between its vertices, however large they are for the sizes. (Where
/// sizes vary geometrically [Borouchaki 1998, eq. 6] the slope along an edge is up to r ln r / (r - 1) times as steep,
/// r the ratio of the sizes of its ends.) A point near the mesh is taken to the triangle it projects into, found by
/// walking from a triangle that is known to be near: so parts that touch or intersect are not confused. Where, on a
/// mesh without parameters, the walk ends farther from the point than a quarter of the size, as behind a sharp edge of
/// a coarse mesh, the closest triangle takes its place.
class ControlSpace {
  public:
    /// @param sizes  one per vertex, > 0 and finite
    /// @throws std::invalid_argument for a wrong number of sizes or a size that is not positive and finite
    ControlSpace(const Background& background, std::span<const double> sizes);
    /// The same of a mesh without parameters, of which all triangles live; nothing of it is kept.
    ControlSpace(std::span<const Eigen::Vector3d> points, const Connectivity& mesh, std::span<const double> sizes);
    ~ControlSpace();
    ControlSpace(ControlSpace&&) noexcept;

    /// Size at p, walking from `triangle` (a triangle of the background near p), which is set to the one p falls into.
    double size(const Eigen::Vector3d& p, int& triangle) const;
    /// A triangle of the background that holds the parameters, or the nearest there is on that patch. Only of a
    /// background with parameters, as the size at a place.
    int locate(const SurfacePoint& at) const;
    /// Size at a place of the surface, interpolated in (u, v).
    double size(const SurfacePoint& at) const;
    /// Number of triangles a unit mesh has: the sum over triangles of the integral of 1 / (sqrt(3)/4 h^2), exact.
    double predicted_triangles() const;

    /// Smallest size over the largest coordinate of a triangle it is at.
    double least_relative_size() const;

    int num_triangles() const { return static_cast<int>(cells_.size()); }

  private:
    // What a step of the walk reads, in one place: barycentric coordinates are 1 - a - b, a, b with a = ga.(p - p0), b
    // = gb.(p - p0).
    struct Cell {
        Eigen::Vector3d p0, ga, gb;
        std::array<double, 3> h;       // at the corners
        std::array<int, 3> neighbour;  // across the edge opposite to corner k, -1 on the boundary
    };
    struct Grid {
        Domain domain;
        int cells = 0;
        std::vector<int> first, triangles;  // those whose boxes overlap cell k: triangles[first[k]] to first[k + 1]

        int index(const Eigen::Vector2d& uv, int axis) const;
    };
    void reserve(std::size_t vertices, std::size_t triangles, std::span<const double> sizes);
    void add_cell(const std::array<Eigen::Vector3d, 3>& corner, const std::array<double, 3>& h,
                  const std::array<int, 3>& neighbour);
    static double size_in(const Cell& cell, double a, double b);
    // Squared height of a point over the plane of a cell times `normal2`, the squared length of the normal that it is a
    // multiple of: 0 without area.
    struct Height {
        double squared_times, normal2;
    };
    static Height height_over(const Cell& cell, const Eigen::Vector3d& d);
    int beyond_fold(const Eigen::Vector3d& p, int triangle, double a, double b, const Height& height) const;
    bool is_far(const Cell& cell, double a, double b, const Height& height) const;
    int closest_cell(const Eigen::Vector3d& p) const;
    double size_in_parameters(const SurfacePoint& at, int& triangle) const;

    std::vector<Cell> cells_;
    struct Tree;
    std::unique_ptr<Tree> tree_;  // over the cells, planted when it is needed
    const Background* background_ = nullptr;
    std::vector<Grid> grids_;  // one per patch
};

}  // namespace gradus

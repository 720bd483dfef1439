#include "gradus/control/triangle_locator.hpp"

#include "../assert.hpp"
#include "gradus/mesh/closest.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>

namespace gradus {

namespace {

constexpr double kInside = 1e-9;  // barycentric coordinates this far below 0 count as inside
// A point this much nearer to a side of a triangle than it is high over it may be of the triangle beyond, where its
// height is less than half.
constexpr double kSteepest = 4;  // tangent: folds of more than 166 degrees aside
constexpr double kLower2 = 0.25;
constexpr int kMostSteps = 10000;  // a walk is a few steps long; the bound only stops one that circles

// Distance of a point of the plane from the sides of a triangle.
double distance_outside(const Eigen::Vector2d& p, const std::array<Eigen::Vector2d, 3>& corners) {
    double least = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) {
        const Eigen::Vector2d& from = corners[k];
        const Eigen::Vector2d along = corners[(k + 1) % 3] - from;
        const double s = std::clamp(along.dot(p - from) / along.squaredNorm(), 0.0, 1.0);
        least = std::min(least, (from + s * along - p).norm());
    }
    return least;
}

// The corner with the most negative coordinate whose opposite edge has a neighbour.
int way_out(double a, double b, const std::array<int, 3>& neighbour) {
    const std::array<double, 3> w{1 - a - b, a, b};
    int out = -1;
    for (int k = 0; k < 3; ++k)
        if (w[k] < -kInside && neighbour[k] >= 0 && (out < 0 || w[k] < w[out])) out = k;
    return out;
}

}  // namespace

struct TriangleLocator::Tree {
    std::once_flag planted;
    std::vector<Eigen::Vector3d> points;
    std::vector<Triangle> triangles;
    std::optional<ClosestTriangle> closest;
};

TriangleLocator::~TriangleLocator() = default;
TriangleLocator::TriangleLocator(TriangleLocator&&) noexcept = default;

void TriangleLocator::add_cell(const std::array<Eigen::Vector3d, 3>& corner, const std::array<int, 3>& neighbour) {
    const Eigen::Vector3d e1 = corner[1] - corner[0], e2 = corner[2] - corner[0], n = e1.cross(e2);
    const double n2 = n.squaredNorm();
    const bool has_area = n2 > 0;
    cells_.push_back({corner[0], has_area ? Eigen::Vector3d(e2.cross(n) / n2) : Eigen::Vector3d::Zero(),
                      has_area ? Eigen::Vector3d(n.cross(e1) / n2) : Eigen::Vector3d::Zero(), neighbour});
}

TriangleLocator::TriangleLocator(std::span<const Eigen::Vector3d> points, const Connectivity& mesh)
    : tree_(std::make_unique<Tree>()) {
    cells_.reserve(mesh.num_triangles());
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const auto [a, b, c] = mesh.triangle(t);
        const auto beyond = [&](int side) { return mesh.twin(3 * t + side) >= 0 ? mesh.twin(3 * t + side) / 3 : -1; };
        add_cell({points[a], points[b], points[c]}, {beyond(1), beyond(2), beyond(0)});
    }
}

TriangleLocator::TriangleLocator(const Background& background)
    : tree_(std::make_unique<Tree>()), background_(&background) {
    const TriMesh& mesh = background.mesh;
    cells_.reserve(mesh.n_faces());
    const auto points = points_of(mesh);
    for (int f = 0; f < static_cast<int>(mesh.n_faces()); ++f) {
        std::array<int, 3> corner, neighbour;
        // The half-edge that ends in corner k starts in corner k - 1: it is opposite to corner k + 1.
        auto halfedge = mesh.halfedge_handle(mesh.face_handle(f));
        for (int k = 0; k < 3; ++k, halfedge = mesh.next_halfedge_handle(halfedge)) {
            corner[k] = mesh.to_vertex_handle(halfedge).idx();
            neighbour[(k + 1) % 3] = mesh.opposite_face_handle(halfedge).idx();
        }
        const auto [a, b, c] = corner;
        add_cell({points[a], points[b], points[c]}, neighbour);
    }
    if (!background.patch.empty()) make_grids(background);
}

// A grid of about one cell per two triangles of each patch finds places by their parameters.
void TriangleLocator::make_grids(const Background& background) {
    const int patches = *std::max_element(background.patch.begin(), background.patch.end()) + 1;
    std::vector<int> count(patches, 0);
    grids_.resize(patches);
    for (const int p : background.patch) ++count[p];
    for (std::size_t t = 0; t < cells_.size(); ++t) {
        const int p = background.patch[t];
        Grid& grid = grids_[p];
        if (grid.cells == 0) {
            grid.cells = std::max(1, static_cast<int>(std::sqrt(count[p] / 2.0)));
            grid.domain = {background.uv[t][0], background.uv[t][0]};
            grid.first.assign(static_cast<std::size_t>(grid.cells) * grid.cells + 1, 0);
        }
        for (const Eigen::Vector2d& x : background.uv[t]) {
            grid.domain.min = grid.domain.min.cwiseMin(x);
            grid.domain.max = grid.domain.max.cwiseMax(x);
        }
    }
    // Triangles by the cells that their boxes overlap, counted first.
    const auto for_each_cell = [&](std::size_t t, const auto& visit) {
        Grid& grid = grids_[background.patch[t]];
        const auto& uv = background.uv[t];
        const Eigen::Vector2d low = uv[0].cwiseMin(uv[1]).cwiseMin(uv[2]), high = uv[0].cwiseMax(uv[1]).cwiseMax(uv[2]);
        for (int j = grid.index(low, 1); j <= grid.index(high, 1); ++j)
            for (int i = grid.index(low, 0); i <= grid.index(high, 0); ++i) visit(grid, j * grid.cells + i);
    };
    for (std::size_t t = 0; t < cells_.size(); ++t)
        for_each_cell(t, [](Grid& grid, int cell) { ++grid.first[cell + 1]; });
    for (Grid& grid : grids_) {
        for (std::size_t k = 1; k < grid.first.size(); ++k) grid.first[k] += grid.first[k - 1];
        if (!grid.first.empty()) grid.triangles.resize(grid.first.back());
    }
    std::vector<std::vector<int>> fill;
    for (const Grid& grid : grids_) fill.push_back(grid.first);
    for (std::size_t t = 0; t < cells_.size(); ++t)
        for_each_cell(
            t, [&](Grid& grid, int cell) { grid.triangles[fill[background.patch[t]][cell]++] = static_cast<int>(t); });
}

int TriangleLocator::Grid::index(const Eigen::Vector2d& uv, int axis) const {
    const double extent = domain.max[axis] - domain.min[axis];
    const double s = extent > 0 ? (uv[axis] - domain.min[axis]) / extent : 0;
    return static_cast<int>(std::clamp(s * cells, 0.0, cells - 1.0));
}

TriangleLocator::Height TriangleLocator::height_over(const Cell& cell, const Eigen::Vector3d& d) {
    const Eigen::Vector3d n = cell.ga.cross(cell.gb);
    const double along = n.dot(d);
    return {along * along, n.squaredNorm()};
}

// Square of how far a point with these coordinates is from a cell: over it, or beyond its sides.
double TriangleLocator::distance2_from(const Cell& cell, double a, double b, const Height& height) {
    double distance2 = height.normal2 > 0 ? height.squared_times / height.normal2 : 0;
    const std::array<double, 3> w{1 - a - b, a, b};
    if (w[0] >= -kInside && w[1] >= -kInside && w[2] >= -kInside) return distance2;
    const std::array<double, 3> slope2{(cell.ga + cell.gb).squaredNorm(), cell.ga.squaredNorm(), cell.gb.squaredNorm()};
    for (int k = 0; k < 3; ++k)
        if (w[k] < 0) distance2 = std::max(distance2, w[k] * w[k] / slope2[k]);
    return distance2;
}

TriangleLocator::Position TriangleLocator::closest(const Eigen::Vector3d& p, int otherwise) const {
    std::call_once(tree_->planted, [&] {
        std::vector<int> with_area;
        for (const Cell& c : cells_) {
            const auto first = static_cast<int>(tree_->points.size());
            const auto corner = corners(static_cast<int>(&c - cells_.data()));
            tree_->points.insert(tree_->points.end(), corner.begin(), corner.end());
            if (c.ga.cross(c.gb).squaredNorm() > 0) with_area.push_back(static_cast<int>(tree_->triangles.size()));
            tree_->triangles.push_back({first, first + 1, first + 2});
        }
        if (!with_area.empty()) tree_->closest.emplace(tree_->points, tree_->triangles, std::move(with_area));
    });
    const int triangle = tree_->closest ? tree_->closest->closest(p).triangle : otherwise;
    const Cell& cell = cells_[triangle];
    const Eigen::Vector3d d = p - cell.p0;
    return {triangle, cell.ga.dot(d), cell.gb.dot(d)};
}

// Where p is over a triangle, but not on it: the one that it may be on, beyond a fold, or -1.
int TriangleLocator::beyond_fold(const Eigen::Vector3d& p, int triangle, double a, double b,
                                 const Height& height_here) const {
    const Cell& cell = cells_[triangle];
    const auto [height2, normal2] = height_here;
    // Whether p is much less high over a cell, and on its side of what leads there from another one.
    const auto is_lower = [&, height = height2, normal = normal2](int t, int from) {
        const Cell& other = cells_[t];
        const Eigen::Vector3d d = p - other.p0;
        const auto [other_height2, other_normal2] = height_over(other, d);
        if (!(other_height2 * normal < kLower2 * height * other_normal2)) return false;
        const double x = other.ga.dot(d), y = other.gb.dot(d);
        const std::array<double, 3> v{1 - x - y, x, y};
        for (int j = 0; j < 3; ++j)
            if (other.neighbour[j] == from && v[j] >= -kInside) return true;
        return false;
    };
    const std::array<double, 3> w{1 - a - b, a, b},
        slope2{(cell.ga + cell.gb).squaredNorm(), cell.ga.squaredNorm(), cell.gb.squaredNorm()};
    for (int k = 0; k < 3; ++k) {
        // w over the slope is the distance from the side opposite to corner k.
        const int beside = cell.neighbour[k];
        if (!(w[k] * w[k] * normal2 < kSteepest * kSteepest * height2 * slope2[k]) || beside < 0) continue;
        if (is_lower(beside, triangle)) return beside;
        // Near a corner the fold may be a side of that one.
        for (const int next : cells_[beside].neighbour)
            if (next >= 0 && next != triangle && is_lower(next, beside)) return next;
    }
    return -1;
}

TriangleLocator::Walk TriangleLocator::walk(const Eigen::Vector3d& p, int from) const {
    GRADUS_ASSERT(from >= 0 && from < num_triangles());
    int triangle = from, came_from = -1;
    for (int step = 0; step < kMostSteps; ++step) {
        const Cell& cell = cells_[triangle];
        const Eigen::Vector3d d = p - cell.p0;
        const double a = cell.ga.dot(d), b = cell.gb.dot(d);
        const Height height = height_over(cell, d);
        const bool is_over = a >= -kInside && b >= -kInside && a + b <= 1 + kInside;
        const int out = is_over ? -1 : way_out(a, b, cell.neighbour);
        int next = is_over ? beyond_fold(p, triangle, a, b, height) : out >= 0 ? cell.neighbour[out] : -1;
        // Over a convex edge neither triangle holds the point: the walk would go to and fro.
        if (!is_over && next == came_from) next = -1;
        if (next < 0) return {{triangle, a, b}, grids_.empty() ? distance2_from(cell, a, b, height) : 0};
        came_from = triangle;
        triangle = next;
    }
    return {{triangle, 0, 0}, std::numeric_limits<double>::infinity()};
}

TriangleLocator::Position TriangleLocator::locate(const SurfacePoint& at) const {
    const Grid& grid = grids_[at.patch];
    const int column = grid.index(at.uv, 0), row = grid.index(at.uv, 1);
    // The triangle that holds the place, else the nearest one: beside the chord of a curve, or in the fan of a pole.
    double least_outside = std::numeric_limits<double>::infinity();
    Position best;
    const auto look_at = [&](int t) {
        const auto& uv = background_->uv[t];
        const Eigen::Vector2d e1 = uv[1] - uv[0], e2 = uv[2] - uv[0], d = at.uv - uv[0];
        const double det = e1.x() * e2.y() - e1.y() * e2.x();
        if (det == 0) return;
        const double a = (d.x() * e2.y() - d.y() * e2.x()) / det, b = (e1.x() * d.y() - e1.y() * d.x()) / det;
        const double least = std::min({a, b, 1 - a - b});
        const double outside = least >= 0 ? 0 : distance_outside(at.uv, uv);
        if (outside < least_outside) least_outside = outside, best = {t, a, b};
    };
    for (int reach = 0; reach < grid.cells; ++reach) {
        const bool had_one = best.triangle >= 0;
        for (int j = std::max(0, row - reach); j <= std::min(grid.cells - 1, row + reach); ++j)
            for (int i = std::max(0, column - reach); i <= std::min(grid.cells - 1, column + reach); ++i) {
                if (std::max(std::abs(i - column), std::abs(j - row)) != reach) continue;
                const int cell = j * grid.cells + i;
                for (int k = grid.first[cell]; k < grid.first[cell + 1] && least_outside > 0; ++k)
                    look_at(grid.triangles[k]);
            }
        // One ring more than the first that had a triangle: it may hold a nearer one.
        if (least_outside == 0 || had_one) break;
    }
    return best;
}

std::array<Eigen::Vector3d, 3> TriangleLocator::corners(int triangle) const {
    // The sides from the gradients of the coordinates.
    const Cell& c = cells_[triangle];
    const Eigen::Vector3d n = c.ga.cross(c.gb);
    const double n2 = n.squaredNorm();
    if (!(n2 > 0)) return {c.p0, c.p0, c.p0};
    return {c.p0, c.p0 + c.gb.cross(n) / n2, c.p0 + n.cross(c.ga) / n2};
}

double TriangleLocator::twice_area(int triangle) const {
    // The gradients of two barycentric coordinates span a parallelogram of one over that of the sides.
    const double over_twice_area = cells_[triangle].ga.cross(cells_[triangle].gb).norm();
    return over_twice_area > 0 ? 1 / over_twice_area : 0;
}

}  // namespace gradus

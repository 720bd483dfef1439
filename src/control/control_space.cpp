#include "gradus/control/control_space.hpp"

#include "../assert.hpp"
#include "gradus/control/metric.hpp"
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
constexpr double kFar2 = 0.0625;   // squared: of the size, from a point to where a walk to it ends
constexpr int kMostSteps = 10000;  // a walk is a few steps long; the bound only stops one that circles

// Weights of the corners after those that are negative are dropped.
std::array<double, 3> clamped(double a, double b) {
    std::array<double, 3> w{std::max(0.0, 1 - a - b), std::max(0.0, a), std::max(0.0, b)};
    const double sum = w[0] + w[1] + w[2];
    for (double& x : w) x /= sum;
    return w;
}

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

// Integral of 1 / h^2 over the triangle of area 1/2, with h linear between its corners: the second divided difference
// of -ln h. [Hermite-Genocchi]
double mean_density(double a, double b, double c) {
    constexpr double kEven = 1.02;  // ratio up to which a quadrature is more exact than differences
    if (a > b) std::swap(a, b);
    if (b > c) std::swap(b, c);
    if (a > b) std::swap(a, b);
    if (c > kEven * a) {
        const auto first = [](double x, double y) { return y > x ? -log_size_ratio(x, y) / (y - x) : -1 / x; };
        return (first(b, c) - first(a, b)) / (c - a);
    }
    // Seven points, exact to degree 5 [Radon 1948].
    const double r = std::sqrt(15.0);
    const double a1 = (6 - r) / 21, a2 = (6 + r) / 21, w0 = 9.0 / 40, w1 = (155 - r) / 1200, w2 = (155 + r) / 1200;
    const auto density = [&](double s, double t) {
        const double h = a + s * (b - a) + t * (c - a);
        return 1 / (h * h);
    };
    const auto orbit = [&](double s) { return density(s, s) + density(s, 1 - 2 * s) + density(1 - 2 * s, s); };
    return 0.5 * (w0 * density(1.0 / 3, 1.0 / 3) + w1 * orbit(a1) + w2 * orbit(a2));
}

}  // namespace

struct ControlSpace::Tree {
    std::once_flag planted;
    std::vector<Eigen::Vector3d> points;
    std::vector<Triangle> triangles;
    std::optional<ClosestTriangle> closest;
};

ControlSpace::~ControlSpace() = default;
ControlSpace::ControlSpace(ControlSpace&&) noexcept = default;

void ControlSpace::reserve(std::size_t vertices, std::size_t triangles, std::span<const double> sizes) {
    if (sizes.size() != vertices)
        throw std::invalid_argument("ControlSpace: " + std::to_string(sizes.size()) + " sizes for " +
                                    std::to_string(vertices) + " vertices");
    for (std::size_t v = 0; v < sizes.size(); ++v)
        if (!(sizes[v] > 0) || !std::isfinite(sizes[v]))
            throw std::invalid_argument("ControlSpace: size of vertex " + std::to_string(v) +
                                        " is not positive and finite");
    cells_.reserve(triangles);
    tree_ = std::make_unique<Tree>();
}

void ControlSpace::add_cell(const std::array<Eigen::Vector3d, 3>& corner, const std::array<double, 3>& h,
                            const std::array<int, 3>& neighbour) {
    const Eigen::Vector3d e1 = corner[1] - corner[0], e2 = corner[2] - corner[0], n = e1.cross(e2);
    const double n2 = n.squaredNorm();
    const bool has_area = n2 > 0;
    cells_.push_back({corner[0], has_area ? Eigen::Vector3d(e2.cross(n) / n2) : Eigen::Vector3d::Zero(),
                      has_area ? Eigen::Vector3d(n.cross(e1) / n2) : Eigen::Vector3d::Zero(), h, neighbour});
}

ControlSpace::ControlSpace(std::span<const Eigen::Vector3d> points, const Connectivity& mesh,
                           std::span<const double> sizes) {
    reserve(points.size(), mesh.num_triangles(), sizes);
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const auto [a, b, c] = mesh.triangle(t);
        const auto beyond = [&](int side) { return mesh.twin(3 * t + side) >= 0 ? mesh.twin(3 * t + side) / 3 : -1; };
        add_cell({points[a], points[b], points[c]}, {sizes[a], sizes[b], sizes[c]}, {beyond(1), beyond(2), beyond(0)});
    }
}

ControlSpace::ControlSpace(const Background& background, std::span<const double> sizes) : background_(&background) {
    const TriMesh& mesh = background.mesh;
    reserve(mesh.n_vertices(), mesh.n_faces(), sizes);
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
        add_cell({points[a], points[b], points[c]}, {sizes[a], sizes[b], sizes[c]}, neighbour);
    }

    // A grid of about one cell per two triangles of each patch finds places by their parameters.
    if (background.patch.empty()) return;
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

int ControlSpace::Grid::index(const Eigen::Vector2d& uv, int axis) const {
    const double extent = domain.max[axis] - domain.min[axis];
    const double s = extent > 0 ? (uv[axis] - domain.min[axis]) / extent : 0;
    return static_cast<int>(std::clamp(s * cells, 0.0, cells - 1.0));
}

ControlSpace::Height ControlSpace::height_over(const Cell& cell, const Eigen::Vector3d& d) {
    const Eigen::Vector3d n = cell.ga.cross(cell.gb);
    const double along = n.dot(d);
    return {along * along, n.squaredNorm()};
}

// Whether a point with these coordinates is too far from a cell to have its size there: over it, or beyond its sides.
bool ControlSpace::is_far(const Cell& cell, double a, double b, const Height& height) const {
    const double size = size_in(cell, a, b), far2 = kFar2 * size * size;
    if (height.squared_times > far2 * height.normal2) return true;
    const std::array<double, 3> w{1 - a - b, a, b};
    if (w[0] >= -kInside && w[1] >= -kInside && w[2] >= -kInside) return false;
    const std::array<double, 3> slope2{(cell.ga + cell.gb).squaredNorm(), cell.ga.squaredNorm(), cell.gb.squaredNorm()};
    for (int k = 0; k < 3; ++k)
        if (w[k] < 0 && w[k] * w[k] > far2 * slope2[k]) return true;
    return false;
}

int ControlSpace::closest_cell(const Eigen::Vector3d& p) const {
    std::call_once(tree_->planted, [&] {
        std::vector<int> with_area;
        for (const Cell& c : cells_) {
            // The sides of a triangle from the gradients of its coordinates.
            const Eigen::Vector3d n = c.ga.cross(c.gb);
            const double n2 = n.squaredNorm();
            const auto first = static_cast<int>(tree_->points.size());
            tree_->points.insert(tree_->points.end(), {c.p0, c.p0, c.p0});
            if (n2 > 0) {
                with_area.push_back(static_cast<int>(tree_->triangles.size()));
                tree_->points[first + 1] += c.gb.cross(n) / n2;
                tree_->points[first + 2] += n.cross(c.ga) / n2;
            }
            tree_->triangles.push_back({first, first + 1, first + 2});
        }
        if (!with_area.empty()) tree_->closest.emplace(tree_->points, tree_->triangles, std::move(with_area));
    });
    return tree_->closest ? tree_->closest->closest(p).triangle : -1;
}

// Where p is over a triangle, but not on it: the one that it may be on, beyond a fold, or -1.
int ControlSpace::beyond_fold(const Eigen::Vector3d& p, int triangle, double a, double b,
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

double ControlSpace::size_in(const Cell& cell, double a, double b) {
    const double w0 = 1 - a - b;
    if (w0 >= 0 && a >= 0 && b >= 0) return w0 * cell.h[0] + a * cell.h[1] + b * cell.h[2];
    const auto w = clamped(a, b);
    return w[0] * cell.h[0] + w[1] * cell.h[1] + w[2] * cell.h[2];
}

double ControlSpace::size(const Eigen::Vector3d& p, int& triangle) const {
    GRADUS_ASSERT(triangle >= 0 && triangle < num_triangles());
    int came_from = -1;
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
        if (next < 0) {
            // Patches are resolved finely, and may touch other parts, which would be closer.
            if (!grids_.empty() || !is_far(cell, a, b, height)) return size_in(cell, a, b);
            break;
        }
        came_from = triangle;
        triangle = next;
    }
    if (const int closest = closest_cell(p); closest >= 0) triangle = closest;
    const Cell& cell = cells_[triangle];
    const Eigen::Vector3d d = p - cell.p0;
    return size_in(cell, cell.ga.dot(d), cell.gb.dot(d));
}

double ControlSpace::size_in_parameters(const SurfacePoint& at, int& triangle) const {
    const Grid& grid = grids_[at.patch];
    const int column = grid.index(at.uv, 0), row = grid.index(at.uv, 1);
    // The triangle that holds the place, else the nearest one: beside the chord of a curve, or in the fan of a pole.
    struct Found {
        double outside = std::numeric_limits<double>::infinity(), a = 0, b = 0;
    } best;
    triangle = -1;
    const auto look_at = [&](int t) {
        const auto& uv = background_->uv[t];
        const Eigen::Vector2d e1 = uv[1] - uv[0], e2 = uv[2] - uv[0], d = at.uv - uv[0];
        const double det = e1.x() * e2.y() - e1.y() * e2.x();
        if (det == 0) return;
        const double a = (d.x() * e2.y() - d.y() * e2.x()) / det, b = (e1.x() * d.y() - e1.y() * d.x()) / det;
        const double least = std::min({a, b, 1 - a - b});
        const double outside = least >= 0 ? 0 : distance_outside(at.uv, uv);
        if (outside < best.outside) best = {outside, a, b}, triangle = t;
    };
    for (int reach = 0; reach < grid.cells; ++reach) {
        const bool had_one = triangle >= 0;
        for (int j = std::max(0, row - reach); j <= std::min(grid.cells - 1, row + reach); ++j)
            for (int i = std::max(0, column - reach); i <= std::min(grid.cells - 1, column + reach); ++i) {
                if (std::max(std::abs(i - column), std::abs(j - row)) != reach) continue;
                const int cell = j * grid.cells + i;
                for (int k = grid.first[cell]; k < grid.first[cell + 1] && best.outside > 0; ++k)
                    look_at(grid.triangles[k]);
            }
        // One ring more than the first that had a triangle: it may hold a nearer one.
        if (best.outside == 0 || had_one) break;
    }
    return size_in(cells_[triangle], best.a, best.b);
}

int ControlSpace::locate(const SurfacePoint& at) const {
    int triangle = -1;
    size_in_parameters(at, triangle);
    return triangle;
}

double ControlSpace::size(const SurfacePoint& at) const {
    int triangle = -1;
    return size_in_parameters(at, triangle);
}

double ControlSpace::least_relative_size() const {
    double least = std::numeric_limits<double>::infinity();
    for (const Cell& c : cells_)
        least = std::min(least, *std::min_element(c.h.begin(), c.h.end()) / c.p0.cwiseAbs().maxCoeff());
    return least;
}

double ControlSpace::predicted_triangles() const {
    double sum = 0;
    for (const Cell& c : cells_) {
        // The gradients of two barycentric coordinates span a parallelogram of one over that of the sides.
        const double over_twice_area = c.ga.cross(c.gb).norm();
        if (over_twice_area > 0) sum += mean_density(c.h[0], c.h[1], c.h[2]) / over_twice_area;
    }
    return sum / (std::numbers::sqrt3 / 4);
}

}  // namespace gradus

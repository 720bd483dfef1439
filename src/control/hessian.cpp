#include "gradus/control/hessian.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace gradus {

namespace {

using Eigen::Vector3d;

constexpr int kUnknowns = 6;  // of a quadratic in two variables
constexpr int kEnough = 12;   // neighbours
constexpr int kMostRings = 6;
constexpr double kWellPosed = 1e-7;  // smallest over largest singular value, of coordinates scaled to one

std::vector<std::vector<int>> neighbours_of(const TriMesh& mesh) {
    std::vector<std::vector<int>> neighbours(mesh.n_vertices());
    for (const auto e : mesh.edges()) {
        const auto h = mesh.halfedge_handle(e, 0);
        const int a = mesh.from_vertex_handle(h).idx(), b = mesh.to_vertex_handle(h).idx();
        neighbours[a].push_back(b);
        neighbours[b].push_back(a);
    }
    return neighbours;
}

std::vector<Vector3d> normals_of(const TriMesh& mesh) {
    const auto points = points_of(mesh);
    std::vector<Vector3d> normals(points.size(), Vector3d::Zero());
    for (const auto& [a, b, c] : triangles_of(mesh)) {
        const Vector3d n = (points[b] - points[a]).cross(points[c] - points[a]);
        for (const int v : {a, b, c}) normals[v] += n;
    }
    for (Vector3d& n : normals) n = n.squaredNorm() > 0 ? n.stableNormalized() : Vector3d::UnitZ().eval();
    return normals;
}

class Fitter {
  public:
    Fitter(const TriMesh& mesh, std::span<const double> values)
        : points_(points_of(mesh)),
          values_(values),
          neighbours_(neighbours_of(mesh)),
          normals_(normals_of(mesh)),
          seen_(mesh.n_vertices(), -1) {}

    Tensor at(int v) {
        std::vector<int> ring{v};
        seen_[v] = v;
        for (int rings = 1, begin = 0; rings <= kMostRings; ++rings) {
            const int end = static_cast<int>(ring.size());
            for (int i = begin; i < end; ++i)
                for (const int w : neighbours_[ring[i]])
                    if (seen_[w] != v) seen_[w] = v, ring.push_back(w);
            begin = end;
            if (rings < 2 || static_cast<int>(ring.size()) <= kEnough) continue;
            if (const auto hessian = fit(v, ring)) return *hessian;
        }
        if (const auto hessian = fit(v, ring)) return *hessian;
        throw std::invalid_argument("recovered_hessians: too few vertices around vertex " + std::to_string(v));
    }

  private:
    // The best quadratic over some vertices, the nearer ones counting for more; nothing where they lie on a conic.
    std::optional<Tensor> fit(int v, const std::vector<int>& ring) const {
        if (static_cast<int>(ring.size()) < kUnknowns) return std::nullopt;
        const Vector3d u = std::abs(normals_[v].z()) == 1 ? Vector3d::UnitX().eval() : normals_[v].unitOrthogonal(),
                       w = normals_[v].cross(u);
        // Neighbours may lie far in one direction and near in another: coordinates are scaled by how they spread.
        Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
        std::vector<Eigen::Vector2d> plane;
        for (const int x : ring) {
            const Vector3d d = points_[x] - points_[v];
            plane.emplace_back(d.dot(u), d.dot(w));
            spread += plane.back() * plane.back().transpose() / static_cast<double>(ring.size());
        }
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(spread);
        if (!(solver.eigenvalues()[0] > 0)) return std::nullopt;
        const Eigen::Matrix2d scale = solver.operatorInverseSqrt();
        Eigen::MatrixXd a(ring.size(), kUnknowns);
        Eigen::VectorXd b(ring.size());
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const Eigen::Vector2d s = scale * plane[i];
            const double weight = 1 / (0.5 + s.squaredNorm());
            a.row(i) << 1, s.x(), s.y(), s.x() * s.x() / 2, s.x() * s.y(), s.y() * s.y() / 2;
            a.row(i) *= weight;
            b[i] = weight * (values_[ring[i]] - values_[v]);
        }
        const Eigen::JacobiSVD<Eigen::MatrixXd> svd(a, Eigen::ComputeThinU | Eigen::ComputeThinV);
        if (!(svd.singularValues()[kUnknowns - 1] > kWellPosed * svd.singularValues()[0])) return std::nullopt;
        const Eigen::VectorXd x = svd.solve(b);
        Eigen::Matrix2d hessian;
        hessian << x[3], x[4], x[4], x[5];
        hessian = scale * hessian * scale;
        Eigen::Matrix<double, 3, 2> axes;
        axes << u, w;
        return tensor_of(axes * hessian * axes.transpose());
    }

    std::span<const Vector3d> points_;
    std::span<const double> values_;
    std::vector<std::vector<int>> neighbours_;
    std::vector<Vector3d> normals_;
    std::vector<int> seen_;
};

// |H| in the tangent plane; across it the geometric mean, which is neither large nor small there. What is 0 in it
// becomes `least`.
Tensor absolute(const Tensor& hessian, const Vector3d& normal, double least) {
    const Vector3d u = std::abs(normal.z()) == 1 ? Vector3d::UnitX().eval() : normal.unitOrthogonal(),
                   w = normal.cross(u);
    Eigen::Matrix<double, 3, 2> axes;
    axes << u, w;
    const Eigen::Matrix2d plane = axes.transpose() * matrix_of(hessian) * axes;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver((plane + plane.transpose()) / 2);
    const Eigen::Vector2d values = solver.eigenvalues().cwiseAbs().cwiseMax(least);
    const Eigen::Matrix<double, 3, 2> directions = axes * solver.eigenvectors();
    return tensor_of(directions * values.asDiagonal() * directions.transpose() +
                     std::sqrt(values[0] * values[1]) * normal * normal.transpose());
}

class Sizing {
  public:
    Sizing(const TriMesh& mesh, std::span<const std::vector<Tensor>> hessians, const HessianMetricOptions& options)
        : options_(options), normals_(normals_of(mesh)), shares_(mesh.n_vertices(), 0) {
        const auto points = points_of(mesh);
        for (const auto& [a, b, c] : triangles_of(mesh)) {
            const double area = (points[b] - points[a]).cross(points[c] - points[a]).norm() / 2;
            for (const int v : {a, b, c}) shares_[v] += area / 3;
        }
        for (const auto& of_field : hessians) {
            double largest = 0;
            for (const Tensor& h : of_field)
                for (const double x : h.v) largest = std::max(largest, std::abs(x));
            // Second derivatives below rounding are none.
            std::vector<Tensor>& field = absolute_.emplace_back();
            for (std::size_t v = 0; v < of_field.size(); ++v)
                field.push_back(absolute(of_field[v], normals_[v], std::max(1e-12 * largest, 1e-200)));
        }
    }

    HessianMetrics run() const {
        if (options_.error) return with_factor(2 / (9 * *options_.error), 0);
        // The number of vertices falls and rises with the factor.
        const double power = -1 / (2 * options_.norm + 2);
        double low = 1e-30, high = 1e30;
        for (int i = 0; i < 200 && high > low * (1 + 1e-9); ++i) {
            const double middle = std::sqrt(low * high);
            (with_factor(middle, power).expected_vertices < *options_.vertices ? low : high) = middle;
        }
        return with_factor(std::sqrt(low * high), power);
    }

  private:
    // Metrics factor det(|H|)^power |H|, bounded.
    HessianMetrics with_factor(double factor, double power) const {
        HessianMetrics result;
        for (std::size_t v = 0; v < shares_.size(); ++v) {
            std::optional<Tensor> metric;
            for (const auto& field : absolute_) {
                const double density = 1 / mean_square_size(size_tensor(field[v]), normals_[v]);
                const Tensor scaled = (factor * std::pow(density * density, power)) * field[v];
                metric = metric ? intersection(*metric, scaled) : scaled;
            }
            const Tensor within = bounded(*metric, options_.bounds);
            count_bounds(*metric, within, result);
            result.metrics.push_back(within);
            result.expected_triangles +=
                4 / std::numbers::sqrt3 * shares_[v] / mean_square_size(size_tensor(within), normals_[v]);
        }
        result.expected_vertices = result.expected_triangles / 2;
        return result;
    }

    void count_bounds(const Tensor& before, const Tensor& after, HessianMetrics& result) const {
        if (before == after) return;
        const Vector3d h = axes_of(size_tensor(before)).values;
        result.at_smallest += h[0] < options_.bounds.smallest;
        result.at_largest += h[2] > options_.bounds.largest;
        const double least = std::clamp(h[0], options_.bounds.smallest, options_.bounds.largest);
        result.at_aspect += std::min(h[2], options_.bounds.largest) > options_.bounds.aspect * least;
    }

    const HessianMetricOptions& options_;
    std::vector<Vector3d> normals_;
    std::vector<double> shares_;  // of the area, at each vertex
    std::vector<std::vector<Tensor>> absolute_;
};

}  // namespace

std::vector<Tensor> recovered_hessians(const TriMesh& mesh, std::span<const double> values) {
    if (values.size() != mesh.n_vertices())
        throw std::invalid_argument("recovered_hessians: " + std::to_string(values.size()) + " values for " +
                                    std::to_string(mesh.n_vertices()) + " vertices");
    for (std::size_t v = 0; v < values.size(); ++v)
        if (!std::isfinite(values[v]))
            throw std::invalid_argument("recovered_hessians: the value at vertex " + std::to_string(v) +
                                        " is not finite");
    Fitter fitter(mesh, values);
    std::vector<Tensor> hessians;
    for (int v = 0; v < static_cast<int>(mesh.n_vertices()); ++v) hessians.push_back(fitter.at(v));
    return hessians;
}

HessianMetrics metrics_of_hessians(const TriMesh& mesh, std::span<const std::vector<Tensor>> hessians,
                                   const HessianMetricOptions& options) {
    if (options.error.has_value() == options.vertices.has_value())
        throw std::invalid_argument("metrics_of_hessians: give an error or a number of vertices");
    if (!(options.error.value_or(1) > 0) || !(options.vertices.value_or(1) > 0) || !(options.norm >= 1))
        throw std::invalid_argument("metrics_of_hessians: error, vertices and norm must be positive");
    if (!(options.bounds.smallest <= options.bounds.largest) || !std::isfinite(options.bounds.largest) ||
        !(options.bounds.aspect >= 1))
        throw std::invalid_argument("metrics_of_hessians: sizes need a largest one, and an aspect of at least 1");
    if (hessians.empty()) throw std::invalid_argument("metrics_of_hessians: no field");
    return Sizing(mesh, hessians, options).run();
}

}  // namespace gradus

#include "gradus/curvature/estimate.hpp"

#include "gradus/surface/unit_normal.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

namespace gradus {

namespace {

using Eigen::Vector3d;

constexpr int kCubic = 10, kQuadratic = 6;  // coefficients
constexpr int kEnoughForCubic = 15;         // vertices, the one in the middle among them
constexpr int kMostVertices = 400;
constexpr double kNormalWeight = 0.5;       // of a slope against a height, once both are lengths
constexpr double kRidge = 1e-9;             // keeps what the vertices do not tell near zero

// The wedges some rings around one, ring by ring. Reused from wedge to wedge.
class Neighbourhood {
  public:
    Neighbourhood(const Connectivity& mesh, const Wedges& wedges) : mesh_(mesh), wedges_(wedges), stamp_(wedges.size(), 0) {}

    void begin(int wedge) {
        ++now_;
        members_.assign(1, wedge);
        stamp_[wedge] = now_;
        ring_ = 0;
        outer_ = 0;
    }
    // @returns whether there was anything to add
    bool add_ring() {
        const std::size_t end = members_.size();
        for (; outer_ < end; ++outer_) {
            if (members_.size() > kMostVertices) break;
            wedges_.for_each(mesh_, members_[outer_], [&](int h) {
                for (const int e : {Connectivity::next(h), Connectivity::prev(h)}) {
                    const int w = wedges_.of_corner[e];
                    if (stamp_[w] != now_) stamp_[w] = now_, members_.push_back(w);
                }
            });
        }
        ++ring_;
        return members_.size() > end;
    }
    const std::vector<int>& members() const { return members_; }
    int rings() const { return ring_; }

  private:
    const Connectivity& mesh_;
    const Wedges& wedges_;
    std::vector<int> stamp_, members_;
    int now_ = 0, ring_ = 0;
    std::size_t outer_ = 0;
};

class Fitter {
  public:
    Fitter(std::span<const Vector3d> points, const Wedges& wedges, std::span<const Vector3d> normals) : points_(points), wedges_(wedges), normals_(normals) {}

    std::optional<WedgeCurvature> fit(const std::vector<int>& members) {
        const int wedge = members.front();
        const Vector3d normal = normals_[wedge];
        if (normal.isZero() || members.size() < 3) return std::nullopt;
        place(members, normal);
        return static_cast<int>(members.size()) >= kEnoughForCubic ? solve<kCubic>(members, normal) : solve<kQuadratic>(members, normal);
    }

  private:
    struct Local {
        double x, y, z, weight;
    };

    // Coordinates along the longer and the shorter spread of the vertices, each over that spread.
    void place(const std::vector<int>& members, const Vector3d& normal) {
        const Vector3d origin = points_[wedges_.vertex[members.front()]];
        const Vector3d u = any_tangent(normal), v = normal.cross(u);
        double xx = 0, xy = 0, yy = 0;
        local_.clear();
        for (const int w : members) {
            const Vector3d d = points_[wedges_.vertex[w]] - origin;
            const double x = d.dot(u), y = d.dot(v);
            local_.push_back({x, y, d.dot(normal), 1});
            xx += x * x, xy += x * y, yy += y * y;
        }
        const double angle = std::atan2(2 * xy, xx - yy) / 2, c = std::cos(angle), s = std::sin(angle);
        u_ = c * u + s * v;
        v_ = c * v - s * u;
        const double n = static_cast<double>(members.size());
        sx_ = std::sqrt(std::max(c * c * xx + 2 * c * s * xy + s * s * yy, 0.0) / n);
        sy_ = std::sqrt(std::max(s * s * xx - 2 * c * s * xy + c * c * yy, 0.0) / n);
        sx_ = std::max(sx_, 1e-300);
        sy_ = std::max(sy_, 1e-6 * sx_);
        for (Local& p : local_) {
            const double x = (c * p.x + s * p.y) / sx_, y = (c * p.y - s * p.x) / sy_;
            p.x = x;
            p.y = y;
            p.weight = 1 / (1 + (x * x + y * y) / 4);
        }
    }

    template <int n>
    WedgeCurvature solve(const std::vector<int>& members, const Vector3d& normal) {
        using Row = Eigen::Matrix<double, n, 1>;
        using Matrix = Eigen::Matrix<double, n, n>;
        const auto row = [](double x, double y) {
            Row r;
            r.template head<6>() << 1, x, y, x * x, x * y, y * y;
            if constexpr (n == kCubic) r.template tail<4>() << x * x * x, x * x * y, x * y * y, y * y * y;
            return r;
        };
        Matrix A = Matrix::Zero();
        Row b = Row::Zero();
        double count = 0;
        const auto add = [&](const Row& r, double value, double weight) {
            A.template selfadjointView<Eigen::Lower>().rankUpdate(r, weight);
            b += weight * value * r;
            ++count;
        };
        for (const Local& p : local_) add(row(p.x, p.y), p.z, p.weight);
        if constexpr (n == kQuadratic) add_slopes(members, normal, add);
        const double ridge = kRidge * A.diagonal().maxCoeff();
        A.diagonal().array() += ridge;
        const Eigen::LLT<Matrix> llt(A);
        const Row x = llt.solve(b);
        double residual = 0, weights = 0;
        for (const Local& p : local_) {
            const double miss = row(p.x, p.y).dot(x) - p.z;
            residual += p.weight * miss * miss;
            weights += p.weight;
        }
        const double free = std::max(1.0, count - n);
        const double variance = residual / weights * count / free;

        const double fx = x[1] / sx_, fy = x[2] / sy_, fxx = 2 * x[3] / (sx_ * sx_), fxy = x[4] / (sx_ * sy_), fyy = 2 * x[5] / (sy_ * sy_);
        const double E = 1 + fx * fx, F = fx * fy, G = 1 + fy * fy, length = std::sqrt(1 + fx * fx + fy * fy);
        const double L = fxx / length, M = fxy / length, N = fyy / length;
        const double det = E * G - F * F, H = (E * N - 2 * F * M + G * L) / (2 * det), K = (L * N - M * M) / det;
        const double root = std::sqrt(std::max(0.0, H * H - K));
        WedgeCurvature result;
        // Heights along the outer normal fall where the surface bends to the inside.
        result.k1 = -(H + (H < 0 ? -root : root));
        result.k2 = -(H - (H < 0 ? -root : root));
        result.normal = (normal - fx * u_ - fy * v_).normalized();
        // The error of the second derivative across, where the vertices are closest together, bounds the others.
        const auto error_of = [&](int i, double scale) {
            Row unit = Row::Zero();
            unit[i] = 1;
            return scale * std::sqrt(std::max(0.0, variance * llt.solve(unit)[i]));
        };
        result.error = std::max(error_of(3, 2 / (sx_ * sx_)), error_of(5, 2 / (sy_ * sy_)));
        return result;
    }

    template <class Add>
    void add_slopes(const std::vector<int>& members, const Vector3d& normal, const Add& add) const {
        for (std::size_t i = 0; i < members.size(); ++i) {
            const Vector3d& m = normals_[members[i]];
            const double up = m.dot(normal);
            constexpr double kSteep = 0.3;
            if (up < kSteep) continue;
            const auto [x, y, z, weight] = local_[i];
            Eigen::Matrix<double, kQuadratic, 1> r;
            r << 0, 1, 0, 2 * x, y, 0;
            add(r, -m.dot(u_) / up * sx_, kNormalWeight * weight);
            r << 0, 0, 1, 0, x, 2 * y;
            add(r, -m.dot(v_) / up * sy_, kNormalWeight * weight);
        }
    }

    std::span<const Vector3d> points_;
    const Wedges& wedges_;
    std::span<const Vector3d> normals_;
    std::vector<Local> local_;
    Vector3d u_, v_;
    double sx_ = 1, sy_ = 1;
};

// Takes a fitted normal back to where the facets around it turn: where few vertices far away lead a fit astray they know better.
Vector3d among_facets(std::span<const Vector3d> points, const Connectivity& mesh, const Wedges& wedges, int wedge, const Vector3d& middle, const Vector3d& fitted) {
    double least = 1;
    wedges.for_each(mesh, wedge, [&](int h) {
        const Vector3d& p = points[mesh.origin(h)];
        const Vector3d n = (points[mesh.target(h)] - p).cross(points[mesh.apex(h)] - p);
        const double length = n.norm();
        if (length > 0) least = std::min(least, n.dot(middle) / length);
    });
    const double cosine = fitted.dot(middle);
    if (cosine >= least) return fitted;
    const Vector3d away = fitted - cosine * middle;
    const double length = away.norm();
    least = std::min(1.0, std::max(least, 0.0));
    return length > 0 ? Vector3d(least * middle + std::sqrt(1 - least * least) / length * away) : middle;
}

}  // namespace

std::vector<WedgeCurvature> estimate_curvature(std::span<const Vector3d> points, const Connectivity& mesh, const Wedges& wedges,
                                               std::span<const Vector3d> normals, const EstimateOptions& options) {
    std::vector<WedgeCurvature> result(wedges.size());
    struct Tools {
        Neighbourhood near;
        Fitter fitter;
    };
    tbb::enumerable_thread_specific<Tools> tools([&] { return Tools{Neighbourhood(mesh, wedges), Fitter(points, wedges, normals)}; });
    tbb::parallel_for(tbb::blocked_range<int>(0, wedges.size(), 256), [&](const tbb::blocked_range<int>& range) {
        auto& [near, fitter] = tools.local();
        for (int wedge = range.begin(); wedge < range.end(); ++wedge) {
            if (wedges.first[wedge] == Connectivity::kNone) continue;
            near.begin(wedge);
            result[wedge].normal = normals[wedge];
            bool fitted = false;
            while (near.rings() < options.most_rings && near.add_ring()) {
                if (near.rings() < options.rings) continue;
                // More rings are better only while they promise a smaller error.
                const std::optional<WedgeCurvature> fit = fitter.fit(near.members());
                if (!fit || (fitted && fit->error >= result[wedge].error)) break;
                result[wedge] = *fit;
                result[wedge].rings = near.rings();
                fitted = true;
                if (fit->error <= options.precision * std::max(std::abs(fit->k1), options.least_curvature)) break;
            }
            if (!fitted)
                if (const auto fit = fitter.fit(near.members())) result[wedge] = *fit;
            result[wedge].normal = among_facets(points, mesh, wedges, wedge, normals[wedge], result[wedge].normal);
        }
    });
    return result;
}

}  // namespace gradus

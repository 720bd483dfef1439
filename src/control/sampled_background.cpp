#include "gradus/control/sampled_background.hpp"

#include "gradus/mesh/frozen.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>

namespace gradus {

namespace {

constexpr int kFewestSamples = 4, kMostSamples = 400;  // along an edge

// By how much two sizes differ, as a ratio, in the direction in which they differ most.
double difference(double a, double b) { return std::max(a / b, b / a); }
double difference(const Tensor& a, const Tensor& b) {
    // Of size tensors the ratios of lengths are those of their inverses, so that of the tensors themselves bounds them
    // where they commute, which is where they are nearly the same.
    const Tensor p = metric_of(a), q = metric_of(b);
    return std::max(largest_ratio(p, q), largest_ratio(q, p));
}

double squared_metric_length(const Eigen::Vector3d& e, double h) { return e.squaredNorm() / (h * h); }
double squared_metric_length(const Eigen::Vector3d& e, const Tensor& h) { return times(inverse(h), e).squaredNorm(); }

// Cuts an edge in its middle. @returns the vertex there
template <class M>
int cut_edge(SampledBackground<M>& background, const SizeFunction<M>& wanted, int h) {
    Connectivity& mesh = background.mesh;
    const std::array<int, 2> ends{mesh.origin(h), mesh.target(h)};
    const Eigen::Vector3d middle = (background.points[ends[0]] + background.points[ends[1]]) / 2;
    background.cuts.push_back({ends, mesh.tag(h)});
    const int v = mesh.split(h);
    background.points.push_back(middle);
    background.sizes.push_back(wanted(middle));
    return v;
}

template <class M>
class Cutter {
  public:
    using Value = typename M::Value;

    Cutter(SampledBackground<M>& background, const SizeFunction<M>& wanted, const SamplingOptions& options)
        : background_(background), wanted_(wanted), options_(options) {
        Eigen::AlignedBox3d box;
        for (const Eigen::Vector3d& p : points()) {
            box.extend(p);
            background_.sizes.push_back(wanted_(p));
        }
        spacing_ = options.spacing * box.diagonal().norm();
    }

    void run() {
        // First in, first out: so triangles of about one size are looked at one after the other.
        std::deque<int> queue;
        for (int t = 0; t < mesh().num_triangles(); ++t) queue.push_back(t);
        queued_.assign(queue.size(), 1);
        std::vector<int> changed;
        while (!queue.empty()) {
            const int t = queue.front();
            queue.pop_front();
            queued_[t] = 0;
            const std::optional<int> edge = edge_to_cut(t);
            if (!edge) continue;
            if (mesh().num_triangles() >= options_.max_triangles) {
                background_.is_fine_enough = false;
                return;
            }
            changed.clear();
            cut(*edge, changed);
            queued_.resize(mesh().num_triangles(), 0);
            for (const int c : changed)
                if (!queued_[c]) queued_[c] = 1, queue.push_back(c);
        }
    }

  private:
    std::vector<Eigen::Vector3d>& points() { return background_.points; }
    Connectivity& mesh() { return background_.mesh; }

    // A triangle with the sizes at its corners.
    struct Corners {
        std::array<Eigen::Vector3d, 3> p;
        std::array<Value, 3> h;
    };

    // The longest side in the metric of a size, if it is too long for that.
    static constexpr int kNone = -1;
    int too_long_side(const Corners& of, const Value& size) const {
        int longest = kNone;
        double most = options_.shortest * options_.shortest;
        for (int k = 0; k < 3; ++k) {
            const double length2 = squared_metric_length(of.p[(k + 1) % 3] - of.p[k], size);
            if (length2 > most) most = length2, longest = k;
        }
        return longest;
    }

    // Where at the point with these barycentric coordinates another size is wanted than the one interpolated, and the
    // triangle is too large for one of them: its longest side for that.
    int side_to_cut(const Corners& of, double a, double b) const {
        const double c = 1 - a - b;
        const Value wanted = wanted_(c * of.p[0] + a * of.p[1] + b * of.p[2]);
        const Value interpolated = c * of.h[0] + a * of.h[1] + b * of.h[2];
        // The length first: it is cheaper to find.
        int side = too_long_side(of, wanted);
        if (side == kNone) side = too_long_side(of, interpolated);
        return side != kNone && difference(wanted, interpolated) > 1 + options_.tolerance ? side : kNone;
    }

    int samples_along(double length) const {
        return std::clamp(static_cast<int>(std::ceil(length / spacing_)), kFewestSamples, kMostSamples);
    }

    // Looks at samples on its edges, and inside as many as its area has room for.
    std::optional<int> edge_to_cut(int t) {
        const Triangle v = mesh().triangle(t);
        const Corners of{{points()[v[0]], points()[v[1]], points()[v[2]]},
                         {background_.sizes[v[0]], background_.sizes[v[1]], background_.sizes[v[2]]}};
        int side = kNone;
        const auto look_at = [&](double a, double b) {
            side = side_to_cut(of, a, b);
            return side != kNone && !is_frozen_tag(mesh().tag(3 * t + side));
        };
        const std::array<Eigen::Vector2d, 3> corner{Eigen::Vector2d{0, 0}, {1, 0}, {0, 1}};
        for (int k = 0; k < 3; ++k) {
            const Eigen::Vector2d &from = corner[k], &to = corner[(k + 1) % 3];
            const int n = samples_along((of.p[(k + 1) % 3] - of.p[k]).norm());
            for (int i = 1; i < n; ++i) {
                const Eigen::Vector2d at = from + (to - from) * (static_cast<double>(i) / n);
                if (look_at(at.x(), at.y())) return 3 * t + side;
            }
        }
        const int n = samples_along(std::sqrt((of.p[1] - of.p[0]).cross(of.p[2] - of.p[0]).norm()));
        for (int i = 1; i < n; ++i)
            for (int j = 1; i + j < n; ++j)
                if (look_at(static_cast<double>(i) / n, static_cast<double>(j) / n)) return 3 * t + side;
        return std::nullopt;
    }

    void cut(int h, std::vector<int>& changed) {
        const int v = cut_edge(background_, wanted_, h);
        mesh().for_each_outgoing(v, [&](int e) { changed.push_back(e / 3); });
    }

    SampledBackground<M>& background_;
    const SizeFunction<M>& wanted_;
    const SamplingOptions& options_;
    double spacing_ = 0;
    std::vector<char> queued_;  // triangles
};

}  // namespace

template <class M>
SampledBackground<M> sampled_background(std::vector<Eigen::Vector3d> points, Connectivity mesh,
                                        const SizeFunction<M>& wanted, const SamplingOptions& options) {
    SampledBackground<M> background{std::move(points), std::move(mesh), {}, {}};
    Cutter<M>(background, wanted, options).run();
    return background;
}

template <class M>
int cut_long_edges(SampledBackground<M>& background, const SizeFunction<M>& wanted,
                   std::vector<typename M::Value> sizes, double longest, int max_triangles) {
    Connectivity& mesh = background.mesh;
    const auto length2 = [&](int h) {
        const int a = mesh.origin(h), b = mesh.target(h);
        return squared_metric_length(background.points[b] - background.points[a], 0.5 * (sizes[a] + sizes[b]));
    };
    int cuts = 0;
    std::deque<int> queue;
    for (int t = 0; t < mesh.num_triangles(); ++t) queue.push_back(t);
    while (!queue.empty() && mesh.num_triangles() < max_triangles) {
        const int t = queue.front();
        queue.pop_front();
        int side = 3 * t;
        for (int h = 3 * t + 1; h < 3 * t + 3; ++h)
            if (length2(h) > length2(side)) side = h;
        if (!(length2(side) > longest * longest) || is_frozen_tag(mesh.tag(side))) continue;
        const auto middle = 0.5 * (sizes[mesh.origin(side)] + sizes[mesh.target(side)]);
        const int v = cut_edge(background, wanted, side);
        sizes.push_back(middle);
        ++cuts;
        mesh.for_each_outgoing(v, [&](int e) { queue.push_back(e / 3); });
    }
    return cuts;
}

template int cut_long_edges(SampledBackground<Size>&, const SizeFunction<Size>&, std::vector<double>, double, int);
template int cut_long_edges(SampledBackground<SizeTensor>&, const SizeFunction<SizeTensor>&, std::vector<Tensor>,
                            double, int);

template SampledBackground<Size> sampled_background(std::vector<Eigen::Vector3d>, Connectivity,
                                                    const SizeFunction<Size>&, const SamplingOptions&);
template SampledBackground<SizeTensor> sampled_background(std::vector<Eigen::Vector3d>, Connectivity,
                                                          const SizeFunction<SizeTensor>&, const SamplingOptions&);

}  // namespace gradus

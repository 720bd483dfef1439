#include "gradus/curvature/estimate.hpp"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "gradus/surface/unit_normal.hpp"

namespace gradus {

namespace {

using Eigen::Vector3d;

constexpr int kQuadratic = 6, kCubic = 10;  // coefficients
constexpr int kEnoughForCubic = 15;         // vertices, the one in the middle among them
constexpr int kMostVertices = 400;
constexpr double kFall = 0.8;          // the outermost ring weighs 1 / (1 + kFall)
constexpr double kNormalWeight = 0.5;  // of a slope against a height, once both are lengths
constexpr double kRidge = 1e-9;        // keeps what the vertices do not tell near zero

// The wedges and their neighbours, numbered anew so that those near each other are near each other in memory too.
struct Graph {
    std::vector<int> wedge;                 // that has each number
    std::vector<Vector3d> points, normals;  // by number, as all below
    std::vector<int> first, neighbours;     // those of one after those of another
    int most_neighbours = 0;

    Graph(std::span<const Vector3d> point_of, const Connectivity& mesh, const Wedges& wedges, std::span<const Vector3d> normal_of) {
        const std::size_t size = wedges.size();
        std::vector<int> number(size, -1);
        wedge.reserve(size);
        points.reserve(size);
        normals.reserve(size);
        first.reserve(size + 1);
        neighbours.reserve(wedges.of_corner.size() + size);
        const auto number_of = [&](int w) {
            if (number[w] < 0) number[w] = static_cast<int>(wedge.size()), wedge.push_back(w);
            return number[w];
        };
        for (int seed = 0; seed < wedges.size(); ++seed) {
            number_of(seed);
            // Breadth first: what is numbered here waits in `wedge` for its turn.
            for (std::size_t i = first.size(); i < wedge.size(); ++i) {
                points.push_back(point_of[wedges.vertex[wedge[i]]]);
                normals.push_back(normal_of[wedge[i]]);
                first.push_back(static_cast<int>(neighbours.size()));
                int last = Connectivity::kNone;
                wedges.for_each(mesh, wedge[i], [&](int h) {
                    neighbours.push_back(number_of(wedges.of_corner[Connectivity::next(h)]));
                    last = Connectivity::prev(h);
                });
                if (last == Connectivity::kNone) continue;
                // Where the triangles go all around, the last neighbour is the first.
                const int end = number_of(wedges.of_corner[last]);
                if (end != neighbours[first.back()]) neighbours.push_back(end);
                most_neighbours = std::max(most_neighbours, static_cast<int>(neighbours.size()) - first.back());
            }
        }
        first.push_back(static_cast<int>(neighbours.size()));
    }
    int size() const { return static_cast<int>(wedge.size()); }
    std::span<const int> neighbours_of(int i) const { return std::span(neighbours).subspan(first[i], first[i + 1] - first[i]); }
};

// The wedges some rings around one, ring by ring. Reused from wedge to wedge.
class Neighbourhood {
  public:
    explicit Neighbourhood(const Graph& graph)
        : graph_(graph), stamp_(graph.size(), 0), members_(kMostVertices + 2 + graph.most_neighbours) {}

    void begin(int middle) {
        ++now_;
        members_[0] = middle;
        stamp_[middle] = now_;
        size_ = 1;
        ends_.assign(1, 1);
        outer_ = 0;
    }
    // @returns whether there was anything to add
    bool add_ring() {
        const std::size_t end = size_;
        std::size_t size = end;
        for (; outer_ < end && size <= kMostVertices; ++outer_)
            for (const int i : graph_.neighbours_of(members_[outer_])) {
                // Whether it is new cannot be foretold: without a branch.
                members_[size] = i;
                size += stamp_[i] != now_ ? 1 : 0;
                stamp_[i] = now_;
            }
        size_ = size;
        ends_.push_back(size);
        return size > end;
    }
    std::span<const int> members() const { return std::span(members_).first(size_); }
    // Ring 0 is the one in the middle.
    std::span<const int> ring(int k) const {
        const std::size_t begin = k > 0 ? ends_[k - 1] : 0;
        return std::span(members_).subspan(begin, ends_[k] - begin);
    }
    int rings() const { return static_cast<int>(ends_.size()) - 1; }

  private:
    const Graph& graph_;
    std::vector<int> stamp_, members_;
    std::vector<std::size_t> ends_;  // of the rings
    std::size_t size_ = 0, outer_ = 0;
    int now_ = 0;
};

// Calls use(std::integral_constant k) for k from 0 to count - 1.
template <int count, class Use>
void unrolled(const Use& use) {
    const auto call = [&]<int... k>(std::integer_sequence<int, k...>) { (use(std::integral_constant<int, k>{}), ...); };
    call(std::make_integer_sequence<int, count>{});
}

// Two vertices at a time.
using Pair = Eigen::Array2d;

// Sums over vertices of x^i y^j for i + j <= 6, of z x^i y^j for i + j <= 3, and of z^2: all that a least squares fit of a cubic
// asks of them. They are added up by ring, so that a larger fit takes nothing up again.
class Moments {
  public:
    static constexpr int kPower = 6, kHeight = 3;
    static constexpr int of_power(int i, int j) { return 7 * j - j * (j - 1) / 2 + i; }
    static constexpr int of_height(int i, int j) { return 28 + 4 * j - j * (j - 1) / 2 + i; }
    static constexpr int kSquare = 38, kSize = 40;  // the last one is always 0
    using Values = Eigen::Array<double, kSize, 1>;

    // @pre as many y and z as x
    static void find(std::span<const double> xs, std::span<const double> ys, std::span<const double> zs, Values& values) {
        std::array<Pair, kSize> sums;
        sums.fill(Pair::Zero());
        std::size_t i = 0;
        for (; i + 1 < xs.size(); i += 2) add({xs[i], xs[i + 1]}, {ys[i], ys[i + 1]}, {zs[i], zs[i + 1]}, sums);
        if (i < xs.size()) add({xs[i], 0}, {ys[i], 0}, {zs[i], 0}, sums);
        for (int k = 0; k < kSize; ++k) values[k] = sums[k][0] + sums[k][1];
        values[of_power(0, 0)] = static_cast<double>(xs.size());
    }

  private:
    static void add(const Pair& x, const Pair& y, const Pair& z, std::array<Pair, kSize>& sums) {
        Pair power = x;  // of y, times x
        unrolled<kPower - 1>([&](auto i) { sums[of_power(i + 1, 0)] += power, power *= x; });
        sums[of_power(kPower, 0)] += power;
        Pair row = y;
        unrolled<kPower>([&](auto j) {
            power = row;
            unrolled<kPower - j>([&](auto i) {
                sums[of_power(i, j + 1)] += power;
                if (i < kPower - j - 1) power *= x;
            });
            row *= y;
        });
        row = z;
        unrolled<kHeight + 1>([&](auto j) {
            power = row;
            unrolled<kHeight + 1 - j>([&](auto i) { sums[of_height(i, j)] += power, power *= x; });
            row *= y;
        });
        sums[kSquare] += z * z;
    }
};

// Exponents of x and y. Slopes and second derivatives come last, where elimination leaves them ready.
template <int n>
constexpr std::array<std::array<int, 2>, n> kTerms{};
template <>
constexpr std::array<std::array<int, 2>, kQuadratic> kTerms<kQuadratic>{{{0, 0}, {1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}}};
template <>
constexpr std::array<std::array<int, 2>, kCubic> kTerms<kCubic>{
    {{0, 0}, {3, 0}, {2, 1}, {1, 2}, {0, 3}, {1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}}};

// z of a height function and what its least squares left: z = ... + fx x + fy y + (fxx x^2 + 2 fxy x y + fyy y^2) / 2.
struct HeightFit {
    double fx, fy, fxx, fxy, fyy;
    double residual;                  // sum of weighted squares
    double variance_xx, variance_yy;  // of fxx and fyy, where heights of weight 1 have a variance of 1
};

// Normal equations of n coefficients, upper triangle, with the right side as the last column and the square of the heights below it.
template <int n>
class NormalEquations {
  public:
    explicit NormalEquations(const Moments::Values& moments) {
        constexpr auto& terms = kTerms<n>;
        unrolled<n>([&](auto r) {
            rows_[r].fill(Pair::Zero());
            unrolled<n - r>([&](auto i) {
                constexpr int c = r + i, power = Moments::of_power(terms[r][0] + terms[c][0], terms[r][1] + terms[c][1]);
                at(r, c) = moments[power];
            });
            at(r, n) = moments[Moments::of_height(terms[r][0], terms[r][1])];
        });
        rows_[n].fill(Pair::Zero());
        at(n, n) = moments[Moments::kSquare];
    }
    // One more equation: row . coefficients = value.
    void add(const std::array<double, n>& row, double value, double weight) {
        for (int r = 0; r < n; ++r) {
            for (int c = r; c < n; ++c) at(r, c) += weight * row[r] * row[c];
            at(r, n) += weight * row[r] * value;
        }
        at(n, n) += weight * value * value;
    }
    HeightFit solve() {
        const double ridge = kRidge * at(0, 0);
        for (int k = 0; k < n; ++k) at(k, k) += kRidge * at(k, k) + ridge;
        std::array<double, n> inverse;
        unrolled<n>([&](auto k) {
            inverse[k] = 1 / at(k, k);
            unrolled<n - k>([&](auto i) {
                constexpr int r = k + 1 + i;
                const double share = at(k, r) * inverse[k];
                unrolled<kWidth - r / 2>([&](auto c) { rows_[r][r / 2 + c] -= share * rows_[k][r / 2 + c]; });
            });
        });
        std::array<double, n> x;
        for (int k = n - 1; k >= n - 5; --k) {
            double sum = at(k, n);
            for (int c = k + 1; c < n; ++c) sum -= at(k, c) * x[c];
            x[k] = sum * inverse[k];
        }
        // Diagonal of the inverse, from that of the triangular factor.
        constexpr int xx = n - 3, xy = n - 2, yy = n - 1;
        const double a = at(xx, xy) * inverse[xx], b = at(xy, yy) * inverse[xy], c = a * b - at(xx, yy) * inverse[xx];
        return {x[n - 5],
                x[n - 4],
                2 * x[xx],
                x[xy],
                2 * x[yy],
                std::max(0.0, at(n, n)),
                4 * (inverse[xx] + a * a * inverse[xy] + c * c * inverse[yy]),
                4 * inverse[yy]};
    }

  private:
    static constexpr int kWidth = n / 2 + 1;  // pairs of n + 1 columns
    static_assert(n % 2 == 0);
    double& at(int r, int c) { return rows_[r][c / 2][c % 2]; }

    std::array<std::array<Pair, kWidth>, n + 1> rows_;
};

class Fitter {
  public:
    explicit Fitter(const Graph& graph) : points_(graph.points), normals_(graph.normals) {}

    // For fits to this neighbourhood, as it is and with more rings: the frame it gives is kept.
    void begin(const Neighbourhood& near) {
        place(near.members());
        summed_ = 0;
    }
    // @pre begun with this neighbourhood
    std::optional<WedgeCurvature> fit(const Neighbourhood& near) {
        const std::span<const int> members = near.members();
        if (w_.isZero() || members.size() < 3) return std::nullopt;
        if (near.rings() >= static_cast<int>(sums_.size())) sums_.resize(near.rings() + 1);
        for (; summed_ <= near.rings(); ++summed_) sum(near.ring(summed_), sums_[summed_]);
        Moments::Values moments = Moments::Values::Zero();
        for (int k = 0; k <= near.rings(); ++k) moments += weight(k, near.rings()) * sums_[k];
        const double count = static_cast<double>(members.size());
        if (static_cast<int>(members.size()) >= kEnoughForCubic)
            return curvature(NormalEquations<kCubic>(moments).solve(), moments[0], count, count - kCubic, near.rings());
        NormalEquations<kQuadratic> equations(moments);
        const auto [slopes, weights] = add_slopes(near, equations);
        return curvature(equations.solve(), moments[0] + weights, count + slopes, count + slopes - kQuadratic, near.rings());
    }

  private:
    static double weight(int ring, int rings) {
        const double share = static_cast<double>(ring) / rings;
        return 1 / (1 + kFall * share * share);
    }

    // Coordinates along the longer and the shorter spread of the vertices, each over that spread.
    void place(std::span<const int> members) {
        origin_ = points_[members.front()];
        w_ = normals_[members.front()];
        if (w_.isZero()) return;
        const Vector3d u = any_tangent(w_), v = w_.cross(u);
        double xx = 0, xy = 0, yy = 0;
        for (const int i : members) {
            const Vector3d d = points_[i] - origin_;
            const double x = d.dot(u), y = d.dot(v);
            xx += x * x, xy += x * y, yy += y * y;
        }
        // Half the angle of (xx - yy, 2 xy).
        const double length = std::hypot(xx - yy, 2 * xy), cosine = length > 0 ? (xx - yy) / length : 1;
        const double c = std::sqrt((1 + cosine) / 2), s = std::copysign(std::sqrt((1 - cosine) / 2), xy);
        u_ = c * u + s * v;
        v_ = c * v - s * u;
        const double n = static_cast<double>(members.size());
        sx_ = std::sqrt(std::max(c * c * xx + 2 * c * s * xy + s * s * yy, 0.0) / n);
        sy_ = std::sqrt(std::max(s * s * xx - 2 * c * s * xy + c * c * yy, 0.0) / n);
        sx_ = std::max(sx_, 1e-300);
        sy_ = std::max(sy_, 1e-6 * sx_);
    }

    void sum(std::span<const int> ring, Moments::Values& values) {
        const Vector3d u = u_ / sx_, v = v_ / sy_;
        for (std::vector<double>* const coordinates : {&x_, &y_, &z_}) coordinates->resize(ring.size());
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const Vector3d d = points_[ring[i]] - origin_;
            x_[i] = d.dot(u);
            y_[i] = d.dot(v);
            z_[i] = d.dot(w_);
        }
        Moments::find(x_, y_, z_, values);
    }

    // @returns how many there were, and the sum of their weights
    std::pair<int, double> add_slopes(const Neighbourhood& near, NormalEquations<kQuadratic>& equations) const {
        int count = 0;
        double weights = 0;
        for (int k = 0; k <= near.rings(); ++k)
            for (const int member : near.ring(k)) {
                const Vector3d& m = normals_[member];
                const double up = m.dot(w_);
                constexpr double kSteep = 0.3;
                if (up < kSteep) continue;
                const Vector3d d = points_[member] - origin_;
                const double x = d.dot(u_) / sx_, y = d.dot(v_) / sy_, share = kNormalWeight * weight(k, near.rings());
                equations.add({0, 1, 0, 2 * x, y, 0}, -m.dot(u_) / up * sx_, share);
                equations.add({0, 0, 1, 0, x, 2 * y}, -m.dot(v_) / up * sy_, share);
                count += 2;
                weights += 2 * share;
            }
        return {count, weights};
    }

    WedgeCurvature curvature(const HeightFit& f, double weights, double count, double free, int rings) const {
        const double fx = f.fx / sx_, fy = f.fy / sy_, fxx = f.fxx / (sx_ * sx_), fxy = f.fxy / (sx_ * sy_), fyy = f.fyy / (sy_ * sy_);
        const double E = 1 + fx * fx, F = fx * fy, G = 1 + fy * fy, length = std::sqrt(1 + fx * fx + fy * fy);
        const double L = fxx / length, M = fxy / length, N = fyy / length;
        const double det = E * G - F * F, H = (E * N - 2 * F * M + G * L) / (2 * det), K = (L * N - M * M) / det;
        const double root = std::sqrt(std::max(0.0, H * H - K));
        WedgeCurvature result;
        // Heights along the outer normal fall where the surface bends to the inside.
        result.k1 = -(H + (H < 0 ? -root : root));
        result.k2 = -(H - (H < 0 ? -root : root));
        result.normal = (w_ - fx * u_ - fy * v_) / length;
        result.rings = rings;
        // The error of the second derivative across, where the vertices are closest together, bounds the others.
        const double variance = f.residual / weights * count / std::max(1.0, free);
        result.error = std::max(std::sqrt(variance * f.variance_xx) / (sx_ * sx_), std::sqrt(variance * f.variance_yy) / (sy_ * sy_));
        return result;
    }

    std::span<const Vector3d> points_, normals_;
    Vector3d origin_, u_, v_, w_;
    double sx_ = 1, sy_ = 1;
    std::vector<double> x_, y_, z_;      // of one ring
    std::vector<Moments::Values> sums_;  // by ring
    int summed_ = 0;                     // rings
};

// Takes a fitted normal back to where the facets around it turn: where few vertices far away lead a fit astray they know better.
Vector3d among_facets(std::span<const Vector3d> points, const Connectivity& mesh, const Wedges& wedges, int wedge, const Vector3d& middle,
                      const Vector3d& fitted) {
    const double cosine = fitted.dot(middle);
    double least = 1;
    wedges.for_each(mesh, wedge, [&](int h) {
        if (cosine >= least) return;
        const Vector3d& p = points[mesh.origin(h)];
        const Vector3d n = (points[mesh.target(h)] - p).cross(points[mesh.apex(h)] - p);
        const double length = n.norm();
        if (length > 0) least = std::min(least, n.dot(middle) / length);
    });
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
    const Graph graph(points, mesh, wedges, normals);
    tbb::enumerable_thread_specific<Tools> tools([&] { return Tools{Neighbourhood(graph), Fitter(graph)}; });
    tbb::parallel_for(tbb::blocked_range<int>(0, graph.size(), 256), [&](const tbb::blocked_range<int>& range) {
        auto& [near, fitter] = tools.local();
        for (int i = range.begin(); i < range.end(); ++i) {
            const int wedge = graph.wedge[i];
            if (wedges.first[wedge] == Connectivity::kNone) continue;
            near.begin(i);
            result[wedge].normal = normals[wedge];
            bool fitted = false;
            while (near.rings() < options.most_rings && near.add_ring()) {
                if (near.rings() < options.rings) continue;
                // More rings are better only while they promise a smaller error.
                if (!fitted) fitter.begin(near);
                const std::optional<WedgeCurvature> fit = fitter.fit(near);
                if (!fit || (fitted && fit->error >= result[wedge].error)) break;
                result[wedge] = *fit;
                fitted = true;
                if (fit->error <= options.precision * std::max(std::abs(fit->k1), options.least_curvature)) break;
            }
            if (!fitted) {
                fitter.begin(near);
                if (const auto fit = fitter.fit(near)) result[wedge] = *fit;
            }
            result[wedge].normal = among_facets(points, mesh, wedges, wedge, normals[wedge], result[wedge].normal);
        }
    });
    return result;
}

}  // namespace gradus

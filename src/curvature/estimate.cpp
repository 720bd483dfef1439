#include "gradus/curvature/estimate.hpp"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
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

constexpr int kQuadratic = 6, kCubic = 10, kQuartic = 15;    // coefficients
constexpr int kEnoughForCubic = 15, kEnoughForQuartic = 17;  // vertices, the one in the middle among them
constexpr int kMostVertices = 400;
constexpr double kFarthestTurn =
    0.7;  // cosine of the angle between normals, 45 degrees: polynomials do not follow what turns farther
constexpr double kSameNoise =
    10;  // of the variance of residuals: with more rings it grows only where the surface is no polynomial
constexpr double kSigmas = 3, kLeastRoot = 0.1;  // of the bound on a variance that is told by few residuals
constexpr double kLead = 0.6;           // of the errors of a cubic and a quartic: a cubic ahead by less is so by chance
constexpr double kFall = 0.8;           // the outermost ring weighs 1 / (1 + kFall)
constexpr double kNormalWeight = 0.5;   // of a slope against a height, once both are lengths
constexpr double kTurnedWeight = 0.01;  // of the height of a neighbour that is turned farther
constexpr double kFlatWeight = 1e-4;    // of the height there that a bend on the way would lead to
constexpr double kRidge = 1e-12;        // keeps what the vertices do not tell near zero

// The wedges and their neighbours, numbered anew so that those near each other are near each other in memory too.
struct Graph {
    std::vector<int> wedge;                 // that has each number
    std::vector<Vector3d> points, normals;  // by number, as all below
    std::vector<char> open;                 // whether a feature or the boundary passes there
    std::vector<int> first, neighbours;     // those of one after those of another
    int most_neighbours = 0;

    Graph(std::span<const Vector3d> point_of, const Connectivity& mesh, const Wedges& wedges,
          std::span<const Vector3d> normal_of) {
        const std::size_t size = wedges.size();
        std::vector<int> number(size, -1);
        wedge.reserve(size);
        points.reserve(size);
        normals.reserve(size);
        open.reserve(size);
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
                open.push_back(0);
                if (last == Connectivity::kNone) continue;
                // Where the triangles go all around, the last neighbour is the first.
                if (const int end = number_of(wedges.of_corner[last]); end != neighbours[first.back()]) {
                    open.back() = 1;
                    neighbours.push_back(end);
                }
                most_neighbours = std::max(most_neighbours, static_cast<int>(neighbours.size()) - first.back());
            }
        }
        first.push_back(static_cast<int>(neighbours.size()));
    }
    int size() const { return static_cast<int>(wedge.size()); }
    std::span<const int> neighbours_of(int i) const {
        return std::span(neighbours).subspan(first[i], first[i + 1] - first[i]);
    }
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
        turns_ = false;
        normal_ = graph_.normals[middle];
        // Around a point all turn away: it is as sharp as they say.
        const auto around = graph_.neighbours_of(middle);
        const auto kept = std::count_if(around.begin(), around.end(),
                                        [&](int i) { return graph_.normals[i].dot(normal_) >= kFarthestTurn; });
        least_ = 2 * kept < std::ssize(around) ? -1 : kFarthestTurn;
    }
    // @returns whether there was anything to add
    bool add_ring() {
        const std::size_t end = size_;
        std::size_t size = end;
        for (; outer_ < end && size <= kMostVertices; ++outer_)
            for (const int i : graph_.neighbours_of(members_[outer_])) {
                // Whether it is new cannot be foretold: without a branch.
                members_[size] = i;
                const bool is_near = graph_.normals[i].dot(normal_) >= least_;
                size += stamp_[i] != now_ && is_near ? 1 : 0;
                turns_ = turns_ || !is_near;
                stamp_[i] = now_;
            }
        size_ = size;
        ends_.push_back(size);
        return size > end;
    }
    // Whether most of its neighbours are turned far.
    bool is_point() const { return least_ < 0; }
    // Whether there was a vertex left out as it is turned too far.
    bool turns() const { return turns_; }
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
    Vector3d normal_;  // of the one in the middle
    double least_ = -1;
    bool turns_ = false;
};

// Calls use(std::integral_constant k) for k from 0 to count - 1.
template <int count, class Use>
void unrolled(const Use& use) {
    const auto call = [&]<int... k>(std::integer_sequence<int, k...>) { (use(std::integral_constant<int, k>{}), ...); };
    call(std::make_integer_sequence<int, count>{});
}

// Two vertices at a time.
using Pair = Eigen::Array2d;

// Sums over vertices of x^i y^j and of z x^i y^j, up to what a least squares fit of a cubic or of a quartic asks of
// them, and of z^2. They are added up by ring, so that a larger fit takes nothing up again.
struct Moments {
    // By degree, those for cubics first.
    static constexpr int of_power(int i, int j) {
        const int degree = i + j, place = degree * (degree + 1) / 2 + j;
        return degree <= 6 ? place : place + kCubicSize - 28;
    }
    static constexpr int of_height(int i, int j) {
        const int degree = i + j, place = degree * (degree + 1) / 2 + j;
        return degree <= 3 ? 28 + place : kCubicSize + 17 + place - 10;
    }
    static constexpr int kSquare = 38, kCubicSize = 40, kSize = 62;  // one is always 0
    using Values = Eigen::Array<double, kSize, 1>;

    // For fits of that degree. @pre the same even number of x, y and z; what is beyond `count` is 0
    template <int degree>
    static void find(std::span<const double> xs, std::span<const double> ys, std::span<const double> zs,
                     std::size_t count, Values& values) {
        std::array<Pair, kSize> sums;
        sums.fill(Pair::Zero());
        for (std::size_t p = 0; p < xs.size(); p += 2) {
            const Pair x(xs[p], xs[p + 1]), y(ys[p], ys[p + 1]), z(zs[p], zs[p + 1]);
            Pair row = x;
            unrolled<2 * degree + 1>([&](auto j) {
                constexpr int least = j == 0 ? 1 : 0;  // 1 itself is not summed
                Pair power = row;
                unrolled<2 * degree + 1 - j - least>([&](auto i) {
                    sums[of_power(i + least, j)] += power;
                    power *= x;
                });
                row = j == 0 ? y : Pair(row * y);
            });
            row = z;
            unrolled<degree + 1>([&](auto j) {
                Pair power = row;
                unrolled<degree + 1 - j>([&](auto i) {
                    sums[of_height(i, j)] += power;
                    power *= x;
                });
                row *= y;
            });
            sums[kSquare] += z * z;
        }
        for (int k = 0; k < (degree == 3 ? kCubicSize : kSize); ++k) values[k] = sums[k][0] + sums[k][1];
        values[of_power(0, 0)] = static_cast<double>(count);
    }
};

// Exponents of x and y. Those of a cubic stand before the rest of a quartic: elimination passes the cubic fit on its
// way.
template <int n>
constexpr std::array<std::array<int, 2>, n> kTerms{};
template <>
constexpr std::array<std::array<int, 2>, kQuadratic> kTerms<kQuadratic>{
    {{0, 0}, {1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}}};
template <>
constexpr std::array<std::array<int, 2>, kCubic> kTerms<kCubic>{
    {{0, 0}, {3, 0}, {2, 1}, {1, 2}, {0, 3}, {1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}}};
template <>
constexpr std::array<std::array<int, 2>, kQuartic> kTerms<kQuartic>{{{0, 0},
                                                                     {3, 0},
                                                                     {2, 1},
                                                                     {1, 2},
                                                                     {0, 3},
                                                                     {1, 0},
                                                                     {0, 1},
                                                                     {2, 0},
                                                                     {1, 1},
                                                                     {0, 2},
                                                                     {4, 0},
                                                                     {3, 1},
                                                                     {2, 2},
                                                                     {1, 3},
                                                                     {0, 4}}};

// z of a height function and what its least squares left: z = ... + fx x + fy y + (fxx x^2 + 2 fxy x y + fyy y^2) / 2.
struct HeightFit {
    double fx, fy, fxx, fxy, fyy;
    double residual;                  // sum of weighted squares
    double variance_xx, variance_yy;  // of fxx and fyy, where heights of weight 1 have a variance of 1
};

// Normal equations of n coefficients, upper triangle, with the right side as the last column and the square of the
// heights below it.
template <int n>
class NormalEquations {
  public:
    explicit NormalEquations(const Moments::Values& moments) {
        constexpr auto& terms = kTerms<n>;
        unrolled<n>([&](auto r) {
            rows_[r].fill(Pair::Zero());
            unrolled<n - r>([&](auto i) {
                constexpr int c = r + i,
                              power = Moments::of_power(terms[r][0] + terms[c][0], terms[r][1] + terms[c][1]);
                at(r, c) = moments[power];
            });
            at(r, n) = moments[Moments::of_height(terms[r][0], terms[r][1])];
        });
        rows_[n].fill(Pair::Zero());
        at(n, n) = moments[Moments::kSquare];
        const double ridge = kRidge * at(0, 0);
        for (int k = 0; k < n; ++k) at(k, k) += kRidge * at(k, k) + ridge;
    }
    // One more equation: row . coefficients = value.
    void add(const std::array<double, n>& row, double value, double weight) {
        for (int r = 0; r < n; ++r) {
            for (int c = r; c < n; ++c) at(r, c) += weight * row[r] * row[c];
            at(r, n) += weight * row[r] * value;
        }
        at(n, n) += weight * value * value;
    }
    template <int from, int to>
    void eliminate() {
        unrolled<to - from>([&](auto step) {
            constexpr int k = from + step;
            inverse_[k] = 1 / at(k, k);
            unrolled<n - k>([&](auto i) {
                constexpr int r = k + 1 + i;
                const double share = at(k, r) * inverse_[k];
                unrolled<kWidth - r / 2>([&](auto c) { rows_[r][r / 2 + c] -= share * rows_[k][r / 2 + c]; });
            });
        });
    }
    // The fit of the first m terms. @pre those are eliminated, and no more
    template <int m>
    HeightFit fit() {
        constexpr int x = n == kQuadratic ? 1 : 5, xx = x + 2, yy = x + 4;
        std::array<double, m> f;
        for (int k = m - 1; k >= x; --k) {
            double sum = at(k, n);
            for (int c = k + 1; c < m; ++c) sum -= at(k, c) * f[c];
            f[k] = sum * inverse_[k];
        }
        return {f[x],
                f[x + 1],
                2 * f[xx],
                f[xx + 1],
                2 * f[yy],
                std::max(0.0, at(n, n)),
                4 * variance<m, xx>(),
                4 * variance<m, yy>()};
    }

  private:
    static constexpr int kWidth = n / 2 + 1;  // pairs of n + 1 columns
    double& at(int r, int c) { return rows_[r][c / 2][c % 2]; }

    // Of coefficient i among m: an element on the diagonal of the inverse, by a column of that of the triangular
    // factor.
    template <int m, int i>
    double variance() {
        std::array<double, m> column{};
        column[i] = 1;
        double sum = inverse_[i];
        for (int k = i + 1; k < m; ++k) {
            for (int c = i; c < k; ++c) column[k] -= at(c, k) * inverse_[c] * column[c];
            sum += column[k] * column[k] * inverse_[k];
        }
        return sum;
    }

    std::array<std::array<Pair, kWidth>, n + 1> rows_;
    std::array<double, n> inverse_;  // of the pivots
};

// What the residuals of a fit tell of its error.
struct Residuals {
    double variance = 0;  // of a height of weight 1
    double degrees = 0;   // of freedom
    double error = 0;     // standard error of the second derivatives where that variance is 1

    double standard_error() const { return std::sqrt(variance) * error; }
    // What it is at most: with few degrees of freedom residuals may be small by chance. By the quantile of chi squared
    // [Wilson, Hilferty 1931].
    double largest_error() const {
        const double spread = 2 / (9 * std::max(1.0, degrees)), root = 1 - spread - kSigmas * std::sqrt(spread);
        return standard_error() / std::sqrt(std::pow(std::max(root, kLeastRoot), 3));
    }
};

struct Fit {
    WedgeCurvature curvature;  // without its error
    Residuals residuals;
};

class Fitter {
  public:
    explicit Fitter(const Graph& graph) : graph_(graph) {}

    // For fits to this neighbourhood, as it is and with more rings: the frame it gives is kept.
    void begin(const Neighbourhood& near) {
        place(near.members());
        summed_ = 0;
        first_rings_ = near.rings();
        largest_ = near.is_point() || std::ssize(near.members()) < kEnoughForCubic
                       ? 0
                       : largest_normal_curvature(near.members());
    }
    // @pre begun with this neighbourhood
    std::optional<Fit> fit(const Neighbourhood& near) {
        const int rings = near.rings();
        const double count = static_cast<double>(near.members().size());
        if (w_.isZero() || count < 3) return std::nullopt;
        // A quartic is for the first fit: with it or without, the surface is known there, or there is noise.
        const bool with_quartic = rings == first_rings_ && count >= kEnoughForQuartic;
        if (rings >= static_cast<int>(sums_.size())) sums_.resize(rings + 1);
        for (; summed_ <= rings; ++summed_) {
            see(near.ring(summed_));
            if (with_quartic)
                Moments::find<4>(x_, y_, z_, near.ring(summed_).size(), sums_[summed_]);
            else
                Moments::find<3>(x_, y_, z_, near.ring(summed_).size(), sums_[summed_]);
        }
        Moments::Values moments = weight(0, rings) * sums_[0];
        for (int k = 1; k <= rings; ++k) {
            if (with_quartic)
                moments += weight(k, rings) * sums_[k];
            else
                moments.head<Moments::kCubicSize>() += weight(k, rings) * sums_[k].head<Moments::kCubicSize>();
        }
        if (with_quartic) {
            NormalEquations<kQuartic> equations(moments);
            equations.eliminate<0, kCubic>();
            const HeightFit cubic = equations.fit<kCubic>();
            const Residuals of_cubic = residuals(cubic, moments[0], count, kCubic);
            equations.eliminate<kCubic, kQuartic>();
            const HeightFit quartic = equations.fit<kQuartic>();
            const Residuals of_quartic = residuals(quartic, moments[0], count, kQuartic);
            // It is better where the surface rather than noise keeps the vertices off the cubic.
            if (kLead * of_quartic.standard_error() < of_cubic.standard_error())
                return Fit{curvature(quartic, rings), of_quartic};
            return Fit{curvature(cubic, rings), of_cubic};
        }
        if (count >= kEnoughForCubic) {
            NormalEquations<kCubic> equations(moments);
            equations.eliminate<0, kCubic>();
            const HeightFit cubic = equations.fit<kCubic>();
            return Fit{curvature(cubic, rings), residuals(cubic, moments[0], count, kCubic)};
        }
        NormalEquations<kQuadratic> equations(moments);
        const auto [slopes, weights] = add_slopes(near, equations);
        heed_turned(near.members().front(), equations);
        equations.eliminate<0, kQuadratic>();
        const HeightFit quadratic = equations.fit<kQuadratic>();
        return Fit{curvature(quadratic, rings), residuals(quadratic, moments[0] + weights, count + slopes, kQuadratic)};
    }

  private:
    static double weight(int ring, int rings) {
        const double share = static_cast<double>(ring) / rings;
        return 1 / (1 + kFall * share * share);
    }

    // Coordinates along the longer and the shorter spread of the vertices, each over that spread.
    void place(std::span<const int> members) {
        origin_ = graph_.points[members.front()];
        w_ = graph_.normals[members.front()];
        if (w_.isZero()) return;
        const Vector3d u = any_tangent(w_), v = w_.cross(u);
        double xx = 0, xy = 0, yy = 0;
        for (const int i : members) {
            const Vector3d d = graph_.points[i] - origin_;
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

    // Of the quadratic through the origin and along the plane that is closest to some vertices, unit 1 / length.
    double largest_normal_curvature(std::span<const int> members) const {
        Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
        Vector3d heights = Vector3d::Zero();
        for (const int i : members) {
            const Vector3d d = graph_.points[i] - origin_;
            const double x = d.dot(u_) / sx_, y = d.dot(v_) / sy_;
            const Vector3d terms(x * x / 2, x * y, y * y / 2);
            squares += terms * terms.transpose();
            heights += d.dot(w_) * terms;
        }
        squares.diagonal().array() += kRidge * squares.trace();
        const Vector3d second = squares.llt().solve(heights).cwiseQuotient(Vector3d(sx_ * sx_, sx_ * sy_, sy_ * sy_));
        const double mean = (second[0] + second[2]) / 2, half = std::hypot((second[0] - second[2]) / 2, second[1]);
        return mean + std::copysign(half, mean);
    }

    // Heights z are taken less k z^2 / 2, which does not change curvatures: so spheres and cylinders of curvature k are
    // quadratics, as far as they may turn. Quadratics are fitted to slopes too, and those over the plane.
    void see(std::span<const int> ring) {
        const Vector3d u = u_ / sx_, v = v_ / sy_;
        for (std::vector<double>* const coordinates : {&x_, &y_, &z_})
            coordinates->assign((ring.size() + 1) / 2 * 2, 0);
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const Vector3d d = graph_.points[ring[i]] - origin_;
            x_[i] = d.dot(u);
            y_[i] = d.dot(v);
            const double z = d.dot(w_);
            z_[i] = z - largest_ / 2 * z * z;
        }
    }

    // @returns how many there were, and the sum of their weights
    std::pair<int, double> add_slopes(const Neighbourhood& near, NormalEquations<kQuadratic>& equations) const {
        int count = 0;
        double weights = 0;
        for (int k = 0; k <= near.rings(); ++k)
            for (const int member : near.ring(k)) {
                const Vector3d& m = graph_.normals[member];
                const double up = m.dot(w_);
                constexpr double kSteep = 0.3;
                if (up < kSteep) continue;
                const Vector3d d = graph_.points[member] - origin_;
                const double x = d.dot(u_) / sx_, y = d.dot(v_) / sy_, share = kNormalWeight * weight(k, near.rings());
                equations.add({0, 1, 0, 2 * x, y, 0}, -m.dot(u_) / up * sx_, share);
                equations.add({0, 0, 1, 0, x, 2 * y}, -m.dot(v_) / up * sy_, share);
                count += 2;
                weights += 2 * share;
            }
        return {count, weights};
    }

    // Neighbours that are turned too far lie on the surface all the same, and up to them it does not bend: the facets
    // do not. Across needles nothing else tells.
    void heed_turned(int middle, NormalEquations<kQuadratic>& equations) const {
        for (const int i : graph_.neighbours_of(middle)) {
            if (graph_.normals[i].dot(w_) >= kFarthestTurn) continue;
            const Vector3d d = graph_.points[i] - origin_;
            const double x = d.dot(u_) / sx_, y = d.dot(v_) / sy_;
            equations.add({1, x, y, x * x, x * y, y * y}, d.dot(w_), kTurnedWeight);
            equations.add({0, 0, 0, x * x, x * y, y * y}, 0, kFlatWeight);
        }
    }

    // Across, where the vertices are closest together, the error of second derivatives bounds that of the others.
    Residuals residuals(const HeightFit& f, double weights, double count, int coefficients) const {
        const double degrees = std::max(1.0, count - coefficients);
        return {f.residual / weights * count / degrees, degrees,
                std::max(std::sqrt(f.variance_xx) / (sx_ * sx_), std::sqrt(f.variance_yy) / (sy_ * sy_))};
    }

    WedgeCurvature curvature(const HeightFit& f, int rings) const {
        const double fx = f.fx / sx_, fy = f.fy / sy_, fxx = f.fxx / (sx_ * sx_), fxy = f.fxy / (sx_ * sy_),
                     fyy = f.fyy / (sy_ * sy_);
        const double E = 1 + fx * fx, F = fx * fy, G = 1 + fy * fy, length = std::sqrt(1 + fx * fx + fy * fy);
        const double L = fxx / length, M = fxy / length, N = fyy / length;
        const double det = E * G - F * F, H = (E * N - 2 * F * M + G * L) / (2 * det), K = (L * N - M * M) / det;
        const double root = std::sqrt(std::max(0.0, H * H - K));
        // Heights along the outer normal fall where the surface bends to the inside.
        return {-(H + (H < 0 ? -root : root)), -(H - (H < 0 ? -root : root)), (w_ - fx * u_ - fy * v_) / length, 0,
                rings};
    }

    const Graph& graph_;
    Vector3d origin_, u_, v_, w_;
    double sx_ = 1, sy_ = 1;
    std::vector<double> x_, y_, z_;      // of one ring
    std::vector<Moments::Values> sums_;  // by ring
    int summed_ = 0, first_rings_ = 0;
    double largest_ = 0;  // curvature about there, 0 where heights are taken as they are
};

// Takes a fitted normal back to where the facets around it turn: where few vertices far away lead a fit astray they
// know better.
Vector3d among_facets(std::span<const Vector3d> points, const Connectivity& mesh, const Wedges& wedges, int wedge,
                      const Vector3d& middle, const Vector3d& fitted) {
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

namespace {

// Fits to the wedges of a graph.
class Estimator {
  public:
    Estimator(const Graph& graph, const EstimateOptions& options)
        : graph_(graph), options_(options), tools_([&] {
              return Tools{Neighbourhood(graph), Fitter(graph)};
          }) {}

    // With as few rings as a fit takes. @pre the wedge has triangles
    std::optional<Fit> first_fit(int i) {
        auto& [near, fitter] = tools_.local();
        begin(near, fitter, i);
        return fitter.fit(near);
    }

    // With more rings than the first fit, while they promise a smaller error and what is left is noise as it was
    // before.
    WedgeCurvature best_of(int i, const Fit& first, double noise) {
        WedgeCurvature best = first.curvature;
        if (is_precise(best)) return best;
        auto& [near, fitter] = tools_.local();
        begin(near, fitter, i);
        fitter.fit(near);
        // No polynomial follows what turns far, with more rings less so.
        while (!near.turns() && !is_precise(best) && near.rings() < options_.most_rings && near.add_ring()) {
            std::optional<Fit> fit = fitter.fit(near);
            if (!fit) break;
            fit->curvature.error = fit->residuals.largest_error();
            if (fit->curvature.error >= best.error || fit->residuals.variance > kSameNoise * noise) break;
            best = fit->curvature;
        }
        return best;
    }

  private:
    struct Tools {
        Neighbourhood near;
        Fitter fitter;
    };

    bool is_precise(const WedgeCurvature& c) const {
        return c.error <= options_.precision * std::max(std::abs(c.k1), options_.least_curvature);
    }

    // Beside a feature, or what turns far, few vertices near by, with their normals, tell more than many far away, all
    // on one side.
    void begin(Neighbourhood& near, Fitter& fitter, int i) const {
        near.begin(i);
        while (near.rings() < options_.most_rings && near.add_ring())
            if (near.rings() >= options_.rings &&
                (graph_.open[i] || near.turns() || near.members().size() >= kEnoughForCubic))
                break;
        fitter.begin(near);
    }

    const Graph& graph_;
    const EstimateOptions& options_;
    tbb::enumerable_thread_specific<Tools> tools_;
};

// Those of a wedge with the noise pooled over its neighbours, as far as these have fits of the same kind: what stands
// alone may be small by chance.
Residuals pooled(const Graph& graph, std::span<const Residuals> residuals, int i) {
    Residuals sum = residuals[i];
    double squares = sum.variance * sum.degrees;
    for (const int k : graph.neighbours_of(i)) {
        if (graph.open[k] != graph.open[i]) continue;
        squares += residuals[k].variance * residuals[k].degrees;
        sum.degrees += residuals[k].degrees;
    }
    sum.variance = std::max(sum.variance, squares / std::max(1.0, sum.degrees));
    return sum;
}

}  // namespace

std::vector<WedgeCurvature> estimate_curvature(std::span<const Vector3d> points, const Connectivity& mesh,
                                               const Wedges& wedges, std::span<const Vector3d> normals,
                                               const EstimateOptions& options) {
    std::vector<WedgeCurvature> result(wedges.size());
    const Graph graph(points, mesh, wedges, normals);
    Estimator estimator(graph, options);
    const auto for_each = [&](const auto& use) {
        tbb::parallel_for(tbb::blocked_range<int>(0, graph.size(), 256), [&](const tbb::blocked_range<int>& range) {
            for (int i = range.begin(); i < range.end(); ++i)
                if (wedges.first[graph.wedge[i]] != Connectivity::kNone) use(i, graph.wedge[i]);
        });
    };
    std::vector<std::optional<Fit>> first(graph.size());
    std::vector<Residuals> residuals(graph.size());
    for_each([&](int i, int) {
        first[i] = estimator.first_fit(i);
        if (first[i]) residuals[i] = first[i]->residuals;
    });
    for_each([&](int i, int wedge) {
        result[wedge].normal = normals[wedge];
        if (first[i]) {
            const Residuals all = pooled(graph, residuals, i);
            first[i]->curvature.error = all.largest_error();
            result[wedge] = estimator.best_of(i, *first[i], all.variance);
        }
        result[wedge].normal = among_facets(points, mesh, wedges, wedge, normals[wedge], result[wedge].normal);
    });
    return result;
}

}  // namespace gradus

#include "gradus/gradation/gradient.hpp"

#include "gradus/gradation/measures.hpp"
#include "monotone_queue.hpp"
#include "vertex_graph.hpp"

#include <optional>
#include <queue>
#include <tuple>

namespace gradus {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// What the result may exceed the bound by, and what triggers a correction: half of it, so that both can be met.
constexpr double kTolerance = 1e-9;
// Between needles corrections may go back and forth in ever smaller steps: a triangle that came back this often is made
// flatter than it has to be, by four times as much each time, and at most by this share of the bound.
constexpr int kPatience = 4;
constexpr double kMostSlack = 0.1;

/// Raising a size by less than this share of it is not worth a look at its neighbours; nor are more sweeps.
constexpr double kRaise = 1e-4;
constexpr int kRaiseSweeps = 20;

/// The triangle ABC seen from C: e = |AB|, s the foot of C on AB (from A), d its distance from AB.
struct Frame {
    double e, s, d;
};

/// A triangle laid flat: its corners at (0, 0), (e, 0) and (s, d).
struct FlatTriangle {
    double e, s, d;

    FlatTriangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
        const Eigen::Vector3d ab = b - a, ac = c - a;
        e = ab.norm();
        s = e > 0 ? ab.dot(ac) / e : 0;
        d = e > 0 ? ab.cross(ac).norm() / e : ac.norm();
    }

    double area2() const { return e * d; }
    Eigen::Vector2d corner(int k) const {
        return k == 0 ? Eigen::Vector2d(0, 0) : k == 1 ? Eigen::Vector2d(e, 0) : Eigen::Vector2d(s, d);
    }

    /// Corner `to` seen from the corners a and b.
    Frame seen_from(int a, int b, int to) const {
        if (a == 0 && b == 1) return {e, s, d};
        const Eigen::Vector2d ab = corner(b) - corner(a), ac = corner(to) - corner(a);
        const double length = ab.norm();
        return length > 0 ? Frame{length, ab.dot(ac) / length, area2() / length} : Frame{0, 0, ac.norm()};
    }

    /// Gradient of the interpolant of three sizes. @pre area2() > 0
    Eigen::Vector2d gradient(double h0, double h1, double h2) const {
        const double along = (h1 - h0) / e;
        return {along, (h2 - h0 - along * s) / d};
    }
};

/// The mesh as triangles, and the triangles at each vertex.
struct Corners {
    std::span<const Eigen::Vector3d> points;
    std::vector<Triangle> triangles;
    std::vector<FlatTriangle> flat;
    std::vector<int> first;
    std::vector<int> around;

    explicit Corners(const TriMesh& mesh) : Corners(points_of(mesh), triangles_of(mesh)) {}
    Corners(std::span<const Eigen::Vector3d> all, std::vector<Triangle> of)
        : points(all), triangles(std::move(of)), first(points.size() + 2, 0) {
        for (const Triangle& triangle : triangles)
            for (const int v : triangle) ++first[v + 2];
        for (std::size_t v = 0; v < points.size(); ++v) first[v + 2] += first[v + 1];
        around.resize(3 * triangles.size());
        for (std::size_t t = 0; t < triangles.size(); ++t)
            for (const int v : triangles[t]) around[first[v + 1]++] = static_cast<int>(t);
        first.pop_back();
        flat.reserve(triangles.size());
        for (const auto& [a, b, c] : triangles) flat.emplace_back(points[a], points[b], points[c]);
    }

    /// Which corner of triangle t vertex v is.
    int corner(int t, int v) const { return triangles[t][0] == v ? 0 : triangles[t][1] == v ? 1 : 2; }
    std::span<const int> at(int v) const { return {around.data() + first[v], around.data() + first[v + 1]}; }
};

/// Size that reaches C from the segment AB with sizes a, b: the least of h(X) + bound |CX| over X on AB.
double size_across(const Frame& f, double a, double b, double bound) {
    const double from_a = a + bound * std::hypot(f.s, f.d), from_b = b + bound * std::hypot(f.e - f.s, f.d);
    const double ends = std::min(from_a, from_b);
    const double k = (b - a) / (bound * f.e);
    if (!(std::abs(k) < 1)) return ends;
    const double x = f.s - f.d * k / std::sqrt(1 - k * k);
    if (x <= 0 || x >= f.e) return ends;
    return std::min(ends, a + (b - a) * (x / f.e) + bound * std::hypot(f.s - x, f.d));
}

/// Largest size at C that a gradient of `bound` allows with sizes a, b at the other corners; nothing where A and B
/// alone are too steep.
std::optional<double> largest_at(const Frame& f, double a, double b, double bound) {
    if (f.e == 0) return a == b ? std::optional(a + bound * f.d) : std::nullopt;
    const double k = (b - a) / f.e, room = bound * bound - k * k;
    if (room < 0) return std::nullopt;
    return a + k * f.s + f.d * std::sqrt(room);
}

/// Two corners rise by y above the smallest one, with the gradient y[0] g[0] + y[1] g[1]. The nearest rises whose
/// gradient has the norm `bound`, where a change of y[1] counts `weight` times.
/// @pre the gradient is longer than the bound
std::array<double, 2> nearest_rises(const std::array<Eigen::Vector2d, 2>& g, const std::array<double, 2>& y,
                                    double weight, double bound) {
    // With z = (y[0], root y[1]) it is the nearest point of the ellipse z.Qz = bound^2, (I + lambda Q)^-1 z.
    const double root = std::sqrt(weight);
    const double q00 = g[0].squaredNorm(), q01 = g[0].dot(g[1]) / root, q11 = g[1].squaredNorm() / weight;
    const double mean = .5 * (q00 + q11), half = .5 * (q00 - q11), radius = std::hypot(half, q01);
    const double large = mean + radius, small = std::max(mean - radius, 0.);
    const double angle = .5 * std::atan2(q01, half), c = std::cos(angle), s = std::sin(angle);
    const double p = c * y[0] + s * root * y[1], q = -s * y[0] + c * root * y[1];
    double lambda = 0;
    // Newton on 1 / norm(lambda), which is nearly linear and concave: from 0 it rises to the root in a few steps.
    for (int i = 0; i < 60; ++i) {
        const double P = p / (1 + lambda * large), Q = q / (1 + lambda * small);
        const double norm2 = large * P * P + small * Q * Q;
        const double slope =
            large * large * P * P / (1 + lambda * large) + small * small * Q * Q / (1 + lambda * small);
        const double step = norm2 / slope * (std::sqrt(norm2) / bound - 1);
        lambda += step;
        if (std::abs(step) <= 1e-12 * lambda) break;
    }
    const double P = p / (1 + lambda * large), Q = q / (1 + lambda * small);
    return {c * P - s * Q, (s * P + c * Q) / root};
}

class GradientLimiter {
  public:
    GradientLimiter(Corners corners, double bound, std::span<double> size, std::vector<char> required)
        : corners_(std::move(corners)),
          bound_(bound),
          size_(size),
          input_(size.begin(), size.end()),
          required_(std::move(required)) {}

    void march();
    void flatten();
    void raise();
    GradientReduction report();

  private:
    /// Triangles in the order of their corners' sizes, smallest first: an order that does not depend on how they are
    /// numbered.
    struct Steep {
        std::array<double, 3> sizes;
        int triangle;
        bool operator<(const Steep& other) const {
            return std::tie(other.sizes, other.triangle) < std::tie(sizes, triangle);
        }
    };

    Steep steep(int t) const {
        const auto& [a, b, c] = corners_.triangles[t];
        Steep s{{size_[a], size_[b], size_[c]}, t};
        std::sort(s.sizes.begin(), s.sizes.end());
        return s;
    }
    bool may_lower(int v) const { return required_.empty() || !required_[v]; }
    /// Norm of the gradient of a triangle; without area, the largest slope of its edges.
    double steepness(int t) const;
    /// What `steepness` can be off by, because sizes are rounded.
    double rounding(int t) const;
    bool too_steep(int t) const {
        const double steep = steepness(t), most = bound_ * (1 + kTolerance / 2);
        return steep > most && steep > most + rounding(t);
    }
    /// Rises of the corners b and c of triangle t above its smallest corner a (each 0, 1 or 2), at least cost, after
    /// which the triangle is no steeper than `bound`.
    std::array<double, 2> flat_rises(int t, int a, int b, int c, double bound) const;
    /// Lowers the corners of a triangle that is steeper than `bound`. @returns the corners that changed, -1 for none
    std::array<int, 2> flatten_triangle(int t, double bound);
    /// Largest size at a vertex that its input and its triangles allow.
    double ceiling(int v) const;

    Corners corners_;
    double bound_;
    std::span<double> size_;
    std::vector<double> input_;
    std::vector<char> required_;
    GradientReduction result_;
};

void GradientLimiter::march() {
    double low = kInfinity, high = 0;
    for (const double h : size_) {
        low = std::min(low, h);
        if (!std::isinf(h)) high = std::max(high, h);
    }
    if (std::isinf(low)) return;
    detail::MonotoneQueue queue(low, std::max(high, 1024 * low), size_.size());
    // Nothing is lowered across a triangle whose gradient keeps the bound: what reaches C from a point X of AB is
    // h(X) + bound |CX| >= h(X) + |grad h| |CX| >= h(C).
    std::vector<char> queued(size_.size(), 0);
    for (int t = 0; t < std::ssize(corners_.triangles); ++t) {
        if (steepness(t) <= bound_ * (1 - kTolerance)) continue;
        for (const int v : corners_.triangles[t])
            if (!queued[v] && !std::isinf(size_[v])) queued[v] = 1, queue.push(size_[v], v);
    }

    const long most = kGradientVisits * static_cast<long>(size_.size());
    double h;
    int v;
    while (queue.pop(h, v)) {
        if (h != size_[v]) continue;
        if (++result_.visits > most) {
            result_.converged = false;
            return;
        }
        for (const int t : corners_.at(v)) {
            const Triangle& triangle = corners_.triangles[t];
            const int i = corners_.corner(t, v);
            for (const auto& [j, k] : {std::pair{(i + 1) % 3, (i + 2) % 3}, std::pair{(i + 2) % 3, (i + 1) % 3}}) {
                const int c = triangle[k];
                // What reaches C is larger than the smaller end it comes from, and that end is popped before.
                if (size_[c] <= h || !may_lower(c)) continue;
                const double reached = size_across(corners_.flat[t].seen_from(i, j, k), h, size_[triangle[j]], bound_);
                // A step below rounding would only go round in circles.
                if (!(reached < size_[c] * (1 - 4e-16))) continue;
                size_[c] = reached;
                queue.push(reached, c);
            }
        }
    }
}

double GradientLimiter::steepness(int t) const {
    const auto& [a, b, c] = corners_.triangles[t];
    const FlatTriangle& flat = corners_.flat[t];
    if (size_[a] == size_[b] && size_[a] == size_[c]) return 0;
    if (flat.area2() > 0) return flat.gradient(size_[a], size_[b], size_[c]).norm();
    return std::max({h_variation(flat.e, size_[a], size_[b]),
                     h_variation(std::hypot(flat.e - flat.s, flat.d), size_[b], size_[c]),
                     h_variation(std::hypot(flat.s, flat.d), size_[c], size_[a])});
}

double GradientLimiter::rounding(int t) const {
    const auto& [a, b, c] = corners_.triangles[t];
    const FlatTriangle& flat = corners_.flat[t];
    if (flat.area2() == 0) return 0;
    const double longest = std::max({flat.e, std::hypot(flat.e - flat.s, flat.d), std::hypot(flat.s, flat.d)});
    return 4e-16 * std::max({size_[a], size_[b], size_[c]}) * longest / flat.area2();
}

std::array<double, 2> GradientLimiter::flat_rises(int t, int a, int b, int c, double bound) const {
    const FlatTriangle& flat = corners_.flat[t];
    const auto h = [&](int corner) { return size_[corners_.triangles[t][corner]]; };
    const std::array<double, 2> rise{h(b) - h(a), h(c) - h(a)};
    if (flat.area2() == 0) return rise;
    const auto unit_rise = [&](int corner) { return flat.gradient(corner == 0, corner == 1, corner == 2); };
    // A size h asks for h^-2 elements per area, so lowering it costs in proportion to h^-3.
    std::array<double, 2> flatter = nearest_rises({unit_rise(b), unit_rise(c)}, rise, std::pow(h(b) / h(c), 3), bound);
    // Sizes are only lowered: where the nearest point would raise one corner, it stays and the other takes what is
    // left.
    const auto left_for = [&](int corner, int other) {
        return largest_at(flat.seen_from(a, other, corner), h(a), h(other), bound).value_or(h(a)) - h(a);
    };
    if (flatter[0] > rise[0]) {
        flatter = {rise[0], left_for(c, b)};
    } else if (flatter[1] > rise[1]) {
        flatter = {left_for(b, c), rise[1]};
    }
    return {std::clamp(flatter[0], 0., rise[0]), std::clamp(flatter[1], 0., rise[1])};
}

std::array<int, 2> GradientLimiter::flatten_triangle(int t, double bound) {
    const Triangle& triangle = corners_.triangles[t];
    std::array<int, 3> rank{0, 1, 2};
    std::sort(rank.begin(), rank.end(), [&](int i, int j) { return size_[triangle[i]] < size_[triangle[j]]; });
    const int a = triangle[rank[0]], b = triangle[rank[1]], c = triangle[rank[2]];
    if (may_lower(b) && may_lower(c)) {
        const double b_before = size_[b], c_before = size_[c];
        const std::array<double, 2> rise = flat_rises(t, rank[0], rank[1], rank[2], bound);
        const auto lower_to = [&](double share) {
            size_[b] = std::min(b_before, size_[a] + share * rise[0]);
            size_[c] = std::min(c_before, size_[a] + share * rise[1]);
        };
        lower_to(1);
        // What is still missing (rounding, or a triangle without area): the gradient is proportional to both rises
        // together.
        const double left = steepness(t);
        if (left > bound) lower_to(bound / left);
        return {size_[b] < b_before ? b : -1, size_[c] < c_before ? c : -1};
    }
    // One of the two is required: the other takes what that leaves, but never less than the smallest corner.
    const int free = may_lower(b) ? 1 : 2, fixed = 3 - free;
    const int v = triangle[rank[free]];
    if (!may_lower(v)) return {-1, -1};
    const Frame frame = corners_.flat[t].seen_from(rank[0], rank[fixed], rank[free]);
    const std::optional<double> most = largest_at(frame, size_[a], size_[triangle[rank[fixed]]], bound);
    if (!most || *most < size_[a] || *most >= size_[v]) return {-1, -1};
    size_[v] = *most;
    return {v, -1};
}

void GradientLimiter::flatten() {
    // Corrections flow from small sizes to large ones, so triangles with small corners come first.
    std::priority_queue<Steep> queue;
    std::vector<char> queued(corners_.triangles.size(), 0);
    std::vector<int> times(corners_.triangles.size(), 0);
    const int n = static_cast<int>(corners_.triangles.size());
    for (int t = 0; t < n; ++t)
        if (too_steep(t)) {
            queue.push(steep(t));
            queued[t] = 1;
        }
    const long most = result_.visits + kGradientVisits * n;
    while (!queue.empty()) {
        const int t = queue.top().triangle;
        queue.pop();
        queued[t] = 0;
        if (!too_steep(t)) continue;
        if (++result_.visits > most) {
            result_.converged = false;
            return;
        }
        const double slack =
            ++times[t] > kPatience ? std::min(std::ldexp(kTolerance, 2 * (times[t] - kPatience)), kMostSlack) : 0;
        for (const int v : flatten_triangle(t, bound_ * (1 - slack))) {
            if (v < 0) continue;
            for (const int s : corners_.at(v))
                if (!queued[s] && s != t && too_steep(s)) {
                    queue.push(steep(s));
                    queued[s] = 1;
                }
        }
    }
}

double GradientLimiter::ceiling(int v) const {
    double most = input_[v];
    for (const int t : corners_.at(v)) {
        const int k = corners_.corner(t, v), i = (k + 1) % 3, j = (k + 2) % 3;
        const Triangle& triangle = corners_.triangles[t];
        const auto allowed =
            largest_at(corners_.flat[t].seen_from(i, j, k), size_[triangle[i]], size_[triangle[j]], bound_);
        most = std::min(most, allowed.value_or(size_[v]));
        if (most <= size_[v]) break;
    }
    return most;
}

void GradientLimiter::raise() {
    std::vector<int> order;
    for (std::size_t v = 0; v < size_.size(); ++v)
        if (size_[v] < input_[v]) order.push_back(static_cast<int>(v));
    std::sort(order.begin(), order.end(), [&](int p, int q) { return std::tie(size_[p], p) < std::tie(size_[q], q); });
    // After the first sweep only a vertex with a raised neighbour can have more room.
    std::vector<char> active(size_.size(), 1);
    for (int sweep = 0; sweep < kRaiseSweeps && !order.empty(); ++sweep) {
        std::vector<char> next(size_.size(), 0);
        for (const int v : order) {
            if (!active[v]) continue;
            const double most = ceiling(v);
            if (!(most > size_[v] * (1 + kRaise))) continue;
            size_[v] = most;
            for (const int t : corners_.at(v))
                for (const int w : corners_.triangles[t])
                    if (w != v) next[w] = 1;
        }
        active.swap(next);
        if (std::count(active.begin(), active.end(), 1) == 0) break;
    }
}

GradientReduction GradientLimiter::report() {
    for (std::size_t v = 0; v < size_.size(); ++v) {
        if (!(size_[v] < input_[v])) continue;
        ++result_.lowered;
        result_.largest_factor = std::max(result_.largest_factor, input_[v] / size_[v]);
    }
    for (int t = 0; t < static_cast<int>(corners_.triangles.size()); ++t) {
        const double g = steepness(t);
        if (g > result_.gradient_max) {
            result_.gradient_max = g;
            result_.gradient_triangle = t;
        }
        if (g <= bound_ * (1 + kTolerance)) continue;
        ++result_.above_bound;
        const Triangle& triangle = corners_.triangles[t];
        if (std::any_of(triangle.begin(), triangle.end(), [&](int v) { return !may_lower(v); }))
            result_.conflicts.push_back(t);
    }
    return result_;
}

GradientLimiter make_limiter(const TriMesh& mesh, double bound, std::span<double> size, std::span<const int> required,
                             const char* function) {
    detail::require_above(bound, 0, "gradient bound", function);
    detail::require_sizes(mesh, size, function);
    return {Corners(mesh), bound, size, detail::required_flags(mesh, size, required, function)};
}

GradientReduction limit(GradientLimiter limiter) {
    limiter.march();
    limiter.flatten();
    limiter.raise();
    return limiter.report();
}

}  // namespace

GradientReduction march_gradient(const TriMesh& mesh, double bound, std::span<double> size,
                                 std::span<const int> required) {
    GradientLimiter limiter = make_limiter(mesh, bound, size, required, "march_gradient");
    limiter.march();
    return limiter.report();
}

GradientReduction limit_gradient(const TriMesh& mesh, double bound, std::span<double> size,
                                 std::span<const int> required) {
    return limit(make_limiter(mesh, bound, size, required, "limit_gradient"));
}

GradientReduction limit_gradient(std::span<const Eigen::Vector3d> points, std::span<const Triangle> triangles,
                                 double bound, std::span<double> size) {
    detail::require_above(bound, 0, "gradient bound", "limit_gradient");
    detail::require_sizes(points.size(), size, "limit_gradient");
    return limit({Corners(points, {triangles.begin(), triangles.end()}), bound, size, {}});
}

}  // namespace gradus

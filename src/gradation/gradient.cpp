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

/// The mesh as triangles, and the triangles at each vertex.
struct Corners {
    std::span<const Eigen::Vector3d> points;
    std::vector<Triangle> triangles;
    std::vector<int> first;
    std::vector<int> around;

    explicit Corners(const TriMesh& mesh) : points(points_of(mesh)), triangles(triangles_of(mesh)), first(points.size() + 2, 0) {
        for (const Triangle& triangle : triangles)
            for (const int v : triangle) ++first[v + 2];
        for (std::size_t v = 0; v < points.size(); ++v) first[v + 2] += first[v + 1];
        around.resize(3 * triangles.size());
        for (std::size_t t = 0; t < triangles.size(); ++t)
            for (const int v : triangles[t]) around[first[v + 1]++] = static_cast<int>(t);
        first.pop_back();
    }

    std::span<const int> at(int v) const { return {around.data() + first[v], around.data() + first[v + 1]}; }
};

/// The triangle ABC seen from C: e = |AB|, s the foot of C on AB (from A), d its distance from AB.
struct Frame {
    double e, s, d;

    Frame(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
        const Eigen::Vector3d ab = b - a, ac = c - a;
        e = ab.norm();
        s = e > 0 ? ab.dot(ac) / e : 0;
        d = e > 0 ? ab.cross(ac).norm() / e : ac.norm();
    }
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

/// Largest size at C that a gradient of `bound` allows with sizes a, b at the other corners; nothing where A and B alone are
/// too steep.
std::optional<double> largest_at(const Frame& f, double a, double b, double bound) {
    if (f.e == 0) return a == b ? std::optional(a + bound * f.d) : std::nullopt;
    const double k = (b - a) / f.e, room = bound * bound - k * k;
    if (room < 0) return std::nullopt;
    return a + k * f.s + f.d * std::sqrt(room);
}

/// Two corners rise by y above the smallest one, with the gradient y[0] g[0] + y[1] g[1]. The nearest rises whose gradient has the
/// norm `bound`, where a change of y[1] counts `weight` times.
/// @pre the gradient is longer than the bound
std::array<double, 2> nearest_rises(const std::array<Eigen::Vector3d, 2>& g, const std::array<double, 2>& y, double weight, double bound) {
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
        const double slope = large * large * P * P / (1 + lambda * large) + small * small * Q * Q / (1 + lambda * small);
        const double step = norm2 / slope * (std::sqrt(norm2) / bound - 1);
        lambda += step;
        if (std::abs(step) <= 1e-12 * lambda) break;
    }
    const double P = p / (1 + lambda * large), Q = q / (1 + lambda * small);
    return {c * P - s * Q, (s * P + c * Q) / root};
}

class GradientLimiter {
  public:
    GradientLimiter(const TriMesh& mesh, double bound, std::span<double> size, std::vector<char> required)
        : corners_(mesh), bound_(bound), size_(size), input_(size.begin(), size.end()), required_(std::move(required)) {}

    void march();
    void flatten();
    void raise();
    GradientReduction report();

  private:
    /// Triangles in the order of their corners' sizes, smallest first: an order that does not depend on how they are numbered.
    struct Steep {
        std::array<double, 3> sizes;
        int triangle;
        bool operator<(const Steep& other) const { return std::tie(other.sizes, other.triangle) < std::tie(sizes, triangle); }
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
    bool too_steep(int t) const { return steepness(t) > bound_ * (1 + kTolerance / 2) + rounding(t); }
    /// Rises of the corners b and c above the smallest corner a, at least cost, after which the triangle is not too steep.
    std::array<double, 2> flat_rises(int a, int b, int c) const;
    /// Lowers the corners of a triangle that is too steep. @returns the corners that changed, -1 for none
    std::array<int, 2> flatten_triangle(int t);
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
    for (std::size_t v = 0; v < size_.size(); ++v)
        if (!std::isinf(size_[v])) queue.push(size_[v], static_cast<int>(v));

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
            const int k = triangle[0] == v ? 0 : triangle[1] == v ? 1 : 2;
            for (const auto& [b, c] : {std::pair{triangle[(k + 1) % 3], triangle[(k + 2) % 3]}, std::pair{triangle[(k + 2) % 3], triangle[(k + 1) % 3]}}) {
                // Whatever reaches C is larger than what it comes from, and of the two ends the smaller one has been or will be popped.
                if (size_[c] <= h || !may_lower(c)) continue;
                const Frame frame(corners_.points[v], corners_.points[b], corners_.points[c]);
                const double reached = size_across(frame, h, size_[b], bound_);
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
    const auto& p = corners_.points;
    const double g = size_gradient({p[a], p[b], p[c]}, {size_[a], size_[b], size_[c]}).norm();
    if (g > 0) return g;
    return std::max({h_variation((p[a] - p[b]).norm(), size_[a], size_[b]), h_variation((p[b] - p[c]).norm(), size_[b], size_[c]),
                     h_variation((p[c] - p[a]).norm(), size_[c], size_[a])});
}

double GradientLimiter::rounding(int t) const {
    const auto& [a, b, c] = corners_.triangles[t];
    const auto& p = corners_.points;
    const double area2 = (p[b] - p[a]).cross(p[c] - p[a]).norm();
    const double longest = std::sqrt(std::max({(p[a] - p[b]).squaredNorm(), (p[b] - p[c]).squaredNorm(), (p[c] - p[a]).squaredNorm()}));
    if (area2 == 0) return 0;
    return 4e-16 * std::max({size_[a], size_[b], size_[c]}) * longest / area2;
}

std::array<double, 2> GradientLimiter::flat_rises(int a, int b, int c) const {
    const auto& p = corners_.points;
    const std::array<double, 2> rise{size_[b] - size_[a], size_[c] - size_[a]};
    const Eigen::Vector3d ab = p[b] - p[a], ac = p[c] - p[a], normal = ab.cross(ac);
    const double area2 = normal.squaredNorm();
    if (area2 == 0) return rise;
    // A size h asks for h^-2 elements per area, so lowering it costs in proportion to h^-3.
    const std::array<Eigen::Vector3d, 2> g{Eigen::Vector3d(ac.cross(normal) / area2), Eigen::Vector3d(normal.cross(ab) / area2)};
    std::array<double, 2> flat = nearest_rises(g, rise, std::pow(size_[b] / size_[c], 3), bound_);
    // Sizes are only lowered: where the nearest point would raise one corner, it stays and the other takes what is left.
    if (flat[0] > rise[0]) {
        flat = {rise[0], largest_at(Frame(p[a], p[b], p[c]), size_[a], size_[b], bound_).value_or(size_[a]) - size_[a]};
    } else if (flat[1] > rise[1]) {
        flat = {largest_at(Frame(p[a], p[c], p[b]), size_[a], size_[c], bound_).value_or(size_[a]) - size_[a], rise[1]};
    }
    return {std::clamp(flat[0], 0., rise[0]), std::clamp(flat[1], 0., rise[1])};
}

std::array<int, 2> GradientLimiter::flatten_triangle(int t) {
    std::array<int, 3> v = corners_.triangles[t];
    std::sort(v.begin(), v.end(), [&](int p, int q) { return size_[p] < size_[q]; });
    const auto& [a, b, c] = v;
    if (may_lower(b) && may_lower(c)) {
        const double b_before = size_[b], c_before = size_[c];
        const std::array<double, 2> rise = flat_rises(a, b, c);
        const auto lower_to = [&](double share) {
            size_[b] = std::min(b_before, size_[a] + share * rise[0]);
            size_[c] = std::min(c_before, size_[a] + share * rise[1]);
        };
        lower_to(1);
        // What is still missing (rounding, or a triangle without area): the gradient is proportional to both rises together.
        const double left = steepness(t);
        if (left > bound_) lower_to(bound_ / left);
        return {size_[b] < b_before ? b : -1, size_[c] < c_before ? c : -1};
    }
    // One of the two is required: the other takes what that leaves, but never less than the smallest corner.
    const int free = may_lower(b) ? b : c, fixed = b + c - free;
    if (!may_lower(free)) return {-1, -1};
    const auto& p = corners_.points;
    const std::optional<double> most = largest_at(Frame(p[a], p[fixed], p[free]), size_[a], size_[fixed], bound_);
    if (!most || *most < size_[a] || *most >= size_[free]) return {-1, -1};
    size_[free] = *most;
    return {free, -1};
}

void GradientLimiter::flatten() {
    // Corrections flow from small sizes to large ones, so triangles with small corners come first.
    std::priority_queue<Steep> queue;
    std::vector<char> queued(corners_.triangles.size(), 0);
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
        for (const int v : flatten_triangle(t)) {
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
        const Triangle& triangle = corners_.triangles[t];
        const int k = triangle[0] == v ? 0 : triangle[1] == v ? 1 : 2;
        const int a = triangle[(k + 1) % 3], b = triangle[(k + 2) % 3];
        const Frame frame(corners_.points[a], corners_.points[b], corners_.points[v]);
        const std::optional<double> allowed = largest_at(frame, size_[a], size_[b], bound_);
        most = std::min(most, allowed ? *allowed : size_[v]);
    }
    return most;
}

void GradientLimiter::raise() {
    const int n = static_cast<int>(size_.size());
    std::vector<int> order(n);
    for (int v = 0; v < n; ++v) order[v] = v;
    std::sort(order.begin(), order.end(), [&](int p, int q) { return size_[p] < size_[q] || (size_[p] == size_[q] && p < q); });
    for (int sweep = 0; sweep < 20; ++sweep) {
        bool changed = false;
        for (const int v : order) {
            if (size_[v] == input_[v]) continue;
            const double most = ceiling(v);
            if (!(most > size_[v])) continue;
            changed = changed || most > size_[v] * (1 + 1e-6);
            size_[v] = most;
        }
        if (!changed) break;
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
        if (std::any_of(triangle.begin(), triangle.end(), [&](int v) { return !may_lower(v); })) result_.conflicts.push_back(t);
    }
    return result_;
}

GradientLimiter make_limiter(const TriMesh& mesh, double bound, std::span<double> size, std::span<const int> required, const char* function) {
    detail::require_above(bound, 0, "gradient bound", function);
    detail::require_sizes(mesh, size, function);
    return GradientLimiter(mesh, bound, size, detail::required_flags(mesh, size, required, function));
}

}  // namespace

GradientReduction march_gradient(const TriMesh& mesh, double bound, std::span<double> size, std::span<const int> required) {
    GradientLimiter limiter = make_limiter(mesh, bound, size, required, "march_gradient");
    limiter.march();
    return limiter.report();
}

GradientReduction limit_gradient(const TriMesh& mesh, double bound, std::span<double> size, std::span<const int> required) {
    GradientLimiter limiter = make_limiter(mesh, bound, size, required, "limit_gradient");
    limiter.march();
    limiter.flatten();
    limiter.raise();
    return limiter.report();
}

}  // namespace gradus

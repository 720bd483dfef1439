#include "gradus/remesh/predicates.hpp"

#include <array>

namespace gradus {
namespace {

/// A sum of doubles that do not overlap, by increasing magnitude: an exact number. [Shewchuk 1997]
template <int N>
struct Expansion {
    std::array<double, N> terms;  // the first `size` count; the rest is never read
    int size = 0;

    void add(double b) {
        int kept = 0;
        for (int i = 0; i < size; ++i) {
            const double sum = b + terms[i];
            const double virtual_b = sum - terms[i];
            const double tail = (b - virtual_b) + (terms[i] - (sum - virtual_b));
            if (tail != 0) terms[kept++] = tail;
            b = sum;
        }
        if (b != 0) terms[kept++] = b;
        size = kept;
    }

    void add_product(double a, double b) {
        const double product = a * b;
        add(std::fma(a, b, -product));  // the rounding error of the product, exactly
        add(product);
    }

    /// Fewest terms for the same number: the cost of products grows with the number of terms.
    void compress() {
        if (size < 2) return;
        int bottom = size - 1;
        double q = terms[bottom];
        for (int i = size - 2; i >= 0; --i) {
            const double sum = q + terms[i];
            const double tail = terms[i] - (sum - q);
            q = sum;
            if (tail == 0) continue;
            terms[bottom--] = q;
            q = tail;
        }
        terms[bottom] = q;
        int top = 0;
        for (int i = bottom + 1; i < size; ++i) {
            const double sum = terms[i] + q;
            const double tail = q - (sum - terms[i]);
            if (tail != 0) terms[top++] = tail;
            q = sum;
        }
        terms[top++] = q;
        size = top;
    }

    int sign() const {
        if (size == 0) return 0;
        return terms[size - 1] > 0 ? 1 : terms[size - 1] < 0 ? -1 : 0;
    }
};

Expansion<2> difference(double a, double b) {
    Expansion<2> result;
    result.add(a);
    result.add(-b);
    return result;
}

template <int N, int A, int B>
void add_product(Expansion<N>& sum, const Expansion<A>& a, const Expansion<B>& b, double factor = 1) {
    for (int i = 0; i < a.size; ++i)
        for (int j = 0; j < b.size; ++j) sum.add_product(factor * a.terms[i], b.terms[j]);
}

using Difference = Expansion<2>;

Expansion<16> cross(const Difference& ax, const Difference& ay, const Difference& bx, const Difference& by) {
    Expansion<16> result;
    add_product(result, ax, by);
    add_product(result, ay, bx, -1);
    result.compress();
    return result;
}

Expansion<16> squared_length(const Difference& x, const Difference& y) {
    Expansion<16> result;
    add_product(result, x, x);
    add_product(result, y, y);
    result.compress();
    return result;
}

int incircle_exact(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c, const Eigen::Vector2d& d) {
    const Difference ax = difference(a.x(), d.x()), ay = difference(a.y(), d.y());
    const Difference bx = difference(b.x(), d.x()), by = difference(b.y(), d.y());
    const Difference cx = difference(c.x(), d.x()), cy = difference(c.y(), d.y());
    Expansion<3 * 512> det;
    add_product(det, squared_length(ax, ay), cross(bx, by, cx, cy));
    add_product(det, squared_length(bx, by), cross(cx, cy, ax, ay));
    add_product(det, squared_length(cx, cy), cross(ax, ay, bx, by));
    return det.sign();
}

}  // namespace

int detail::orient2d_exact(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
    const Difference ax = difference(a.x(), c.x()), ay = difference(a.y(), c.y());
    const Difference bx = difference(b.x(), c.x()), by = difference(b.y(), c.y());
    return cross(ax, ay, bx, by).sign();
}

int incircle(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c, const Eigen::Vector2d& d) {
    const double ax = a.x() - d.x(), ay = a.y() - d.y();
    const double bx = b.x() - d.x(), by = b.y() - d.y();
    const double cx = c.x() - d.x(), cy = c.y() - d.y();
    const double bxcy = bx * cy, cxby = cx * by, cxay = cx * ay, axcy = ax * cy, axby = ax * by, bxay = bx * ay;
    const double a2 = ax * ax + ay * ay, b2 = bx * bx + by * by, c2 = cx * cx + cy * cy;
    const double det = a2 * (bxcy - cxby) + b2 * (cxay - axcy) + c2 * (axby - bxay);
    const double permanent =
        a2 * (std::abs(bxcy) + std::abs(cxby)) + b2 * (std::abs(cxay) + std::abs(axcy)) + c2 * (std::abs(axby) + std::abs(bxay));
    constexpr double kBound = 1.1102230246251577e-15;  // (10 + 96 u) u, u = 2^-53
    if (det > kBound * permanent) return 1;
    if (det < -kBound * permanent) return -1;
    return incircle_exact(a, b, c, d);
}

}  // namespace gradus

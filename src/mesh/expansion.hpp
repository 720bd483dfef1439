/// Private to the sources: exact sums and products of doubles.
#pragma once

#include <array>
#include <cmath>

namespace gradus::exact {

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

inline Expansion<2> difference(double a, double b) {
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

/// ax by - ay bx.
inline Expansion<16> cross(const Difference& ax, const Difference& ay, const Difference& bx, const Difference& by) {
    Expansion<16> result;
    add_product(result, ax, by);
    add_product(result, ay, bx, -1);
    result.compress();
    return result;
}

}  // namespace gradus::exact

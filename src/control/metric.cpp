#include "gradus/control/metric.hpp"

#include <cmath>
#include <utility>

namespace gradus {

double log_size_ratio(double small, double large) {
    // The difference is exact for sizes within a factor of two; beyond that the quotient loses nothing, unless it
    // overflows.
    if (large <= 2 * small) return std::log1p((large - small) / small);
    const double ratio = large / small;
    return std::isinf(ratio) ? std::log(large) - std::log(small) : std::log(ratio);
}

double metric_length(double L, double h_p, double h_q) {
    if (h_p > h_q) std::swap(h_p, h_q);
    if (std::isinf(h_q)) return 0;
    const double u = log_size_ratio(h_p, h_q);
    // (7) is L / h_p times the mean of e^(-u t) over t in [0, 1].
    const double mean = u > 0 ? -std::expm1(-u) / u : 1;
    return L / h_p * mean;
}

}  // namespace gradus

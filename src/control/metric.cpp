#include "gradus/control/metric.hpp"

#include <cmath>
#include <utility>

namespace gradus {

double metric_length(double L, double h_p, double h_q) {
    if (h_p > h_q) std::swap(h_p, h_q);
    if (std::isinf(h_q)) return std::isinf(h_p) ? 0.0 : L / h_p * 0.0;  // ln(h_q / h_p) grows without bound
    const double u = std::log1p((h_q - h_p) / h_p);
    // (1 - e^-u) / u, by its series where the quotient loses digits
    const double mean = u < 1e-5 ? 1 - u / 2 + u * u / 6 : -std::expm1(-u) / u;
    return L / h_p * mean;
}

}  // namespace gradus

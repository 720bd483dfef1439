#include "gradus/control/metric.hpp"

#include <catch2/catch.hpp>

#include <cmath>
#include <limits>

using namespace gradus;

TEST_CASE("The metric length agrees with its integral", "[control][exact]") {
    const double h_p = GENERATE(1e-6, .3, 1., 7.), ratio = GENERATE(1., 1.0000001, 1.1, 2.5, 1e4),
                 L = GENERATE(1e-3, 1., 20.);
    const double h_q = ratio * h_p;
    // Gauss-Legendre on many pieces of the integral of dt / h(t), h geometric. [eq. 5, 6]
    double integral = 0;
    const int pieces = 2000;
    for (int k = 0; k < pieces; ++k)
        for (const double g : {-1 / std::sqrt(3.), 1 / std::sqrt(3.)})
            integral += std::pow(ratio, -(k + .5 + .5 * g) / pieces) / (2 * pieces);
    CHECK(metric_length(L, h_p, h_q) == Approx(L / h_p * integral).epsilon(1e-9));
    CHECK(metric_length(L, h_p, h_q) == metric_length(L, h_q, h_p));
}

TEST_CASE("The metric length of nearly equal sizes keeps its digits", "[control][exact]") {
    // (1 - e^-u)/u = 1 - u/2 + u^2/6 - ...
    for (double u = 1e-16; u < 1e-4; u *= 3) {
        const double h = 1 + u, v = std::log1p(h - 1);
        CHECK(metric_length(1, 1, h) == Approx(1 - v / 2 + v * v / 6 - v * v * v / 24).epsilon(1e-15));
    }
    CHECK(metric_length(2, .5, .5) == 4);
}

TEST_CASE("Infinite and extreme sizes have a length", "[control][exact]") {
    const double inf = std::numeric_limits<double>::infinity();
    CHECK(metric_length(1, inf, inf) == 0);
    CHECK(metric_length(1, 1, inf) == 0);
    CHECK(metric_length(1, inf, 1) == 0);
    CHECK(metric_length(0, 1, 2) == 0);
    CHECK(metric_length(1, 1e-300, 1e300) == Approx(1e300 / (600 * std::log(10.))));
}

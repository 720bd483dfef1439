#include "gradus/quality/statistics.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

using namespace gradus;

TEST_CASE("quantiles lie where sorting puts them", "[quality][exact]") {
    const int n = GENERATE(1, 2, 3, 10, 1001, 5000);
    std::mt19937 random(7);
    std::vector<double> values(n);
    for (double& x : values) x = std::uniform_real_distribution<double>(-3, 5)(random);
    const Summary s = summarise(values);
    std::sort(values.begin(), values.end());
    const auto quantile = [&](double q) {
        const double rank = q * (n - 1);
        const int i = std::min(static_cast<int>(rank), n - 1), j = std::min(i + 1, n - 1);
        return values[i] + (rank - i) * (values[j] - values[i]);
    };
    CHECK(s.count == values.size());
    CHECK(s.min == values.front());
    CHECK(s.max == values.back());
    CHECK(s.p001 == Approx(quantile(.001)));
    CHECK(s.p01 == Approx(quantile(.01)));
    CHECK(s.median == Approx(quantile(.5)));
    CHECK(s.p99 == Approx(quantile(.99)));
    CHECK(s.p999 == Approx(quantile(.999)));
}

TEST_CASE("a summary of nothing is not a number, and of infinities is no surprise", "[quality]") {
    const double infinity = std::numeric_limits<double>::infinity();
    CHECK(summarise({}).count == 0);
    CHECK(std::isnan(summarise({}).median));
    const Summary s = summarise({1, infinity, infinity, std::nan("")});
    CHECK(s.count == 3);
    CHECK(s.min == 1);
    CHECK(s.median == infinity);
    CHECK(s.p999 == infinity);
}

TEST_CASE("histograms keep everything", "[quality]") {
    Histogram histogram(0, 1, 4);
    for (const double x : {-5., 0., .25, .3, .99, 1., 7., std::numeric_limits<double>::infinity(), std::nan("")})
        histogram.add(x);
    CHECK(histogram.counts == std::vector<std::size_t>{2, 2, 0, 4});
    CHECK(histogram.total() == 8);
}

TEST_CASE("the worst few are the largest, whatever the order", "[quality]") {
    Worst worst(3);
    for (const int i : {5, 1, 9, 4, 3, 8}) worst.add(i, i / 2);  // values 2 0 4 2 1 4
    const std::vector<Offender> list = worst.sorted();
    REQUIRE(list.size() == 3);
    CHECK(list[0].index == 8);
    CHECK(list[1].index == 9);
    CHECK(list[2].index == 4);
}

#include "gradus/io/histogram.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <regex>

using namespace gradus;

namespace {

/// Pixels of exactly this colour with x in [left, right).
int count_pixels(const Image& image, const Colour& colour, int left, int right) {
    const Image wanted(1, 1, colour);
    int count = 0;
    for (int y = 0; y < image.height; ++y)
        for (int x = left; x < right; ++x) {
            const auto* p = image.rgb.data() + 3 * (static_cast<std::size_t>(y) * image.width + x);
            count += std::equal(p, p + 3, wanted.rgb.data());
        }
    return count;
}

}  // namespace

TEST_CASE("every value is counted once", "[io][property]") {
    std::mt19937 random(3);
    std::lognormal_distribution<double> draw(0, 2);
    std::vector<double> values(5000);
    for (double& v : values) v = draw(random);
    values.push_back(std::numeric_limits<double>::quiet_NaN());
    values.push_back(std::numeric_limits<double>::infinity());
    const Scale scale = GENERATE(Scale::Linear, Scale::Logarithmic);
    const auto range = GENERATE(std::optional<Range>{}, std::optional<Range>{Range{0.5, 3}});
    const HistogramData histogram = count_values(values, 17, range, scale);
    CHECK(histogram.total() == 5001);
    CHECK(histogram.missing == 1);
    CHECK(histogram.above >= 1);
    for (std::size_t bin = 0; bin < histogram.counts.size(); ++bin) {
        const auto limits = histogram.limits_of(bin);
        // A value at a limit may fall to either side of it by rounding.
        const auto inside = [&](double slack) {
            return static_cast<std::size_t>(std::ranges::count_if(
                values, [&](double v) { return v >= limits[0] * (1 - slack) && v <= limits[1] * (1 + slack); }));
        };
        CHECK(histogram.counts[bin] <= inside(1e-12));
        CHECK(histogram.counts[bin] + 2 >= inside(-1e-12));
    }
}

TEST_CASE("the ends of the range belong to the first and the last bin", "[io][exact]") {
    const std::vector<double> values{0, 0.5, 1, -0.1, 1.1};
    const HistogramData histogram = count_values(values, 2, Range{0, 1});
    CHECK(histogram.counts == std::vector<std::size_t>{1, 2});
    CHECK(histogram.below == 1);
    CHECK(histogram.above == 1);
    CHECK(histogram.share(1) == Approx(0.4));
    const std::vector<double> same(7, 2.5);
    CHECK(count_values(same, 5).counts[2] == 7);
    CHECK(count_values({}, 5).total() == 0);
    CHECK_THROWS_AS(count_values(values, 0), std::invalid_argument);
    CHECK_THROWS_AS(count_values(values, 3, Range{1, 1}), std::invalid_argument);
    CHECK_THROWS_AS(count_values(values, 3, Range{0, 1}, Scale::Logarithmic), std::invalid_argument);
}

TEST_CASE("bars are as high as their shares", "[io]") {
    std::vector<double> values(100, 0.25);
    values.insert(values.end(), 300, 0.75);
    const HistogramData histogram = count_values(values, 2, Range{0, 1});
    const HistogramStyle style{.title = "title", .x_label = "x", .width = 400, .height = 300, .bar = hex(0x00a000)};
    const Image image = draw_histogram(histogram, style);
    // The first pixel column after the gap between the bars belongs to the second.
    int split = image.width / 4;
    while (count_pixels(image, style.bar, split, split + 1) > 0) ++split;
    const int low = count_pixels(image, style.bar, 0, split), high = count_pixels(image, style.bar, split, image.width);
    CHECK(static_cast<double>(high) / low == Approx(3).epsilon(0.03));

    const std::string svg = histogram_svg(histogram, style);
    const std::regex height("<rect[^>]* height=\"([0-9.]+)\"");
    std::vector<double> heights;
    for (std::sregex_iterator it(svg.begin(), svg.end(), height), end; it != end; ++it)
        heights.push_back(std::stod((*it)[1]));
    REQUIRE(heights.size() == 2);
    CHECK(heights[1] / heights[0] == Approx(3).epsilon(0.001));
}

TEST_CASE("two histograms side by side have one vertical axis", "[io]") {
    const std::vector<double> spread{0.1, 0.3, 0.6, 0.9}, together{0.9, 0.91, 0.92, 0.93};
    const HistogramData left = count_values(spread, 4, Range{0, 1}), right = count_values(together, 4, Range{0, 1});
    const HistogramStyle style{.width = 800, .height = 500, .bar = hex(0x00a000)};
    const Image image = draw_histograms(left, style, right, style);
    // Four bars of a quarter, one bar of the whole: the same area.
    const double a = count_pixels(image, style.bar, 0, 800), b = count_pixels(image, style.bar, 800, 1600);
    CHECK(a / b == Approx(1).epsilon(0.05));
}

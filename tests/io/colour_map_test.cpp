#include "gradus/io/colour_map.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

using namespace gradus;

TEST_CASE("the sequential map grows lighter in even steps", "[io][property]") {
    const int steps = 64;
    const double first = lightness(colour_at(ColourMap::Sequential, 0)),
                 last = lightness(colour_at(ColourMap::Sequential, 1));
    CHECK(first < 0.35);
    CHECK(last > 0.85);
    for (int i = 0; i < steps; ++i) {
        const double a = lightness(colour_at(ColourMap::Sequential, i / 64.0)),
                     b = lightness(colour_at(ColourMap::Sequential, (i + 1) / 64.0));
        CHECK(b - a == Approx((last - first) / steps).epsilon(0.15));
    }
}

TEST_CASE("the diverging map grows darker from the middle to both ends alike", "[io][property]") {
    for (int i = 0; i < 32; ++i) {
        const double near = i / 64.0, far = (i + 1) / 64.0;
        for (const double side : {-1.0, 1.0})
            CHECK(lightness(colour_at(ColourMap::Diverging, 0.5 + side * far)) <
                  lightness(colour_at(ColourMap::Diverging, 0.5 + side * near)));
        CHECK(lightness(colour_at(ColourMap::Diverging, 0.5 + far)) ==
              Approx(lightness(colour_at(ColourMap::Diverging, 0.5 - far))).epsilon(0.01));
    }
}

TEST_CASE("values without a colour are grey, values beyond the range have the end's", "[io]") {
    const Colour none = colour_at(ColourMap::Sequential, std::numeric_limits<double>::quiet_NaN());
    CHECK(none.r == missing_colour.r);
    CHECK(colour_at(ColourMap::Sequential, -3).r == colour_at(ColourMap::Sequential, 0).r);
    CHECK(colour_at(ColourMap::Sequential, std::numeric_limits<double>::infinity()).r ==
          colour_at(ColourMap::Sequential, 1).r);
}

TEST_CASE("a value finds its place on a linear and a logarithmic scale", "[io][exact]") {
    CHECK(place_on({2, 6}, Scale::Linear, 3) == Approx(0.25));
    CHECK(place_on({0.01, 100}, Scale::Logarithmic, 1) == Approx(0.5));
    CHECK(place_on({2, 6}, Scale::Linear, 8) == Approx(1.5));
    CHECK(place_on({5, 5}, Scale::Linear, 5) == 0.5);
    CHECK(std::isnan(place_on({0.01, 100}, Scale::Logarithmic, 0)));
    const double inf = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
    const std::vector<double> values{3, -1, nan, 0, inf, 7};
    CHECK(range_of(values).low == -1);
    CHECK(range_of(values).high == 7);
    CHECK(range_of(values, Scale::Logarithmic).low == 3);
    CHECK(range_of({}, Scale::Logarithmic).high == 10);
}

TEST_CASE("ticks are round, rising and inside their range", "[io][property]") {
    const Range range = GENERATE(Range{0, 1}, Range{0.013, 6.9}, Range{1e-9, 3e-3}, Range{997, 1003}, Range{0.2, 0.21},
                                 Range{1e-12, 1e12});
    const Scale scale = GENERATE(Scale::Linear, Scale::Logarithmic);
    if (scale == Scale::Logarithmic && range.low <= 0) return;
    const std::vector<double> marks = ticks(range, scale, 6);
    CHECK(marks.size() >= 2);
    CHECK(marks.size() <= 16);
    for (std::size_t i = 0; i < marks.size(); ++i) {
        CHECK(marks[i] >= range.low - 1e-9 * std::abs(range.high));
        CHECK(marks[i] <= range.high * (1 + 1e-9));
        if (i > 0) CHECK(marks[i] > marks[i - 1]);
        CHECK(std::stod(tick_label(marks[i])) == Approx(marks[i]));
    }
}

TEST_CASE("a range that is none but for rounding has one tick, and one colour", "[io][exact]") {
    const double h = 0.0377;
    const Range range{h, h * (1 + 3e-16)};
    REQUIRE(range.high > range.low);
    CHECK(is_one_value(range));
    const Scale scale = GENERATE(Scale::Linear, Scale::Logarithmic);
    CHECK(ticks(range, scale) == std::vector<double>{h});
    CHECK(place_on(range, scale, range.low) == 0.5);
    CHECK(place_on(range, scale, range.high) == 0.5);
    CHECK(place_on(range, scale, 0.9 * h) == 0);
    CHECK(place_on(range, scale, 1.1 * h) == 1);
}

TEST_CASE("tick labels are short", "[io][exact]") {
    CHECK(tick_label(0) == "0");
    CHECK(tick_label(0.2) == "0.2");
    CHECK(tick_label(1e-6) == "1e-6");
    CHECK(tick_label(2.5e12) == "2.5e12");
    CHECK(tick_label(-3) == "-3");
}

#include "gradus/io/figure.hpp"

#include <catch2/catch.hpp>
#include <numeric>

using namespace gradus;

TEST_CASE("composed pictures are all there, unchanged and apart", "[io][property]") {
    const int columns = GENERATE(1, 2, 3);
    const std::vector<Panel> panels{{Image(60, 40, hex(0xff0000)), "raw"},
                                    {Image(50, 30, hex(0x00ff00)), "graded"},
                                    {Image(60, 40, hex(0x0000ff)), ""}};
    const Image image = compose(panels, {.columns = columns, .gap = 10, .title = "both", .text_size = 9});
    for (const Panel& panel : panels) {
        const Colour wanted = panel.image.at(0, 0);
        int count = 0;
        for (int y = 0; y < image.height; ++y)
            for (int x = 0; x < image.width; ++x) {
                const Colour c = image.at(x, y);
                count += c.r == wanted.r && c.g == wanted.g && c.b == wanted.b;
            }
        CHECK(count == panel.image.width * panel.image.height);
    }
    CHECK_THROWS_AS(compose({}, {}), std::invalid_argument);
    CHECK_THROWS_AS(compose(panels, {.columns = 0}), std::invalid_argument);
}

TEST_CASE("a colour bar runs from the low colour at the bottom to the high one at the top", "[io]") {
    Image image(200, 300);
    const ColourBar bar{.range = {1e-3, 2}, .scale = Scale::Logarithmic, .title = "size", .text_size = 10};
    CHECK(colour_bar_width(bar) < 190);
    draw_colour_bar(image, {5, 10}, {195, 290}, bar);
    double last = 2;
    int rows = 0;
    for (int y = 0; y < image.height; ++y) {
        const Colour c = image.at(10, y);
        const bool on_bar = std::max({c.r, c.g, c.b}) - std::min({c.r, c.g, c.b}) > 0.15f;
        if (!on_bar) continue;
        CHECK(lightness(c) <= last + 0.004);
        last = lightness(c);
        ++rows;
    }
    CHECK(rows > 200);
    CHECK(last == Approx(lightness(colour_at(ColourMap::Sequential, 0))).margin(0.02));
}

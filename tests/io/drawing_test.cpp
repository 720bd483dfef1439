#include "gradus/io/drawing.hpp"

#include <catch2/catch.hpp>
#include <numbers>
#include <set>
#include <string>

using namespace gradus;

namespace {

/// Area covered with black, in pixels.
double ink(const Image& image) {
    double sum = 0;
    for (const auto byte : image.rgb) sum += 255 - byte;
    return sum / (3 * 255);
}

}  // namespace

TEST_CASE("a box covers its area, parts of pixels included", "[io][exact]") {
    Image image(20, 20);
    fill_box(image, {2.25, 3.5}, {10.75, 8.25}, {0, 0, 0});
    CHECK(ink(image) == Approx(8.5 * 4.75).epsilon(0.003));
    Image outside(20, 20);
    fill_box(outside, {-50, 5}, {-10, 8}, {0, 0, 0});
    CHECK(ink(outside) == 0);
    fill_box(outside, {-50, -50}, {100, 100}, {0, 0, 0});
    CHECK(ink(outside) == Approx(400));
}

TEST_CASE("a line covers its length times its width and two round ends", "[io][exact]") {
    const double width = GENERATE(1.0, 2.0, 3.5), angle = GENERATE(0.0, 0.3, 1.1);
    Image image(120, 120);
    const Eigen::Vector2d from(20.3, 15.7), to = from + 80 * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    draw_segment(image, from, to, width, {0, 0, 0});
    CHECK(ink(image) == Approx(80 * width + std::numbers::pi * width * width / 4).epsilon(0.03));
}

TEST_CASE("every printable letter looks different", "[io][property]") {
    std::set<std::vector<std::uint8_t>> seen;
    for (char c = ' '; c < 127; ++c) {
        Image image(60, 60);
        draw_text(image, {10, 40}, std::string(1, c), {.size = 24});
        INFO(c);
        CHECK(seen.insert(image.rgb).second);
        CHECK((ink(image) > 0) == (c != ' '));
    }
    Image unknown(60, 60);
    draw_text(unknown, {10, 40}, "\x07", {.size = 24});
    CHECK(seen.insert(unknown.rgb).second);
}

TEST_CASE("a text is as long as announced and stands where it was put", "[io]") {
    const TextStyle style{.size = 20, .colour = {0, 0, 0}, .align = GENERATE(Align::Left, Align::Centre, Align::Right)};
    const std::string text = "HillH";  // straight stems at both ends
    const double length = text_width(text, style);
    const double start = style.align == Align::Left     ? 100
                         : style.align == Align::Centre ? 100 - length / 2
                                                        : 100 - length;
    Image image(200, 60);
    draw_text(image, {100, 40}, text, style);
    int left = image.width, right = 0, top = image.height, bottom = 0;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            if (image.at(x, y).g < 0.5f)
                left = std::min(left, x), right = std::max(right, x + 1), top = std::min(top, y),
                bottom = std::max(bottom, y + 1);
    CHECK(left == Approx(start).margin(2.5));
    CHECK(right == Approx(start + length).margin(2.5));
    CHECK(bottom == Approx(40).margin(2.5));
    CHECK(top == Approx(20).margin(3.5));  // l is a little higher than a capital
    CHECK(text_width("", style) == 0);
}

TEST_CASE("pasting keeps to the image", "[io]") {
    const Image black(10, 10, {0, 0, 0});
    const auto [x, y, area] =
        GENERATE(table<int, int, double>({{0, 0, 100}, {-4, 2, 60}, {15, 15, 25}, {30, 0, 0}, {-10, -10, 0}}));
    Image image(20, 20);
    paste(image, black, x, y);
    CHECK(ink(image) == Approx(area));
}

#include "gradus/io/image.hpp"

#include <png.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "gradus/io/error.hpp"

using namespace gradus;

namespace {

Image random_image(int width, int height) {
    std::mt19937 random(7);
    Image image(width, height);
    for (auto& byte : image.rgb) byte = static_cast<std::uint8_t>(random());
    return image;
}

Image decode(const std::string& bytes) {
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    REQUIRE(png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()));
    png.format = PNG_FORMAT_RGB;
    Image image(static_cast<int>(png.width), static_cast<int>(png.height));
    REQUIRE(png_image_finish_read(&png, nullptr, image.rgb.data(), 0, nullptr));
    return image;
}

}  // namespace

TEST_CASE("a PNG file holds the pixels of its image", "[io][exact]") {
    const auto [width, height] = GENERATE(std::pair{1, 1}, std::pair{3, 2}, std::pair{257, 131});
    const Image image = random_image(width, height), back = decode(encode_png(image));
    CHECK(back.width == width);
    CHECK(back.height == height);
    CHECK(back.rgb == image.rgb);
}

TEST_CASE("write_png replaces a file as a whole and leaves nothing beside it", "[io]") {
    const auto folder = std::filesystem::temp_directory_path() / "gradus_image_test";
    std::filesystem::remove_all(folder);
    std::filesystem::create_directory(folder);
    write_png(folder / "a.png", random_image(5, 5));
    const Image image = random_image(40, 30);
    write_png(folder / "a.png", image);
    std::ifstream file(folder / "a.png", std::ios::binary);
    std::stringstream bytes;
    bytes << file.rdbuf();
    CHECK(bytes.str() == encode_png(image));
    CHECK(std::distance(std::filesystem::directory_iterator(folder), {}) == 1);
    CHECK_THROWS_AS(write_png(folder / "missing" / "a.png", image), IoError);
    std::filesystem::remove_all(folder);
}

TEST_CASE("an image has a size and whole pixels", "[io]") {
    CHECK_THROWS_AS(Image(0, 5), std::invalid_argument);
    CHECK_THROWS_AS(Image(5, -1), std::invalid_argument);
    CHECK_THROWS_AS(encode_png(Image{}), std::invalid_argument);
    Image image(2, 2, hex(0x336699));
    CHECK(image.rgb[3] == 0x33);
    CHECK(image.rgb[5] == 0x99);
    image.blend(0, 0, {0, 0, 0}, 0.5);
    CHECK(image.at(0, 0).b == Approx(0.3).margin(0.003));
    CHECK_NOTHROW(image.blend(-1, 7, {0, 0, 0}, 1));
}

#include "gradus/io/image.hpp"

#include <png.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "gradus/io/output_file.hpp"

namespace gradus {
namespace {

std::uint8_t byte_of(float part) { return static_cast<std::uint8_t>(std::clamp(part, 0.0f, 1.0f) * 255 + 0.5f); }

std::size_t offset(const Image& image, int x, int y) { return 3 * (static_cast<std::size_t>(y) * image.width + x); }

}  // namespace

Image::Image(int width_, int height_, const Colour& fill) : width(width_), height(height_) {
    constexpr int limit = 32768;
    if (width < 1 || height < 1 || width > limit || height > limit)
        throw std::invalid_argument("Image: size " + std::to_string(width) + " x " + std::to_string(height) +
                                    " is not in 1.." + std::to_string(limit));
    const std::uint8_t pixel[3] = {byte_of(fill.r), byte_of(fill.g), byte_of(fill.b)};
    rgb.resize(3 * static_cast<std::size_t>(width) * height);
    for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = pixel[i % 3];
}

Colour Image::at(int x, int y) const {
    const std::uint8_t* p = rgb.data() + offset(*this, x, y);
    return {p[0] / 255.0f, p[1] / 255.0f, p[2] / 255.0f};
}

void Image::set(int x, int y, const Colour& colour) {
    std::uint8_t* p = rgb.data() + offset(*this, x, y);
    p[0] = byte_of(colour.r), p[1] = byte_of(colour.g), p[2] = byte_of(colour.b);
}

void Image::blend(int x, int y, const Colour& colour, double alpha) {
    if (x < 0 || y < 0 || x >= width || y >= height || !(alpha > 0)) return;
    set(x, y, mix(at(x, y), colour, static_cast<float>(std::min(alpha, 1.0))));
}

std::string encode_png(const Image& image) {
    if (image.width < 1 || image.height < 1 ||
        image.rgb.size() != 3 * static_cast<std::size_t>(image.width) * image.height)
        throw std::invalid_argument("encode_png: image is empty or its pixels do not match its size");
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    png.width = static_cast<png_uint_32>(image.width);
    png.height = static_cast<png_uint_32>(image.height);
    png.format = PNG_FORMAT_RGB;
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
    std::string bytes(size, '\0');
    if (!png_image_write_to_memory(&png, bytes.data(), &size, 0, image.rgb.data(), 0, nullptr))
        throw std::runtime_error(std::string("encode_png: ") + png.message);
    bytes.resize(size);
    return bytes;
}

void write_png(const std::filesystem::path& path, const Image& image) { write_file(path.string(), encode_png(image)); }

}  // namespace gradus

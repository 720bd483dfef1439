/// Pixels, and PNG files made of them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace gradus {

/// A colour as a screen takes it: sRGB, each part in [0, 1].
struct Colour {
    float r = 0, g = 0, b = 0;
};

/// A colour written the way style sheets do: hex(0xff8000).
constexpr Colour hex(std::uint32_t rgb) {
    return {static_cast<float>(rgb >> 16 & 255) / 255, static_cast<float>(rgb >> 8 & 255) / 255,
            static_cast<float>(rgb & 255) / 255};
}

/// Moves from `a` (t = 0) to `b` (t = 1).
constexpr Colour mix(const Colour& a, const Colour& b, float t) {
    return {a.r + t * (b.r - a.r), a.g + t * (b.g - a.g), a.b + t * (b.b - a.b)};
}

/// 8-bit RGB pixels, rows from the top.
struct Image {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;  ///< 3 * width * height

    Image() = default;
    /// @throws std::invalid_argument unless both sides are in [1, 32768]
    Image(int width, int height, const Colour& fill = {1, 1, 1});

    Colour at(int x, int y) const;
    void set(int x, int y, const Colour& colour);
    /// Lays `colour` over a pixel with opacity `alpha` in [0, 1]; pixels outside the image are ignored.
    void blend(int x, int y, const Colour& colour, double alpha);
};

/// PNG file of an image, in memory. Same image, same bytes.
/// @throws std::invalid_argument if the image is empty, std::runtime_error if the encoder fails
std::string encode_png(const Image& image);

/// Writes a PNG file as a whole, see write_file.
/// @throws IoError if the file cannot be written
void write_png(const std::filesystem::path& path, const Image& image);

}  // namespace gradus

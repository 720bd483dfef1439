/// Colours for numbers: maps of even lightness steps, and how a value finds its place on them.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "gradus/io/image.hpp"

namespace gradus {

/// Built in OKLab, the lightness being linear along the map. [Ottosson, *A perceptual color space for image
/// processing*, 2020]
enum class ColourMap {
    Sequential,  ///< dark violet, blue, green, yellow: lightness rises all the way
    Diverging    ///< blue, near-white in the middle, red: lightness falls from the middle to both ends
};

/// Colour of a map at t, clamped to [0, 1]; NaN gives the grey of `missing_colour`.
Colour colour_at(ColourMap map, double t);
inline constexpr Colour missing_colour = hex(0xb8b8b8);

/// Perceived lightness (the L of OKLab) in [0, 1].
double lightness(const Colour& colour);

enum class Scale { Linear, Logarithmic };

/// Least and greatest value of a scale.
struct Range {
    double low = 0, high = 1;
};

/// Least and greatest of the finite values, of the positive ones only if the scale is logarithmic; [0, 1] (linear) or
/// [1, 10] if there are none.
Range range_of(std::span<const double> values, Scale scale = Scale::Linear);

/// Whether the ends are equal but for rounding: within 1e-9 of the larger.
bool is_one_value(const Range& range);

/// Place of a value: 0 at range.low, 1 at range.high, beyond them outside [0, 1]; NaN for a value the scale cannot
/// show. Where the range is one value, that has the middle.
double place_on(const Range& range, Scale scale, double value);

/// Round values for the ticks of an axis, about `wanted` of them, all inside the range; one where that is one value.
/// Linear: multiples of 1, 2 or 5 times a power of ten. Logarithmic: powers of ten, with 2 and 5 between if they are
/// few.
std::vector<double> ticks(const Range& range, Scale scale, int wanted = 5);

/// Shortest usual writing of a tick: 0.01, 2.5, 1e-6.
std::string tick_label(double value);

}  // namespace gradus

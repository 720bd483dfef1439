/// Histograms, as pictures and as SVG.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gradus/io/colour_map.hpp"

namespace gradus {

/// Values counted in bins of equal width on a scale; the last bin holds its upper end.
struct HistogramData {
    Range range;
    Scale scale = Scale::Linear;
    std::vector<std::size_t> counts;
    std::size_t below = 0, above = 0;  ///< outside the range
    std::size_t missing = 0;           ///< NaN, or not positive on a logarithmic scale

    std::size_t total() const;                               ///< of all values but the missing ones
    double share(std::size_t bin) const;                     ///< of the total, in [0, 1]
    std::array<double, 2> limits_of(std::size_t bin) const;  ///< least and greatest value of a bin
};

/// @param range  default: that of the values
/// @throws std::invalid_argument if bins < 1, or the range is not increasing, or not positive on a logarithmic scale
HistogramData count_values(std::span<const double> values, int bins = 40, std::optional<Range> range = {},
                           Scale scale = Scale::Linear);

struct HistogramStyle {
    std::string title = {}, x_label = {};
    int width = 800, height = 480;  ///< pixels
    Colour bar = hex(0x4878a8);
    std::optional<double> greatest_share =
        {};  ///< top of the vertical axis, to draw several alike; default: the tallest bar fits
    std::optional<double> mark = {};  ///< value with a vertical line: a bound, a mean
};

/// Gives two styles the same vertical axis, high enough for the tallest bar of both, unless the left one has its own.
void share_axis(const HistogramData& left, HistogramStyle& left_style, const HistogramData& right,
                HistogramStyle& right_style);

Image draw_histogram(const HistogramData& histogram, const HistogramStyle& style = {});

/// Two histograms side by side with the same axes. They should have the same range and bins.
Image draw_histograms(const HistogramData& left, HistogramStyle left_style, const HistogramData& right,
                      HistogramStyle right_style);

/// The same as an <svg> element for a web page; text takes the colour of the page.
std::string histogram_svg(const HistogramData& histogram, const HistogramStyle& style = {});

}  // namespace gradus

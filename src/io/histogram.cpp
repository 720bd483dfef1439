#include "gradus/io/histogram.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "gradus/io/drawing.hpp"
#include "markup.hpp"

namespace gradus {
namespace {

/// Where a histogram's parts lie, pixels from the left and the top; the same for the picture and the SVG.
struct Layout {
    double text = 0;                                  ///< height of a capital
    double left = 0, right = 0, top = 0, bottom = 0;  ///< of the axes
    Range shares;                                     ///< vertical axis
    Range values;                                     ///< horizontal axis
    Scale scale;

    double x(double value) const { return left + place_on(values, scale, value) * (right - left); }
    double y(double share) const { return bottom - share / shares.high * (bottom - top); }
};

constexpr double headroom = 1.06;  // of the axis over the tallest bar

double tallest(const HistogramData& histogram) {
    double share = 0;
    for (std::size_t i = 0; i < histogram.counts.size(); ++i) share = std::max(share, histogram.share(i));
    return share;
}

std::vector<double> share_ticks(const Layout& layout) { return ticks(layout.shares, Scale::Linear, 5); }
std::string percent(double share) { return tick_label(100 * share) + "%"; }

Layout lay_out(const HistogramData& histogram, const HistogramStyle& style) {
    Layout layout;
    layout.text = std::clamp(std::min(style.width / 58.0, style.height / 36.0), 7.0, 40.0);
    layout.shares = {0, style.greatest_share.value_or(headroom * tallest(histogram))};
    if (!(layout.shares.high > 0)) layout.shares.high = 1;
    layout.values = histogram.range;
    layout.scale = histogram.scale;
    double label = 0;
    for (const double share : share_ticks(layout))
        label = std::max(label, text_width(percent(share), {.size = layout.text}));
    layout.left = label + 2.2 * layout.text;
    layout.right = style.width - 2.5 * layout.text;
    layout.top = (style.title.empty() ? 1.5 : 4.2) * layout.text;
    layout.bottom = style.height - (style.x_label.empty() ? 3.2 : 5.6) * layout.text;
    return layout;
}

void check(const HistogramStyle& style) {
    if (style.width < 64 || style.height < 64)
        throw std::invalid_argument("draw_histogram: picture smaller than 64 x 64");
    if (style.greatest_share && !(*style.greatest_share > 0))
        throw std::invalid_argument("draw_histogram: greatest_share must be positive");
}

/// Left and right end of a bar, with a gap that keeps bars apart if they are wide enough for it.
std::array<double, 2> bar_ends(const Layout& layout, const HistogramData& histogram, std::size_t bin) {
    const auto [low, high] = histogram.limits_of(bin);
    const double left = layout.x(low), right = layout.x(high), gap = std::min(1.0, 0.12 * (right - left));
    return {left + gap / 2, right - gap / 2};
}

std::string svg_text(double x, double y, double size, const char* anchor, const std::string& text) {
    // A capital is about 0.72 of a font's size.
    return fmt::format(
        "<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"{:.1f}\" text-anchor=\"{}\" fill=\"currentColor\">{}</text>\n", x,
        y, size / 0.72, anchor, markup::escape(text));
}

std::string svg_line(double x0, double y0, double x1, double y1, const std::string& look) {
    return fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" {}/>\n", x0, y0, x1, y1, look);
}

}  // namespace

std::size_t HistogramData::total() const { return std::accumulate(counts.begin(), counts.end(), below + above); }

double HistogramData::share(std::size_t bin) const {
    const std::size_t all = total();
    return all == 0 ? 0 : static_cast<double>(counts[bin]) / static_cast<double>(all);
}

std::array<double, 2> HistogramData::limits_of(std::size_t bin) const {
    const auto limit = [&](std::size_t i) {
        const double t = static_cast<double>(i) / static_cast<double>(counts.size());
        return scale == Scale::Linear ? range.low + t * (range.high - range.low)
                                      : range.low * std::pow(range.high / range.low, t);
    };
    return {limit(bin), limit(bin + 1)};
}

HistogramData count_values(std::span<const double> values, int bins, std::optional<Range> range, Scale scale) {
    if (bins < 1) throw std::invalid_argument("count_values: bins " + std::to_string(bins) + " is less than 1");
    if (range && !(range->high > range->low)) throw std::invalid_argument("count_values: range is not increasing");
    if (range && scale == Scale::Logarithmic && !(range->low > 0))
        throw std::invalid_argument("count_values: range is not positive");
    HistogramData histogram;
    histogram.range = range.value_or(range_of(values, scale));
    histogram.scale = scale;
    // All values the same: a bin around them.
    if (is_one_value(histogram.range)) {
        const double v = histogram.range.low, spread = v == 0 ? 0.5 : 0.05 * std::abs(v);
        histogram.range = {v - spread, v + spread};
    }
    histogram.counts.assign(static_cast<std::size_t>(bins), 0);
    for (const double value : values) {
        const double place = place_on(histogram.range, scale, value);
        if (std::isnan(place))
            ++histogram.missing;
        else if (value < histogram.range.low)
            ++histogram.below;
        else if (value > histogram.range.high)
            ++histogram.above;
        else
            ++histogram.counts[static_cast<std::size_t>(std::clamp(place * bins, 0.0, bins - 1.0))];
    }
    return histogram;
}

void share_axis(const HistogramData& left, HistogramStyle& left_style, const HistogramData& right,
                HistogramStyle& right_style) {
    constexpr double least = 1e-9;  // both may be empty
    if (!left_style.greatest_share)
        left_style.greatest_share = std::max(headroom * std::max(tallest(left), tallest(right)), least);
    right_style.greatest_share = left_style.greatest_share;
}

Image draw_histogram(const HistogramData& histogram, const HistogramStyle& style) {
    check(style);
    const Layout layout = lay_out(histogram, style);
    const double size = layout.text, thin = std::max(1.0, 0.08 * size);
    const Colour grid = hex(0xe3e6eb), ink = hex(0x1c2330);
    Image image(style.width, style.height);
    for (const double share : share_ticks(layout)) {
        const double y = layout.y(share);
        draw_segment(image, {layout.left, y}, {layout.right, y}, thin, grid);
        draw_text(image, {layout.left - 0.7 * size, y + size / 2}, percent(share),
                  {.size = size, .align = Align::Right});
    }
    for (std::size_t i = 0; i < histogram.counts.size(); ++i) {
        const auto [left, right] = bar_ends(layout, histogram, i);
        fill_box(image, {left, std::max(layout.y(histogram.share(i)), layout.top)}, {right, layout.bottom}, style.bar);
    }
    draw_segment(image, {layout.left, layout.bottom}, {layout.right, layout.bottom}, 1.3 * thin, ink);
    for (const double value : ticks(histogram.range, histogram.scale, 6)) {
        const double x = layout.x(value);
        draw_segment(image, {x, layout.bottom}, {x, layout.bottom + 0.5 * size}, thin, ink);
        draw_text(image, {x, layout.bottom + 2 * size}, tick_label(value), {.size = size, .align = Align::Centre});
    }
    if (style.mark) {
        const double x = layout.x(*style.mark);
        if (x >= layout.left && x <= layout.right)
            draw_segment(image, {x, layout.top}, {x, layout.bottom}, 1.8 * thin, hex(0xb5392b));
    }
    const double middle = (layout.left + layout.right) / 2;
    draw_text(image, {middle, style.height - 1.2 * size}, style.x_label, {.size = size, .align = Align::Centre});
    draw_text(image, {middle, 2.4 * size}, style.title, {.size = 1.25 * size, .align = Align::Centre, .weight = 0.15});
    return image;
}

Image draw_histograms(const HistogramData& left, HistogramStyle left_style, const HistogramData& right,
                      HistogramStyle right_style) {
    share_axis(left, left_style, right, right_style);
    const Image a = draw_histogram(left, left_style), b = draw_histogram(right, right_style);
    Image image(a.width + b.width, std::max(a.height, b.height));
    paste(image, a, 0, 0);
    paste(image, b, a.width, 0);
    return image;
}

std::string histogram_svg(const HistogramData& histogram, const HistogramStyle& style) {
    check(style);
    const Layout layout = lay_out(histogram, style);
    const double size = layout.text, middle = (layout.left + layout.right) / 2;
    const std::string grid = "stroke=\"currentColor\" stroke-opacity=\"0.15\"", ink = "stroke=\"currentColor\"";
    std::string svg =
        fmt::format("<svg viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" role=\"img\" aria-label=\"{2}\">\n",
                    style.width, style.height, markup::escape(style.title.empty() ? "histogram" : style.title));
    for (const double share : share_ticks(layout)) {
        svg += svg_line(layout.left, layout.y(share), layout.right, layout.y(share), grid);
        svg += svg_text(layout.left - 0.7 * size, layout.y(share) + size / 2, size, "end", percent(share));
    }
    for (std::size_t i = 0; i < histogram.counts.size(); ++i) {
        if (histogram.counts[i] == 0) continue;
        const auto [left, right] = bar_ends(layout, histogram, i);
        const auto [low, high] = histogram.limits_of(i);
        const double top = std::max(layout.y(histogram.share(i)), layout.top);
        svg += fmt::format(
            "<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" fill=\"{}\"><title>{} to {}: {} "
            "({})</title></rect>\n",
            left, top, right - left, layout.bottom - top, markup::colour(style.bar), tick_label(low), tick_label(high),
            histogram.counts[i], percent(histogram.share(i)));
    }
    svg += svg_line(layout.left, layout.bottom, layout.right, layout.bottom, ink);
    for (const double value : ticks(histogram.range, histogram.scale, 6)) {
        svg += svg_line(layout.x(value), layout.bottom, layout.x(value), layout.bottom + 0.5 * size, ink);
        svg += svg_text(layout.x(value), layout.bottom + 2 * size, size, "middle", tick_label(value));
    }
    if (style.mark) {
        const double x = layout.x(*style.mark);
        if (x >= layout.left && x <= layout.right)
            svg += svg_line(x, layout.top, x, layout.bottom, "stroke=\"#b5392b\" stroke-width=\"2\"");
    }
    if (!style.x_label.empty()) svg += svg_text(middle, style.height - 1.2 * size, size, "middle", style.x_label);
    if (!style.title.empty()) svg += svg_text(middle, 2.4 * size, 1.25 * size, "middle", style.title);
    return svg + "</svg>\n";
}

}  // namespace gradus

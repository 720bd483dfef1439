#include "gradus/io/colour_map.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

namespace gradus {
namespace {

struct Lab {
    double l, a, b;
};

double to_linear(double s) { return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4); }
double to_screen(double x) { return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055; }

/// Linear sRGB of an OKLab colour; parts leave [0, 1] if no screen can show it.
std::array<double, 3> linear_rgb(const Lab& c) {
    const double l = std::pow(c.l + 0.3963377774 * c.a + 0.2158037573 * c.b, 3);
    const double m = std::pow(c.l - 0.1055613458 * c.a - 0.0638541728 * c.b, 3);
    const double s = std::pow(c.l - 0.0894841775 * c.a - 1.2914855480 * c.b, 3);
    return {4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
            -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
            -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s};
}

/// Screen colour of a lightness, chroma and hue (degrees); the chroma is lowered until a screen can show it.
Colour from_lch(double l, double chroma, double hue) {
    const double angle = hue * std::numbers::pi / 180;
    const auto rgb = [&](double c) { return linear_rgb({l, c * std::cos(angle), c * std::sin(angle)}); };
    const auto shows = [&](double c) {
        return std::ranges::all_of(rgb(c), [](double x) { return x >= -1e-9 && x <= 1 + 1e-9; });
    };
    double low = 0, high = chroma;
    if (shows(high)) low = high;
    for (int i = 0; i < 30 && low < high; ++i) {
        const double middle = (low + high) / 2;
        (shows(middle) ? low : high) = middle;
    }
    const auto c = rgb(low);
    const auto part = [](double x) { return static_cast<float>(to_screen(std::clamp(x, 0.0, 1.0))); };
    return {part(c[0]), part(c[1]), part(c[2])};
}

/// Value at t of a smooth curve (uniform cubic B-spline) that starts and ends at the first and last control value.
/// Kinks in a colour map would be seen as lines in the picture.
template <std::size_t N>
double along(const std::array<double, N>& control, double t) {
    const auto value = [&](int i) {
        if (i < 0) return 2 * control[0] - control[1];
        if (i >= static_cast<int>(N)) return 2 * control[N - 1] - control[N - 2];
        return control[static_cast<std::size_t>(i)];
    };
    const double x = t * (N - 1);
    const int i = std::min(static_cast<int>(x), static_cast<int>(N) - 2);
    const double s = x - i, r = 1 - s;
    return (r * r * r * value(i - 1) + (3 * s * s * s - 6 * s * s + 4) * value(i) +
            (3 * r * r * r - 6 * r * r + 4) * value(i + 1) + s * s * s * value(i + 2)) /
           6;
}

Colour sequential(double t) {
    constexpr std::array hue{315.0, 290.0, 258.0, 215.0, 172.0, 138.0, 104.0};
    constexpr std::array chroma{0.12, 0.145, 0.115, 0.085, 0.115, 0.175, 0.185};
    return from_lch(0.27 + 0.65 * t, along(chroma, t), along(hue, t));
}

Colour diverging(double t) {
    const double side = std::abs(2 * t - 1);
    return from_lch(0.955 - 0.53 * side, (t < 0.5 ? 0.14 : 0.165) * side, t < 0.5 ? 255 : 28);
}

constexpr int table_size = 1024;
using Table = std::array<Colour, table_size + 1>;

Table tabulate(Colour (*map)(double)) {
    Table table;
    for (int i = 0; i <= table_size; ++i) table[i] = map(static_cast<double>(i) / table_size);
    return table;
}

/// Differences of values in a range that say nothing.
double rounding_of(const Range& range) { return 1e-9 * std::max(std::abs(range.low), std::abs(range.high)); }

}  // namespace

Colour colour_at(ColourMap map, double t) {
    static const Table sequential_table = tabulate(sequential), diverging_table = tabulate(diverging);
    if (std::isnan(t)) return missing_colour;
    const Table& table = map == ColourMap::Sequential ? sequential_table : diverging_table;
    return table[static_cast<std::size_t>(std::lround(std::clamp(t, 0.0, 1.0) * table_size))];
}

double lightness(const Colour& colour) {
    const double r = to_linear(colour.r), g = to_linear(colour.g), b = to_linear(colour.b);
    const double l = std::cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
    const double m = std::cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
    const double s = std::cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
    return 0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s;
}

Range range_of(std::span<const double> values, Scale scale) {
    Range range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    for (const double v : values) {
        if (!std::isfinite(v) || (scale == Scale::Logarithmic && v <= 0)) continue;
        range.low = std::min(range.low, v), range.high = std::max(range.high, v);
    }
    if (range.low > range.high) return scale == Scale::Linear ? Range{0, 1} : Range{1, 10};
    return range;
}

bool is_one_value(const Range& range) { return !(range.high - range.low > rounding_of(range)); }

double place_on(const Range& range, Scale scale, double value) {
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    if (std::isnan(value) || (scale == Scale::Logarithmic && !(value > 0))) return none;
    const bool logarithmic = scale == Scale::Logarithmic;
    const double low = logarithmic ? std::log(range.low) : range.low,
                 high = logarithmic ? std::log(range.high) : range.high;
    const double x = logarithmic ? std::log(value) : value;
    if (is_one_value(range))
        return value < range.low - rounding_of(range) ? 0 : value > range.high + rounding_of(range) ? 1 : 0.5;
    return (x - low) / (high - low);
}

std::vector<double> ticks(const Range& range, Scale scale, int wanted) {
    std::vector<double> result;
    const double slack = 1e-9;  // a tick at the very end of the range is wanted in spite of rounding
    if (scale == Scale::Logarithmic) {
        const double decades = std::log10(range.high / range.low);
        if (range.low > 0 && decades > 0.7) {
            const int first = static_cast<int>(std::floor(std::log10(range.low))),
                      last = static_cast<int>(std::ceil(std::log10(range.high)));
            const int step = std::max(1, static_cast<int>(std::lround(decades / std::max(wanted, 1))));
            const auto add = [&](double v) {
                if (v >= range.low * (1 - slack) && v <= range.high * (1 + slack)) result.push_back(v);
            };
            for (int e = first; e <= last; e += step) {
                // Through decimal text, so that the tick is the double nearest to 0.01 and not a product beside it.
                const auto power = [&](int digit) {
                    return std::stod(std::to_string(digit) + "e" + std::to_string(e));
                };
                add(power(1));
                if (decades <= 0.7 * wanted) add(power(2)), add(power(5));
            }
            return result;
        }
    }
    const double span = range.high - range.low;
    if (is_one_value(range) || !std::isfinite(span)) return {range.low};
    const double rough = span / std::max(wanted, 1), power = std::pow(10, std::floor(std::log10(rough)));
    const double digit = rough / power < 1.5 ? 1 : rough / power < 3.5 ? 2 : rough / power < 7.5 ? 5 : 10;
    const double step = digit * power;
    const double first = std::ceil(range.low / step - slack), last = std::floor(range.high / step + slack);
    for (double i = first; i <= last; ++i) result.push_back(i == 0 ? 0 : i * step);
    return result;
}

std::string tick_label(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", value);
    std::string label = text;
    // 1e-06 reads better as 1e-6.
    if (const auto e = label.find('e'); e != std::string::npos) {
        std::size_t digit = e + 1;
        if (label[digit] == '+')
            label.erase(digit, 1);
        else
            ++digit;
        while (digit + 1 < label.size() && label[digit] == '0') label.erase(digit, 1);
    }
    return label;
}

}  // namespace gradus

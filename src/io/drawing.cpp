#include "gradus/io/drawing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

namespace gradus {
namespace {

using Polyline = std::vector<Eigen::Vector2d>;

/// A letter: capitals are 10 high, small letters 7, the base line is at 0, y points up.
/// Its path: M x y moves, L x y draws a line, A cx cy rx ry from to draws a line to the start of an elliptic arc
/// (degrees) and the arc, B the same with a move instead of the line.
struct Glyph {
    char letter;
    double width;
    const char* path;
};

constexpr Glyph glyphs[] = {
    {'A', 8, "M 0 0 L 4 10 L 8 0 M 1.3 3.2 L 6.7 3.2"},
    {'B', 6.6, "M 0 5.2 L 3.6 5.2 A 3.6 7.6 2.4 2.4 -90 90 L 0 10 L 0 0 L 3.9 0 A 3.9 2.6 2.7 2.6 -90 90"},
    {'C', 7.8, "B 4.4 5 4.4 5 46 314"},
    {'D', 7.4, "M 0 0 L 0 10 L 2.8 10 A 2.8 5 4.6 5 90 -90 L 0 0"},
    {'E', 5.8, "M 5.8 0 L 0 0 L 0 10 L 5.6 10 M 0 5.2 L 5 5.2"},
    {'F', 5.4, "M 0 0 L 0 10 L 5.4 10 M 0 5.1 L 4.7 5.1"},
    {'G', 8.4, "B 4.3 5 4.3 5 48 345 L 8.45 4.8 L 5 4.8"},
    {'H', 7.2, "M 0 0 L 0 10 M 7.2 0 L 7.2 10 M 0 5.2 L 7.2 5.2"},
    {'I', 0.8, "M 0.4 0 L 0.4 10"},
    {'J', 4.6, "M 4.6 10 L 4.6 2.4 A 2.3 2.4 2.3 2.4 0 -165"},
    {'K', 6.8, "M 0 0 L 0 10 M 6.4 10 L 0 4 M 2.3 6.1 L 6.8 0"},
    {'L', 5.2, "M 0 10 L 0 0 L 5.2 0"},
    {'M', 8.6, "M 0 0 L 0 10 L 4.3 2.5 L 8.6 10 L 8.6 0"},
    {'N', 7.2, "M 0 0 L 0 10 L 7.2 0 L 7.2 10"},
    {'O', 8.8, "B 4.4 5 4.4 5 0 360"},
    {'P', 6.2, "M 0 0 L 0 10 L 3.4 10 A 3.4 7.3 2.8 2.7 90 -90 L 0 4.6"},
    {'Q', 8.8, "B 4.4 5 4.4 5 0 360 M 5.4 2.6 L 8.6 -0.8"},
    {'R', 6.6, "M 0 0 L 0 10 L 3.5 10 A 3.5 7.4 2.7 2.6 90 -90 L 0 4.8 M 3.2 4.8 L 6.6 0"},
    {'S', 6.4, "B 3.2 7.5 2.8 2.5 30 270 A 3.2 2.5 3.2 2.5 90 -150"},
    {'T', 7, "M 0 10 L 7 10 M 3.5 10 L 3.5 0"},
    {'U', 7, "M 0 10 L 0 3.5 A 3.5 3.5 3.5 3.5 180 360 L 7 10"},
    {'V', 7.8, "M 0 10 L 3.9 0 L 7.8 10"},
    {'W', 11, "M 0 10 L 2.7 0 L 5.5 9.4 L 8.3 0 L 11 10"},
    {'X', 7, "M 0 0 L 7 10 M 0 10 L 7 0"},
    {'Y', 7.2, "M 0 10 L 3.6 5 L 7.2 10 M 3.6 5 L 3.6 0"},
    {'Z', 6.6, "M 0 10 L 6.6 10 L 0 0 L 6.6 0"},
    {'0', 5.8, "B 2.9 5 2.9 5 0 360"},
    {'1', 5.8, "M 0.9 7.9 L 3.3 10 L 3.3 0"},
    {'2', 5.8, "B 2.9 7.2 2.7 2.8 165 -32 L 0.1 0 L 5.8 0"},
    {'3', 5.8, "B 2.8 7.5 2.5 2.5 150 -90 L 1.8 5 M 2.8 5 A 2.8 2.6 3 2.6 90 -150"},
    {'4', 5.8, "M 4.4 0 L 4.4 10 L 0 3 L 6 3"},
    {'5', 5.8, "M 5.2 10 L 1 10 L 0.5 5.3 A 2.8 3.2 3 3.2 130 -150"},
    {'6', 5.8, "B 2.9 3.1 2.9 3.1 0 360 B 5.4 3.4 5.4 6.6 180 105"},
    {'7', 5.8, "M 0 10 L 5.8 10 L 1.8 0"},
    {'8', 5.8, "B 2.9 7.6 2.4 2.4 0 360 B 2.9 2.6 2.9 2.6 0 360"},
    {'9', 5.8, "B 2.9 6.9 2.9 3.1 0 360 B 0.4 6.6 5.4 6.6 0 -75"},
    {'a', 5.6, "B 2.8 3.5 2.8 3.5 0 360 M 5.6 7 L 5.6 0"},
    {'b', 5.6, "M 0 10.5 L 0 0 B 2.8 3.5 2.8 3.5 0 360"},
    {'c', 5.1, "B 3 3.5 3 3.5 46 314"},
    {'d', 5.6, "B 2.8 3.5 2.8 3.5 0 360 M 5.6 10.5 L 5.6 0"},
    {'e', 5.7, "M 0.1 3.6 L 5.7 3.6 A 2.85 3.5 2.85 3.5 2 318"},
    {'f', 3.6, "B 3.2 8.7 1.8 1.9 70 180 L 1.4 0 M 0 6.8 L 3.4 6.8"},
    {'g', 5.6, "B 2.8 3.5 2.8 3.5 0 360 M 5.6 7 L 5.6 -0.3 A 2.8 -0.3 2.8 2.9 0 -150"},
    {'h', 5.2, "M 0 0 L 0 10.5 M 0 4.2 A 2.6 4.2 2.6 2.8 180 0 L 5.2 0"},
    {'i', 0.4, "M 0.2 0 L 0.2 7 M 0.2 9.5 L 0.2 9.8"},
    {'j', 1.6, "M 1.6 7 L 1.6 -1.5 A 0 -1.5 1.6 1.6 0 -80 M 1.6 9.5 L 1.6 9.8"},
    {'k', 5, "M 0 0 L 0 10.5 M 4.7 7 L 0 2.8 M 1.8 4.4 L 5 0"},
    {'l', 0.4, "M 0.2 0 L 0.2 10.5"},
    {'m', 8.8, "M 0 0 L 0 7 M 0 4.6 A 2.2 4.6 2.2 2.4 180 0 L 4.4 0 M 4.4 4.6 A 6.6 4.6 2.2 2.4 180 0 L 8.8 0"},
    {'n', 5.2, "M 0 0 L 0 7 M 0 4.2 A 2.6 4.2 2.6 2.8 180 0 L 5.2 0"},
    {'o', 5.8, "B 2.9 3.5 2.9 3.5 0 360"},
    {'p', 5.6, "M 0 7 L 0 -3 B 2.8 3.5 2.8 3.5 0 360"},
    {'q', 5.6, "M 5.6 7 L 5.6 -3 B 2.8 3.5 2.8 3.5 0 360"},
    {'r', 3.2, "M 0 0 L 0 7 M 0 4 A 2.9 4 2.9 3 180 80"},
    {'s', 4.6, "B 2.3 5.25 2 1.75 30 270 A 2.3 1.75 2.3 1.75 90 -150"},
    {'t', 3.5, "M 1.4 9.2 L 1.4 1.8 A 3.2 1.8 1.8 1.8 180 285 M 0 7 L 3.4 7"},
    {'u', 5.2, "M 0 7 L 0 2.7 A 2.6 2.7 2.6 2.7 180 360 M 5.2 7 L 5.2 0"},
    {'v', 5.4, "M 0 7 L 2.7 0 L 5.4 7"},
    {'w', 8, "M 0 7 L 1.9 0 L 4 6.6 L 6.1 0 L 8 7"},
    {'x', 5, "M 0 0 L 5 7 M 0 7 L 5 0"},
    {'y', 5.5, "M 0 7 L 2.8 0 M 5.5 7 L 1.7 -2.6 L 0.3 -3"},
    {'z', 4.9, "M 0.1 7 L 4.8 7 L 0 0 L 4.9 0"},
    {' ', 1.6, ""},
    {'.', 0.2, "M 0.1 0 L 0.1 0.1"},
    {',', 0.6, "M 0.5 0.2 L 0 -1.7"},
    {':', 0.2, "M 0.1 0.2 L 0.1 0.3 M 0.1 5.6 L 0.1 5.7"},
    {';', 0.6, "M 0.5 0.2 L 0 -1.7 M 0.5 5.6 L 0.5 5.7"},
    {'!', 0.2, "M 0.1 0 L 0.1 0.1 M 0.1 3 L 0.1 10"},
    {'?', 5, "B 2.5 7.5 2.5 2.5 165 -50 L 2.4 4.3 L 2.4 3 M 2.4 0 L 2.4 0.1"},
    {'\'', 0.2, "M 0.1 7.5 L 0.1 10"},
    {'"', 2, "M 0 7.5 L 0 10 M 2 7.5 L 2 10"},
    {'(', 2, "B 4.6 4 4.6 7 125 235"},
    {')', 2, "B -2.6 4 4.6 7 55 -55"},
    {'[', 2, "M 2 11 L 0 11 L 0 -2 L 2 -2"},
    {']', 2, "M 0 11 L 2 11 L 2 -2 L 0 -2"},
    {'{', 2.6, "M 2.6 11 L 1.4 10.4 L 1.4 5.4 L 0 4.5 L 1.4 3.6 L 1.4 -1.4 L 2.6 -2"},
    {'}', 2.6, "M 0 11 L 1.2 10.4 L 1.2 5.4 L 2.6 4.5 L 1.2 3.6 L 1.2 -1.4 L 0 -2"},
    {'/', 4, "M 0 -1.5 L 4 11"},
    {'\\', 4, "M 0 11 L 4 -1.5"},
    {'|', 0.8, "M 0.4 -2 L 0.4 11"},
    {'-', 3.6, "M 0 4 L 3.6 4"},
    {'_', 6, "M 0 -1.5 L 6 -1.5"},
    {'+', 6, "M 0 4.4 L 6 4.4 M 3 1.4 L 3 7.4"},
    {'=', 6, "M 0 3.1 L 6 3.1 M 0 5.9 L 6 5.9"},
    {'<', 5.6, "M 5.6 7.6 L 0 4.4 L 5.6 1.2"},
    {'>', 5.6, "M 0 7.6 L 5.6 4.4 L 0 1.2"},
    {'%', 8.8, "B 1.7 7.8 1.7 2.2 0 360 B 7.1 2.2 1.7 2.2 0 360 M 7.4 10 L 1.4 0"},
    {'*', 4.4, "M 2.2 5.4 L 2.2 10 M 0.2 6.6 L 4.2 8.8 M 0.2 8.8 L 4.2 6.6"},
    {'#', 6.6, "M 1.4 0 L 2.6 10 M 4.4 0 L 5.6 10 M 0.2 3.3 L 6.2 3.3 M 0.6 6.7 L 6.6 6.7"},
    {'&', 7.4, "M 7.4 0 L 1.8 6.9 A 3.1 8.1 1.8 1.9 205 -40 L 1 4.4 A 2.8 2.4 2.8 2.4 140 330 L 7 4.6"},
    {'^', 5, "M 0 6.5 L 2.5 10 L 5 6.5"},
    {'~', 6, "B 1.6 3.9 1.6 1.3 170 30 L 3.4 4.1 A 4.4 4.9 1.6 1.3 210 350"},
    {'`', 1.4, "M 0 10.4 L 1.4 8.4"},
    {'$', 6.4, "B 3.2 7.2 2.6 2 30 270 A 3.2 2.8 2.9 2.4 90 -150 M 3.2 -1.2 L 3.2 11"},
    {'@', 9.6, "B 4.6 4.4 2 2.2 0 360 M 6.6 6.6 L 6.6 3.6 A 8 3.6 1.4 1.6 180 300 A 4.8 4.4 4.8 5.4 -10 310"},
};
constexpr Glyph unknown{'\0', 5, "M 0 0 L 5 0 L 5 10 L 0 10 L 0 0"};
constexpr double letter_gap = 2.4, units_per_size = 10;

struct Letter {
    double width = 0;
    std::vector<Polyline> strokes;
};

Letter trace(const Glyph& glyph) {
    Letter letter{glyph.width, {}};
    std::istringstream path(glyph.path);
    for (char command; path >> command;) {
        if (command == 'M' || command == 'L') {
            Eigen::Vector2d p;
            path >> p.x() >> p.y();
            if (command == 'M') letter.strokes.emplace_back();
            letter.strokes.back().push_back(p);
            continue;
        }
        double cx, cy, rx, ry, from, to;
        path >> cx >> cy >> rx >> ry >> from >> to;
        if (command == 'B') letter.strokes.emplace_back();
        const int steps = std::max(2, static_cast<int>(std::ceil(std::abs(to - from) / 9)));
        for (int i = 0; i <= steps; ++i) {
            const double angle = (from + (to - from) * i / steps) * std::numbers::pi / 180;
            letter.strokes.back().emplace_back(cx + rx * std::cos(angle), cy + ry * std::sin(angle));
        }
    }
    return letter;
}

const Letter& letter_of(char c) {
    static const std::array<Letter, 128> letters = [] {
        std::array<Letter, 128> table;
        table.fill(trace(unknown));
        for (const Glyph& glyph : glyphs) table[static_cast<unsigned char>(glyph.letter)] = trace(glyph);
        return table;
    }();
    const auto code = static_cast<unsigned char>(c);
    return letters[code < 128 ? code : 0];
}

double distance_to_segment(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    const Eigen::Vector2d along = b - a;
    const double squared = along.squaredNorm();
    const double t = squared > 0 ? std::clamp((p - a).dot(along) / squared, 0.0, 1.0) : 0.0;
    return (p - a - t * along).norm();
}

/// Lays colour along strokes; a pixel under several of them is covered once.
void cover(Image& image, const std::vector<Polyline>& strokes, double width, const Colour& colour) {
    Eigen::Array2d low(1e300, 1e300), high(-1e300, -1e300);
    for (const Polyline& stroke : strokes)
        for (const Eigen::Vector2d& p : stroke) low = low.min(p.array()), high = high.max(p.array());
    if (!(low <= high).all()) return;
    const auto clamped = [](double x, int limit) {
        return static_cast<int>(std::clamp(std::floor(x), 0.0, static_cast<double>(limit)));
    };
    const double reach = width / 2 + 1;
    const int x0 = clamped(low.x() - reach, image.width), x1 = clamped(high.x() + reach + 1, image.width);
    const int y0 = clamped(low.y() - reach, image.height), y1 = clamped(high.y() + reach + 1, image.height);
    if (x0 >= x1 || y0 >= y1) return;
    std::vector<double> covered(static_cast<std::size_t>(x1 - x0) * (y1 - y0), 0);
    for (const Polyline& stroke : strokes) {
        for (std::size_t i = 0; i < stroke.size(); ++i) {
            const Eigen::Vector2d &a = stroke[i], &b = stroke[std::min(i + 1, stroke.size() - 1)];
            if (i > 0 && i + 1 == stroke.size()) break;
            const int left = std::max(x0, clamped(std::min(a.x(), b.x()) - reach, image.width));
            const int right = std::min(x1, clamped(std::max(a.x(), b.x()) + reach + 1, image.width));
            const int top = std::max(y0, clamped(std::min(a.y(), b.y()) - reach, image.height));
            const int bottom = std::min(y1, clamped(std::max(a.y(), b.y()) + reach + 1, image.height));
            for (int y = top; y < bottom; ++y)
                for (int x = left; x < right; ++x) {
                    const double distance = distance_to_segment({x + 0.5, y + 0.5}, a, b);
                    // Coverage of a pixel by a half-plane at this distance; a line thinner than a pixel covers its
                    // width at most.
                    const double part = std::clamp(width / 2 - distance + 0.5, 0.0, std::min(1.0, width));
                    double& c = covered[static_cast<std::size_t>(y - y0) * (x1 - x0) + (x - x0)];
                    c = std::max(c, part);
                }
        }
    }
    for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x)
            image.blend(x, y, colour, covered[static_cast<std::size_t>(y - y0) * (x1 - x0) + (x - x0)]);
}

}  // namespace

void fill_box(Image& image, const Eigen::Vector2d& low, const Eigen::Vector2d& high, const Colour& colour) {
    const int x0 = std::max(0, static_cast<int>(std::floor(low.x()))),
              x1 = std::min(image.width, static_cast<int>(std::ceil(high.x())));
    const int y0 = std::max(0, static_cast<int>(std::floor(low.y()))),
              y1 = std::min(image.height, static_cast<int>(std::ceil(high.y())));
    const auto part = [](double a, double b, int i) {
        return std::clamp(std::min(b, i + 1.0) - std::max(a, static_cast<double>(i)), 0.0, 1.0);
    };
    for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x)
            image.blend(x, y, colour, part(low.x(), high.x(), x) * part(low.y(), high.y(), y));
}

void draw_polyline(Image& image, std::span<const Eigen::Vector2d> points, double width, const Colour& colour) {
    cover(image, {Polyline(points.begin(), points.end())}, width, colour);
}

void draw_segment(Image& image, const Eigen::Vector2d& from, const Eigen::Vector2d& to, double width,
                  const Colour& colour) {
    cover(image, {Polyline{from, to}}, width, colour);
}

void paste(Image& image, const Image& source, int x, int y) {
    const int first = std::max(0, -x), last = std::min(source.width, image.width - x);
    if (first >= last) return;
    for (int row = std::max(0, -y); row < std::min(source.height, image.height - y); ++row) {
        const auto* from = source.rgb.data() + 3 * (static_cast<std::size_t>(row) * source.width + first);
        std::copy(from, from + 3 * (last - first),
                  image.rgb.data() + 3 * (static_cast<std::size_t>(row + y) * image.width + x + first));
    }
}

double text_width(std::string_view text, const TextStyle& style) {
    double width = text.empty() ? 0 : -letter_gap;
    for (const char c : text) width += letter_of(c).width + letter_gap;
    return width * style.size / units_per_size;
}

void draw_text(Image& image, const Eigen::Vector2d& at, std::string_view text, const TextStyle& style) {
    const double unit = style.size / units_per_size, length = text_width(text, style);
    double pen = style.align == Align::Left ? 0 : style.align == Align::Centre ? -length / 2 : -length;
    const double width = std::max(1.0, style.weight * style.size);
    for (const char c : text) {
        const Letter& letter = letter_of(c);
        std::vector<Polyline> strokes = letter.strokes;
        for (Polyline& stroke : strokes)
            for (Eigen::Vector2d& p : stroke) {
                const double along = pen + unit * p.x(), up = unit * p.y();
                p = style.upwards ? Eigen::Vector2d(at.x() - up, at.y() - along)
                                  : Eigen::Vector2d(at.x() + along, at.y() - up);
            }
        cover(image, strokes, width, style.colour);
        pen += unit * (letter.width + letter_gap);
    }
}

}  // namespace gradus

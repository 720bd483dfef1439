#include "gradus/io/figure.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "gradus/io/drawing.hpp"

namespace gradus {
namespace {

/// Space a title takes, capitals and a little air below and above.
int title_height(const std::string& title, double size) {
    return title.empty() ? 0 : static_cast<int>(std::ceil(2.4 * size));
}

double widest_label(const std::vector<double>& values, const TextStyle& style) {
    double widest = 0;
    for (const double v : values) widest = std::max(widest, text_width(tick_label(v), style));
    return widest;
}

constexpr double bar_thickness = 1.5, tick_length = 0.45, label_gap = 0.5;  // in text sizes

}  // namespace

Image compose(std::span<const Panel> panels, const ComposeOptions& options) {
    if (panels.empty()) throw std::invalid_argument("compose: there are no panels");
    if (options.columns < 1)
        throw std::invalid_argument("compose: columns " + std::to_string(options.columns) + " is less than 1");
    const std::size_t columns = std::min(static_cast<std::size_t>(options.columns), panels.size());
    const std::size_t rows = (panels.size() + columns - 1) / columns;
    std::vector<int> widths(columns, 0), heights(rows, 0), titles(rows, 0);
    for (std::size_t i = 0; i < panels.size(); ++i) {
        widths[i % columns] = std::max(widths[i % columns], panels[i].image.width);
        heights[i / columns] = std::max(heights[i / columns], panels[i].image.height);
        titles[i / columns] = std::max(titles[i / columns], title_height(panels[i].title, options.text_size));
    }
    const double head_size = 1.25 * options.text_size;
    const int head = title_height(options.title, head_size);
    int width = options.gap, height = options.gap + head;
    for (const int w : widths) width += w + options.gap;
    for (std::size_t r = 0; r < rows; ++r) height += titles[r] + heights[r] + options.gap;

    Image image(width, height, options.background);
    if (head > 0)
        draw_text(image, {width / 2.0, options.gap + 1.2 * head_size}, options.title,
                  {.size = head_size, .colour = options.text, .align = Align::Centre, .weight = 0.15});
    int y = options.gap + head;
    for (std::size_t r = 0; r < rows; ++r) {
        int x = options.gap;
        for (std::size_t c = 0; c < columns && r * columns + c < panels.size(); ++c) {
            const Panel& panel = panels[r * columns + c];
            draw_text(image, {x + widths[c] / 2.0, y + 1.3 * options.text_size}, panel.title,
                      {.size = options.text_size, .colour = options.text, .align = Align::Centre});
            paste(image, panel.image, x + (widths[c] - panel.image.width) / 2,
                  y + titles[r] + (heights[r] - panel.image.height) / 2);
            x += widths[c] + options.gap;
        }
        y += titles[r] + heights[r] + options.gap;
    }
    return image;
}

double colour_bar_width(const ColourBar& bar) {
    const TextStyle style{.size = bar.text_size};
    const double beside =
        (bar_thickness + tick_length + label_gap) * bar.text_size + widest_label(ticks(bar.range, bar.scale, 6), style);
    return std::max(beside, text_width(bar.title, style));
}

void draw_colour_bar(Image& image, const Eigen::Vector2d& low, const Eigen::Vector2d& high, const ColourBar& bar) {
    const double size = bar.text_size;
    const TextStyle style{.size = size, .colour = bar.text};
    draw_text(image, {low.x(), low.y() + size}, bar.title, style);
    const double left = std::round(low.x()), right = left + std::round(bar_thickness * size);
    const double top = std::round(low.y() + (bar.title.empty() ? 0.5 : 2.4) * size),
                 bottom = std::round(high.y() - 0.5 * size);
    for (double y = top; y < bottom; ++y)
        fill_box(image, {left, y}, {right, y + 1}, colour_at(bar.map, (bottom - y - 0.5) / (bottom - top)));
    for (const double value : ticks(bar.range, bar.scale, 6)) {
        const double y = bottom - place_on(bar.range, bar.scale, value) * (bottom - top);
        draw_segment(image, {right, y}, {right + tick_length * size, y}, std::max(1.0, 0.09 * size), bar.text);
        draw_text(image, {right + (tick_length + label_gap) * size, y + size / 2}, tick_label(value), style);
    }
}

}  // namespace gradus

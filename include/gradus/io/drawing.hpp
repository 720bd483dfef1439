/// Lines, areas and letters on an image, antialiased. Coordinates are pixels from the left and the top; a pixel is a
/// unit square.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string_view>

#include "gradus/io/image.hpp"

namespace gradus {

/// Lays `colour` over the part of each pixel that is inside the box.
void fill_box(Image& image, const Eigen::Vector2d& low, const Eigen::Vector2d& high, const Colour& colour);

/// Draws a polyline with round joints.
void draw_polyline(Image& image, std::span<const Eigen::Vector2d> points, double width, const Colour& colour);

void draw_segment(Image& image, const Eigen::Vector2d& from, const Eigen::Vector2d& to, double width,
                  const Colour& colour);

/// Copies `source` with its upper left corner at (x, y); what falls outside is left away.
void paste(Image& image, const Image& source, int x, int y);

enum class Align { Left, Centre, Right };

struct TextStyle {
    double size = 14;  ///< height of a capital, pixels, > 0
    Colour colour = hex(0x1c2330);
    Align align = Align::Left;
    bool upwards = false;  ///< written from below to above, for the name of a vertical axis
    double weight = 0.13;  ///< thickness of a stroke, fraction of the size
};

/// Writes a line of text in a stroke font of our own: printable ASCII, anything else as an empty box.
/// @param at  where the base line meets the left end, the middle or the right end of the text, as `align` says
void draw_text(Image& image, const Eigen::Vector2d& at, std::string_view text, const TextStyle& style = {});

/// Length of a text in pixels.
double text_width(std::string_view text, const TextStyle& style = {});

}  // namespace gradus

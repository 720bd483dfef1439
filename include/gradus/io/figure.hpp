/// Figures put together from pictures.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "gradus/io/colour_map.hpp"
#include "gradus/io/image.hpp"

namespace gradus {

struct Panel {
    Image image;
    std::string title = {};  ///< above the picture; may be empty
};

struct ComposeOptions {
    int columns = 1;  ///< pictures side by side; 1 puts them below one another
    int gap = 24;     ///< pixels between and around them
    std::string title = {};
    double text_size = 18;  ///< height of a capital in the panels' titles, pixels
    Colour background = hex(0xffffff);
    Colour text = hex(0x1c2330);
};

/// Puts pictures in rows and columns; a smaller picture is centred in its cell.
/// @throws std::invalid_argument if there are no panels or columns < 1
Image compose(std::span<const Panel> panels, const ComposeOptions& options = {});

struct ColourBar {
    ColourMap map = ColourMap::Sequential;
    Range range = {};
    Scale scale = Scale::Linear;
    std::string title = {};
    double text_size = 14;  ///< height of a capital, pixels
    Colour text = hex(0x1c2330);
};

/// Draws an upright colour bar with ticks at its right and the title above, inside a box of the image.
void draw_colour_bar(Image& image, const Eigen::Vector2d& low, const Eigen::Vector2d& high, const ColourBar& bar);

/// Width in pixels the bar with its texts needs.
double colour_bar_width(const ColourBar& bar);

}  // namespace gradus

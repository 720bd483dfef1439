/// Private to `picture`: triangles and lines in pixel coordinates to pixels.
/// The image is cut into tiles, each drawn alone with its own samples, so memory stays small and threads cannot change
/// the result.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "gradus/io/colour_map.hpp"
#include "gradus/io/image.hpp"
#include "gradus/mesh/tri_mesh.hpp"

namespace gradus::raster {

/// A vertex as projected.
struct ScreenPoint {
    double x = 0, y = 0;  ///< pixels from the left and the top
    double depth = 0;     ///< affine on the screen, greater is nearer
    double weight = 1;    ///< of attributes interpolated on the screen: 1, or nearness to the eye in perspective
};

/// Attributes of a triangle's corners.
struct Corners {
    std::array<float, 3> light{1, 1, 1};  ///< 0 in shadow, 1 in full light
    std::array<float, 3> place{0, 0, 0};  ///< on the colour map
};

/// A line segment in front of the surface, with round ends.
struct Line {
    Eigen::Vector2d from, to;     ///< pixels
    double from_depth, to_depth;  ///< already moved a little to the eye
    double width;                 ///< pixels
    Colour colour;
};

struct Scene {
    int width = 0, height = 0;
    int samples = 3;  ///< per pixel in each direction
    std::span<const ScreenPoint> points;
    std::span<const Triangle> triangles;
    std::span<const Corners> corners;           ///< one per triangle
    std::span<const std::uint8_t> shown_edges;  ///< one per triangle or empty
    std::optional<ColourMap> map;               ///< colours by `place`, else by `fill`
    std::vector<Line> lines;                    ///< drawn in this order over the triangles
    Colour background, edge;
    std::array<Colour, 2> fill, shadow;  ///< of front and of back faces
    double edge_width = 1;               ///< pixels, 0 for none
};

/// Twice the area in pixels, positive if the corners run clockwise as seen (the y axis points down).
double screen_area(const ScreenPoint& a, const ScreenPoint& b, const ScreenPoint& c);

Image draw(const Scene& scene);

}  // namespace gradus::raster

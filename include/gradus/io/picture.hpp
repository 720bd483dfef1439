/// Pictures of triangle meshes: hidden surfaces removed, crisp edges of constant width, colours for a scalar field.
/// A software rasteriser of our own: no display, no graphics library, the same pixels on any number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "gradus/io/colour_map.hpp"
#include "gradus/io/image.hpp"
#include "gradus/mesh/tri_mesh.hpp"

namespace gradus {

enum class CameraProjection { Orthographic, Perspective };

/// Where the picture is taken from. By default the whole mesh is in it.
struct Camera {
    Eigen::Vector3d direction{0.5, -0.8, 0.35};  ///< from the mesh towards the eye, any length
    Eigen::Vector3d up{0, 0, 1};  ///< upright in the picture; another axis is taken if parallel to `direction`
    CameraProjection projection = CameraProjection::Orthographic;
    double view_angle = 20;  ///< perspective only: angle in degrees, in (0, 120), at which the eye sees the whole mesh
    std::optional<Eigen::Vector3d> target =
        {};                            ///< point in the middle of the picture; default: middle of the mesh as projected
    std::optional<double> width = {};  ///< length at the target that spans the picture, > 0; default: the mesh fits
    double margin = 0.03;              ///< free border when the mesh is fitted, fraction of the picture, in [0, 0.5)
};

/// Numbers to colour a mesh with.
struct ScalarField {
    enum class On { Vertices, Triangles };
    std::span<const double> values;  ///< NaN: no value, drawn grey
    On on = On::Vertices;
    ColourMap map = ColourMap::Sequential;
    Scale scale = Scale::Linear;
    std::optional<Range> range = {};  ///< default: that of the values
    std::string title = {};           ///< of the legend
};

/// What is drawn; the spans must outlive the call.
struct DrawnMesh {
    std::span<const Eigen::Vector3d> points;
    std::span<const Triangle> triangles;
    std::optional<ScalarField> field = {};
    std::span<const std::array<int, 2>> features = {};  ///< vertex pairs, drawn as heavy lines
    /// One per triangle, or empty for all edges: bit k shows the edge from corner k to the next. Hides the diagonals of
    /// quadrilaterals.
    std::span<const std::uint8_t> shown_edges = {};
};

enum class Shading { None, Flat, Smooth };

struct RenderOptions {
    int width = 1600, height = 1000;  ///< pixels
    int supersampling = 3;            ///< samples per pixel in each direction, 1 to 8
    Colour background = hex(0xffffff);
    Colour fill = hex(0xfcfaf5);       ///< surface in full light
    Colour shadow = hex(0xa7a5a6);     ///< surface in shadow
    Colour back_fill = hex(0xd9e2ee);  ///< the same for back faces (clockwise as seen)
    Colour back_shadow = hex(0x8593a6);
    Shading shading = Shading::Smooth;
    double crease_angle = 35;  ///< degrees: smooth shading stops where two triangles meet at more
    Colour edge = hex(0x1f2d42);
    /// Pixels; 0 for no edges. Where triangles are only a few pixels wide, edges become thinner, then fainter, so dense
    /// parts keep a middle tone.
    double edge_width = 1.0;
    Colour outline = hex(0x101826);
    double outline_width = 1.8;  ///< pixels, for silhouettes and borders; 0 for none
    Colour feature = hex(0xb5392b);
    double feature_width = 2.4;  ///< pixels
    bool legend = true;          ///< colour bar at the right if there is a field
};

/// Draws a mesh.
/// @throws std::invalid_argument for a bad index, a field or edge mask of the wrong length, a point that is not finite,
/// or an option out of range
Image render(const DrawnMesh& mesh, const Camera& camera = {}, const RenderOptions& options = {});

/// Where a point of space falls in the picture `render` would draw: pixels from the left and the top. For labels and
/// arrows.
Eigen::Vector2d pixel_of(const Eigen::Vector3d& point, const DrawnMesh& mesh, const Camera& camera = {},
                         const RenderOptions& options = {});

}  // namespace gradus

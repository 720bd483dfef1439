#include "gradus/io/picture.hpp"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "gradus/io/drawing.hpp"
#include "gradus/io/figure.hpp"
#include "raster.hpp"

namespace gradus {
namespace {

using raster::ScreenPoint;

[[noreturn]] void refuse(const std::string& what) { throw std::invalid_argument("render: " + what); }

void require(bool holds, const char* what) {
    if (!holds) refuse(what);
}

void check(const DrawnMesh& mesh) {
    const int n = static_cast<int>(mesh.points.size());
    const auto valid = [n](int v) { return v >= 0 && v < n; };
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (const int v : mesh.triangles[t])
            if (!valid(v)) refuse("triangle " + std::to_string(t) + " names vertex " + std::to_string(v));
    for (const auto& [a, b] : mesh.features)
        if (!valid(a) || !valid(b))
            refuse("feature edge " + std::to_string(a) + "-" + std::to_string(b) + " names no vertex");
    for (int v = 0; v < n; ++v)
        if (!mesh.points[v].allFinite()) refuse("point " + std::to_string(v) + " is not finite");
    if (mesh.field) {
        const std::size_t wanted =
            mesh.field->on == ScalarField::On::Vertices ? mesh.points.size() : mesh.triangles.size();
        if (mesh.field->values.size() != wanted)
            refuse("field has " + std::to_string(mesh.field->values.size()) + " values for " + std::to_string(wanted) +
                   " places");
    }
    if (mesh.field && mesh.field->range) {
        require(mesh.field->range->low <= mesh.field->range->high, "range of the field is decreasing");
        require(mesh.field->scale == Scale::Linear || mesh.field->range->low > 0,
                "range of a logarithmic field must be positive");
    }
    require(mesh.shown_edges.empty() || mesh.shown_edges.size() == mesh.triangles.size(),
            "shown_edges needs one entry per triangle");
}

void check(const Camera& camera, const RenderOptions& options) {
    require(camera.direction.allFinite() && camera.direction.norm() > 0, "camera direction is zero or not finite");
    require(camera.view_angle > 0 && camera.view_angle < 120, "view_angle must be in (0, 120) degrees");
    require(!camera.width || (*camera.width > 0 && std::isfinite(*camera.width)), "camera width must be positive");
    require(!camera.target || camera.target->allFinite(), "camera target is not finite");
    require(camera.margin >= 0 && camera.margin < 0.5, "margin must be in [0, 0.5)");
    require(options.width > 0 && options.height > 0, "picture size must be positive");
    require(options.supersampling >= 1 && options.supersampling <= 8, "supersampling must be in 1..8");
    require(options.edge_width >= 0 && options.outline_width >= 0 && options.feature_width >= 0,
            "line widths must not be negative");
}

/// From space to pixels: turned into the frame of the eye, projected, then scaled and shifted in the plane.
struct View {
    Eigen::Matrix3d frame;   ///< rows: to the right, up, to the eye
    Eigen::Vector3d centre;  ///< of the mesh
    double distance = 0;     ///< of the eye from the centre; 0: infinite
    double scale = 1;        ///< pixels per length at the centre
    Eigen::Vector2d shift{0, 0};

    ScreenPoint project(const Eigen::Vector3d& point) const {
        const Eigen::Vector3d p = frame * (point - centre);
        const double nearness = distance > 0 ? distance / (distance - p.z()) : 1;
        return {shift.x() + scale * nearness * p.x(), shift.y() - scale * nearness * p.y(),
                distance > 0 ? nearness : p.z(), nearness};
    }

    /// Depth of a point moved `pixels` to the eye.
    double nearer(const ScreenPoint& p, double pixels) const {
        const double length = pixels / (scale * p.weight);
        return distance > 0 ? p.depth + p.weight * p.weight * length / distance : p.depth + length;
    }
};

Eigen::Matrix3d eye_frame(const Camera& camera) {
    const Eigen::Vector3d to_eye = camera.direction.normalized();
    Eigen::Vector3d right = camera.up.cross(to_eye);
    if (!(right.norm() > 1e-9 * camera.up.norm())) {
        // Looking along `up`: the axis least along the view then points up.
        int axis = 0;
        to_eye.cwiseAbs().minCoeff(&axis);
        right = Eigen::Vector3d::Unit(axis).cross(to_eye);
    }
    right.normalize();
    Eigen::Matrix3d frame;
    frame.row(0) = right, frame.row(1) = to_eye.cross(right), frame.row(2) = to_eye;
    return frame;
}

/// Vertices that are in a triangle or a feature: only they count for fitting.
std::vector<char> used_vertices(const DrawnMesh& mesh) {
    std::vector<char> used(mesh.points.size(), 0);
    for (const Triangle& t : mesh.triangles)
        for (const int v : t) used[v] = 1;
    for (const auto& e : mesh.features) used[e[0]] = used[e[1]] = 1;
    return used;
}

View make_view(const DrawnMesh& mesh, const Camera& camera, double width, double height) {
    View view;
    view.frame = eye_frame(camera);
    const std::vector<char> used = used_vertices(mesh);
    Eigen::AlignedBox3d box;
    for (std::size_t v = 0; v < used.size(); ++v)
        if (used[v]) box.extend(mesh.points[v]);
    if (box.isEmpty()) box.extend(Eigen::Vector3d(0, 0, 0));
    view.centre = box.center();
    if (camera.projection == CameraProjection::Perspective) {
        // From the sphere around the mesh, so the eye is always outside, however far the picture is enlarged.
        const double radius = std::max(box.diagonal().norm() / 2, 1e-300);
        view.distance = radius / std::sin(camera.view_angle * std::numbers::pi / 360);
    }
    Eigen::AlignedBox2d seen;
    for (std::size_t v = 0; v < used.size(); ++v) {
        if (!used[v]) continue;
        const ScreenPoint p = view.project(mesh.points[v]);
        seen.extend(Eigen::Vector2d(p.x, p.y));
    }
    if (seen.isEmpty()) seen.extend(Eigen::Vector2d(0, 0));
    Eigen::Vector2d middle = seen.center();
    double nearness = 1;
    if (camera.target) {
        const ScreenPoint p = view.project(*camera.target);
        middle = {p.x, p.y}, nearness = p.weight;
    }
    const Eigen::Vector2d room(width * (1 - 2 * camera.margin), height * (1 - 2 * camera.margin)), size = seen.sizes();
    if (camera.width)
        view.scale = width / (*camera.width * nearness);
    else if (size.maxCoeff() > 0)
        view.scale = std::min(size.x() > 0 ? room.x() / size.x() : 1e300, size.y() > 0 ? room.y() / size.y() : 1e300);
    view.shift = Eigen::Vector2d(width, height) / 2 - view.scale * middle;
    return view;
}

/// Triangles around each vertex.
struct Fans {
    std::vector<int> start, triangle;
    std::span<const int> of(int v) const {
        return {triangle.data() + start[v], static_cast<std::size_t>(start[v + 1] - start[v])};
    }
};

Fans fans_of(const DrawnMesh& mesh) {
    Fans fans;
    fans.start.assign(mesh.points.size() + 1, 0);
    for (const Triangle& t : mesh.triangles)
        for (const int v : t) ++fans.start[v + 1];
    for (std::size_t v = 0; v < mesh.points.size(); ++v) fans.start[v + 1] += fans.start[v];
    fans.triangle.resize(3 * mesh.triangles.size());
    std::vector<int> next(fans.start.begin(), fans.start.end() - 1);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (const int v : mesh.triangles[t]) fans.triangle[next[v]++] = static_cast<int>(t);
    return fans;
}

/// Light on a surface with normal n in the frame of the eye, in [0, 1]: a large soft lamp at the upper left, and some
/// light from the eye.
float light_on(const Eigen::Vector3d& n) {
    static const Eigen::Vector3d lamp = Eigen::Vector3d(-0.45, 0.65, 0.62).normalized();
    const double lit = 0.5 + 0.5 * n.dot(lamp), facing = std::max(0.0, n.z());
    return static_cast<float>(std::clamp(0.80 * lit * lit + 0.32 * facing, 0.0, 1.0));
}

/// What the steps of one picture share.
struct Prepared {
    std::vector<ScreenPoint> points;
    std::vector<char> back;  ///< per triangle
    Fans fans;
    std::vector<raster::Corners> corners;
};

std::vector<Eigen::Vector3d> normals_to_eye(const DrawnMesh& mesh, const View& view, const std::vector<char>& back) {
    std::vector<Eigen::Vector3d> normals(mesh.triangles.size());
    tbb::parallel_for(std::size_t{0}, normals.size(), [&](std::size_t t) {
        const auto& [a, b, c] = mesh.triangles[t];
        const Eigen::Vector3d ab = mesh.points[b] - mesh.points[a], ac = mesh.points[c] - mesh.points[a];
        normals[t] = (back[t] ? -1.0 : 1.0) * (view.frame * ab.cross(ac));
    });
    return normals;
}

void light_corners(const DrawnMesh& mesh, const View& view, const RenderOptions& options, Prepared& scene) {
    const std::vector<Eigen::Vector3d> normals = normals_to_eye(mesh, view, scene.back);
    if (options.shading == Shading::Flat) {
        tbb::parallel_for(std::size_t{0}, normals.size(),
                          [&](std::size_t t) { scene.corners[t].light.fill(light_on(normals[t].stableNormalized())); });
        return;
    }
    const double least = std::cos(options.crease_angle * std::numbers::pi / 180);
    std::vector<double> norms(normals.size());
    tbb::parallel_for(std::size_t{0}, normals.size(), [&](std::size_t t) { norms[t] = normals[t].norm(); });
    tbb::parallel_for(std::size_t{0}, normals.size(), [&](std::size_t t) {
        for (int k = 0; k < 3; ++k) {
            Eigen::Vector3d sum(0, 0, 0);
            for (const int other : scene.fans.of(mesh.triangles[t][k])) {
                // Seen from opposite sides they share the surface, not the side the light falls on.
                const double sign = scene.back[other] == scene.back[t] ? 1 : -1;
                if (sign * normals[other].dot(normals[t]) >= least * norms[other] * norms[t])
                    sum += sign * normals[other];
            }
            scene.corners[t].light[k] = light_on(sum.stableNormalized());
        }
    });
}

void place_corners(const DrawnMesh& mesh, const ScalarField& field, const Range& range,
                   std::vector<raster::Corners>& corners) {
    const bool by_vertex = field.on == ScalarField::On::Vertices;
    std::vector<float> place(field.values.size());
    for (std::size_t i = 0; i < place.size(); ++i)
        place[i] = static_cast<float>(place_on(range, field.scale, field.values[i]));
    for (std::size_t t = 0; t < corners.size(); ++t)
        for (int k = 0; k < 3; ++k)
            corners[t].place[k] = place[by_vertex ? static_cast<std::size_t>(mesh.triangles[t][k]) : t];
}

/// How far lines are moved to the eye, in widths, since the surface beside them rises to it. Features lie on slopes of
/// up to 80 degrees; one side of an outline is free, and moving it further would show it where the surface dips into
/// another.
constexpr double feature_lift = 3, outline_lift = 0.5;

raster::Line line_between(const View& view, const ScreenPoint& a, const ScreenPoint& b, double width, double lift,
                          const Colour& colour) {
    const double pixels = lift * width;
    return {{a.x, a.y}, {b.x, b.y}, view.nearer(a, pixels), view.nearer(b, pixels), width, colour};
}

/// Edges on the border or between a front and a back face.
std::vector<std::array<int, 2>> outline_edges(const DrawnMesh& mesh, const Prepared& scene) {
    std::vector<std::array<int, 2>> outline;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (int k = 0; k < 3; ++k) {
            const int a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
            bool inner = false, first = true;
            for (const int other : scene.fans.of(a)) {
                if (other == static_cast<int>(t)) continue;
                const Triangle& o = mesh.triangles[other];
                if (o[0] != b && o[1] != b && o[2] != b) continue;
                inner = inner || scene.back[other] == scene.back[t];
                first = first && other > static_cast<int>(t);
            }
            if (!inner && first) outline.push_back({a, b});
        }
    }
    return outline;
}

ColourBar legend_of(const ScalarField& field, int height) {
    return {.map = field.map,
            .range = field.range.value_or(range_of(field.values, field.scale)),
            .scale = field.scale,
            .title = field.title,
            .text_size = std::clamp(height / 62.0, 8.0, 60.0)};
}

/// Width of the strip kept free for the legend, at the right.
int legend_width(const DrawnMesh& mesh, const RenderOptions& options) {
    if (!mesh.field || !options.legend) return 0;
    const ColourBar bar = legend_of(*mesh.field, options.height);
    const int wanted = static_cast<int>(std::ceil(colour_bar_width(bar) + 3 * bar.text_size));
    return std::min(wanted, options.width / 2);
}

void add_legend(Image& image, const ScalarField& field, double left) {
    const ColourBar bar = legend_of(field, image.height);
    draw_colour_bar(image, {left + 1.5 * bar.text_size, 0.2 * image.height},
                    {image.width - bar.text_size, 0.8 * image.height}, bar);
}

}  // namespace

Image render(const DrawnMesh& mesh, const Camera& camera, const RenderOptions& options) {
    check(mesh), check(camera, options);
    const int width = options.width - legend_width(mesh, options);
    const View view = make_view(mesh, camera, width, options.height);
    Prepared scene;
    scene.points.resize(mesh.points.size());
    tbb::parallel_for(std::size_t{0}, mesh.points.size(),
                      [&](std::size_t v) { scene.points[v] = view.project(mesh.points[v]); });
    scene.back.resize(mesh.triangles.size());
    tbb::parallel_for(std::size_t{0}, mesh.triangles.size(), [&](std::size_t t) {
        const auto& [a, b, c] = mesh.triangles[t];
        scene.back[t] = raster::screen_area(scene.points[a], scene.points[b], scene.points[c]) > 0;
    });
    scene.corners.resize(mesh.triangles.size());
    if (options.shading == Shading::Smooth || options.outline_width > 0) scene.fans = fans_of(mesh);
    if (options.shading != Shading::None) light_corners(mesh, view, options, scene);

    raster::Scene drawing;
    drawing.width = width, drawing.height = options.height, drawing.samples = options.supersampling;
    drawing.points = scene.points, drawing.triangles = mesh.triangles, drawing.corners = scene.corners;
    drawing.shown_edges = mesh.shown_edges;
    drawing.background = options.background, drawing.edge = options.edge, drawing.edge_width = options.edge_width;
    drawing.fill = {options.fill, options.back_fill}, drawing.shadow = {options.shadow, options.back_shadow};
    if (mesh.field) {
        drawing.map = mesh.field->map;
        place_corners(mesh, *mesh.field, mesh.field->range.value_or(range_of(mesh.field->values, mesh.field->scale)),
                      scene.corners);
    }
    const auto add_lines = [&](std::span<const std::array<int, 2>> edges, double thickness, double lift,
                               const Colour& colour) {
        if (thickness > 0)
            for (const auto& [a, b] : edges)
                drawing.lines.push_back(line_between(view, scene.points[a], scene.points[b], thickness, lift, colour));
    };
    if (options.outline_width > 0)
        add_lines(outline_edges(mesh, scene), options.outline_width, outline_lift, options.outline);
    add_lines(mesh.features, options.feature_width, feature_lift, options.feature);
    Image picture = raster::draw(drawing);
    if (width == options.width) return picture;
    Image image(options.width, options.height, options.background);
    paste(image, picture, 0, 0);
    add_legend(image, *mesh.field, width);
    return image;
}

Eigen::Vector2d pixel_of(const Eigen::Vector3d& point, const DrawnMesh& mesh, const Camera& camera,
                         const RenderOptions& options) {
    check(mesh), check(camera, options);
    const ScreenPoint p =
        make_view(mesh, camera, options.width - legend_width(mesh, options), options.height).project(point);
    return {p.x, p.y};
}

}  // namespace gradus

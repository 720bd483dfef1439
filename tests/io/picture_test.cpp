#include "gradus/io/picture.hpp"

#include <tbb/global_control.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

using namespace gradus;

namespace {

using Points = std::vector<Eigen::Vector3d>;
using Triangles = std::vector<Triangle>;

const Colour black{0, 0, 0}, white{1, 1, 1};

/// Seen from above, the picture filled to its border.
const Camera from_above{.direction = {0, 0, 1}, .up = {0, 1, 0}, .margin = 0};

/// Black surfaces on white, no lines, no light.
RenderOptions silhouette(int width, int height) {
    return {.width = width,
            .height = height,
            .fill = black,
            .back_fill = black,
            .shading = Shading::None,
            .edge_width = 0,
            .outline_width = 0};
}

/// Part of the picture that is dark, in [0, 1].
double darkness(const Image& image) {
    double sum = 0;
    for (const auto byte : image.rgb) sum += 255 - byte;
    return sum / (255.0 * static_cast<double>(image.rgb.size()));
}

struct Mesh {
    Points points;
    Triangles triangles;
    DrawnMesh view() const { return {.points = points, .triangles = triangles}; }
};

/// A height field over [0, 1]^2 with n x n cells and jittered inner points.
Mesh bumpy_square(int n) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> draw(-0.3, 0.3);
    Mesh mesh;
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n; ++j) {
            const bool inner = i > 0 && j > 0 && i < n && j < n;
            const double dx = inner ? draw(random) : 0, dy = inner ? draw(random) : 0;
            mesh.points.emplace_back((i + dx) / n, (j + dy) / n, 0.1 * draw(random));
        }
    const auto at = [n](int i, int j) { return i * (n + 1) + j; };
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    return mesh;
}

Mesh sphere(int n) {
    Mesh mesh;
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j < 2 * n; ++j) {
            const bool pole = i == 0 || i == n;
            if (pole && j > 0) continue;
            const double theta = std::numbers::pi * i / n, phi = std::numbers::pi * j / n;
            mesh.points.emplace_back(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
        }
    const auto at = [n](int i, int j) {
        return i == 0 ? 0 : i == n ? 1 + 2 * n * (n - 1) : 1 + 2 * n * (i - 1) + j % (2 * n);
    };
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < 2 * n; ++j) {
            if (i + 1 < n) mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            if (i == 0) continue;
            mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    return mesh;
}

const Mesh square{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}};

}  // namespace

TEST_CASE("half a square covers half the picture", "[io][exact]") {
    const Triangles half{{0, 1, 2}};
    const Image image = render({.points = square.points, .triangles = half}, from_above, silhouette(150, 150));
    CHECK(darkness(image) == Approx(0.5).epsilon(0.005));
    // The right angle is at the lower right.
    CHECK(image.at(140, 140).r == 0);
    CHECK(image.at(10, 10).r == 1);
}

TEST_CASE("a sphere covers a disc", "[io][converges]") {
    const CameraProjection projection = GENERATE(CameraProjection::Orthographic, CameraProjection::Perspective);
    Camera camera = from_above;
    camera.projection = projection;
    const Mesh mesh = sphere(100);
    CHECK(darkness(render(mesh.view(), camera, silhouette(200, 200))) == Approx(std::numbers::pi / 4).epsilon(0.003));
    CHECK(darkness(render(mesh.view(), camera, silhouette(400, 200))) == Approx(std::numbers::pi / 8).epsilon(0.003));
}

TEST_CASE("no gaps open between triangles", "[io][property]") {
    const Mesh mesh = bumpy_square(GENERATE(3, 40, 150));
    const int samples = GENERATE(1, 3);
    RenderOptions options = silhouette(123, 123);
    options.supersampling = samples;
    const Image image = render(mesh.view(), from_above, options);
    int light = 0;
    for (int y = 1; y < 122; ++y)
        for (int x = 1; x < 122; ++x) light += image.at(x, y).r > 0;
    CHECK(light == 0);
}

TEST_CASE("what is hidden leaves no trace", "[io][exact]") {
    // A smaller square with features below the first, and the first again with features of its own below everything.
    Mesh both = square;
    for (const double z : {-0.5, -1.0})
        for (const Eigen::Vector3d& p : square.points)
            both.points.emplace_back(0.25 + 0.5 * p.x(), 0.25 + 0.5 * p.y(), z);
    both.triangles = {{4, 5, 6}, {0, 1, 2}, {8, 10, 9}, {0, 2, 3}, {4, 6, 7}};
    const std::vector<std::array<int, 2>> hidden{{4, 6}, {8, 9}};
    const Camera camera{.direction = {0, 0, 1}, .up = {0, 1, 0}, .target = Eigen::Vector3d(0.5, 0.5, 0), .width = 1.2};
    const RenderOptions options{.width = 200, .height = 200, .outline_width = 0};
    const Image alone = render(square.view(), camera, options);
    CHECK(render({.points = both.points, .triangles = both.triangles, .features = hidden}, camera, options).rgb ==
          alone.rgb);
    const std::vector<std::array<int, 2>> shown{{0, 1}};
    CHECK(render({.points = both.points, .triangles = both.triangles, .features = shown}, camera, options).rgb !=
          alone.rgb);
}

TEST_CASE("edges keep their width however far the picture is enlarged", "[io][exact]") {
    const double seen = GENERATE(0.5, 1e-2, 1e-6), width = GENERATE(1.0, 2.0, 3.0);
    RenderOptions options = silhouette(200, 200);
    options.fill = options.background = white;
    options.edge = black, options.edge_width = width;
    Camera camera = from_above;
    camera.target = Eigen::Vector3d(0.5, 0.5, 0);
    camera.width = seen;
    // Only the diagonal is in the picture, from corner to corner.
    const double length = 200 * std::numbers::sqrt2;
    CHECK(darkness(render(square.view(), camera, options)) * 200 * 200 == Approx(length * width).epsilon(0.03));

    const std::vector<std::uint8_t> no_diagonal{0b011, 0b110};
    CHECK(darkness(render({.points = square.points, .triangles = square.triangles, .shown_edges = no_diagonal}, camera,
                          options)) == 0);
    options.edge_width = 0, options.feature = black, options.feature_width = width;
    const std::vector<std::array<int, 2>> diagonal{{2, 0}};
    CHECK(darkness(
              render({.points = square.points, .triangles = square.triangles, .features = diagonal}, camera, options)) *
              200 * 200 ==
          Approx(length * width).epsilon(0.03));
}

TEST_CASE("shown edges are named by their first corner, seen from either side", "[io]") {
    const Triangles one{{0, 1, 2}};
    const int bit = GENERATE(0, 1, 2);
    const bool from_below = GENERATE(false, true);
    const std::vector<std::uint8_t> shown{static_cast<std::uint8_t>(1 << bit)};
    RenderOptions options = silhouette(100, 100);
    options.fill = options.back_fill = options.background = white;
    options.edge = black, options.edge_width = 6;
    Camera camera = from_above;
    if (from_below) camera.direction = {0, 0, -1};
    const DrawnMesh view{.points = square.points, .triangles = one, .shown_edges = shown};
    const Image image = render(view, camera, options);
    for (int k = 0; k < 3; ++k) {
        const Eigen::Vector3d middle = (square.points[one[0][k]] + square.points[one[0][(k + 1) % 3]]) / 2;
        const Eigen::Vector3d inside = 0.98 * middle + 0.02 * Eigen::Vector3d(2.0 / 3, 1.0 / 3, 0);
        const Eigen::Vector2d pixel = pixel_of(inside, view, camera, options);
        CHECK((image.at(static_cast<int>(pixel.x()), static_cast<int>(pixel.y())).r < 0.5f) == (k == bit));
    }
}

TEST_CASE("a mesh too dense for its edges keeps a middle tone", "[io]") {
    const int n = GENERATE(60, 200, 400);
    RenderOptions options = silhouette(100, 100);
    options.fill = options.back_fill = white;
    options.edge = black, options.edge_width = 1;
    const double dark = darkness(render(bumpy_square(n).view(), from_above, options));
    CHECK(dark > 0.2);
    CHECK(dark < 0.5);
}

TEST_CASE("the picture does not depend on the number of threads", "[io][property]") {
    const Mesh mesh = sphere(60);
    std::vector<double> values;
    for (const Eigen::Vector3d& p : mesh.points) values.push_back(2 + p.z());
    DrawnMesh view = mesh.view();
    view.field = ScalarField{.values = values, .scale = Scale::Logarithmic, .title = "h"};
    const auto draw = [&](std::size_t threads) {
        const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
        return encode_png(render(view, {.projection = CameraProjection::Perspective}, {.width = 300, .height = 200}));
    };
    const std::string one = draw(1);
    CHECK(draw(2) == one);
    CHECK(draw(5) == one);
}

TEST_CASE("a field shows the colour of its value where pixel_of says", "[io][exact]") {
    // Values linear in space, on a square that runs away from the eye.
    const ColourMap map = GENERATE(ColourMap::Sequential, ColourMap::Diverging);
    std::vector<double> values;
    for (const Eigen::Vector3d& p : square.points) values.push_back(3 + p.y());
    const Camera camera{.direction = {0.2, -1, 0.5}, .projection = CameraProjection::Perspective, .view_angle = 60};
    RenderOptions options = silhouette(900, 720);
    DrawnMesh view = square.view();
    view.field = ScalarField{.values = values, .map = map, .title = "value"};
    const Image image = render(view, camera, options);
    for (const double y : {0.1, 0.3, 0.5, 0.7, 0.9}) {
        const Eigen::Vector2d pixel = pixel_of({0.45, y, 0}, view, camera, options);
        const Colour seen = image.at(static_cast<int>(pixel.x()), static_cast<int>(pixel.y())),
                     wanted = colour_at(map, y);
        CHECK(std::abs(seen.r - wanted.r) + std::abs(seen.g - wanted.g) + std::abs(seen.b - wanted.b) < 0.04);
    }
}

TEST_CASE("triangles have one colour each, grey without a value", "[io]") {
    const std::vector<double> values{2, std::numeric_limits<double>::quiet_NaN()};
    DrawnMesh view = square.view();
    view.field = ScalarField{.values = values, .on = ScalarField::On::Triangles, .range = Range{0, 2}};
    RenderOptions options = silhouette(90, 90);
    options.legend = false;
    const Image image = render(view, from_above, options);
    CHECK(image.at(70, 80).g == Approx(colour_at(ColourMap::Sequential, 1).g).margin(0.01));
    CHECK(image.at(10, 20).g == Approx(missing_colour.g).margin(0.01));
}

TEST_CASE("light falls on the surface, not on its orientation", "[io]") {
    Mesh turned = sphere(30);
    for (Triangle& t : turned.triangles) std::swap(t[1], t[2]);
    RenderOptions options{.width = 120, .height = 120, .edge_width = 0};
    options.back_fill = options.fill, options.back_shadow = options.shadow;
    const Image front = render(sphere(30).view(), from_above, options),
                back = render(turned.view(), from_above, options);
    int different = 0;
    for (std::size_t i = 0; i < front.rgb.size(); ++i) different += std::abs(front.rgb[i] - back.rgb[i]) > 2;
    CHECK(different == 0);
    // The lamp is at the upper left.
    CHECK(front.at(35, 35).r > front.at(85, 85).r);
    options.back_fill = black, options.back_shadow = black;
    CHECK(render(turned.view(), from_above, options).at(60, 60).r < 0.1f);
}

TEST_CASE("the target is in the middle and up is up", "[io][exact]") {
    const Mesh mesh = sphere(20);
    const CameraProjection projection = GENERATE(CameraProjection::Orthographic, CameraProjection::Perspective);
    const Camera camera{
        .direction = {1, 2, 0.5}, .projection = projection, .target = Eigen::Vector3d(0.3, -0.2, 0.4), .width = 0.1};
    const RenderOptions options{.width = 400, .height = 300};
    CHECK((pixel_of(*camera.target, mesh.view(), camera, options) - Eigen::Vector2d(200, 150)).norm() < 1e-9);
    const Eigen::Vector3d right = camera.up.cross(camera.direction).normalized();
    CHECK((pixel_of(*camera.target + 0.05 * right, mesh.view(), camera, options) - Eigen::Vector2d(400, 150)).norm() <
          1e-9);
    CHECK(pixel_of(*camera.target + Eigen::Vector3d(0, 0, 0.01), mesh.view(), camera, options).y() < 150);
    // Looking along up is no trouble.
    CHECK(darkness(render(mesh.view(), {.direction = {0, 0, -2}}, silhouette(100, 100))) ==
          Approx(std::numbers::pi / 4 * 0.94 * 0.94).epsilon(0.02));
}

TEST_CASE("a picture of nothing is its background", "[io]") {
    CHECK(darkness(render({}, {}, {.width = 50, .height = 40})) == 0);
    const Triangles flat{{0, 0, 1}};
    CHECK_NOTHROW(render({.points = square.points, .triangles = flat}, {}, {.width = 50, .height = 40}));
}

TEST_CASE("render refuses what it cannot draw", "[io]") {
    const auto refused = [](const DrawnMesh& view, const Camera& camera = {}, const RenderOptions& options = {}) {
        CHECK_THROWS_AS(render(view, camera, options), std::invalid_argument);
    };
    const Triangles bad{{0, 1, 4}};
    refused({.points = square.points, .triangles = bad});
    const std::vector<double> three{1, 2, 3};
    DrawnMesh view = square.view();
    view.field = ScalarField{.values = three};
    refused(view);
    Mesh infinite = square;
    infinite.points[1].x() = std::numeric_limits<double>::infinity();
    refused(infinite.view());
    refused(square.view(), {.direction = {0, 0, 0}});
    refused(square.view(), {.width = 0.0});
    refused(square.view(), {}, {.supersampling = 0});
    refused(square.view(), {}, {.width = 0});
}

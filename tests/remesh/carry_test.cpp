// Fields of a triangulation on its mesh.
#include "gradus/remesh/carry.hpp"

#include <catch2/catch.hpp>
#include <set>

#include "gradus/mesh/closest.hpp"
#include "gradus/remesh/triangulated.hpp"
#include "support/triangulations.hpp"

using namespace gradus;
using Eigen::Vector3d;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

SurfaceMesh remeshed(const Triangulation& surface, double h) {
    const TriangulationBackground map = make_background(
        surface, {.kind = SizingRule::Kind::Proportional, .value = 1e6, .hmin = 0.999999 * h, .hmax = h});
    const ControlSpace control(map.background, map.sizes);
    const SmoothSupport support = surface.support();
    return remesh({support, surface.features(), surface.soup().labels}, control, map.cells).mesh;
}

template <class F>
Field at_points(const TriangleSoup& soup, const F& f) {
    Field field{"f"};
    for (const Vector3d& p : soup.points) field.values.push_back(f(p));
    return field;
}

std::vector<double> carried(const Triangulation& surface, const Field& field, const SurfaceMesh& mesh) {
    return carry_point_fields(surface, std::vector{field}, mesh).front().values;
}

TriangleSoup plane(int n) {
    return triangulations::soup(triangulations::graph(
        n, [](double, double) { return 0; }, 0.3));
}

// A plane in `count` strips along y, with the number of its strip as each triangle's label.
TriangleSoup strips(int n, int count) {
    TriangleSoup soup = triangulations::soup(testing::square(n));
    for (const Triangle& t : soup.triangles) {
        const double x = (soup.points[t[0]].x() + soup.points[t[1]].x() + soup.points[t[2]].x()) / 3;
        soup.labels.push_back(1 + static_cast<int>(x * count));
    }
    return soup;
}

}  // namespace

TEST_CASE("a linear field on a plane is carried exactly, to finer and to coarser meshes", "[exact]") {
    const Triangulation surface(plane(12));
    const double h = GENERATE(0.03, 0.3);
    const SurfaceMesh mesh = remeshed(surface, h);
    const auto f = [](const Vector3d& p) { return 1.5 + 2 * p.x() - 3 * p.y(); };
    const std::vector<double> values = carried(surface, at_points(surface.soup(), f), mesh);
    REQUIRE(values.size() == mesh.points.size());
    double worst = 0;
    for (std::size_t v = 0; v < values.size(); ++v) worst = std::max(worst, std::abs(values[v] - f(mesh.points[v])));
    CHECK(worst <= 1e-12);
}

TEST_CASE("a linear field in space is carried to a sphere to second order", "[converges]") {
    const auto f = [](const Vector3d& p) { return p.x() + 2 * p.y() - p.z(); };
    std::vector<double> errors;
    for (const int halvings : {2, 3, 4}) {
        const Triangulation surface(triangulations::soup(triangulations::sphere(halvings)));
        const SurfaceMesh mesh = remeshed(surface, 0.5 / (1 << halvings));
        const std::vector<double> values = carried(surface, at_points(surface.soup(), f), mesh);
        double worst = 0;
        for (std::size_t v = 0; v < values.size(); ++v)
            worst = std::max(worst, std::abs(values[v] - f(mesh.points[v])));
        errors.push_back(worst);
    }
    CAPTURE(errors);
    CHECK(errors[1] < errors[0] / 2.8);
    CHECK(errors[2] < errors[1] / 2.8);
    CHECK(errors[2] < 0.02);
}

TEST_CASE("constants are carried bit by bit, infinite ones too, and nothing is carried beyond its range", "[exact]") {
    const Triangulation surface(triangulations::soup(triangulations::torus(30, 14)));
    const SurfaceMesh mesh = remeshed(surface, 0.25);
    for (const double c : {0.1, -1e300, 1.0 / 3, kInfinity, -kInfinity}) {
        const std::vector<double> values =
            carried(surface, at_points(surface.soup(), [=](const Vector3d&) { return c; }), mesh);
        CHECK(std::all_of(values.begin(), values.end(), [=](double x) { return x == c; }));
    }
    std::mt19937 random(3);
    const std::vector<double> noise =
        carried(surface,
                at_points(surface.soup(),
                          [&](const Vector3d&) { return std::uniform_real_distribution<double>(2, 3)(random); }),
                mesh);
    CHECK(std::all_of(noise.begin(), noise.end(), [](double x) { return x >= 2 && x <= 3; }));
}

TEST_CASE("components, names and integers go along", "[remesh]") {
    const Triangulation surface(plane(10));
    const SurfaceMesh mesh = remeshed(surface, 0.06);
    Field flow{"flow", 3}, count{"count", 1, {}, true};
    for (const Vector3d& p : surface.soup().points) {
        flow.values.insert(flow.values.end(), {p.x(), p.y(), 7});
        count.values.push_back(std::round(10 * p.x()));
    }
    const std::vector<Field> fields = carry_point_fields(surface, std::vector{flow, count}, mesh);
    REQUIRE(fields.size() == 2);
    CHECK(fields[0].name == "flow");
    CHECK(fields[0].components == 3);
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
        CHECK(fields[0].values[3 * v] == Approx(mesh.points[v].x()).margin(1e-12));
        CHECK(fields[0].values[3 * v + 2] == 7);
        CHECK(fields[1].values[v] == std::round(fields[1].values[v]));
    }
    CHECK(fields[1].integer);
}

TEST_CASE("where there is no value none is made up, and it does not spread", "[exact]") {
    const Triangulation surface(plane(10));
    const SurfaceMesh mesh = remeshed(surface, 0.05);
    const auto known = [](const Vector3d& p) { return p.x() > 0.5; };
    const std::vector<double> values = carried(
        surface, at_points(surface.soup(), [&](const Vector3d& p) { return known(p) ? 4 : std::nan(""); }), mesh);
    for (std::size_t v = 0; v < values.size(); ++v) {
        if (mesh.points[v].x() > 0.5 + 0.2) CHECK(values[v] == 4);
        if (mesh.points[v].x() < 0.5 - 0.2) CHECK(std::isnan(values[v]));
    }
    Field cells{"m", 1, {}, true};
    for (std::size_t t = 0; t < surface.soup().triangles.size(); ++t)
        cells.values.push_back(t % 2 == 0 ? std::nan("") : 5);
    const std::vector<Field> on_cells = carry_cell_fields(surface, std::vector{cells}, mesh);
    const std::vector<int> under = triangles_of_input(surface, mesh);
    for (std::size_t t = 0; t < under.size(); ++t)
        CHECK((under[t] % 2 == 0 ? std::isnan(on_cells[0].values[t]) : on_cells[0].values[t] == 5));
}

TEST_CASE("a triangle has the value of the one under its centroid", "[property]") {
    const Triangulation surface(plane(9));
    const double h = GENERATE(0.04, 0.25);
    const SurfaceMesh mesh = remeshed(surface, h);
    const std::vector<int> under = triangles_of_input(surface, mesh);
    REQUIRE(under.size() == mesh.triangles.size());
    for (std::size_t t = 0; t < under.size(); ++t) {
        const auto& [a, b, c] = mesh.triangles[t];
        const Vector3d middle = (mesh.points[a] + mesh.points[b] + mesh.points[c]) / 3;
        const Triangle& v = surface.soup().triangles[under[t]];
        CHECK((closest_point(middle, surface.soup().points[v[0]], surface.soup().points[v[1]],
                             surface.soup().points[v[2]]) -
               middle)
                  .norm() < 1e-12);
    }
}

TEST_CASE("cell fields keep to their regions, those of one element's width too", "[property]") {
    const int count = GENERATE(2, 4, 8);
    const double h = GENERATE(0.03, 0.12, 0.3);
    CAPTURE(count, h);
    const Triangulation surface(strips(16, count));
    const SurfaceMesh mesh = remeshed(surface, h);
    Field region{"region", 2, {}, true};
    for (const int label : surface.soup().labels)
        region.values.insert(region.values.end(), {10.0 * label, -1.0 * label});
    const std::vector<Field> fields = carry_cell_fields(surface, std::vector{region}, mesh);
    REQUIRE(fields[0].values.size() == 2 * mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const Triangle& v = mesh.triangles[t];
        const int strip =
            1 + static_cast<int>((mesh.points[v[0]].x() + mesh.points[v[1]].x() + mesh.points[v[2]].x()) / 3 * count);
        CHECK(fields[0].values[2 * t] == 10 * strip);
        CHECK(fields[0].values[2 * t + 1] == -strip);
    }
}

TEST_CASE("sheets that nearly touch keep their own values", "[exact]") {
    testing::Mesh above = triangulations::graph(
        10, [](double, double) { return 1e-7; }, 0.3, 5);
    const TriangleSoup both = triangulations::soup(testing::together(triangulations::graph(
                                                                         12, [](double, double) { return 0; }, 0.3),
                                                                     above));
    const Triangulation surface(both);
    const SurfaceMesh mesh = remeshed(surface, 0.07);
    const auto upper = [](const Vector3d& p) { return p.z() > 5e-8; };
    Field cells{"sheet"};
    for (const Triangle& t : both.triangles) cells.values.push_back(upper(both.points[t[0]]) ? 2 : 1);
    const std::vector<double> points =
        carried(surface, at_points(both, [&](const Vector3d& p) { return upper(p) ? 2 : 1; }), mesh);
    const std::vector<double> sheets = carry_cell_fields(surface, std::vector{cells}, mesh)[0].values;
    for (std::size_t v = 0; v < points.size(); ++v) CHECK(points[v] == (upper(mesh.points[v]) ? 2 : 1));
    for (std::size_t t = 0; t < sheets.size(); ++t)
        CHECK(sheets[t] == (upper(mesh.points[mesh.triangles[t][0]]) ? 2 : 1));
}

TEST_CASE("sides of a crease keep their own values", "[property]") {
    const double h = GENERATE(0.1, 0.5, 1.0);
    const TriangleSoup cube = triangulations::soup(triangulations::cube(4));
    const Triangulation surface(cube);
    const SurfaceMesh mesh = remeshed(surface, h);
    const auto side = [](const std::vector<Vector3d>& points, const Triangle& t) {
        const Vector3d n = (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]).normalized();
        return n.x() + 2 * n.y() + 4 * n.z();
    };
    Field field{"side"};
    for (const Triangle& t : cube.triangles) field.values.push_back(side(cube.points, t));
    const std::vector<double> values = carry_cell_fields(surface, std::vector{field}, mesh)[0].values;
    for (std::size_t t = 0; t < values.size(); ++t) CHECK(values[t] == Approx(side(mesh.points, mesh.triangles[t])));
}

TEST_CASE("fields of another size and places of another surface are refused", "[remesh]") {
    const Triangulation surface(plane(4));
    SurfaceMesh mesh = remeshed(surface, 0.3);
    CHECK_THROWS_AS(carry_point_fields(surface, std::vector{Field{"short", 1, {1, 2}}}, mesh), std::invalid_argument);
    CHECK_THROWS_AS(carry_cell_fields(surface, std::vector{Field{"short", 1, {1, 2}}}, mesh), std::invalid_argument);
    mesh.places[0].patch = 1 << 20;
    CHECK_THROWS_AS(triangles_of_input(surface, mesh), std::invalid_argument);
}

// Meshes against triangulated references: distances, angles and topology that are known.
#include "gradus/quality/reference.hpp"

#include <catch2/catch.hpp>

#include "gradus/quality/report.hpp"
#include "support/triangulations.hpp"

using namespace gradus;
using Eigen::Vector3d;
using testing::Mesh;

namespace {

MeshReport measured(const Mesh& mesh, const Mesh& surface) {
    const Reference reference(surface.view());
    return measure(mesh.view(), {.reference = &reference});
}

Mesh moved_up(Mesh mesh, double d) {
    for (Vector3d& p : mesh.points) p.z() += d;
    return mesh;
}

bool same(const MeshReport& report, const std::string& name) {
    for (const TopologyComparison& c : compare(report.topology, report.reference->topology))
        if (c.name == name) return c.same();
    throw std::invalid_argument(name);
}

// A quarter of a tube of radius 1 and thickness t, outside outwards and inside inwards; the sheets are not joined.
Mesh shell(int n, int m, double t) {
    const auto sheet = [&](double radius) {
        return testing::grid(n, m, false, false, [=](double u, double v) {
            const double a = std::numbers::pi / 2 * u;
            return Vector3d(radius * std::cos(a), radius * std::sin(a), v);
        });
    };
    Mesh inside = sheet(1 - t);
    for (Triangle& triangle : inside.triangles) std::swap(triangle[1], triangle[2]);
    return testing::together(sheet(1), inside);
}

}  // namespace

TEST_CASE("a mesh is at no distance from itself, in any order and place", "[exact]") {
    const Mesh sphere = triangulations::sphere(3);
    const bool shuffled = GENERATE(false, true);
    const MeshReport r = measured(shuffled ? testing::relabelled(sphere, 4) : sphere, sphere);
    REQUIRE(r.reference);
    CHECK(r.reference->hausdorff.largest() < 1e-15);
    CHECK(r.reference->hausdorff.bound() < 1e-8);
    CHECK(r.distance->centroids.max < 1e-15);
    CHECK(r.normals->angle.max < 1e-5);
    for (const char* name : {"components", "boundary loops", "Euler characteristic", "genus"}) CHECK(same(r, name));
    const MeshReport elsewhere = measured(testing::moved(sphere, 100), testing::moved(sphere, 100));
    CHECK(elsewhere.reference->hausdorff.bound() < 1e-6);
    CHECK(elsewhere.distance->diagonal == Approx(100 * r.distance->diagonal).epsilon(0.2));
}

TEST_CASE("a plane moved by d is d away everywhere, both ways", "[exact]") {
    const Mesh plane = triangulations::graph(
        6, [](double, double) { return 0; }, 0.3);
    const double d = 0.125;
    const MeshReport r = measured(moved_up(triangulations::graph(
                                               9, [](double, double) { return 0; }, 0.3, 8),
                                           d),
                                  plane);
    const HausdorffReport& h = r.reference->hausdorff;
    CHECK(h.diagonal == Approx(std::sqrt(2)));
    for (const OneSidedDistance* side : {&h.from_mesh, &h.from_reference}) {
        CHECK(side->largest == Approx(d).epsilon(1e-12));
        CHECK(side->bound >= d);
        CHECK(side->bound <= 1.01 * d * (1 + 1e-12));
    }
    CHECK(h.relative_bound() == Approx(h.bound() / std::sqrt(2)));
    for (const Summary* s : {&r.distance->vertices, &r.distance->midpoints, &r.distance->centroids}) {
        CHECK(s->min == Approx(d / std::sqrt(2)));
        CHECK(s->max == Approx(d / std::sqrt(2)));
    }
    CHECK(r.normals->angle.max < 1e-6);
}

TEST_CASE("a sphere is d away from one whose radius is larger by d", "[exact]") {
    const double d = GENERATE(0.3, 0.01, -0.05);
    const Mesh sphere = triangulations::sphere(4, 1, 0);
    const MeshReport r = measured(triangulations::sphere(4, 1 + d, 0), sphere);
    CHECK(r.reference->hausdorff.from_mesh.largest == Approx(std::abs(d)).epsilon(0.01));
    CHECK(r.reference->hausdorff.from_reference.largest == Approx(std::abs(d)).epsilon(0.01));
    CHECK(r.reference->hausdorff.bound() <= std::abs(d) * 1.0101);
    CHECK(std::abs(r.reference->hausdorff.from_mesh.point.norm() - (1 + d)) < 0.01);
    CHECK(r.normals->angle.max < 1);
    CHECK(r.normals->over_45 == 0);
}

TEST_CASE("the statistics are those of vertices, middles of edges and of triangles", "[exact]") {
    // A ridge over the plane z = 0: two facets that rise to 1.
    const Mesh plane{{{-5, -5, 0}, {5, -5, 0}, {5, 5, 0}, {-5, 5, 0}}, {{0, 1, 2}, {0, 2, 3}}};
    const Mesh ridge{{{-1, 0, 0}, {0, -1, 1}, {0, 1, 1}, {1, 0, 0}}, {{0, 1, 2}, {1, 3, 2}}};
    const MeshReport r = measured(ridge, plane);
    const double unit = std::sqrt(200);
    CHECK(r.distance->vertices.max * unit == Approx(1));
    CHECK(r.distance->vertices.mean * unit == Approx(0.5));
    CHECK(r.distance->midpoints.max * unit == Approx(1));
    CHECK(r.distance->midpoints.min * unit == Approx(0.5));
    CHECK(r.distance->centroids.min * unit == Approx(2. / 3));
    CHECK(r.distance->worst_vertices.front().index == 1);
    CHECK(r.distance->worst_edges.front().ends == std::array<int, 2>{1, 2});
    CHECK(r.normals->angle.min == Approx(45));
    CHECK(r.normals->angle.max == Approx(45));
    CHECK(r.reference->hausdorff.from_reference.largest > 5);
}

TEST_CASE("what became of pieces, holes and handles is said", "[quality]") {
    const Mesh whole = testing::square(20);
    Mesh open = whole;
    std::erase_if(open.triangles, [&](const Triangle& t) {
        return ((whole.points[t[0]] + whole.points[t[1]] + whole.points[t[2]]) / 3 - Vector3d(.5, .5, 0)).norm() < 0.3;
    });
    const MeshReport holed = measured(open, whole);
    CHECK(same(holed, "components"));
    CHECK_FALSE(same(holed, "boundary loops"));
    CHECK_FALSE(same(holed, "Euler characteristic"));
    CHECK(same(holed, "genus"));
    const MeshReport handled = measured(testing::torus(20, 10), triangulations::sphere(2));
    CHECK_FALSE(same(handled, "genus"));
    CHECK(same(handled, "boundary loops"));
    CHECK_FALSE(same(measured(testing::together(whole, moved_up(whole, 1)), whole), "components"));
}

TEST_CASE("triangles that are turned round lean by 180 degrees", "[exact]") {
    const bool thin = GENERATE(false, true);
    const Mesh surface = thin ? shell(24, 6, 0.02) : triangulations::sphere(3);
    Mesh mesh = surface;
    std::swap(mesh.triangles[7][0], mesh.triangles[7][1]);
    const MeshReport r = measured(mesh, surface);
    CHECK(r.normals->angle.max == Approx(180));
    CHECK(r.normals->over_60 == 1);
    CHECK(r.normals->worst.front().index == 7);
}

TEST_CASE("a thin surface is not taken for the other sheet", "[quality]") {
    const double t = 0.035;
    const Mesh surface = shell(60, 10, t), mesh = shell(3, 2, t);
    const MeshReport r = measured(mesh, surface);
    // Middles of the outer sheet's facets are nearer to the inner one.
    CHECK(r.distance->centroids.min * r.distance->diagonal < t / 4);
    CHECK(r.normals->angle.max < 20);
    CHECK(r.normals->without_normal == 0);
}

TEST_CASE("creases of the reference do not count for angles, and its flat facets are passed over", "[exact]") {
    Mesh cube = triangulations::cube(5);
    CHECK(measured(triangulations::cube(3), cube).normals->angle.max < 1e-5);
    cube.triangles.push_back({0, 0, 1});
    CHECK(measured(triangulations::cube(3), cube).normals->angle.max < 1e-5);
    Mesh flat = triangulations::cube(3);
    flat.triangles.push_back({0, 1, 0});
    CHECK(measured(flat, cube).normals->without_normal == 1);
}

TEST_CASE("surfaces without triangles or with bad corners are refused", "[quality]") {
    const Mesh square = testing::square(2);
    CHECK_THROWS_AS(Reference(MeshView{}), std::invalid_argument);
    Mesh bad = square;
    bad.points[0].x() = std::nan("");
    CHECK_THROWS_AS(Reference(bad.view()), std::invalid_argument);
    const Reference reference(square.view());
    CHECK_THROWS_AS(reference.measure(bad.view()), std::invalid_argument);
    CHECK_THROWS_AS(reference.measure(MeshView{}), std::invalid_argument);
    bad.triangles[0][0] = 99;
    CHECK_THROWS_AS(Reference(bad.view()), std::invalid_argument);
}

TEST_CASE("the text of a report against a reference says the distance, where it is, and what differs", "[quality]") {
    const std::string text = to_text(measured(testing::torus(20, 10), triangulations::sphere(2)));
    for (const char* part : {"Hausdorff distance to the reference", "from mesh to reference", "nowhere above", "genus",
                             "differs", "same", "angle to the normal", "edge midpoints"})
        CHECK_THAT(text, Catch::Contains(part));
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) CHECK(line.size() <= 110);
}

#include "gradus/quality/distance.hpp"

#include "gradus/io/patch_files.hpp"
#include "gradus/surface/locate.hpp"
#include "quality/surfaces.hpp"

#include <catch2/catch.hpp>

using namespace gradus;
using namespace gradus::testing;
using Eigen::Vector3d;

namespace {

constexpr double kPi = std::numbers::pi;

std::unique_ptr<const ParametricSurface> unit_square(double x) { return make_plane({x, 0, 0}, {1, 0, 0}, {0, 1, 0}); }

/// Largest distances by a formula for the distance to the surface.
template <class Distance>
void check_against(const SurfaceModel& model, const PlacedTriangles& mesh, const Distance& distance) {
    const MeshEdges edges = edges_of(mesh.view());
    const DistanceReport report = measure_distance(model, mesh.placed(), edges);
    double midpoint = 0, centroid = 0;
    for (const auto& [a, b] : edges.ends)
        midpoint = std::max(midpoint, distance((mesh.points[a] + mesh.points[b]) / 2));
    for (const auto& [a, b, c] : mesh.triangles)
        centroid = std::max(centroid, distance((mesh.points[a] + mesh.points[b] + mesh.points[c]) / 3));
    CHECK(report.vertices.max < 1e-14);
    CHECK(report.midpoints.max * report.diagonal == Approx(midpoint));
    CHECK(report.centroids.max * report.diagonal == Approx(centroid));
    CHECK(report.midpoints.count == edges.ends.size());
}

}  // namespace

TEST_CASE("distance to a sphere is the gap below its radius, across the seam and at the poles too",
          "[quality][exact]") {
    const SurfaceModel model = model_of(make_sphere({1, 2, 3}, 2));
    const int n = GENERATE(6, 20);
    check_against(model, mesh_of(model, n, n / 2),
                  [](const Vector3d& p) { return std::abs((p - Vector3d(1, 2, 3)).norm() - 2); });
}

TEST_CASE("distance to a torus and to a cylinder has a closed form", "[quality][exact]") {
    const SurfaceModel torus_model = model_of(make_torus({0, 0, 0}, 3, 1));
    check_against(torus_model, mesh_of(torus_model, 24, 12),
                  [](const Vector3d& p) { return std::abs(std::hypot(std::hypot(p[0], p[1]) - 3, p[2]) - 1); });
    const SurfaceModel cylinder = model_of(make_cylinder({0, 0, 0}, 1, 4));
    check_against(cylinder, mesh_of(cylinder, 12, 5),
                  [](const Vector3d& p) { return std::abs(std::hypot(p[0], p[1]) - 1); });
}

TEST_CASE("the gap of midpoints shrinks with the square of the edges", "[quality][converges]") {
    const SurfaceModel model = model_of(make_torus({0, 0, 0}, 3, 1));
    const auto gap = [&](int n) {
        const PlacedTriangles mesh = mesh_of(model, 2 * n, n);
        return measure_distance(model, mesh.placed(), edges_of(mesh.view())).midpoints.max;
    };
    CHECK(gap(16) / gap(32) == Approx(4).epsilon(.1));
}

TEST_CASE("a triangle across a shared curve finds the surface on both sides", "[quality]") {
    std::vector<std::unique_ptr<const ParametricSurface>> squares;
    squares.push_back(unit_square(0));
    squares.push_back(unit_square(1));
    const SurfaceModel model = glue(std::move(squares));
    // The corners lie inside different patches; midpoints and centroids are found across the curve x = 1.
    PlacedTriangles mesh;
    mesh.places = {{0, {.5, .5}}, {1, {.9, .2}}, {1, {.7, .8}}};
    for (const SurfacePoint& at : mesh.places) mesh.points.push_back(model.position(at));
    mesh.triangles = {{0, 1, 2}};
    const DistanceReport report = measure_distance(model, mesh.placed(), edges_of(mesh.view()));
    CHECK(report.midpoints.max < 1e-14);
    CHECK(report.centroids.max < 1e-14);
    CHECK(project(model, {1.9, .3, .25}, {0, {.1, .9}}).distance == Approx(.25));
    CHECK(project(model, {1.9, .3, .25}, {0, {.1, .9}}).at.patch == 1);
    CHECK(project(model, {-3, .5, 4}, {1, {.5, .5}}).distance == Approx(5));
    CHECK(measure_normals(model, mesh.placed()).angle.max == Approx(0).margin(1e-9));
}

TEST_CASE("a foot beyond a pole is found from anywhere near it", "[quality]") {
    const SurfaceModel model = model_of(make_sphere({0, 0, 0}, 1));
    const double longitude = GENERATE(.1, 1.7, 3.3, 6.2), target = GENERATE(.4, 2., 4.4);
    const Vector3d foot(std::cos(target) * std::cos(1.5), std::sin(target) * std::cos(1.5), std::sin(1.5));
    CHECK(project(model, 1.1 * foot, {0, {longitude, 1.45}}).distance == Approx(.1));
    CHECK(project(model, .9 * foot, {0, {longitude, kPi / 2}}).distance == Approx(.1));
}

TEST_CASE("normals of a mesh of a sphere lean by half an edge, and all the way round when turned inside out",
          "[quality]") {
    const SurfaceModel model = model_of(make_sphere({0, 0, 0}, 1));
    PlacedTriangles mesh = mesh_of(model, 40, 20);
    NormalReport report = measure_normals(model, mesh.placed());
    CHECK(report.over_45 == 0);
    CHECK(report.angle.max < 9);
    CHECK(report.angle.count == mesh.triangles.size());
    for (Triangle& t : mesh.triangles) std::swap(t[0], t[1]);
    report = measure_normals(model, mesh.placed());
    CHECK(report.over_60 == mesh.triangles.size());
    CHECK(report.worst.size() == 10);
    mesh.patches.clear();
    CHECK(measure_normals(model, mesh.placed()).angle.min == Approx(report.angle.min));
}

TEST_CASE("a triangle at a crease is compared with its own side", "[quality]") {
    std::vector<std::unique_ptr<const ParametricSurface>> sides;
    sides.push_back(make_plane({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
    sides.push_back(make_plane({0, 0, 0}, {0, 1, 0}, {0, 0, 1}));
    const SurfaceModel model = glue(std::move(sides));
    REQUIRE(model.num_components() == 1);
    PlacedTriangles mesh = mesh_of(model, 4, 4);
    CHECK(measure_normals(model, mesh.placed()).angle.max == Approx(0).margin(1e-9));
    mesh.patches.clear();
    CHECK(measure_normals(model, mesh.placed()).angle.max == Approx(0).margin(1e-9));
}

TEST_CASE("displaced vertices are as far off as they were moved", "[quality][exact]") {
    const SurfaceModel model = model_of(make_sphere({0, 0, 0}, 1));
    PlacedTriangles mesh = mesh_of(model, 20, 10);
    mesh.points[77] *= 1.01;
    const DistanceReport report = measure_distance(model, mesh.placed(), edges_of(mesh.view()));
    CHECK(report.vertices.max * report.diagonal == Approx(.01));
    CHECK(report.worst_vertices.front().index == 77);
}

TEST_CASE("a mesh of the teapot is measured across its curves and poles", "[quality]") {
    const SurfaceModel model = make_model(read_patches(GRADUS_ASSETS "/teapot.bpt"));
    const PlacedTriangles mesh = mesh_of(model, 6, 6);
    const MeshEdges edges = edges_of(mesh.view());
    const DistanceReport report = measure_distance(model, mesh.placed(), edges);
    CHECK(report.vertices.max < 1e-12);
    CHECK(report.midpoints.max < 1e-2);
    // Brute force: no sample of the same part (they run through each other) is nearer than the foot that was found.
    const int n = 60;
    for (const EdgeOffender& edge : report.worst_edges) {
        const Vector3d p = (mesh.points[edge.ends[0]] + mesh.points[edge.ends[1]]) / 2;
        double nearest = 1e300;
        for (int patch = 0; patch < model.num_patches(); ++patch) {
            if (model.component(patch) != model.component(mesh.places[edge.ends[0]].patch)) continue;
            for (int j = 0; j <= n; ++j)
                for (int i = 0; i <= n; ++i)
                    nearest = std::min(nearest, (p - model.position({patch, {double(i) / n, double(j) / n}})).norm());
        }
        CHECK(edge.value * report.diagonal <= nearest * (1 + 1e-9));
    }
    // The triangles follow the orientation of the model, and its normals once they are fine enough for the knob and the
    // spout.
    CHECK(measure_normals(model, mesh_of(model, 20, 20).placed()).over_45 == 0);
}

TEST_CASE("places must fit the mesh and the model", "[quality]") {
    const SurfaceModel model = model_of(unit_square(0));
    PlacedTriangles mesh = mesh_of(model, 2, 2);
    mesh.places[3].patch = 7;
    CHECK_THROWS_WITH(measure_distance(model, mesh.placed(), edges_of(mesh.view())),
                      Catch::Contains("vertex 3") && Catch::Contains("7"));
    mesh.places.pop_back();
    CHECK_THROWS_AS(measure_normals(model, mesh.placed()), std::invalid_argument);
}

#include "gradus/surface/locate.hpp"

#include "gradus/io/patch_files.hpp"
#include "quality/surfaces.hpp"

#include <catch2/catch.hpp>

using namespace gradus;
using namespace gradus::testing;
using Eigen::Vector3d;

namespace {

SurfaceModel teapot() { return make_model(read_patches(GRADUS_ASSETS "/teapot.bpt")); }

SurfaceModel some_model(int which) {
    if (which == 0) return teapot();
    return which == 1 ? model_of(make_torus({0, 0, 0}, 3, 1)) : model_of(make_sphere({0, 0, 0}, 1));
}

}  // namespace

TEST_CASE("the places of a point on shared curves and corners are one point", "[quality]") {
    const SurfaceModel model = some_model(GENERATE(0, 1));
    int shared = 0;
    for (int patch = 0; patch < model.num_patches(); ++patch) {
        const Domain domain = model.patch(patch).domain();
        for (const Eigen::Vector2d& part : std::vector<Eigen::Vector2d>{{.3, 0}, {1, .25}, {.5, 1}, {0, 1}, {0, .6}}) {
            const SurfacePoint at{patch, domain.min + part.cwiseProduct(domain.max - domain.min)};
            const std::vector<SurfacePoint> places = places_of(model, at);
            CHECK(places[0].uv == at.uv);
            shared += places.size() > 1;
            for (const SurfacePoint& place : places)
                CHECK((model.position(place) - model.position(at)).norm() < 1e-9 * model.diagonal());
        }
        CHECK(places_of(model, {patch, (domain.min + domain.max) / 2}).size() == 1);
    }
    CHECK(shared > 3 * model.num_patches());
}

TEST_CASE("a point lifted along the normal falls back to its foot", "[quality][property]") {
    const SurfaceModel model = teapot();
    std::mt19937 random(21);
    std::uniform_real_distribution<double> inside(.02, .98), near(-.03, .03);
    for (int i = 0; i < 300; ++i) {
        const SurfacePoint foot{int(random() % model.num_patches()), {inside(random), inside(random)}};
        // Small against the radii of curvature, so that the foot is the closest point around.
        const double height = 1e-3;
        const Vector3d point = model.position(foot) + height * model.normal(foot);
        const SurfacePoint start{foot.patch, foot.uv + Eigen::Vector2d(near(random), near(random))};
        const Projection found = project(model, point, start);
        CHECK(found.distance == Approx(height).epsilon(1e-9));
        CHECK((model.position(found.at) - point).norm() == Approx(found.distance));
    }
}

TEST_CASE("points of a model are located without a hint", "[quality]") {
    const SurfaceModel model = some_model(GENERATE(0, 1, 2));
    const PlacedTriangles mesh = mesh_of(model, 7, 5);
    const std::vector<SurfacePoint> places = locate(model, mesh.points);
    REQUIRE(places.size() == mesh.points.size());
    for (std::size_t v = 0; v < places.size(); ++v)
        CHECK((model.position(places[v]) - mesh.points[v]).norm() < 1e-7 * model.diagonal());
    CHECK_THROWS_AS(locate(model, mesh.points, {.intervals = 0}), std::invalid_argument);
}

TEST_CASE("a point that is not finite has no place", "[quality]") {
    const SurfaceModel model = model_of(make_sphere({0, 0, 0}, 1));
    const std::vector<Vector3d> points{{std::nan(""), 0, 0}, {0, 0, 2}};
    const std::vector<SurfacePoint> places = locate(model, points);
    CHECK(places[0].patch == -1);
    CHECK((model.position(places[1]) - Vector3d(0, 0, 1)).norm() < 1e-9);
}

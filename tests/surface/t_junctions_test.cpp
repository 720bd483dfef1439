#include "gradus/surface/t_junctions.hpp"

#include <catch2/catch.hpp>

#include "support/models.hpp"

using namespace gradus;
using Eigen::Vector3d;

TEST_CASE("A T-junction is found where two squares meet a longer one", "[surface][exact]") {
    // A square above y = 0 over x in [0, 1], two half as large below it.
    models::Nets nets{models::flat_square()};
    for (const double x : {0.0, 0.5})
        nets.push_back(models::mapped({models::flat_square()}, [x](const Vector3d& p) -> Vector3d {
            return {x + p.x() / 2, -p.y() / 2, 0};
        })[0]);
    const SurfaceModel model = models::model_of(nets);
    CHECK(model.num_components() == 2);
    const std::vector<TJunction> found = find_t_junctions(model);
    REQUIRE(found.size() == 1);
    CHECK(model.vertices()[found[0].vertex].point.isApprox(Vector3d(0.5, 0, 0)));
    CHECK(found[0].curve == model.loops(0)[0][0].curve);
    CHECK(found[0].t == Approx(0.5));
    CHECK(found[0].distance < 1e-12);
}

TEST_CASE("Models that are glued well have no T-junction", "[surface]") {
    CHECK(find_t_junctions(models::teapot()).empty());
    CHECK(find_t_junctions(models::model_of(models::wavy_sheet(3))).empty());
    CHECK(find_t_junctions(models::cylinder_with_seam()).empty());
    CHECK(find_t_junctions(models::model_of(models::cube())).empty());
    CHECK_THROWS_AS(find_t_junctions(models::teapot(), 0), std::invalid_argument);
}

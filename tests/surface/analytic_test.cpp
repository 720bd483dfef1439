#include "gradus/surface/analytic.hpp"

#include <catch2/catch.hpp>
#include <random>

#include "support/jets.hpp"
#include "support/models.hpp"

using namespace gradus;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {
std::vector<models::Patch> all_analytic() {
    std::vector<models::Patch> surfaces;
    surfaces.push_back(make_plane({1, 2, 3}, {1, 0, 1}, {0, 2, 0}));
    surfaces.push_back(make_sphere({1, 2, 3}, 2));
    surfaces.push_back(make_torus({0, 0, 1}, 3, 1));
    surfaces.push_back(make_cylinder({0, 1, 0}, 2, 5));
    Eigen::Matrix2d A;
    A << 0.3, 0.1, -0.2, 0.5;
    surfaces.push_back(reparametrise(make_torus({0, 0, 0}, 3, 1), A, {0.1, 0.2}, {}));
    return surfaces;
}
}  // namespace

TEST_CASE("Derivatives of analytic surfaces are those of their positions", "[surface][property]") {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> in(0, 1);
    for (const models::Patch& surface : all_analytic())
        for (int k = 0; k < 20; ++k) {
            const Domain d = surface->domain();
            check_jets(*surface, d.min + Vector2d(in(random), in(random)).cwiseProduct(d.max - d.min));
        }
}

TEST_CASE("Analytic surfaces lie where their equations say", "[surface][exact]") {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> in(-1, 1);
    for (int k = 0; k < 50; ++k) {
        const Vector2d uv(3 * in(random), 1.5 * in(random));
        CHECK((make_sphere({1, 2, 3}, 2)->position(uv) - Vector3d(1, 2, 3)).norm() == Approx(2));
        const Vector3d t = make_torus({0, 0, 0}, 3, 1)->position(uv);
        CHECK(std::hypot(t.head<2>().norm() - 3, t.z()) == Approx(1));
        CHECK(make_cylinder({0, 0, 0}, 2, 5)->position(uv).head<2>().norm() == Approx(2));
    }
}

TEST_CASE("Analytic surfaces refuse sizes that make none", "[surface]") {
    CHECK_THROWS_AS(make_sphere({0, 0, 0}, 0), std::invalid_argument);
    CHECK_THROWS_AS(make_torus({0, 0, 0}, 1, 1), std::invalid_argument);
    CHECK_THROWS_AS(make_cylinder({0, 0, 0}, 1, -1), std::invalid_argument);
    CHECK_THROWS_AS(make_plane({0, 0, 0}, {1, 1, 0}, {2, 2, 0}), std::invalid_argument);
    CHECK_THROWS_AS(reparametrise(make_sphere({0, 0, 0}, 1), Eigen::Matrix2d::Zero(), {0, 0}, {}),
                    std::invalid_argument);
}

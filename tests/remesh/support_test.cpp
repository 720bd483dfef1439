#include "gradus/remesh/support.hpp"

#include "gradus/surface/locate.hpp"
#include "remesh/judged.hpp"

#include <catch2/catch.hpp>

#include <numbers>
#include <random>
#include <set>

using namespace gradus;
using namespace gradus::testing;

namespace {

struct Fixture {
    models::Kind kind;
    SurfaceModel model;
    SizedBackground sized;
    ControlSpace control;
    PatchSupport support;

    explicit Fixture(const std::string& name)
        : kind(models::kind_of(name)),
          model(kind.make()),
          sized(graded_background(model, kind.size)),
          control(sized.background, sized.sizes),
          support(model) {}

    Place place(const SurfacePoint& at) const { return {at, -1, 0, control.locate(at)}; }
};

void check_foot(const Fixture& f, const Foot& foot) {
    CHECK(foot.point == f.model.position(foot.place.at));
    CHECK(foot.normal.norm() == Approx(1));
    CHECK(foot.normal.dot(f.model.normal(foot.place.at)) >= 1 - 1e-9);
}

int features(const SurfaceModel& model) {
    int count = 0;
    for (int c = 0; c < static_cast<int>(model.curves().size()); ++c) count += is_feature(model, c);
    return count;
}

}  // namespace

TEST_CASE("A move ends on the surface near its target, across patches and seams", "[remesh][property]") {
    for (const std::string name :
         {"sphere from a cube", "sphere from a cube shuffled", "torus", "torus shuffled", "torus with seams",
          "sphere of octants", "sphere with seam", "stretched sphere", "wavy sheet", "wavy sheet shuffled",
          "differing parameters", "mixed degrees", "uneven square"})
        DYNAMIC_SECTION(name) {
            const Fixture f(name);
            std::mt19937 random(4);
            std::uniform_real_distribution<double> uniform(0, 1);
            constexpr int kMoves = 1500;
            int barred = 0, astray = 0;
            for (int i = 0; i < kMoves; ++i) {
                const int p = static_cast<int>(random() % f.model.num_patches());
                const Domain d = f.model.patch(p).domain();
                const double s = uniform(random), t = uniform(random), turn = 2 * std::numbers::pi * uniform(random);
                const SurfacePoint at{p, d.min + Eigen::Vector2d(s, t).cwiseProduct(d.max - d.min)};
                const Eigen::Vector3d n = f.model.normal(at), x = n.unitOrthogonal(), y = n.cross(x);
                const double step = 0.7 * f.kind.size;
                const Eigen::Vector3d target = f.model.position(at) + step * (std::cos(turn) * x + std::sin(turn) * y);
                const std::optional<Foot> foot = f.support.move(f.place(at), f.model.position(at), target);
                if (!foot) {
                    ++barred;
                    continue;
                }
                check_foot(f, *foot);
                astray += (foot->point - target).norm() > project(f.model, target, at).distance + 0.15 * step;
            }
            // Beside a pole a step in parameters is not one in space: a few moves do not arrive.
            const bool poles = std::any_of(f.model.vertices().begin(), f.model.vertices().end(),
                                           [](const ModelVertex& v) { return v.pole; });
            CHECK(astray <= (poles ? 0.02 * kMoves : 0));
            CHECK(barred <= (poles || features(f.model) > 0 ? 0.2 * kMoves : 0));
        }
}

TEST_CASE("A crease and a boundary bar the way", "[remesh][exact]") {
    const Fixture hinge("hinge");
    const Place left = hinge.place({0, {0.9, 0.5}});
    const Eigen::Vector3d at = hinge.model.position(left.at);
    CHECK_FALSE(hinge.support.move(left, at, {0.1 * std::cos(1.0), 0.5, 0.1 * std::sin(1.0)}).has_value());
    CHECK(hinge.support.move(left, at, {-0.05, 0.6, 0}).has_value());
    const Fixture flat("coplanar hinge");
    const auto across =
        flat.support.move(flat.place({0, {0.9, 0.5}}), flat.model.position({0, {0.9, 0.5}}), {0.1, 0.5, 0});
    REQUIRE(across.has_value());
    CHECK(across->place.at.patch == 1);
    CHECK((across->point - Eigen::Vector3d(0.1, 0.5, 0)).norm() <= 1e-12);
    CHECK_FALSE(flat.support.move(flat.place({0, {0.1, 0.5}}), flat.model.position({0, {0.1, 0.5}}), {-1.1, 0.5, 0})
                    .has_value());
}

TEST_CASE("Feature curves that continue each other are one chain", "[remesh][exact]") {
    const auto chains = [](const Fixture& f) {
        std::set<int> all;
        for (int c = 0; c < static_cast<int>(f.model.curves().size()); ++c)
            if (is_feature(f.model, c)) all.insert(f.support.chain_of(c));
        return static_cast<int>(all.size());
    };
    const auto junctions = [](const Fixture& f) {
        int count = 0;
        for (int v = 0; v < static_cast<int>(f.model.vertices().size()); ++v)
            count += f.support.junction(v).has_value();
        return count;
    };
    CHECK(chains(Fixture("cube")) == 12);
    CHECK(junctions(Fixture("cube")) == 0);
    CHECK(chains(Fixture("cylinder")) == 2);
    CHECK(junctions(Fixture("cylinder")) == 8);
    CHECK(chains(Fixture("cylinder with seam")) == 2);
    CHECK(chains(Fixture("wavy sheet")) == 4);
    CHECK(junctions(Fixture("wavy sheet")) == 8);
    CHECK(chains(Fixture("hinge")) == 7);
}

TEST_CASE("A point slides around a circle of several curves and back to where it was", "[remesh][exact]") {
    for (const std::string name : {"cylinder", "cylinder shuffled", "cylinder with seam"}) DYNAMIC_SECTION(name) {
            const Fixture f(name);
            int bottom = -1;
            for (int c = 0; c < static_cast<int>(f.model.curves().size()); ++c)
                if (is_feature(f.model, c) && std::abs(f.model.position(f.model.on_curve(c, 0, 0.5)).z()) < 1e-12)
                    bottom = c;
            REQUIRE(bottom >= 0);
            const SurfacePoint at = f.model.on_curve(bottom, 0, 0.3);
            Foot foot = f.support.foot({at, bottom, 0.3, f.control.locate(at)});
            const double start = std::atan2(foot.point.y(), foot.point.x());
            constexpr int kSteps = 80;
            for (int i = 1; i <= kSteps; ++i) {
                const double angle = start + 2 * std::numbers::pi * i / kSteps;
                const auto next = f.support.slide(foot.place, {std::cos(angle), std::sin(angle), 0});
                REQUIRE(next.has_value());
                CHECK(next->point.z() == Approx(0).margin(1e-12));
                CHECK(next->point.head<2>().norm() == Approx(1).epsilon(1e-12));
                CHECK((next->point - Eigen::Vector3d(std::cos(angle), std::sin(angle), 0)).norm() <= 0.01);
                CHECK(next->point == f.model.position(next->place.at));
                // Half way from the last point, wherever the curves begin.
                const Foot middle = f.support.middle(f.support.chain_of(bottom), foot, *next);
                CHECK((middle.point - foot.point).norm() == Approx((middle.point - next->point).norm()).epsilon(0.15));
                CHECK((middle.point - foot.point).norm() <= 0.05);
                foot = *next;
            }
        }
}

TEST_CASE("A point does not slide past a corner", "[remesh][exact]") {
    const Fixture f("flat square");
    for (int c = 0; c < 4; ++c) {
        const SurfacePoint at = f.model.on_curve(c, 0, 0.9);
        const Foot foot = f.support.foot({at, c, 0.9, f.control.locate(at)});
        const Eigen::Vector3d a = f.model.position(f.model.on_curve(c, 0, 0)),
                              b = f.model.position(f.model.on_curve(c, 0, 1));
        CHECK_FALSE(f.support.slide(foot.place, a + 1.1 * (b - a)).has_value());
        const auto nearer = f.support.slide(foot.place, a + 0.95 * (b - a));
        REQUIRE(nearer.has_value());
        CHECK((nearer->point - (a + 0.95 * (b - a))).norm() <= 1e-12);
        // Between the corner and a point of the side.
        Foot corner = f.support.foot(f.place(f.model.on_curve(c, 0, 1)));
        const Foot middle = f.support.middle(f.support.chain_of(c), corner, foot);
        CHECK((middle.point - (a + 0.95 * (b - a))).norm() <= 1e-12);
    }
}

TEST_CASE("A move that does not arrive is none", "[remesh][property]") {
    // The length of S_u varies a millionfold: Newton's steps in parameters are far from steps in space.
    const SurfaceModel model = models::model_of({models::uneven_square(1e6)});
    const SizedBackground sized = make_background(model, {.hmin = 0.05, .hmax = 0.1});
    const ControlSpace control(sized.background, sized.sizes);
    const PatchSupport support(model);
    std::mt19937 random(8);
    std::uniform_real_distribution<double> uniform(0, 1);
    int barred = 0;
    for (int i = 0; i < 2000; ++i) {
        const SurfacePoint at{0, {std::pow(uniform(random), 4), uniform(random)}};
        const Eigen::Vector3d from = model.position(at), target(uniform(random), uniform(random), 0);
        const auto foot = support.move({at, -1, 0, control.locate(at)}, from, target);
        barred += !foot;
        if (foot) CHECK((foot->point - target).norm() <= 0.11 * (target - from).norm());
    }
    CHECK(barred < 2000);
}

#include "gradus/surface/surface_model.hpp"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <random>

#include "support/models.hpp"

using namespace gradus;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr double pi = 3.14159265358979323846;

int count(const SurfaceModel& model, CurveKind kind) {
    int n = 0;
    for (const ModelCurve& curve : model.curves()) n += curve.kind == kind;
    return n;
}

double total_length(const SurfaceModel& model, CurveKind kind) {
    double length = 0;
    for (const ModelCurve& curve : model.curves())
        if (curve.kind == kind) length += curve.length;
    return length;
}

/// Vertices - edges + faces. Poles count as neither edge nor curve: their side is a point.
int euler_characteristic(const SurfaceModel& model) {
    return static_cast<int>(model.vertices().size()) -
           (static_cast<int>(model.curves().size()) - count(model, CurveKind::Pole)) + model.num_patches();
}

/// Volume enclosed by outward orientation, by the midpoint rule.
double enclosed_volume(const SurfaceModel& model, int n = 40) {
    double volume = 0;
    for (int i = 0; i < model.num_patches(); ++i) {
        const Domain d = model.patch(i).domain();
        const Vector2d size = d.max - d.min;
        for (int b = 0; b < n; ++b)
            for (int a = 0; a < n; ++a) {
                const Jet1 jet = model.patch(i).jet1(d.min + Vector2d((a + 0.5) / n, (b + 0.5) / n).cwiseProduct(size));
                volume += (model.flipped(i) ? -1 : 1) * jet.p.dot(jet.du.cross(jet.dv)) * size.prod() / (3.0 * n * n);
            }
    }
    return volume;
}

/// What holds for every model, whatever its shape.
void check_consistent(const SurfaceModel& model, double gap) {
    std::size_t corners = 0;
    for (int i = 0; i < model.num_patches(); ++i)
        for (const std::vector<UseRef>& loop : model.loops(i))
            for (std::size_t k = 0; k < loop.size(); ++k) {
                const UseRef &ref = loop[k], &next = loop[(k + 1) % loop.size()];
                const CurveUse& use = model.use(ref);
                CHECK(use.patch == i);
                ++corners;
                // The loop goes on where the use ends.
                const Vector2d end = use.image->uv(use.reversed ? 0 : 1),
                               start = model.use(next).image->uv(model.use(next).reversed ? 1 : 0);
                CHECK((end - start).norm() <= 1e-12 * (1 + end.norm()));
                // The patch lies on the left.
                const Vector2d middle = use.image->uv(0.5),
                               along = use.reversed ? Vector2d(-use.image->duv(0.5)) : use.image->duv(0.5);
                CHECK(model.contains({i, middle + 1e-3 * Vector2d(-along.y(), along.x())}));
                CHECK(!model.contains({i, middle - 1e-3 * Vector2d(-along.y(), along.x())}));
            }
    for (int c = 0; c < static_cast<int>(model.curves().size()); ++c) {
        const ModelCurve& curve = model.curves()[c];
        REQUIRE(curve.uses.size() >= 1);
        CHECK((curve.uses.size() == 2) == (curve.kind == CurveKind::Smooth || curve.kind == CurveKind::Crease));
        for (int use = 0; use < static_cast<int>(curve.uses.size()); ++use) {
            for (int k = 0; k <= 20; ++k) {
                const double t = k / 20.0 * 0.999 + 0.0005;
                const SurfacePoint first = model.on_curve(c, 0, t), other = model.on_curve(c, use, t);
                CHECK((model.position(first) - model.position(other)).norm() <= gap);
                if (curve.kind != CurveKind::Pole) {
                    CHECK(curve.uses[use].image->parameter(other.uv) == Approx(t).margin(1e-6));
                    const auto border = model.border_at(other);
                    REQUIRE(border.size() == 1);
                    CHECK(border[0].use == UseRef{c, use});
                }
            }
            for (int end = 0; end < 2; ++end) {
                const Vector3d p = model.position(model.on_curve(c, use, end));
                CHECK((p - model.vertices()[curve.ends[end]].point).norm() <= std::max(gap, 2e-6 * model.diagonal()));
            }
        }
        if (curve.uses.size() == 2) CHECK(model.component(curve.uses[0].patch) == model.component(curve.uses[1].patch));
    }
    std::size_t places = 0;
    for (const ModelVertex& vertex : model.vertices()) places += vertex.places.size();
    CHECK(places == corners);
}

/// Whether the second use has parameters that differ from those of the first by more than their direction.
bool is_followed(const ModelCurve& curve) {
    const PlaneCurve& image = *curve.uses[1].image;
    return (image.uv(0.25) - (0.75 * image.uv(0) + 0.25 * image.uv(1))).norm() > 1e-9;
}

}  // namespace

TEST_CASE("The teapot has four smooth components, six boundary loops and eight collapsed sides", "[surface][exact]") {
    const SurfaceModel model = models::teapot();
    check_consistent(model, 0);
    CHECK(model.num_patches() == 32);
    CHECK(model.num_components() == 4);
    CHECK(count(model, CurveKind::Boundary) == 16);
    CHECK(count(model, CurveKind::Smooth) == 52);
    CHECK(count(model, CurveKind::Crease) == 0);
    CHECK(count(model, CurveKind::Pole) == 8);
    int poles = 0;
    for (const ModelVertex& vertex : model.vertices())
        if (vertex.pole) {
            ++poles;
            CHECK(vertex.places.size() == 8);
        }
    CHECK(poles == 2);
    for (const ModelCurve& curve : model.curves()) {
        if (curve.uses.size() == 2) CHECK(!is_followed(curve));
        CHECK(curve.largest_angle < 1e-12);
    }
    CHECK(enclosed_volume(model) > 0);
    // The bottom looks down, the knob's top up, the body outward.
    CHECK(model.normal({28, {0.5, 0}}).isApprox(-Vector3d::UnitZ(), 1e-9));
    CHECK(model.normal({20, {0.5, 0}}).isApprox(Vector3d::UnitZ(), 1e-9));
    for (int i = 4; i < 8; ++i) {
        const Vector2d middle(0.5, 0.5);
        const Vector3d p = model.position({i, middle});
        CHECK(model.normal({i, middle}).dot(Vector3d(p.x(), p.y(), 0)) > 0);
    }
}

TEST_CASE("The teapot is the same model in any parametrisation, size and place", "[surface][property]") {
    const SurfaceModel reference = models::teapot();
    const double volume = enclosed_volume(reference, 10);
    for (const double factor : {1.0, 1e-6, 1e6}) {
        const SurfaceModel model = models::model_of(models::scaled(models::shuffled(models::teapot_nets()), factor));
        check_consistent(model, 0);
        CHECK(model.num_components() == 4);
        for (const CurveKind kind : {CurveKind::Boundary, CurveKind::Smooth, CurveKind::Crease, CurveKind::Pole})
            CHECK(count(model, kind) == count(reference, kind));
        CHECK(model.vertices().size() == reference.vertices().size());
        CHECK(enclosed_volume(model, 10) / std::pow(factor, 3) == Approx(volume));
        CHECK(total_length(model, CurveKind::Boundary) / factor ==
              Approx(total_length(reference, CurveKind::Boundary)).epsilon(1e-9));
        for (int i = 0; i < 32; ++i) {
            // The middle of a patch is the middle in all parametrisations.
            const SurfacePoint middle{i, {0.5, 0.5}};
            CHECK(model.normal(middle).isApprox(reference.normal(middle), 1e-9));
        }
    }
    const Eigen::AngleAxisd turn(1.0, Vector3d(1, 2, 3).normalized());
    const SurfaceModel moved = models::model_of(models::mapped(
        models::teapot_nets(), [&](const Vector3d& p) -> Vector3d { return turn * p + Vector3d(100, 0, 0); }));
    CHECK(moved.num_components() == 4);
    CHECK(moved.curves().size() == reference.curves().size());
    CHECK(count(moved, CurveKind::Crease) == 0);
}

TEST_CASE("Spheres, tori and cylinders have their topology and outward normals", "[surface][exact]") {
    struct Expected {
        models::Nets nets;
        int euler, boundaries, poles;
        double volume;
    };
    const std::vector<Expected> cases{{models::sphere_octants(2), 2, 0, 8, 4.0 / 3 * pi * 8},
                                      {models::sphere_cube(2), 2, 0, 0, 4.0 / 3 * pi * 8},
                                      {models::torus(3, 1), 0, 0, 0, 2 * pi * pi * 3},
                                      {models::cylinder(1, 2), 0, 8, 0, 4.0 / 3 * pi}};
    for (const Expected& expected : cases)
        for (const bool shuffle : {false, true}) {
            const SurfaceModel model = models::model_of(shuffle ? models::shuffled(expected.nets) : expected.nets);
            check_consistent(model, 1e-14);
            CHECK(model.num_components() == 1);
            CHECK(euler_characteristic(model) == expected.euler);
            CHECK(count(model, CurveKind::Boundary) == expected.boundaries);
            CHECK(count(model, CurveKind::Pole) == expected.poles);
            CHECK(count(model, CurveKind::Crease) == 0);
            for (const ModelCurve& curve : model.curves()) CHECK(curve.largest_angle < 1e-6);
            CHECK(enclosed_volume(model, 100) == Approx(expected.volume).epsilon(1e-3));
        }
    CHECK(total_length(models::model_of(models::sphere_cube(1)), CurveKind::Smooth) ==
          Approx(12 * std::acos(1.0 / 3)).epsilon(1e-9));
    CHECK(total_length(models::model_of(models::cylinder(1, 2)), CurveKind::Boundary) == Approx(4 * pi).epsilon(1e-9));
}

TEST_CASE("A patch is glued to itself along its seams", "[surface][exact]") {
    const SurfaceModel sphere = models::sphere_with_seam(2);
    check_consistent(sphere, 1e-14);
    CHECK(count(sphere, CurveKind::Smooth) == 1);
    CHECK(count(sphere, CurveKind::Pole) == 2);
    CHECK(sphere.vertices().size() == 2);
    CHECK(total_length(sphere, CurveKind::Smooth) == Approx(2 * pi).epsilon(1e-12));
    CHECK((sphere.normal({0, {1, pi / 2}}) - Vector3d::UnitZ()).norm() < 1e-12);

    const SurfaceModel torus = models::torus_with_seams(2, 0.5);
    check_consistent(torus, 1e-14);
    CHECK(count(torus, CurveKind::Smooth) == 2);
    CHECK(torus.curves().size() == 2);
    CHECK(torus.vertices().size() == 1);
    CHECK(euler_characteristic(torus) == 0);

    const SurfaceModel cylinder = models::cylinder_with_seam(1, 2);
    check_consistent(cylinder, 1e-14);
    CHECK(count(cylinder, CurveKind::Boundary) == 2);
    CHECK(count(cylinder, CurveKind::Smooth) == 1);
    CHECK(cylinder.vertices().size() == 2);
    for (const ModelCurve& curve : cylinder.curves())
        if (curve.kind == CurveKind::Boundary) CHECK(curve.ends[0] == curve.ends[1]);
    CHECK((cylinder.normal({0, {0, 1}}) - Vector3d::UnitX()).norm() < 1e-12);

    Eigen::Matrix2d swap;
    swap << 0, 1, 1, 0;
    const SurfaceModel inward =
        models::model_of(reparametrise(make_torus({5, 0, 0}, 2, 0.5), swap, {0, 0}, {{0, 0}, {2 * pi, 2 * pi}}));
    CHECK(inward.flipped(0));
    CHECK(inward.normal({0, {0, 0}}).isApprox(Vector3d::UnitX(), 1e-12));
}

TEST_CASE("Creases are told from smooth curves by the angle between normals", "[surface][exact]") {
    for (const double degrees : {0.0, 5.0, 14.9, 15.1, 40.0, 90.0, 170.0}) {
        const SurfaceModel model = models::model_of(models::hinge(degrees * pi / 180));
        check_consistent(model, 0);
        CHECK(count(model, degrees > 15 ? CurveKind::Crease : CurveKind::Smooth) == 1);
        CHECK(model.curves()[model.loops(0)[0][1].curve].largest_angle == Approx(degrees * pi / 180).margin(1e-12));
    }
    const SurfaceModel cube = models::model_of(models::cube());
    check_consistent(cube, 0);
    CHECK(count(cube, CurveKind::Crease) == 12);
    CHECK(cube.vertices().size() == 8);
    CHECK(enclosed_volume(cube) == Approx(1));
    CHECK(count(models::model_of(models::cube(), {.crease_angle = 2}), CurveKind::Smooth) == 12);
}

TEST_CASE("Patches of different degree and different parameters are glued", "[surface][exact]") {
    const SurfaceModel mixed = models::model_of(models::mixed_degrees());
    check_consistent(mixed, 1e-14);
    CHECK(mixed.num_components() == 1);
    CHECK(mixed.curves()[mixed.loops(0)[0][3].curve].uses.size() == 2);
    CHECK(!is_followed(mixed.curves()[mixed.loops(0)[0][3].curve]));

    for (int variant = 0; variant < 64; variant += 7) {
        models::Nets nets = models::differing_parameters();
        nets[0] = models::turned(nets[0], variant % 8);
        nets[1] = models::turned(nets[1], variant / 8);
        const SurfaceModel model = models::model_of(nets);
        check_consistent(model, 1e-12);
        CHECK(model.num_components() == 1);
        CHECK(count(model, CurveKind::Smooth) == 1);
        for (const ModelCurve& curve : model.curves())
            if (curve.uses.size() == 2) CHECK(is_followed(curve));
        CHECK(model.normal({0, {0.5, 0.5}}).isApprox(model.normal({1, {0.5, 0.5}})));
    }
}

TEST_CASE("Sides within the tolerance are glued, farther ones not", "[surface]") {
    for (const double gap : {1e-9, 1e-4}) {
        models::Nets nets = models::hinge(0);
        for (Vector3d& p : nets[1].points) p += gap * Vector3d(0.6, 0, 0.8);
        const SurfaceModel model = models::model_of(nets);
        CHECK(model.num_components() == (gap < 1e-6 ? 1 : 2));
        CHECK(models::model_of(nets, {.tolerance = 1e-3}).num_components() == 1);
    }
}

TEST_CASE("Parts that only touch stay apart", "[surface][exact]") {
    models::Nets nets = models::cube();
    for (const BezierNet& net : models::cube())
        nets.push_back(models::mapped({net}, [](const Vector3d& p) -> Vector3d { return p + Vector3d(1, 1, 1); })[0]);
    const SurfaceModel model = models::model_of(nets);
    CHECK(model.num_components() == 2);
    CHECK(model.vertices().size() == 16);
    // A sphere with a smaller one that shares its pole.
    models::Nets spheres = models::sphere_octants(1);
    for (const BezierNet& net : models::mapped(models::sphere_octants(0.5),
                                               [](const Vector3d& p) -> Vector3d { return p + Vector3d(0, 0, 0.5); }))
        spheres.push_back(net);
    const SurfaceModel nested = models::model_of(spheres);
    CHECK(nested.num_components() == 2);
    CHECK(nested.vertices().size() == 12);
}

TEST_CASE("Open sheets keep the orientation of their first patch", "[surface][exact]") {
    models::Nets sheet = models::wavy_sheet(3);
    for (std::size_t i = 1; i < sheet.size(); ++i) sheet[i] = models::turned(sheet[i], static_cast<int>(i) % 8);
    const SurfaceModel up = models::model_of(sheet);
    check_consistent(up, 0);
    CHECK(count(up, CurveKind::Smooth) == 12);
    CHECK(count(up, CurveKind::Boundary) == 12);
    for (const ModelCurve& curve : up.curves()) CHECK(curve.largest_angle < 1e-12);
    for (int i = 0; i < 9; ++i) CHECK(up.normal({i, {0.5, 0.5}}).z() > 0);
    sheet[0] = models::flip_u(sheet[0]);
    const SurfaceModel down = models::model_of(sheet);
    for (int i = 0; i < 9; ++i) CHECK(down.normal({i, {0.5, 0.5}}).z() < 0);
}

TEST_CASE("Slivers and uneven parametrisations are models like others", "[surface]") {
    for (const double aspect : {1e2, 1e4}) {
        const SurfaceModel model = models::model_of({models::sliver(aspect)});
        check_consistent(model, 0);
        CHECK(count(model, CurveKind::Boundary) == 4);
    }
    check_consistent(models::model_of({models::uneven_square(1e6)}), 0);
}

TEST_CASE("Models that are no surface are refused, by number", "[surface]") {
    models::Nets fan = models::hinge(0);
    fan.push_back(models::hinge(1.0)[1]);
    CHECK_THROWS_WITH(models::model_of(fan), Catch::Contains("three sides share curve") &&
                                                 Catch::Contains("patch 0 right") && Catch::Contains("patch 2 left"));

    models::Nets flat = models::hinge(0);
    flat[1].points[3] = flat[1].points[2] = {2, 0, 0};
    flat[1].points[1] = {1, 0, 0};
    flat[1].points[0] = {0, 0, 0};
    CHECK_THROWS_WITH(models::model_of(flat), Catch::Contains("patch 1 has zero area"));
    CHECK_THROWS_WITH(models::model_of({BezierNet{1, 1, std::vector<Vector3d>(4, Vector3d(1, 2, 3)), {}}}),
                      Catch::Contains("patch 0 has zero area"));

    class Broken final : public ParametricSurface {
      public:
        Domain domain() const override { return {}; }
        Vector3d position(const Vector2d&) const override { return Vector3d::Constant(NAN); }
        Jet1 jet1(const Vector2d& uv) const override { return {position(uv), Vector3d::UnitX(), Vector3d::UnitY()}; }
        Jet2 jet2(const Vector2d& uv) const override {
            return {position(uv),     Vector3d::UnitX(), Vector3d::UnitY(),
                    Vector3d::Zero(), Vector3d::Zero(),  Vector3d::Zero()};
        }
    };
    CHECK_THROWS_WITH(models::model_of(std::make_unique<const Broken>()),
                      Catch::Contains("patch 0 has values that are not finite"));
    CHECK_THROWS_AS(models::model_of(models::Patch()), std::invalid_argument);
    CHECK_THROWS_AS(models::model_of(models::cube(), {.tolerance = 0}), std::invalid_argument);

    // A band of three patches closed with half a twist.
    models::Nets band;
    for (int k = 0; k < 3; ++k) {
        const auto rail = [](int i, int end) -> Vector3d {
            const double turn = 2 * pi * i / 3, twist = pi * i / 3 + (end ? pi : 0);
            const Vector3d outward(std::cos(turn), std::sin(turn), 0);
            return 3 * outward + std::cos(twist) * outward + std::sin(twist) * Vector3d::UnitZ();
        };
        band.push_back({1, 1, {rail(k, 0), rail(k + 1, 0), rail(k, 1), rail(k + 1, 1)}, {}});
    }
    CHECK_THROWS_WITH(models::model_of(band), Catch::Contains("one-sided"));
}

TEST_CASE("An empty model and thousands of patches are fine", "[surface]") {
    CHECK(models::model_of(models::Nets{}).num_patches() == 0);
    const auto start = std::chrono::steady_clock::now();
    const int n = 50;
    const SurfaceModel model = models::model_of(models::wavy_sheet(n));
    CHECK(model.num_components() == 1);
    CHECK(count(model, CurveKind::Smooth) == 2 * n * (n - 1));
    CHECK(static_cast<int>(model.vertices().size()) == (n + 1) * (n + 1));
    CHECK(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() < 5);
}

TEST_CASE("Trimmed patches have their topology, areas and ways out", "[surface][exact]") {
    const SurfaceModel plate = models::plate_with_hole(0.2);
    check_consistent(plate, 1e-14);
    CHECK(count(plate, CurveKind::Boundary) == 5);
    CHECK(plate.area(0) == Approx(1 - pi * 0.04).epsilon(1e-9));
    CHECK(total_length(plate, CurveKind::Boundary) == Approx(4 + 2 * pi * 0.2));
    CHECK(plate.contains({0, {0.3, 0.7}}));
    CHECK(!plate.contains({0, {0.65, 0.4}}));
    CHECK(!plate.contains({0, {1.1, 0.4}}));
    // From the left into the hole, from inside a small step, and from its rim away from it.
    const auto into = plate.exit({0, {0.1, 0.35}}, {0.8, 0});
    REQUIRE(into);
    CHECK(into->fraction * 0.8 == Approx(0.35));
    CHECK(into->t == Approx(0.5));
    CHECK(into->use == plate.loops(0)[1][0]);
    CHECK(!plate.exit({0, {0.1, 0.35}}, {0.3, 0}));
    CHECK(!plate.exit(plate.on_curve(into->use.curve, 0, 0.3), {-0.1, 0.1}));
    CHECK(plate.exit(plate.on_curve(into->use.curve, 0, 0.3), {0.05, -0.1})->fraction == Approx(0).margin(1e-9));

    const SurfaceModel disc = models::disc_in_square(0.2);
    check_consistent(disc, 1e-14);
    CHECK(count(disc, CurveKind::Smooth) == 1);
    CHECK(disc.num_components() == 1);
    CHECK(disc.area(1) == Approx(pi * 0.04).epsilon(1e-9));

    const SurfaceModel block = models::bored_block(0.2, 0.4);
    check_consistent(block, 1e-14);
    CHECK(count(block, CurveKind::Crease) == 14);
    CHECK(count(block, CurveKind::Smooth) == 1);
    // The bore looks inward, the walls outward.
    CHECK(block.normal({2, {0, 0.2}}).isApprox(-Vector3d::UnitX(), 1e-12));
    CHECK(block.normal({0, {0.1, 0.1}}).isApprox(-Vector3d::UnitZ(), 1e-12));

    const SurfaceModel sphere = models::sphere_with_hole();
    check_consistent(sphere, 1e-14);
    CHECK(count(sphere, CurveKind::Pole) == 2);
    CHECK(count(sphere, CurveKind::Boundary) == 1);
}

TEST_CASE("Steps leave a trimmed patch where brute force says", "[surface][property]") {
    const SurfaceModel model = models::plate_with_hole(0.2);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(0, 1);
    const auto is_inside = [](const Vector2d& p) {
        return (p.array() >= 0).all() && (p.array() <= 1).all() && (p - Vector2d(0.65, 0.35)).norm() >= 0.2;
    };
    for (int i = 0; i < 2000; ++i) {
        const Vector2d from(unit(random), unit(random));
        CHECK(model.contains({0, from}) == is_inside(from));
        if (!is_inside(from)) continue;
        const Vector2d step = Vector2d(unit(random) - 0.5, unit(random) - 0.5) * (i % 2 == 0 ? 1 : 0.1);
        constexpr int n = 4000;
        int k = 0;
        while (k < n && is_inside(from + step * (k + 1.0) / n)) ++k;
        const auto exit = model.exit({0, from}, step);
        if (k == n) {
            // A corner that is only grazed may fall between the samples.
            if (exit) CHECK(!is_inside(from + step * (exit->fraction + 0.5 / n)));
            continue;
        }
        REQUIRE(exit);
        CHECK(exit->fraction == Approx((k + 0.5) / n).margin(1.0 / n));
    }
}

TEST_CASE("Topologies that do not hold together are refused, by number", "[surface]") {
    const auto square = [](auto&& change) {
        Topology topology;
        topology.patches.push_back({make_plane({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), {{}}});
        const Vector2d corners[] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
        for (int k = 0; k < 4; ++k) {
            topology.curves.emplace_back();
            topology.curves[k].uses.push_back({0, false, straight_image(corners[k], corners[(k + 1) % 4])});
            topology.patches[0].loops[0].push_back({k, 0});
        }
        change(topology);
        return SurfaceModel(std::move(topology));
    };
    CHECK_NOTHROW(square([](Topology&) {}));
    CHECK_THROWS_WITH(square([](Topology& t) { t.patches[0].loops[0].pop_back(); }),
                      Catch::Contains("curve 3 has a use in no loop"));
    CHECK_THROWS_WITH(square([](Topology& t) { t.patches[0].loops[0][1] = {0, 0}; }), Catch::Contains("curve 0"));
    CHECK_THROWS_WITH(square([](Topology& t) { t.patches[0].loops[0][1] = {7, 0}; }), Catch::Contains("curve 7"));
    CHECK_THROWS_WITH(square([](Topology& t) { t.curves[2].uses.clear(); }), Catch::Contains("curve 2 has 0 uses"));
    CHECK_THROWS_WITH(square([](Topology& t) {
                          t.curves[2].uses[0].image = straight_image({1, 1}, {0, 0.5});
                      }),
                      Catch::Contains("does not end where the next curve of patch 0 begins"));
    CHECK_THROWS_WITH(square([](Topology& t) {
                          std::reverse(t.patches[0].loops[0].begin(), t.patches[0].loops[0].end());
                          for (Topology::Curve& curve : t.curves) curve.uses[0].reversed = true;
                      }),
                      Catch::Contains("on their right"));
}

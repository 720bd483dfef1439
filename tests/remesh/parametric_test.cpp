#include "gradus/remesh/parametric.hpp"

#include "remesh/judged.hpp"

#include <catch2/catch.hpp>

#include <cstring>
#include <limits>

using namespace gradus;
using namespace gradus::testing;

namespace {

/// What holds for any sizes, however coarse.
void check_faithful(const models::Kind& kind, const SurfaceModel& model, const Judged& judged) {
    CHECK(judged.right_topology(kind));
    CHECK(judged.misplaced == 0);
    CHECK(judged.off_surface <= 1e-12 * model.diagonal());
    CHECK(judged.stray_features == 0);
    CHECK(judged.missing_corners == 0);
    CHECK(judged.missing_boundary == 0);
    CHECK(judged.report.shape.degenerate == 0);
    CHECK(judged.feature_length <= judged.curve_length * (1 + 1e-12));
}

/// What a unit mesh of sizes below the radii of curvature meets.
void check_good(const models::Kind& kind, const Judged& judged) {
    CHECK(judged.report.shape.area_length.min >= 0.6);
    CHECK(judged.report.shape.area_length.mean >= 0.95);
    CHECK(judged.report.edges->unit_share >= 0.95);
    CHECK(judged.report.normals->angle.max <= 60);
    CHECK(judged.turned <= 90);
    CHECK(judged.area == Approx(kind.area).epsilon(0.02));
    CHECK(judged.feature_length == Approx(judged.curve_length).epsilon(0.02));
}

std::vector<std::string> names() {
    std::vector<std::string> all;
    for (const models::Kind& kind : models::zoo()) all.push_back(kind.name);
    return all;
}

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

bool same_bits(const SurfaceMesh& a, const SurfaceMesh& b) {
    bool places = a.places.size() == b.places.size();
    for (std::size_t i = 0; places && i < a.places.size(); ++i)
        places = a.places[i].patch == b.places[i].patch && a.places[i].uv == b.places[i].uv;
    return places && same_bits(a.points, b.points) && same_bits(a.triangles, b.triangles) &&
           same_bits(a.patches, b.patches) && same_bits(a.sizes, b.sizes) && same_bits(a.features, b.features);
}

}  // namespace

TEST_CASE("Every kind of model gets a faithful unit mesh of uniform size", "[remesh][property]") {
    for (const std::string& name : names()) DYNAMIC_SECTION(name) {
            const models::Kind kind = models::kind_of(name);
            const SurfaceModel model = kind.make();
            const Judged judged = remesh_and_judge(kind, model, uniform_background(model, kind.size));
            check_faithful(kind, model, judged);
            check_good(kind, judged);
        }
}

TEST_CASE("Every kind of model gets a faithful unit mesh of graded sizes", "[remesh][property]") {
    for (const std::string& name : names()) DYNAMIC_SECTION(name) {
            const models::Kind kind = models::kind_of(name);
            const SurfaceModel model = kind.make();
            // Sizes of four times `size` are wider than the sliver.
            const double size = name == "sliver" ? kind.size / 4 : kind.size;
            const Judged judged = remesh_and_judge(kind, model, graded_background(model, size));
            check_faithful(kind, model, judged);
            check_good(kind, judged);
            CHECK(*std::min_element(judged.mesh.sizes.begin(), judged.mesh.sizes.end()) <=
                  0.14 * size);  // an eighth, and what it grows to on the way to the nearest vertex
        }
}

TEST_CASE("Sizes as large as the model and larger still give its topology", "[remesh][property]") {
    for (const std::string& name : names()) DYNAMIC_SECTION(name) {
            const models::Kind kind = models::kind_of(name);
            const SurfaceModel model = kind.make();
            for (const double factor : {4., 8., 20.}) {
                CAPTURE(factor);
                const Judged judged = remesh_and_judge(kind, model, uniform_background(model, factor * kind.size));
                check_faithful(kind, model, judged);
            }
        }
}

TEST_CASE("A fine mesh has as many triangles as predicted", "[remesh][converges]") {
    for (const std::string name : {"bump", "uneven square", "cube", "sphere of octants", "sphere with seam", "torus",
                                   "cylinder", "differing parameters"})
        DYNAMIC_SECTION(name) {
            const models::Kind kind = models::kind_of(name);
            const SurfaceModel model = kind.make();
            const Judged judged =
                remesh_and_judge(kind, model, uniform_background(model, 0.4 * kind.size), {.fast = true});
            check_faithful(kind, model, judged);
            CHECK(judged.mesh.triangles.size() == Approx(judged.statistics.predicted_triangles).epsilon(0.06));
            // The mesh is inscribed: its area is short of the surface's by the order of h^2.
            CHECK(judged.area == Approx(kind.area).epsilon(0.002));
        }
}

TEST_CASE("A model of any scale gets the mesh of its own size", "[remesh][property]") {
    for (const double scale : {1e-6, 1e6})
        for (const std::string name : {"bump", "cube", "sphere", "wavy", "mixed"}) {
            CAPTURE(scale, name);
            const models::Nets nets = name == "bump"     ? models::Nets{models::bump()}
                                      : name == "cube"   ? models::cube()
                                      : name == "sphere" ? models::sphere_octants()
                                      : name == "wavy"   ? models::wavy_sheet(3)
                                                         : models::mixed_degrees();
            const SurfaceModel unit = models::model_of(nets), model = models::model_of(models::scaled(nets, scale));
            models::Kind kind{.name = name, .size = 0.1, .loops = name == "cube" || name == "sphere" ? 0 : 1};
            const Judged reference = remesh_and_judge(kind, unit, graded_background(unit, kind.size));
            const Judged judged = remesh_and_judge(kind, model, graded_background(model, kind.size * scale));
            kind.area = reference.area * scale * scale;
            check_faithful(kind, model, judged);
            check_good(kind, judged);
            // A decimal factor rounds, and one decision that falls otherwise is some percent of a few hundred
            // triangles.
            CHECK(judged.mesh.triangles.size() == Approx(reference.mesh.triangles.size()).epsilon(0.1));
        }
}

TEST_CASE("A model far from the origin is meshed as well", "[remesh][property]") {
    const Eigen::Vector3d far(1e5, -2e5, 3e5);
    const auto moved = [&](const models::Nets& nets) {
        return models::model_of(
            models::mapped(nets, [&](const Eigen::Vector3d& p) -> Eigen::Vector3d { return p + far; }));
    };
    const SurfaceModel cube = moved(models::cube()), sphere = moved(models::sphere_octants());
    models::Kind kind{.name = "cube", .area = 6, .size = 0.15};
    const Judged of_cube = remesh_and_judge(kind, cube, graded_background(cube, kind.size));
    check_faithful(kind, cube, of_cube);
    check_good(kind, of_cube);
    kind.area = 4 * 3.14159265358979;
    kind.off_surface = [&](const Eigen::Vector3d& p) { return std::abs((p - far).norm() - 1) - 3e-10; };
    const Judged of_sphere = remesh_and_judge(kind, sphere, graded_background(sphere, kind.size));
    check_faithful(kind, sphere, of_sphere);
    check_good(kind, of_sphere);
}

TEST_CASE("The parametrisation does not show in the mesh", "[remesh][property]") {
    // The same surface in eight parametrisations, and stretched ones: counts and shapes agree.
    const models::Kind kind = models::kind_of("bump");
    const SurfaceModel plain = kind.make();
    const Judged reference = remesh_and_judge(kind, plain, graded_background(plain, kind.size));
    for (int k = 1; k < 8; ++k) {
        const SurfaceModel model = models::model_of({models::turned(models::bump(), k)});
        // The spot lies elsewhere in other parameters: take the uniform map.
        const Judged judged = remesh_and_judge(kind, model, uniform_background(model, kind.size));
        const Judged uniform = remesh_and_judge(kind, plain, uniform_background(plain, kind.size));
        CHECK(judged.mesh.triangles.size() == Approx(uniform.mesh.triangles.size()).epsilon(0.02));
        CHECK(judged.report.shape.area_length.mean == Approx(uniform.report.shape.area_length.mean).margin(0.01));
    }
    for (const double stretch : {1e-3, 1e3}) {
        const models::Kind sphere = models::kind_of("sphere with seam");
        const SurfaceModel model = models::model_of(models::stretched_sphere(stretch));
        const Judged judged = remesh_and_judge(sphere, model, uniform_background(model, sphere.size));
        check_faithful(sphere, model, judged);
        check_good(sphere, judged);
    }
}

TEST_CASE("A seam gives the mesh that several patches give", "[remesh][property]") {
    const auto pair = GENERATE(std::array<std::string, 2>{"torus", "torus with seams"},
                               std::array<std::string, 2>{"sphere of octants", "sphere with seam"},
                               std::array<std::string, 2>{"cylinder", "cylinder with seam"},
                               std::array<std::string, 2>{"sphere from a cube", "two hemispheres"});
    CAPTURE(pair[0]);
    std::array<double, 2> count, mean;
    for (int i = 0; i < 2; ++i) {
        const models::Kind kind = models::kind_of(pair[i]);
        const SurfaceModel model = kind.make();
        const Judged judged = remesh_and_judge(kind, model, uniform_background(model, kind.size));
        count[i] = static_cast<double>(judged.mesh.triangles.size());
        mean[i] = judged.report.shape.area_length.mean;
    }
    CHECK(count[0] == Approx(count[1]).epsilon(0.08));
    CHECK(mean[0] == Approx(mean[1]).margin(0.015));
}

TEST_CASE("Sizes that jump are meshed without a fold", "[remesh][property]") {
    // Not graded: from h to 20 h within one triangle of the background.
    for (const std::string name : {"bump", "sphere of octants", "cube", "torus with seams", "cylinder"})
        DYNAMIC_SECTION(name) {
            const models::Kind kind = models::kind_of(name);
            const SurfaceModel model = kind.make();
            const Domain d = model.patch(0).domain();
            const double h = 2 * kind.size;
            const SizedBackground sized = make_background(
                model, {.hmin = h / 20, .hmax = h, .at = {{model.position({0, (d.min + d.max) / 2}), h / 20}}});
            const Judged judged = remesh_and_judge(kind, model, sized);
            check_faithful(kind, model, judged);
            CHECK(judged.report.shape.area_length.min >= 0.15);
            CHECK(judged.report.normals->angle.max <= 60);
        }
}

TEST_CASE("A long thin patch is meshed", "[remesh][property]") {
    const models::Nets nets{models::sliver(1e3)};
    const SurfaceModel model = models::model_of(nets);
    models::Kind kind{.name = "sliver", .loops = 1};
    const Judged judged = remesh_and_judge(kind, model, uniform_background(model, 5e-3));
    check_faithful(kind, model, judged);
    // A strip of one row, as wide as a fifth of the size.
    CHECK(judged.mesh.triangles.size() >= 200);
    CHECK(judged.mesh.triangles.size() <= 2000);
    CHECK(judged.report.normals->angle.max <= 60);
}

TEST_CASE("The mesh does not depend on the number of threads nor on the run", "[remesh][property]") {
    for (const std::string name : {"sphere from a cube", "torus", "cube", "wavy sheet"}) DYNAMIC_SECTION(name) {
            const models::Kind kind = models::kind_of(name);
            const SurfaceModel model = kind.make();
            const SizedBackground sized = graded_background(model, kind.size);
            const ControlSpace control(sized.background, sized.sizes);
            const SurfaceMesh one = remesh(model, control, {.threads = 1}).mesh;
            CHECK(same_bits(one, remesh(model, control, {.threads = 2}).mesh));
            CHECK(same_bits(one, remesh(model, control, {.threads = 1}).mesh));
            const SurfaceModel again = kind.make();
            const SizedBackground sized_again = graded_background(again, kind.size);
            CHECK(same_bits(one, remesh(again, ControlSpace(sized_again.background, sized_again.sizes)).mesh));
        }
}

TEST_CASE("The fast schedule gives a valid mesh too", "[remesh][property]") {
    for (const std::string name : {"bump", "cube", "sphere of octants", "torus with seams", "cylinder", "cone"})
        DYNAMIC_SECTION(name) {
            const models::Kind kind = models::kind_of(name);
            const SurfaceModel model = kind.make();
            const Judged judged = remesh_and_judge(kind, model, graded_background(model, kind.size), {.fast = true});
            check_faithful(kind, model, judged);
            CHECK(judged.report.shape.area_length.min >= 0.4);
            CHECK(judged.report.shape.area_length.mean >= 0.92);
            CHECK(judged.report.edges->unit_share >= 0.95);
        }
}

TEST_CASE("A map that asks for too many triangles is refused with the number", "[remesh]") {
    const models::Kind kind = models::kind_of("flat square");
    const SurfaceModel model = kind.make();
    const SizedBackground sized = uniform_background(model, 0.1);
    SizedBackground tiny = sized;
    for (double& h : tiny.sizes) h = 1e-5;
    const ControlSpace control(tiny.background, tiny.sizes);
    // 1 / (sqrt(3)/4 1e-10) = 2.309e10
    REQUIRE_THROWS_AS(remesh(model, control), std::length_error);
    REQUIRE_THROWS_WITH(remesh(model, control), Catch::Contains("23094010768") && Catch::Contains("20000000"));
    const ControlSpace coarse(sized.background, sized.sizes);
    CHECK_THROWS_AS(remesh(model, coarse, {.max_triangles = 100}), std::length_error);
    CHECK_NOTHROW(remesh(model, coarse, {.max_triangles = 300}));
}

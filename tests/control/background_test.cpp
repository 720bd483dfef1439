#include "gradus/control/background.hpp"

#include "gradus/control/control_space.hpp"
#include "gradus/control/geometric_size.hpp"
#include "gradus/curvature/principal.hpp"
#include "gradus/quality/topology.hpp"
#include "support/zoo.hpp"

#include <catch2/catch.hpp>

#include <cmath>
#include <random>

using namespace gradus;

namespace {

SizingRule proportional(double alpha, double hmin, double hmax) {
    SizingRule rule;
    rule.value = alpha;
    rule.hmin = hmin;
    rule.hmax = hmax;
    return rule;
}

/// Largest distance of a vertex from the surface point at its parameters, over all corners.
double gap(const SurfaceModel& model, const Background& background) {
    const auto triangles = triangles_of(background.mesh);
    const auto points = points_of(background.mesh);
    double largest = 0;
    for (std::size_t t = 0; t < triangles.size(); ++t)
        for (int k = 0; k < 3; ++k)
            largest = std::max(
                largest, (model.position({background.patch[t], background.uv[t][k]}) - points[triangles[t][k]]).norm());
    return largest;
}

TopologyReport topology(const Background& background) {
    const auto triangles = triangles_of(background.mesh);
    const MeshView view{points_of(background.mesh), triangles};
    return measure_topology(view, edges_of(view));
}

}  // namespace

TEST_CASE("The background of every kind of model has its topology, its points on every patch and its sizes",
          "[control][property]") {
    for (const models::Kind& kind : models::zoo()) {
        CAPTURE(kind.name);
        const SurfaceModel model = kind.make();
        const SizingRule rule = proportional(0.3, 0.2 * kind.size, 4 * kind.size);
        const SizedBackground sized = make_background(model, rule);
        CHECK(sized.resolved);
        CHECK(gap(model, sized.background) <= 1e-9 * model.diagonal());
        const TopologyReport t = topology(sized.background);
        CHECK(t.oriented_manifold());
        CHECK(t.components == std::size_t(kind.components));
        CHECK(t.boundary_loops == std::size_t(kind.loops));
        CHECK(t.genus == kind.genus);
        CHECK(t.duplicate_positions == 0);
        CHECK(t.unused_vertices == 0);
        REQUIRE(sized.sizes.size() == sized.background.mesh.n_vertices());
        for (const double h : sized.sizes) CHECK((h >= rule.hmin && h <= rule.hmax));
        CHECK(sized.largest_error <= BackgroundOptions{}.size_tolerance);
        // Every face turns the way of the surface.
        const auto triangles = triangles_of(sized.background.mesh);
        const auto points = points_of(sized.background.mesh);
        int turned = 0;
        for (std::size_t f = 0; f < triangles.size(); ++f) {
            const auto& uv = sized.background.uv[f];
            const Eigen::Vector3d n = (points[triangles[f][1]] - points[triangles[f][0]])
                                          .cross(points[triangles[f][2]] - points[triangles[f][0]]);
            turned += n.dot(model.normal({sized.background.patch[f], (uv[0] + uv[1] + uv[2]) / 3})) <= 0;
        }
        CHECK(turned == 0);
    }
}

TEST_CASE("The size map is represented to its tolerance anywhere", "[control][property]") {
    for (const std::string name :
         {"bump", "wavy sheet", "torus", "torus with seams", "sphere with seam", "mixed degrees"})
        for (const double tolerance : {0.2, 0.05}) {
            CAPTURE(name, tolerance);
            const models::Kind kind = models::kind_of(name);
            const SurfaceModel model = kind.make();
            const SizingRule rule = proportional(0.3, 0.05 * kind.size, 4 * kind.size);
            const SizedBackground sized = make_background(model, rule, {.size_tolerance = tolerance, .finest = 0.05});
            const ControlSpace space(sized.background, sized.sizes);
            std::mt19937 random(3);
            std::uniform_real_distribution<double> uniform(0, 1);
            int beyond = 0;
            double largest = 0;
            constexpr int kSamples = 4000;
            for (int i = 0; i < kSamples; ++i) {
                const int p = static_cast<int>(random() % model.num_patches());
                const Domain d = model.patch(p).domain();
                const double s = uniform(random), t = uniform(random);
                const SurfacePoint at{p, d.min + Eigen::Vector2d(s, t).cwiseProduct(d.max - d.min)};
                const double error =
                    std::abs(std::log(space.size(at) / size_from_radius(rule, minimal_radius(model.patch(p), at.uv))));
                beyond += error > tolerance;
                largest = std::max(largest, error);
            }
            // It is asked for at middles and centroids; in between, and beside lines where the map has a kink, it may
            // be more.
            CHECK(beyond <= 0.02 * kSamples);
            CHECK(largest <= 4 * tolerance);
        }
}

TEST_CASE("Prescribed sizes are met at their points", "[control][exact]") {
    const models::Kind kind = models::kind_of("sphere of octants");
    const SurfaceModel model = kind.make();
    SizingRule rule = proportional(0.3, 0, 1);
    const Eigen::Vector3d first = model.position({2, {0.4, 0.3}}), second = model.position({6, {0.1, 0.8}});
    rule.at = {{first, 0.01}, {second, 0.05}};
    const SizedBackground sized = make_background(model, rule);
    const auto points = points_of(sized.background.mesh);
    for (const SizingRule::At& at : rule.at) {
        double nearest = 1e9, size = 0;
        for (std::size_t v = 0; v < points.size(); ++v)
            if (const double distance = (points[v] - at.point).norm(); distance < nearest)
                nearest = distance, size = sized.sizes[v];
        CHECK(nearest <= at.size);
        CHECK(size == at.size);
    }
    const std::vector<double> again = geometric_sizes(model, sized.background, rule);
    REQUIRE(again.size() == sized.sizes.size());
    for (std::size_t v = 0; v < again.size(); ++v) CHECK(again[v] == Approx(sized.sizes[v]).epsilon(1e-9));
    // A larger size than the rule's changes nothing.
    SizingRule larger = proportional(0.3, 0, 1);
    const SizedBackground plain = make_background(model, larger);
    larger.at = {{first, 5}};
    const SizedBackground same = make_background(model, larger);
    CHECK(same.sizes == plain.sizes);
}

TEST_CASE("Sizes by the rule are those of the sphere", "[control][exact]") {
    const double radius = GENERATE(1e-6, 1., 1e6);
    const SurfaceModel model = models::model_of(models::sphere_octants(radius));
    const SizedBackground sized = make_background(model, proportional(0.3, 0, 1e9));
    for (const double h : sized.sizes) CHECK(h == Approx(0.3 * radius).epsilon(1e-6));
}

TEST_CASE("The background is refused beyond its number of triangles, and for bad options", "[control]") {
    const SurfaceModel model = models::kind_of("bump").make();
    const SizingRule rule = proportional(0.3, 0, 1);
    const SizedBackground stopped =
        make_background(model, rule, {.size_tolerance = 1e-4, .finest = 0.01, .max_triangles = 5000});
    CHECK_FALSE(stopped.resolved);
    CHECK(stopped.background.mesh.n_faces() <= 5000);
    CHECK(gap(model, stopped.background) <= 1e-9 * model.diagonal());
    CHECK_THROWS_AS(make_background(model, rule, {.cells = 1}), std::invalid_argument);
    CHECK_THROWS_AS(make_background(model, rule, {.size_tolerance = 0}), std::invalid_argument);
    CHECK_THROWS_AS(make_background(model, rule, {.chord_tolerance = -1}), std::invalid_argument);
    CHECK_THROWS_AS(make_background(model, rule, {.finest = 0}), std::invalid_argument);
    CHECK_THROWS_AS(make_background(model, proportional(0, 0, 1)), std::invalid_argument);
}

TEST_CASE("A background goes to a file and comes back, with its parameters and without", "[control][property]") {
    for (const models::Kind& kind : models::zoo()) {
        CAPTURE(kind.name);
        const SurfaceModel model = kind.make();
        const SizedBackground sized = make_background(model, proportional(0.3, 0.5 * kind.size, 4 * kind.size));
        if (sized.background.mesh.n_faces() > 5000) continue;
        TriangleSoup soup = soup_from_background(sized.background);
        const Background with = background_from_soup(model, soup);
        CHECK(with.patch == sized.background.patch);
        CHECK(gap(model, with) <= 1e-9 * model.diagonal());
        // At a pole any of the parameters of its side will do.
        const bool pole =
            std::any_of(model.vertices().begin(), model.vertices().end(), [](const ModelVertex& v) { return v.pole; });
        if (!pole && kind.name.find("seam") == std::string::npos) CHECK(with.uv == sized.background.uv);
        CHECK(std::ranges::equal(points_of(with.mesh), points_of(sized.background.mesh)));
        CHECK(triangles_of(with.mesh) == triangles_of(sized.background.mesh));
        soup.parameters.clear();
        const Background without = background_from_soup(model, soup);
        CHECK(without.patch == sized.background.patch);
        CHECK(gap(model, without) <= 1e-6 * model.diagonal());
        soup.labels.clear();
        CHECK(gap(model, background_from_soup(model, soup)) <= 1e-6 * model.diagonal());
        // Parameters of a triangle belong together: no triangle spans a seam.
        for (std::size_t f = 0; f < without.uv.size(); ++f) {
            const Domain d = model.patch(without.patch[f]).domain();
            const auto& uv = without.uv[f];
            const Eigen::Vector2d centre = (uv[0] + uv[1] + uv[2]) / 3,
                                  middle = (sized.background.uv[f][0] + sized.background.uv[f][1] +
                                            sized.background.uv[f][2]) /
                                           3;
            CHECK((centre - middle).cwiseQuotient(d.max - d.min).norm() <= 0.2);
        }
    }
}

TEST_CASE("A file's vertex off its patch is refused by number", "[control]") {
    const SurfaceModel model = models::model_of({models::flat_square()});
    const SizedBackground sized = make_background(model, proportional(0.3, 0, 1));
    TriangleSoup soup = soup_from_background(sized.background);
    soup.parameters.clear();
    soup.points[5].z() += 0.01;
    CHECK_THROWS_AS(background_from_soup(model, soup), std::invalid_argument);
    CHECK_THROWS_WITH(background_from_soup(model, soup), Catch::Contains("vertex 6"));
}

TEST_CASE("Cutting for gradation leaves no long edge between unequal sizes", "[control][property]") {
    const SurfaceModel model = models::kind_of("sphere of octants").make();
    SizingRule rule = proportional(0.3, 0, 1);
    rule.at = {{model.position({2, {0.4, 0.3}}), 0.02}};
    SizedBackground sized = make_background(model, rule);
    std::vector<double> graded = sized.sizes;
    const std::size_t before = graded.size();
    const int cuts = refine_for_gradation(model, rule, 2, sized, graded);
    CHECK(graded.size() == before + cuts);
    CHECK(sized.sizes.size() == graded.size());
    CHECK(sized.background.mesh.n_vertices() == graded.size());
    CHECK(gap(model, sized.background) <= 1e-9 * model.diagonal());
    const auto points = points_of(sized.background.mesh);
    for (const Triangle& t : triangles_of(sized.background.mesh))
        for (int k = 0; k < 3; ++k) {
            const int a = t[k], b = t[(k + 1) % 3];
            if (std::max(graded[a], graded[b]) > 1.1 * std::min(graded[a], graded[b]))
                CHECK((points[a] - points[b]).norm() <= 2 * std::min(graded[a], graded[b]) * (1 + 1e-12));
        }
    for (std::size_t v = before; v < sized.sizes.size(); ++v) CHECK(sized.sizes[v] == Approx(0.3).epsilon(1e-6));
}

TEST_CASE("Sizes far too small for a mesh are refused before the background is refined", "[control]") {
    const SurfaceModel model = models::model_of({models::bump()});
    CHECK_THROWS_AS(make_background(model, {.value = 1e-6, .hmax = 1e-6}, {.max_unit_triangles = 1e6}),
                    std::length_error);
    CHECK_NOTHROW(make_background(model, {.value = 0.3, .hmin = 0.05, .hmax = 1}, {.max_unit_triangles = 1e6}));
}

#include "gradus/remesh/adapt.hpp"

#include "remesh/judged.hpp"
#include "remesh/simple_supports.hpp"

#include <catch2/catch.hpp>

using namespace gradus;
using namespace gradus::testing;

TEST_CASE("On a sphere of one size the loop ends at once with a unit mesh that leaves nothing to do",
          "[remesh][converges]") {
    constexpr double kValenceWorth = 0.15;  // as flips count it
    for (const std::string name : {"sphere from a cube", "sphere of octants", "sphere with seam"})
        for (const double h : {0.3, 0.15, 0.08}) {
            CAPTURE(name, h);
            const SurfaceModel model = models::kind_of(name).make();
            AdaptOptions options;
            options.rule.hmin = options.rule.hmax = h;
            int calls = 0;
            options.progress = [&](int iteration) { CHECK(iteration == ++calls); };
            const AdaptResult result = adapt(model, options);
            const SurfaceMesh& mesh = result.mesh;
            CHECK(result.converged);
            // The map is the same on any mesh, so there is no second iteration.
            REQUIRE(result.iterations.size() == 1);
            CHECK(calls == 1);
            const AdaptIteration& only = result.iterations.front();
            CHECK(only.unit_share >= 0.99);
            CHECK(only.next_unit_share == Approx(only.unit_share).margin(1e-3));
            CHECK(only.quality_min >= 0.88);
            CHECK(only.triangles == static_cast<int>(mesh.triangles.size()));
            // The integral of 1 / (sqrt(3)/4 h^2) over the sphere.
            const double integral = 4 * std::numbers::pi / (std::sqrt(3.0) / 4 * h * h);
            CHECK(only.predicted_triangles == Approx(integral).epsilon(0.015));
            CHECK(only.triangles == Approx(integral).epsilon(h > 0.2 ? 0.06 : 0.04));
            for (const Eigen::Vector3d& p : mesh.points) CHECK(std::abs(p.norm() - 1) <= 1e-12);
            for (const double size : mesh.sizes) CHECK(size == Approx(h).epsilon(1e-12));

            const SimpleSupport sphere = ball(1, h);
            Editor editor = editor_of(sphere, {mesh.points, mesh.triangles});
            const TopologyReport topology = topology_of(editor);
            CHECK(topology.oriented_manifold());
            CHECK(topology.closed());
            CHECK(topology.euler == 2);
            int too_long = 0, too_short = 0, flips = 0, far = 0;
            const int halfedges = 3 * editor.mesh().num_triangles();
            for (int e = 0; e < halfedges; ++e) {
                too_long += editor.length(e) > std::numbers::sqrt2;
                too_short += editor.length(e) < 1 / std::numbers::sqrt2;
                flips += editor.mesh().twin(e) > e && editor.can_flip(e) &&
                         editor.flip_rise(e) < kValenceWorth * editor.flip_gain(e) - 1e-9;
            }
            CHECK(too_short == 0);
            CHECK(too_long <= 0.01 * halfedges);
            CHECK(flips == 0);
            for (int v = 0; v < editor.mesh().num_vertices(); ++v) far += editor.relax(v) > 0.05;
            CHECK(far <= 0.02 * editor.mesh().num_vertices());
        }
}

TEST_CASE("Where curvature varies the loop ends when the mesh meets the map on it", "[remesh][converges]") {
    const models::Kind kind = models::kind_of("torus");
    const SurfaceModel model = kind.make();
    AdaptOptions options;
    options.rule.value = 0.3;
    options.rule.hmax = 0.5;
    const AdaptResult result = adapt(model, options);
    REQUIRE(result.converged);
    const auto& iterations = result.iterations;
    for (std::size_t i = 0; i < iterations.size(); ++i)
        CHECK((iterations[i].next_unit_share >= options.unit_share) == (i + 1 == iterations.size()));
    for (const Eigen::Vector3d& p : result.mesh.points) CHECK(kind.off_surface(p) <= 1e-12);

    // A share that no mesh has, and as many iterations as are let.
    AdaptOptions never = options;
    never.unit_share = 1.1;
    never.max_iterations = 2;
    const AdaptResult endless = adapt(model, never);
    CHECK_FALSE(endless.converged);
    CHECK(endless.iterations.size() == 2);

    // The same again is the same to the bit.
    const AdaptResult again = adapt(model, options);
    CHECK(again.mesh.triangles == result.mesh.triangles);
    CHECK(again.mesh.points == result.mesh.points);
}

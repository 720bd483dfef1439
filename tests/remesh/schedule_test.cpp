// What the schedule of operations leaves when it is run again.
#include "../../src/remesh/optimise.hpp"
#include "remesh/simple_supports.hpp"

#include <catch2/catch.hpp>

using namespace gradus;
using namespace gradus::testing;
using Eigen::Vector3d;

namespace {

OptimiseReport run(Editor& editor, const OptimiseOptions& options = {}) {
    StageClock::Stages stages;
    StageClock clock(stages);
    return optimise(editor, options, clock);
}

int operations(const OptimiseReport& report) {
    return report.splits + report.collapses + report.flips + report.kept + report.worst_kept;
}

double mean_energy(const Editor& editor) {
    double sum = 0;
    for (int t = 0; t < editor.mesh().num_triangles(); ++t) sum += editor.energy(t);
    return sum / editor.mesh().num_triangles();
}

// The largest move of a vertex over the size, of the same connectivity.
double farthest(const Editor& before, const Editor& after) {
    double most = 0;
    for (int v = 0; v < before.mesh().num_vertices(); ++v)
        most = std::max(most, (before.vertex(v).p - after.vertex(v).p).norm() / after.vertex(v).h);
    return most;
}

Editor irregular(const SimpleSupport& support) {
    return support.curves.empty() ? editor_of(support, triangulations::sphere(4))
                                  : editor_with_curves(support, square(10));
}

}  // namespace

TEST_CASE("Run again and again the schedule comes to an end where all triangles meet the goal, and changes no bit",
          "[remesh][property]") {
    // A second run is not idle: from the new places some operations help that did not before, and vertices creep on.
    // But operations cease, moves shrink, and then there is nothing left.
    constexpr int kMostRuns = 20;
    for (const SimpleSupport& support :
         {ball(1, 0.5), ball(1, 0.4), ball(1, 0.3), ball(1, 0.25), square_support(0.15)}) {
        Editor editor = irregular(support);
        const OptimiseReport first = run(editor);
        CHECK(operations(first) > 50);
        int runs = 0;
        for (;; ++runs) {
            const Editor before = editor;
            const OptimiseReport report = run(editor);
            CAPTURE(runs, report.splits, report.collapses, report.flips, report.kept, report.worst_kept);
            REQUIRE(runs < kMostRuns);
            CHECK(operations(report) <= 0.1 * operations(first));
            if (operations(report) > 0) continue;
            REQUIRE(mesh_of(editor).triangles.size() == mesh_of(before).triangles.size());
            const double moved = farthest(before, editor);
            if (moved == 0) {
                CHECK(mesh_of(editor).triangles == mesh_of(before).triangles);
                CHECK(mesh_of(editor).points == mesh_of(before).points);
                break;
            }
            // Without operations vertices only move to lower the energy, and by little.
            CHECK(mean_energy(editor) < mean_energy(before));
            CHECK(moved < 0.1);
        }
        CHECK(runs >= 1);
    }
}

TEST_CASE("Where some triangles stay below the goal the rest comes to an end all the same", "[remesh][property]") {
    // The search for better worst triangles moves vertices that the next run moves back for the mean: no end of that.
    for (const double h : {0.1, 0.2, 0.25}) {
        CAPTURE(h);
        const SimpleSupport support = square_support(h);
        Editor editor = irregular(support);
        for (int runs = 0; runs < 20; ++runs) run(editor);
        const double before = mean_energy(editor);
        const int triangles = editor.mesh().num_triangles();
        const OptimiseReport report = run(editor);
        CHECK(report.below_goal > 0);
        CHECK(report.splits + report.collapses + report.flips + report.kept == 0);
        CHECK(editor.mesh().num_triangles() == triangles);
        CHECK(mean_energy(editor) == Approx(before).margin(1e-4));
    }
}

TEST_CASE("What the schedule leaves has no edge to split or collapse, no flip that helps, and next to no moves",
          "[remesh][property]") {
    constexpr double kValenceWorth = 0.15;  // as flips count it
    for (const SimpleSupport& support : {ball(1, 0.3), ball(1, 0.2), ball(1, 0.12), square_support(0.1)}) {
        Editor editor = irregular(support);
        run(editor);
        const Connectivity& mesh = editor.mesh();
        CHECK(mesh.check() == "");
        int outside = 0, flips = 0, far = 0;
        const int halfedges = 3 * mesh.num_triangles();
        for (int h = 0; h < halfedges; ++h) {
            const double length = editor.length(h);
            outside += length > std::numbers::sqrt2 || length < 1 / std::numbers::sqrt2;
            flips += mesh.twin(h) > h && editor.can_flip(h) &&
                     editor.flip_rise(h) < kValenceWorth * editor.flip_gain(h) - 1e-9;
        }
        CAPTURE(halfedges, outside);
        CHECK(outside <= 0.03 * halfedges);
        CHECK(flips == 0);
        CHECK(mesh.num_live_triangles() == mesh.num_triangles());
        double least = 1;
        for (int t = 0; t < mesh.num_triangles(); ++t) least = std::min(least, editor.quality(t));
        CHECK(least >= 0.85);
        for (int v = 0; v < mesh.num_vertices(); ++v) far += editor.relax(v) > 0.05;
        CHECK(far <= 0.02 * mesh.num_vertices());
    }
}

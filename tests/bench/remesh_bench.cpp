// The teapot from its patches to the graded mesh, stage by stage.
#include <benchmark/benchmark.h>

#include <string>

#include "gradus/control/control_space.hpp"
#include "gradus/control/geometric_size.hpp"
#include "gradus/gradation/grade.hpp"
#include "gradus/io/patch_files.hpp"
#include "gradus/remesh/parametric.hpp"

namespace {

using namespace gradus;

const SurfaceModel& teapot() {
    static const SurfaceModel model = make_model(read_patches(std::string(GRADUS_ASSETS) + "/teapot.bpt"));
    return model;
}

/// The paper's experiment; sizes in the unit of the teapot, whose diagonal is 8.2.
const SizingRule kRule{.value = 0.3, .hmin = 0.01, .hmax = 0.5};

const SizedBackground& background() {
    static const SizedBackground sized = make_background(teapot(), kRule);
    return sized;
}

std::vector<double> graded_sizes() {
    std::vector<double> sizes = background().sizes;
    grade(background().background.mesh, sizes, {.shock = 1.5});
    return sizes;
}

void teapot_background(benchmark::State& state) {
    for (auto _ : state) benchmark::DoNotOptimize(make_background(teapot(), kRule).sizes.data());
    state.counters["vertices"] = static_cast<double>(background().sizes.size());
}

void teapot_grade(benchmark::State& state) {
    background();
    for (auto _ : state) benchmark::DoNotOptimize(graded_sizes().data());
}

void teapot_remesh(benchmark::State& state, bool fast) {
    const ControlSpace control(background().background, graded_sizes());
    std::size_t triangles = 0;
    for (auto _ : state) triangles = remesh(teapot(), control, {.fast = fast}).mesh.triangles.size();
    state.counters["triangles"] = static_cast<double>(triangles);
}

BENCHMARK(teapot_background)->Unit(benchmark::kMillisecond);
BENCHMARK(teapot_grade)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(teapot_remesh, default, false)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(teapot_remesh, fast, true)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace

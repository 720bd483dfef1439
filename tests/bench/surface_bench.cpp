// Evaluation of patches, and gluing.
#include <benchmark/benchmark.h>

#include <random>
#include <vector>

#include "gradus/curvature/principal.hpp"
#include "gradus/io/patch_files.hpp"

namespace {

using namespace gradus;

PatchFile teapot_file() { return read_patches(std::string(GRADUS_ASSETS) + "/teapot.bpt"); }

std::vector<Eigen::Vector2d> places() {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> in(0, 1);
    std::vector<Eigen::Vector2d> uv(4096);
    for (Eigen::Vector2d& x : uv) x = {in(random), in(random)};
    return uv;
}

/// Calls evaluate(model, place) for many places; one item is one place.
template <class Evaluate>
void over_places(benchmark::State& state, const Evaluate& evaluate) {
    const SurfaceModel model = make_model(teapot_file());
    const std::vector<Eigen::Vector2d> uv = places();
    for (auto _ : state)
        for (const Eigen::Vector2d& x : uv) benchmark::DoNotOptimize(evaluate(model, SurfacePoint{4, x}));
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(uv.size()));
}

void teapot_position(benchmark::State& state) {
    over_places(state, [](const SurfaceModel& m, const SurfacePoint& at) { return m.position(at); });
}
void teapot_jet1(benchmark::State& state) {
    over_places(state, [](const SurfaceModel& m, const SurfacePoint& at) { return m.patch(at.patch).jet1(at.uv); });
}
void teapot_jet2(benchmark::State& state) {
    over_places(state, [](const SurfaceModel& m, const SurfacePoint& at) { return m.patch(at.patch).jet2(at.uv); });
}
void teapot_normal(benchmark::State& state) {
    over_places(state, [](const SurfaceModel& m, const SurfacePoint& at) { return m.normal(at); });
}
void teapot_minimal_radius(benchmark::State& state) {
    over_places(state,
                [](const SurfaceModel& m, const SurfacePoint& at) { return minimal_radius(m.patch(at.patch), at.uv); });
}

void teapot_gluing(benchmark::State& state) {
    const PatchFile file = teapot_file();
    for (auto _ : state) benchmark::DoNotOptimize(make_model(file).num_components());
}

BENCHMARK(teapot_position);
BENCHMARK(teapot_jet1);
BENCHMARK(teapot_jet2);
BENCHMARK(teapot_normal);
BENCHMARK(teapot_minimal_radius);
BENCHMARK(teapot_gluing)->Unit(benchmark::kMillisecond);

}  // namespace

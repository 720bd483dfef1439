/// Time per point of the planar generator. The metric is a closed form, so its cost hardly counts.
#include <benchmark/benchmark.h>

#include "gradus/plane/delaunay.hpp"
#include "support/planar_cases.hpp"

using namespace gradus;
using namespace gradus::planar_cases;

namespace {

void run(benchmark::State& state, const PlanarDomain& domain, const PlaneMetric& metric) {
    std::size_t points = 0;
    for (auto _ : state) {
        const PlanarMesh mesh = mesh_domain(domain, metric);
        points = mesh.points.size();
        benchmark::DoNotOptimize(mesh.triangles.data());
    }
    state.counters["points"] = static_cast<double>(points);
    state.counters["per_point"] = benchmark::Counter(
        static_cast<double>(points), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void uniform_square(benchmark::State& state) {
    const PlaneMetric metric = uniform_metric(1.0 / static_cast<double>(state.range(0)));
    PlanarDomain domain;
    add_rectangle(domain, metric, 1, 1);
    run(state, domain, metric);
}

/// Sizes from 1 in the middle to 50 on the boundary.
void radial_square(benchmark::State& state) {
    const double coarse = 1.0 / static_cast<double>(state.range(0));
    const PlaneMetric metric = radial_metric({0.5, 0.5}, coarse / 50, coarse / 0.6);
    PlanarDomain domain;
    add_rectangle(domain, metric, 1, 1);
    run(state, domain, metric);
}

void polar_cone(benchmark::State& state) {
    const PlaneMetric metric = polar_metric(1.0 / static_cast<double>(state.range(0)));
    PlanarDomain domain;
    add_rectangle(domain, metric, 1.5707963267948966, 1);
    run(state, domain, metric);
}

}  // namespace

BENCHMARK(uniform_square)->Arg(140)->Arg(1320)->Unit(benchmark::kMillisecond);
BENCHMARK(radial_square)->Arg(55)->Unit(benchmark::kMillisecond);
BENCHMARK(polar_cone)->Arg(155)->Unit(benchmark::kMillisecond);

#include "gradus/gradation/isotropic.hpp"
#include "gradus/gradation/measures.hpp"

#include <benchmark/benchmark.h>

#include <cmath>
#include <random>

using namespace gradus;

namespace {

constexpr int kSide = 1000;

const TriMesh& grid() {
    static const TriMesh mesh = [] {
        std::vector<Eigen::Vector3d> points;
        std::vector<Triangle> triangles;
        for (int j = 0; j < kSide; ++j)
            for (int i = 0; i < kSide; ++i) points.emplace_back(i / (kSide - 1.), j / (kSide - 1.), 0);
        for (int j = 0; j + 1 < kSide; ++j)
            for (int i = 0; i + 1 < kSide; ++i) {
                const int a = j * kSide + i, b = a + 1, c = b + kSide, d = a + kSide;
                triangles.push_back({a, b, c});
                triangles.push_back({a, c, d});
            }
        return make_mesh(points, triangles);
    }();
    return mesh;
}

/// Log-uniform over three decades from the edge length up, each vertex for itself.
std::vector<double> rough_map() {
    std::mt19937 random(1);
    std::vector<double> size(grid().n_vertices());
    for (double& h : size) h = std::pow(10., -3 + 3 * (random() / 4294967296.));
    return size;
}

/// Small around a circle, growing faster than the bound.
std::vector<double> smooth_map() {
    std::vector<double> size;
    for (const Eigen::Vector3d& p : points_of(grid()))
        size.push_back(.002 + 3 * std::abs((p - Eigen::Vector3d(.5, .5, 0)).norm() - .3));
    return size;
}

std::vector<double> unset_map() {
    std::vector<double> size(grid().n_vertices(), INFINITY);
    for (std::size_t v = 0; v < size.size(); v += 100003) size[v] = 1e-3;
    return size;
}

template <class Map>
void shock(benchmark::State& state, Map map) {
    const std::vector<double> input = map();
    for (auto _ : state) {
        state.PauseTiming();
        std::vector<double> size = input;
        state.ResumeTiming();
        const EdgeReduction result = limit_h_shock(grid(), 1.5, size);
        state.counters["lowered"] = result.lowered;
        state.counters["coarse"] = result.coarse_edges;
    }
}

}  // namespace

BENCHMARK_CAPTURE(shock, rough, rough_map)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(shock, smooth, smooth_map)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(shock, unset, unset_map)->Unit(benchmark::kMillisecond);

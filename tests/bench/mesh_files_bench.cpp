// Reading, writing and diagnosing a million triangles.
#include <benchmark/benchmark.h>

#include <filesystem>

#include "gradus/io/mesh_files.hpp"
#include "gradus/mesh/diagnose.hpp"
#include "support/files.hpp"
#include "support/soups.hpp"

namespace {

const gradus::TriangleSoup& million() {
    static const gradus::TriangleSoup soup = support::grid(707);
    return soup;
}

void write(benchmark::State& state, const char* name, bool ascii) {
    const support::TemporaryFolder folder;
    for (auto _ : state) gradus::write_mesh(folder / name, million(), {.ascii = ascii});
    state.counters["MB"] = static_cast<double>(std::filesystem::file_size(folder / name)) / 1e6;
}

void read(benchmark::State& state, const char* name, bool ascii) {
    const support::TemporaryFolder folder;
    gradus::write_mesh(folder / name, million(), {.ascii = ascii});
    for (auto _ : state) benchmark::DoNotOptimize(gradus::read_mesh(folder / name));
}

void diagnose(benchmark::State& state) {
    for (auto _ : state) benchmark::DoNotOptimize(gradus::diagnose(million()));
}

}  // namespace

#define GRADUS_FORMAT_BENCH(label, name, ascii)                                  \
    BENCHMARK_CAPTURE(write, label, name, ascii)->Unit(benchmark::kMillisecond); \
    BENCHMARK_CAPTURE(read, label, name, ascii)->Unit(benchmark::kMillisecond)

GRADUS_FORMAT_BENCH(mesh, "a.mesh", false);
GRADUS_FORMAT_BENCH(meshb, "a.meshb", false);
GRADUS_FORMAT_BENCH(obj, "a.obj", false);
GRADUS_FORMAT_BENCH(off, "a.off", false);
GRADUS_FORMAT_BENCH(ply_binary, "a.ply", false);
GRADUS_FORMAT_BENCH(ply_text, "a.ply", true);
GRADUS_FORMAT_BENCH(stl_binary, "a.stl", false);
GRADUS_FORMAT_BENCH(stl_text, "a.stl", true);
BENCHMARK(diagnose)->Unit(benchmark::kMillisecond);

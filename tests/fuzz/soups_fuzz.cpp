// Target of libFuzzer: any triangles on any points, many of which coincide or lie on lines.
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "support/hostile_file.hpp"

namespace {

/// Small numbers mostly, so that there is something to repair; then what is hard to compute with.
double coordinate(std::uint8_t byte) {
    constexpr std::array<double, 16> kOdd{0.1,    0.2,       0.30000000000000004,
                                          1e-9,   1 + 1e-15, 1e-17,
                                          -0.0,   5e-324,    1e-160,
                                          1e-40,  1e20,      1e40,
                                          1e100,  1e160,     1e200,
                                          1.7e308};
    return byte < 224 ? byte % 7 - 3 : kOdd[byte % kOdd.size()];
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    constexpr std::size_t kMostPoints = 64;
    if (size < 7) return -1;
    const std::size_t n = 1 + data[0] % kMostPoints;
    gradus::TriangleSoup soup;
    std::size_t at = 1;
    const auto next = [&] { return data[at++]; };
    while (soup.points.size() < n && at + 3 <= size) {
        const double x = coordinate(next()), y = coordinate(next()), z = coordinate(next());
        soup.points.push_back({x, y, z});
    }
    const auto vertex = [&] { return static_cast<int>(next() % soup.points.size()); };
    while (at + 3 <= size) {
        const int a = vertex(), b = vertex(), c = vertex();
        soup.triangles.push_back({a, b, c});
    }
    for (std::size_t t = 0; data[0] >= 192 && t < soup.triangles.size(); ++t) {
        soup.labels.push_back(static_cast<int>(t % 3));
        if (t % 4 == 0) soup.edges.push_back({soup.triangles[t][0], soup.triangles[t][1]});
        if (t % 5 == 0) soup.corners.push_back(soup.triangles[t][2]);
        if (t % 6 == 0) soup.required.triangles.push_back(static_cast<int>(t));
        if (t % 7 == 0) soup.required.edges.push_back({soup.triangles[t][1], soup.triangles[t][2]});
    }
    if (const std::string fault = support::fault_of_use(soup); !fault.empty()) {
        std::fprintf(stderr, "%s\n", fault.c_str());
        std::abort();
    }
    return 0;
}

#include "gradus/mesh/parts.hpp"

#include <algorithm>
#include <numeric>

namespace gradus {

std::vector<int> connected_parts(std::size_t vertices, std::span<const Triangle> triangles) {
    std::vector<int> up(vertices);
    std::iota(up.begin(), up.end(), 0);
    const auto root = [&](int v) {
        while (up[v] != v) v = up[v] = up[up[v]];
        return v;
    };
    for (const Triangle& t : triangles)
        for (const int k : {1, 2}) {
            const int a = root(t[0]), b = root(t[k]);
            up[std::max(a, b)] = std::min(a, b);
        }
    // A root is the least vertex of its part, so it is met first.
    std::vector<int> part(vertices);
    int count = 0;
    for (std::size_t v = 0; v < vertices; ++v) {
        const int r = root(static_cast<int>(v));
        part[v] = r == static_cast<int>(v) ? count++ : part[r];
    }
    return part;
}

}  // namespace gradus

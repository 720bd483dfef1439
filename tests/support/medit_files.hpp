/// Binary Medit files of the versions that are only read.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "support/bytes.hpp"

namespace support {

/// A square as one quadrilateral with reference 6, and a section that no reader knows.
inline std::string binary_medit(int version, bool big) {
    std::string bytes;
    const auto integer = [&](std::int64_t i) { version == 4 ? put(bytes, i, big) : put(bytes, std::int32_t(i), big); };
    const auto real = [&](double r) { version == 1 ? put(bytes, float(r), big) : put(bytes, r, big); };
    const auto section = [&](std::int32_t keyword, std::size_t size) {
        put(bytes, keyword, big);
        const std::size_t next = bytes.size() + (version < 3 ? 4 : 8) + size;
        version < 3 ? put(bytes, std::int32_t(next), big) : put(bytes, std::int64_t(next), big);
    };
    const std::size_t i = version == 4 ? 8 : 4, r = version == 1 ? 4 : 8;
    put(bytes, std::int32_t{1}, big);
    put(bytes, std::int32_t{version}, big);
    section(3, 4);
    put(bytes, std::int32_t{3}, big);
    section(60, 3 * r);
    for (int k = 0; k < 3; ++k) real(k);
    section(4, i + 4 * (3 * r + i));
    integer(4);
    for (const auto& p : {std::array{0., 0., 0.}, {1., 0., 0.}, {1., 1., 0.}, {0., 1., .5}}) {
        for (const double x : p) real(x);
        integer(0);
    }
    section(7, i + 5 * i);
    for (const int k : {1, 1, 2, 3, 4, 6}) integer(k);
    section(54, 0);
    return bytes;
}

}  // namespace support

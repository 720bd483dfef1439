/// How the first byte of an input of the fuzzer tells the format of the rest.
#pragma once

#include <algorithm>
#include <array>
#include <string_view>

namespace support {

inline constexpr std::array<std::string_view, 12> kFuzzedFormats{".mesh", ".meshb", ".msh", ".obj", ".off", ".ply",
                                                                 ".poly", ".stl",   ".vtu", ".vtp", ".sol", ".solb"};

inline std::string_view fuzzed_format(unsigned char first_byte) {
    return kFuzzedFormats[first_byte % kFuzzedFormats.size()];
}

inline char first_byte_of(std::string_view format) {
    const auto at = std::find(kFuzzedFormats.begin(), kFuzzedFormats.end(), format);
    return static_cast<char>(8 * kFuzzedFormats.size() +
                             static_cast<std::size_t>(at - kFuzzedFormats.begin()));  // printable
}

}  // namespace support

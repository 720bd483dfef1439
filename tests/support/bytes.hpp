/// Numbers as bytes of a file.
#pragma once

#include <algorithm>
#include <cstring>
#include <string>

namespace support {

/// Appends a number to bytes.
template <class Number>
void put(std::string& bytes, Number value, bool big_endian = false) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    if (big_endian) std::reverse(raw, raw + sizeof raw);
    bytes.append(raw, sizeof raw);
}

}  // namespace support

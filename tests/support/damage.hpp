/// Files that are not as they should be.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <random>
#include <string>

#include "gradus/io/error.hpp"
#include "support/files.hpp"

namespace support {

/// Appends a number to bytes.
template <class Number>
void put(std::string& bytes, Number value, bool big_endian = false) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    if (big_endian) std::reverse(raw, raw + sizeof raw);
    bytes.append(raw, sizeof raw);
}

/// Flips bits, changes a character, cuts off the end; or leaves all as it is.
inline std::string damaged(std::string contents, std::mt19937_64& random) {
    const int flips = static_cast<int>(random() % 4);
    for (int k = 0; k < flips; ++k) contents[random() % contents.size()] ^= static_cast<char>(1 << random() % 8);
    if (random() % 3 == 0) contents[random() % contents.size()] = "0-.e \n9\xff\0"[random() % 9];
    if (random() % 3 == 0) contents.resize(random() % contents.size());
    return contents;
}

/// Checks that a file is refused with an IoError that names it and its line (0 for none) and says what is wrong.
template <class Read>
void check_refused(const std::string& path, const std::string& contents, int line, const char* says, const Read& read) {
    spill(path, contents);
    INFO(path << "\n" << contents);
    try {
        read(path);
        FAIL_CHECK("was accepted");
    } catch (const gradus::IoError& error) {
        CHECK(error.path() == path);
        CHECK(error.line() == line);
        CHECK_THAT(error.what(), Catch::StartsWith(path + ":") && Catch::Contains(says));
        CHECK(std::string(error.what()).find('\n') == std::string::npos);
    }
}

}  // namespace support

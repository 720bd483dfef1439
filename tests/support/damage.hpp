/// Files that are not as they should be.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <iterator>
#include <random>
#include <string>

#include "gradus/io/error.hpp"
#include "support/bytes.hpp"
#include "support/files.hpp"

namespace support {

namespace detail {

inline std::size_t place_in(const std::string& text, std::mt19937_64& random) {
    return text.empty() ? 0 : random() % text.size();
}

/// A number of the text, or a few bytes where there is none, is replaced by what readers may stumble over.
inline void put_odd_number(std::string& contents, std::mt19937_64& random) {
    constexpr const char* kNumbers[] = {"0",
                                        "-1",
                                        "1",
                                        "3",
                                        "1000000000",
                                        "2147483648",
                                        "-2147483649",
                                        "9223372036854775807",
                                        "18446744073709551616",
                                        "1e200",
                                        "-1e308",
                                        "1e-320",
                                        "1e999",
                                        "nan",
                                        "-inf",
                                        "0x10",
                                        "1.5",
                                        ""};
    constexpr std::uint64_t kBytes[] = {0,
                                        1,
                                        0x7f,
                                        0x80,
                                        0xff,
                                        0x7fffffff,
                                        0x80000000,
                                        0xffffffff,
                                        0x7fffffffffffffff,
                                        ~std::uint64_t{0},
                                        0x7ff0000000000000,
                                        0x7ff8000000000000,
                                        0x7fefffffffffffff};
    const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
    std::size_t first = place_in(contents, random);
    if (random() % 2 == 0) {
        std::string bytes;
        put(bytes, kBytes[random() % std::size(kBytes)], random() % 2 == 0);
        bytes.resize(std::size_t{1} << random() % 4);
        contents.replace(first, std::min(bytes.size(), contents.size() - first), bytes);
        return;
    }
    while (first < contents.size() && !is_digit(contents[first])) ++first;
    while (first > 0 && first < contents.size() && is_digit(contents[first - 1])) --first;
    std::size_t last = first;
    while (last < contents.size() && is_digit(contents[last])) ++last;
    contents.replace(first, last - first, kNumbers[random() % std::size(kNumbers)]);
}

/// A stretch is lost, comes twice, or comes elsewhere.
inline void move_stretch(std::string& contents, std::mt19937_64& random) {
    const std::size_t first = place_in(contents, random), length = 1 + random() % 60;
    const std::string stretch = contents.substr(first, length);
    if (random() % 2 == 0) contents.erase(first, length);
    if (random() % 2 == 0) contents.insert(place_in(contents, random), stretch);
}

}  // namespace detail

/// Flips bits, changes a character, replaces numbers, moves a stretch, cuts off the end; or leaves all as it is.
inline std::string damaged(std::string contents, std::mt19937_64& random) {
    const std::size_t flips = random() % 4;
    for (std::size_t k = 0; k < flips; ++k)
        contents[random() % contents.size()] ^= static_cast<char>(1 << random() % 8);
    if (random() % 3 == 0) contents[random() % contents.size()] = "0-.e \n9\xff\0"[random() % 9];
    if (random() % 3 == 0) detail::put_odd_number(contents, random);
    if (random() % 4 == 0) detail::move_stretch(contents, random);
    if (random() % 4 == 0 && !contents.empty()) contents.resize(random() % contents.size());
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

// What the code guarantees to itself, checked where GRADUS_ASSERTS is on (the presets debug, asan and fuzz) and
// compiled out elsewhere. What a caller or a file may get wrong is not asserted but thrown.
#pragma once

#ifdef GRADUS_ASSERTS
#include <cstdio>
#include <cstdlib>

namespace gradus {

[[noreturn]] inline void assertion_failed(const char* file, int line, const char* condition) {
    std::fprintf(stderr, "%s:%d: assertion failed: %s\n", file, line, condition);
    std::abort();
}

}  // namespace gradus

#define GRADUS_ASSERT(...) ((__VA_ARGS__) ? void() : ::gradus::assertion_failed(__FILE__, __LINE__, #__VA_ARGS__))
#else
// Compiled, so that it stays valid, but never evaluated.
#define GRADUS_ASSERT(...) void(sizeof(bool(__VA_ARGS__)))
#endif

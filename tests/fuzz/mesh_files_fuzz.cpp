// Target of libFuzzer: any bytes as a file of each format. The first byte chooses the format, see formats.hpp.
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "formats.hpp"
#include "support/files.hpp"
#include "support/hostile_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return -1;
    static const support::TemporaryFolder folder;
    const std::string path = folder / ("a" + std::string(support::fuzzed_format(data[0])));
    support::spill(path, {reinterpret_cast<const char*>(data) + 1, size - 1});
    const support::Attempt attempt = support::read_and_use(path);
    if (!attempt.fault.empty()) {
        std::fprintf(stderr, "%s: %s\n", path.c_str(), attempt.fault.c_str());
        std::abort();
    }
    return 0;
}

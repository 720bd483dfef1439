#include "gradus/io/input_file.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>

#include "gradus/io/error.hpp"

namespace gradus {

std::string read_file(const std::string& path) {
    std::error_code error;
    if (std::filesystem::is_directory(path, error)) throw IoError(path, 0, "is a directory, not a file");
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
    if (!file) throw IoError(path, 0, std::string("cannot be opened: ") + std::strerror(errno));

    // The size is a first guess only: pipes have none, and a file may grow. One byte more than the size sees the end at
    // once.
    const auto size = std::filesystem::is_regular_file(path, error) ? std::filesystem::file_size(path, error) : 0;
    std::string contents(error ? 1 << 16 : static_cast<std::size_t>(size) + 1, '\0');
    std::size_t used = 0;
    while (true) {
        const std::size_t got = std::fread(contents.data() + used, 1, contents.size() - used, file.get());
        used += got;
        if (got == 0) break;
        if (used == contents.size()) contents.resize(2 * contents.size() + (1 << 16));
    }
    if (std::ferror(file.get())) throw IoError(path, 0, std::string("cannot be read: ") + std::strerror(errno));
    contents.resize(used);
    return contents;
}

}  // namespace gradus

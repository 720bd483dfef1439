#include "gradus/io/output_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "gradus/io/error.hpp"

namespace gradus {
namespace {

[[noreturn]] void fail(const std::string& path, const std::string& what, int error) {
    throw IoError(path, 0, what + ": " + std::strerror(error));
}

/// Writes and closes. A full disk may show at any of the two. @returns 0 or the error number
int write_and_close(int descriptor, std::string_view contents) {
    int error = 0;
    while (!contents.empty() && error == 0) {
        const ssize_t written = ::write(descriptor, contents.data(), std::min<std::size_t>(contents.size(), 1 << 30));
        if (written >= 0)
            contents.remove_prefix(static_cast<std::size_t>(written));
        else if (errno != EINTR)
            error = errno;
    }
    if (::close(descriptor) != 0 && error == 0) error = errno;
    return error;
}

void write_directly(const std::string& path, std::string_view contents) {
    const int descriptor = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
    if (descriptor < 0) fail(path, "cannot be opened for writing", errno);
    if (const int error = write_and_close(descriptor, contents)) fail(path, "cannot be written", error);
}

/// A name beside the target that no other thread or process uses.
std::string temporary_name(const std::string& target) {
    static std::atomic<unsigned> counter{0};
    return target + ".tmp" + std::to_string(::getpid()) + "-" + std::to_string(counter++);
}

}  // namespace

void write_file(const std::string& path, std::string_view contents) {
    if (path.empty()) throw IoError(path, 0, "no file name given");
    std::error_code none;
    const bool link = std::filesystem::is_symlink(path, none);
    const std::string target = link ? std::filesystem::weakly_canonical(path, none).string() : path;
    struct stat old {};
    const bool replaces = ::stat(target.c_str(), &old) == 0;
    if (replaces && S_ISDIR(old.st_mode)) throw IoError(path, 0, "is a directory, not a file");
    if (replaces && !S_ISREG(old.st_mode)) return write_directly(path, contents);
    // The rename would replace a write-protected file without asking.
    if (replaces && ::access(target.c_str(), W_OK) != 0) fail(path, "cannot be written", errno);

    const std::string temporary = temporary_name(target);
    const int descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor < 0) fail(path, "cannot be written", errno);
    if (replaces) (void)::fchmod(descriptor, old.st_mode & 07777);
    int error = write_and_close(descriptor, contents);
    if (error == 0 && std::rename(temporary.c_str(), target.c_str()) != 0) error = errno;
    if (error != 0) {
        ::unlink(temporary.c_str());
        fail(path, "cannot be written", error);
    }
}

}  // namespace gradus

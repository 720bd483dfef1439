#include "bytes.hpp"

#include <limits>

#include "gradus/io/error.hpp"

namespace gradus::io {

void ByteReader::seek(std::size_t offset, const char* what) {
    if (offset > bytes_.size()) fail_truncated(what);
    offset_ = offset;
}

void ByteReader::check_count(std::uint64_t count, std::size_t least, const char* what) const {
    if (count > std::numeric_limits<int>::max() || count > remaining() / least)
        fail(std::string(what) + " is " + std::to_string(count) + ", more than the rest of the file can hold (" +
             std::to_string(remaining()) + " bytes)");
}

void ByteReader::fail_at(std::size_t offset, const std::string& what) const {
    throw IoError(path_, 0, "at byte " + std::to_string(offset) + ": " + what);
}

void ByteReader::fail_truncated(const char* what) const {
    fail(std::string("expected ") + what + ", found the end of the file");
}

}  // namespace gradus::io

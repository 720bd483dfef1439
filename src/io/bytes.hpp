/// Reads and builds binary data; a read beyond the end names the file and the byte.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace gradus::io {

static_assert(std::endian::native == std::endian::little, "binary files are written in the byte order of the machine");

class ByteReader {
  public:
    ByteReader(const std::string& path, std::string_view bytes) : path_(path), bytes_(bytes) {}

    /// Numbers from here on have the other byte order.
    void swap_bytes() { swap_ = true; }

    std::size_t offset() const { return offset_; }
    std::size_t remaining() const { return bytes_.size() - offset_; }

    /// @param what  what the number is, for the message when the file ends before it
    template <class Number>
    Number get(const char* what) {
        if (remaining() < sizeof(Number)) fail_truncated(what);
        char raw[sizeof(Number)];
        std::memcpy(raw, bytes_.data() + offset_, sizeof raw);
        offset_ += sizeof raw;
        if (swap_)
            for (std::size_t i = 0; i < sizeof raw / 2; ++i) std::swap(raw[i], raw[sizeof raw - 1 - i]);
        Number value;
        std::memcpy(&value, raw, sizeof raw);
        return value;
    }

    /// Goes to a byte, which must not be behind the end.
    void seek(std::size_t offset, const char* what);
    void skip(std::size_t bytes, const char* what) {
        bytes > remaining() ? fail_truncated(what) : seek(offset_ + bytes, what);
    }

    /// Fails unless `count` things of `least` bytes each can follow.
    void check_count(std::uint64_t count, std::size_t least, const char* what) const;

    [[noreturn]] void fail(const std::string& what) const { fail_at(offset_, what); }
    [[noreturn]] void fail_at(std::size_t offset, const std::string& what) const;
    [[noreturn]] void fail_truncated(const char* what) const;

  private:
    const std::string& path_;
    std::string_view bytes_;
    std::size_t offset_ = 0;
    bool swap_ = false;
};

template <class Number>
void append_bytes(std::string& bytes, Number value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    bytes.append(raw, sizeof raw);
}

}  // namespace gradus::io

/// Builds a text; numbers get the fewest digits that read back to the same bits.
#pragma once

#include <charconv>
#include <string>
#include <string_view>

namespace gradus::io {

class TextWriter {
  public:
    /// @param expected  about how many characters will be written
    explicit TextWriter(std::size_t expected) { text_.reserve(expected); }

    TextWriter& operator<<(std::string_view text) {
        text_.append(text);
        return *this;
    }
    TextWriter& operator<<(char c) {
        text_.push_back(c);
        return *this;
    }
    TextWriter& operator<<(double value) { return number(value); }
    TextWriter& operator<<(int value) { return number(value); }
    TextWriter& operator<<(std::size_t value) { return number(value); }

    std::string take() { return std::move(text_); }

  private:
    template <class Number>
    TextWriter& number(Number value) {
        char buffer[32];  // the longest double takes 24 characters
        const char* end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
        text_.append(std::string_view(buffer, static_cast<std::size_t>(end - buffer)));
        return *this;
    }

    std::string text_;
};

}  // namespace gradus::io

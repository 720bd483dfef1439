#include "scanner.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>

#include "gradus/io/error.hpp"

namespace gradus::io {

std::string quoted(std::string_view text) {
    constexpr std::size_t kLongest = 40;
    std::string result = "'";
    for (const char c : text.substr(0, kLongest)) result += c >= ' ' && c <= '~' ? c : '?';
    return result + (text.size() > kLongest ? "...'" : "'");
}

Scanner::Scanner(const std::string& path, std::string_view text, char comment, bool continues)
    : path_(path),
      begin_(text.data()),
      end_(text.data() + text.size()),
      pos_(begin_),
      comment_(comment),
      continues_(continues) {
    if (text.starts_with("\xEF\xBB\xBF")) pos_ += 3;  // byte order mark of UTF-8
    if (text.starts_with("\xFE\xFF") || text.starts_with("\xFF\xFE")) fail("is text in UTF-16; save it in UTF-8");
}

bool Scanner::at_end() {
    while (pos_ != end_) {
        if (is_space(*pos_) || (comments_are_read_ && is_comment(pos_)))
            ++pos_;
        else if (is_comment(pos_))
            next_line();
        else
            return false;
    }
    return true;
}

bool Scanner::at_line_end() {
    while (pos_ != end_ && *pos_ != '\n') {
        if (is_space(*pos_)) {
            ++pos_;
        } else if (is_comment(pos_)) {
            const void* newline = std::memchr(pos_, '\n', remaining());
            pos_ = newline ? static_cast<const char*>(newline) : end_;
        } else if (continues_ && *pos_ == '\\') {
            const char* next = pos_ + 1;
            if (next != end_ && *next == '\r') ++next;
            if (next != end_ && *next != '\n') return false;
            pos_ = next == end_ ? end_ : next + 1;
        } else {
            return false;
        }
    }
    return true;
}

void Scanner::next_line() {
    while (pos_ != end_) {
        const void* newline = std::memchr(pos_, '\n', remaining());
        const char* last = newline ? static_cast<const char*>(newline) : end_;
        const char* before = last != pos_ && last[-1] == '\r' ? last - 1 : last;
        const bool continued = continues_ && before != pos_ && before[-1] == '\\';
        pos_ = newline ? last + 1 : end_;
        if (!continued) return;
    }
}

std::string_view Scanner::line() {
    const char* first = pos_;
    next_line();
    std::string_view result(first, static_cast<std::size_t>(pos_ - first));
    while (!result.empty() && (result.back() == '\n' || result.back() == '\r')) result.remove_suffix(1);
    return result;
}

std::string_view Scanner::word_here() const {
    const char* last = pos_;
    while (!ends_word(last)) ++last;
    return {pos_, static_cast<std::size_t>(last - pos_)};
}

std::string_view Scanner::peek() { return at_end() ? std::string_view{} : word_here(); }

std::string_view Scanner::word(const char* what) {
    if (at_end()) fail_expected(what);
    const std::string_view result = word_here();
    pos_ += result.size();
    return result;
}

double Scanner::real(const char* what) {
    if (at_end()) fail_expected(what);
    return real_here(what);
}

double Scanner::real_or_inf(const char* what) {
    if (at_end()) fail_expected(what);
    return parse_real(what);
}

double Scanner::real_here(const char* what) {
    const char* first = pos_;
    const double value = parse_real(what);
    if (!std::isfinite(value)) fail_at(first, std::string("expected ") + what + ", found a number that is not finite");
    return value;
}

double Scanner::parse_real(const char* what) {
    const char* first = pos_ != end_ && *pos_ == '+' ? pos_ + 1 : pos_;
    double value = 0;
    const auto [last, error] = std::from_chars(first, end_, value);
    if (error != std::errc{} || !ends_word(last) || (first != pos_ && *first == '-')) return parse_odd_real(what);
    pos_ = last;
    return value;
}

/// Fortran's exponent letters, and numbers too small for a double; from_chars refuses both.
double Scanner::parse_odd_real(const char* what) {
    const std::string_view found = word_here();
    std::string text(found);
    std::replace_if(
        text.begin(), text.end(), [](char c) { return c == 'd' || c == 'D'; }, 'e');
    const char* first = text.data();
    const char* last = first + text.size();
    if (first != last && *first == '+' && first[1] != '-') ++first;
    double value = 0;
    auto result = std::from_chars(first, last, value);
    if (result.ec == std::errc::result_out_of_range) {
        long double wide = 0;
        result = std::from_chars(first, last, wide);
        const bool tiny = result.ec == std::errc{} && std::abs(wide) < 1;
        if (!tiny)
            fail(std::string("expected ") + what + ", found " + quoted(found) + ", which is beyond double precision");
        value = static_cast<double>(wide);
    }
    if (result.ec != std::errc{} || result.ptr != last) fail_expected(what);
    pos_ += found.size();
    return value;
}

std::int64_t Scanner::integer(const char* what) {
    if (at_end()) fail_expected(what);
    return integer_here(what);
}

std::int64_t Scanner::integer_here(const char* what) {
    const char* first = pos_ != end_ && *pos_ == '+' ? pos_ + 1 : pos_;
    std::int64_t value = 0;
    const auto [last, error] = std::from_chars(first, end_, value);
    if (error != std::errc{} || !ends_word(last) || (first != pos_ && *first == '-')) fail_expected(what);
    pos_ = last;
    return value;
}

std::size_t Scanner::count(const char* what, std::size_t least) {
    if (at_end()) fail_expected(what);
    const char* where = pos_;
    const std::int64_t value = integer_here(what);
    if (value < 0) fail_at(where, std::string(what) + " is negative: " + std::to_string(value));
    if (static_cast<std::uint64_t>(value) > std::numeric_limits<int>::max() ||
        static_cast<std::size_t>(value) > remaining() / least + 1)
        fail_at(where, std::string(what) + " is " + std::to_string(value) +
                           ", more than the rest of the file can hold (" + std::to_string(remaining()) + " bytes)");
    return static_cast<std::size_t>(value);
}

void Scanner::fail_at(const char* where, const std::string& what) const {
    // What is missing at the end is missed on the last line that holds something.
    if (where == end_)
        while (where != begin_ && is_space(where[-1])) --where;
    const auto line = 1 + std::count(begin_, where, '\n');
    throw IoError(path_, static_cast<int>(std::min<std::ptrdiff_t>(line, std::numeric_limits<int>::max())), what);
}

void Scanner::fail_expected(const char* what) {
    if (pos_ == end_) fail(std::string("expected ") + what + ", found the end of the file");
    fail(std::string("expected ") + what + ", found " + (*pos_ == '\n' ? "the end of the line" : quoted(word_here())));
}

int Scanner::int_in_line(const char* what) {
    at_line_end();
    const char* const where = pos_;
    const std::int64_t value = integer_here(what);
    if (value != static_cast<int>(value))
        fail_at(where, std::string(what) + " is out of range: " + std::to_string(value));
    return static_cast<int>(value);
}

}  // namespace gradus::io

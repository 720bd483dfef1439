/// Reads words and numbers from a text held in memory; every error names the file and the line.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>

namespace gradus::io {

inline bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

/// `text` in printable form and of readable length, between quotes.
std::string quoted(std::string_view text);

class Scanner {
  public:
    /// @param comment    character that starts a comment up to the end of the line, '\0' for none
    /// @param continues  whether a backslash at the end of a line continues it on the next
    Scanner(const std::string& path, std::string_view text, char comment, bool continues = false);

    const char* position() const { return pos_; }
    std::size_t remaining() const { return static_cast<std::size_t>(end_ - pos_); }

    // Across lines
    // -----------------------------------------------------------------------------------------------------
    /// Passes white space and comments. @returns whether the text is at its end
    bool at_end();
    /// From here on the character that starts a comment counts as a blank between words: what comments say is read.
    void read_comments() { comments_are_read_ = true; }
    /// The next word, not passed. Empty at the end.
    std::string_view peek();
    /// The next word. @throws IoError "expected `what`" at the end
    std::string_view word(const char* what);
    double real(const char* what);                                   ///< a finite number
    double real_or_inf(const char* what);                            ///< a number or `inf`
    double any_real(const char* what) { return real_or_inf(what); }  ///< a number, `inf` or `nan`
    std::int64_t integer(const char* what);
    /// A count of things that take at least `least` characters each, which the rest of the text must be able to hold.
    std::size_t count(const char* what, std::size_t least);

    // Within a line
    // ----------------------------------------------------------------------------------------------------
    /// Passes blanks and comments. @returns whether the line is at its end
    bool at_line_end();
    /// Goes behind the end of the line, whatever is left of it.
    void next_line();
    /// The line up to its end, which is passed; without the line end.
    std::string_view line();
    /// Numbers at the very position, see at_line_end.
    double real_here(const char* what);
    std::int64_t integer_here(const char* what);
    /// The next number of the line.
    double real_in_line(const char* what) { return at_line_end(), real_here(what); }
    std::int64_t integer_in_line(const char* what) { return at_line_end(), integer_here(what); }
    int int_in_line(const char* what);  ///< the same in the range of int
    void advance(std::size_t characters) { pos_ += characters; }

    [[noreturn]] void fail(const std::string& what) const { fail_at(pos_, what); }
    [[noreturn]] void fail_at(const char* where, const std::string& what) const;
    /// Fails with "expected `what`, found ..." at the next word.
    [[noreturn]] void fail_expected(const char* what);

  private:
    bool is_comment(const char* at) const { return comment_ != '\0' && *at == comment_; }
    bool ends_word(const char* at) const {
        return at == end_ || is_space(*at) || is_comment(at) || (continues_ && *at == '\\');
    }
    std::string_view word_here() const;
    double parse_real(const char* what);
    double parse_odd_real(const char* what);

    const std::string& path_;
    const char* begin_;
    const char* end_;
    const char* pos_;
    char comment_;
    bool comments_are_read_ = false;
    bool continues_;
};

}  // namespace gradus::io

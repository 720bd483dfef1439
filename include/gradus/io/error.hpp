/// What readers and writers throw when a file is at fault.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace gradus {

/// A fault of a file: what() is "path:line: what", or "path: what" if no line is to blame.
class IoError : public std::runtime_error {
  public:
    /// @param line  1-based, or 0 for none
    IoError(std::string path, int line, const std::string& what)
        : std::runtime_error(line > 0 ? path + ":" + std::to_string(line) + ": " + what : path + ": " + what),
          path_(std::move(path)),
          line_(line) {}

    const std::string& path() const { return path_; }
    int line() const { return line_; }

  private:
    std::string path_;
    int line_;
};

}  // namespace gradus

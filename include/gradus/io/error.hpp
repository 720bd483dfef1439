/// What readers and writers throw when a file is at fault.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace gradus {

/// A file that cannot be read, written or understood. what() is "path:line: what", or "path: what" where no line is
/// known.
class IoError : public std::runtime_error {
  public:
    /// @param line  1-based line of the file, 0 for none (binary files name a byte in `what`)
    IoError(std::string path, int line, const std::string& what)
        : std::runtime_error((line > 0 ? path + ":" + std::to_string(line) : path) + ": " + what),
          path_(std::move(path)),
          line_(line) {}

    const std::string& path() const { return path_; }
    int line() const { return line_; }

  private:
    std::string path_;
    int line_;
};

}  // namespace gradus

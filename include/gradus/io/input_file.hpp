/// Reading a whole file at once.
#pragma once

#include <string>

namespace gradus {

/// The bytes of a file, or of a pipe up to its end.
/// @throws IoError if the file is missing, a directory, or cannot be read
std::string read_file(const std::string& path);

}  // namespace gradus

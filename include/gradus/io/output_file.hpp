/// Writing a whole file at once, or leaving what was there.
#pragma once

#include <string>
#include <string_view>

namespace gradus {

/// Writes a temporary file beside the target and renames it onto the target once every byte is accepted, so that a
/// failure (a full disk, an interrupted program) never leaves half a file or loses the previous one. A symbolic link is
/// followed, the permissions of a replaced file are kept, and what is not a regular file (a pipe, /dev/stdout) is
/// written directly.
/// @throws IoError if the folder or the file cannot be written, or the disk is full; the temporary file is removed
void write_file(const std::string& path, std::string_view contents);

}  // namespace gradus

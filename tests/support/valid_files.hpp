/// Small valid files of every format that is read, in its variants: by the writers of the library where it has them,
/// else made here.
#pragma once

#include <string>
#include <vector>

namespace support {

struct ValidFile {
    std::string extension;  ///< with the dot
    std::string contents;
};

std::vector<ValidFile> valid_mesh_files();
/// Sizes, kSizesInFile of them.
std::vector<ValidFile> valid_size_files();
inline constexpr std::size_t kSizesInFile = 16;

}  // namespace support

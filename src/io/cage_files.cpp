#include "gradus/io/cage_files.hpp"

#include "formats.hpp"
#include "gradus/io/input_file.hpp"

namespace gradus {

Cage read_cage(const std::string& path) {
    if (io::extension_of(path) != ".obj") throw IoError(path, 0, "is no .obj, from which cages are read");
    const std::string text = read_file(path);
    if (text.empty()) throw IoError(path, 0, "is empty");
    return io::parse_cage(path, text);
}

}  // namespace gradus

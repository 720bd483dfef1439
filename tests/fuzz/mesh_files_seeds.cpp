// Writes the corpus that the fuzzer starts from: mesh_files_seeds FOLDER
#include <cstdio>
#include <filesystem>

#include "formats.hpp"
#include "support/files.hpp"
#include "support/valid_files.hpp"

int main(int argc, char** argv) {
    if (argc != 2) return std::fputs("usage: mesh_files_seeds FOLDER\n", stderr), 1;
    std::filesystem::create_directories(argv[1]);
    int number = 0;
    for (const auto& files : {support::valid_mesh_files(), support::valid_size_files()})
        for (const support::ValidFile& file : files) {
            const std::filesystem::path path = std::filesystem::path(argv[1]) / ("seed" + std::to_string(number++));
            support::spill(path.string(), support::first_byte_of(file.extension) + file.contents);
        }
}

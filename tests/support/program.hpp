/// Runs the command line.
#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <string>

#include "gradus/io/input_file.hpp"
#include "support/files.hpp"

namespace support {

struct Outcome {
    int code = -1;
    std::string out, err;
};

/// The program inside a folder, with what it printed.
inline Outcome run(const TemporaryFolder& folder, const std::string& arguments) {
    const std::string command = "cd '" + folder.path().string() + "' && '" GRADUS_PROGRAM "' " + arguments + " > '" +
                                (folder / "stdout") + "' 2> '" + (folder / "stderr") + "'";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, gradus::read_file(folder / "stdout"),
            gradus::read_file(folder / "stderr")};
}

}  // namespace support

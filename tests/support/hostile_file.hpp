/// What the library owes whoever gives it any file at all.
#pragma once

#include <string>

#include "gradus/mesh/soup.hpp"

namespace support {

struct Attempt {
    bool refused = false;  ///< by the reader
    std::string fault;     ///< what is not as it should be; empty if all is
};

/// Reads a file, measures, diagnoses and repairs what is in it, and makes a Triangulation of that if it is small.
/// Either the file is refused in one line that names it, or all indices are in range, all numbers are finite, fields
/// and labels are one per item, and repair() gives an oriented manifold that needs no further repair, which then is a
/// surface or is refused in one line.
Attempt read_and_use(const std::string& path);

/// The same from the soup on, whose indices are in range and whose coordinates are finite. @returns the fault, empty if
/// there is none
std::string fault_of_use(const gradus::TriangleSoup& soup);

}  // namespace support

/// Region labels of triangles.
#pragma once

#include <span>
#include <string>

namespace gradus {

/// Which labels there are, for messages: "its labels are 1, 2, 7", the first twenty by value; or "there are none".
std::string labels_there(std::span<const int> labels);

}  // namespace gradus

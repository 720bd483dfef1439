#include "gradus/mesh/labels.hpp"

#include <set>

namespace gradus {

std::string labels_there(std::span<const int> labels) {
    constexpr std::size_t kMost = 20;
    const std::set<int> all(labels.begin(), labels.end());
    if (all.empty()) return "there are none";
    std::string text = "its labels are";
    std::size_t count = 0;
    for (const int label : all)
        if (count++ < kMost) text += (count > 1 ? ", " : " ") + std::to_string(label);
    return all.size() > kMost ? text + " and more, up to " + std::to_string(*all.rbegin()) : text;
}

}  // namespace gradus

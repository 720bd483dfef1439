/// Private to the sources: a grid of cells that finds what is near a point.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace gradus {

/// Items at points, by cells of one width. There are at most 2^20 cells along each axis from the low corner on, which
/// no point is below.
class Cells {
  public:
    Cells(const Eigen::Vector3d& low, double width) : low_(low), width_(width) {}

    void insert(const Eigen::Vector3d& p, int item) { items_[key(cell_of(p))].push_back(item); }
    /// Calls visit(item) for those in the cell of p and the 26 around it: all within a width of p, and some more.
    template <class Visit>
    void for_each_near(const Eigen::Vector3d& p, const Visit& visit) const {
        const Eigen::Vector3i centre = cell_of(p);
        for (int k = 0; k < 27; ++k) {
            const auto found = items_.find(key(centre + Eigen::Vector3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1)));
            if (found == items_.end()) continue;
            for (const int item : found->second) visit(item);
        }
    }

  private:
    Eigen::Vector3i cell_of(const Eigen::Vector3d& p) const { return ((p - low_) / width_).cast<int>(); }
    static std::uint64_t key(const Eigen::Vector3i& c) {
        return static_cast<std::uint64_t>(c.x() + 1) << 42 | static_cast<std::uint64_t>(c.y() + 1) << 21 |
               static_cast<std::uint64_t>(c.z() + 1);
    }

    Eigen::Vector3d low_;
    double width_;
    std::unordered_map<std::uint64_t, std::vector<int>> items_;
};

}  // namespace gradus

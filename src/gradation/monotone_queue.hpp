/// A priority queue for keys that never fall below the last one taken out (label setting).
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace gradus::detail {

/// Positive finite keys, smallest first; equal keys by rising item. Keys are sorted roughly into buckets by their leading
/// bits (which grow like the logarithm), and exactly, in a heap, only once their bucket is reached.
class MonotoneQueue {
  public:
    /// Keys above `high` are allowed, but share one bucket. @pre 0 < low <= every key pushed
    MonotoneQueue(double low, double high, std::size_t expected) : base_(bits(low)) {
        const std::uint64_t span = bits(std::max(low, high)) - base_;
        const std::uint64_t wanted = std::max<std::uint64_t>(expected, 1);
        while ((span >> shift_) + 1 > wanted) ++shift_;
        buckets_.assign((span >> shift_) + 1, -1);
        entries_.reserve(expected);
    }

    void push(double key, int item) {
        const std::ptrdiff_t b = bucket(key);
        if (b <= current_) {
            front_.push_back({key, item});
            std::push_heap(front_.begin(), front_.end(), later);
        } else {
            entries_.push_back({{key, item}, buckets_[b]});
            buckets_[b] = static_cast<int>(entries_.size()) - 1;
        }
    }

    bool pop(double& key, int& item) {
        while (front_.empty()) {
            if (++current_ >= static_cast<std::ptrdiff_t>(buckets_.size())) return false;
            open_bucket();
        }
        std::pop_heap(front_.begin(), front_.end(), later);
        key = front_.back().key;
        item = front_.back().item;
        front_.pop_back();
        return true;
    }

  private:
    struct Label {
        double key;
        int item;
    };
    struct Entry {
        Label label;
        int next;  ///< in the same bucket, -1 at its end
    };

    static std::uint64_t bits(double key) { return std::bit_cast<std::uint64_t>(key); }
    static bool later(const Label& p, const Label& q) { return p.key > q.key || (p.key == q.key && p.item > q.item); }
    std::ptrdiff_t bucket(double key) const {
        return static_cast<std::ptrdiff_t>(std::min<std::uint64_t>((bits(key) - base_) >> shift_, buckets_.size() - 1));
    }

    void open_bucket() {
        for (int e = buckets_[current_]; e >= 0; e = entries_[e].next) front_.push_back(entries_[e].label);
        std::make_heap(front_.begin(), front_.end(), later);
    }

    std::uint64_t base_;
    int shift_ = 0;
    std::ptrdiff_t current_ = -1;
    std::vector<int> buckets_;  ///< first entry of each, -1 for none
    std::vector<Entry> entries_;
    std::vector<Label> front_;  ///< heap: what is left of the current bucket
};

}  // namespace gradus::detail

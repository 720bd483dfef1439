/// A priority queue for keys that never fall below the last one taken out (label setting).
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace gradus::detail {

/// Positive finite keys, smallest first; equal keys by rising item. Keys are put roughly in order into buckets by their
/// leading bits (which grow like the logarithm), and exactly only when their bucket is reached; so what comes next is
/// known a little ahead, and can be fetched from memory.
class MonotoneQueue {
  public:
    /// Keys above `high` are allowed, but share one bucket. @pre 0 < low <= every key pushed
    MonotoneQueue(double low, double high, std::size_t expected) : base_(bits(low)) {
        // Few enough buckets that their ends stay in the cache, few enough keys in each that sorting is cheap.
        const std::uint64_t wanted = std::clamp<std::uint64_t>(expected / 32, 1, 32768);
        const std::uint64_t span = bits(std::max(low, high)) - base_;
        while ((span >> shift_) + 1 > wanted) ++shift_;
        buckets_.resize((span >> shift_) + 1);
    }

    void push(double key, int item) {
        const std::ptrdiff_t b =
            static_cast<std::ptrdiff_t>(std::min<std::uint64_t>((bits(key) - base_) >> shift_, buckets_.size() - 1));
        if (b > current_) {
            buckets_[b].push_back({key, item});
        } else {
            late_.push_back({key, item});
            std::push_heap(late_.begin(), late_.end(), later);
        }
    }

    bool pop(double& key, int& item) {
        while (next_ == front_.size() && late_.empty())
            if (!open_bucket()) return false;
        if (late_.empty() || (next_ < front_.size() && earlier(front_[next_], late_.front()))) {
            key = front_[next_].key;
            item = front_[next_++].item;
        } else {
            std::pop_heap(late_.begin(), late_.end(), later);
            key = late_.back().key;
            item = late_.back().item;
            late_.pop_back();
        }
        return true;
    }

    /// An item that is likely to come soon, `steps` after the next one, or -1.
    int ahead(std::size_t steps) const { return next_ + steps < front_.size() ? front_[next_ + steps].item : -1; }

  private:
    struct Label {
        double key;
        int item;
    };

    static std::uint64_t bits(double key) { return std::bit_cast<std::uint64_t>(key); }
    static constexpr auto earlier = [](const Label& p, const Label& q) {
        return p.key < q.key || (p.key == q.key && p.item < q.item);
    };
    static constexpr auto later = [](const Label& p, const Label& q) { return earlier(q, p); };

    bool open_bucket() {
        do {
            if (++current_ == static_cast<std::ptrdiff_t>(buckets_.size())) {
                --current_;
                return false;
            }
        } while (buckets_[current_].empty());
        front_ = std::move(buckets_[current_]);
        next_ = 0;
        std::sort(front_.begin(), front_.end(), earlier);
        return true;
    }

    std::uint64_t base_;
    int shift_ = 0;
    std::ptrdiff_t current_ = -1;              ///< bucket whose keys are being taken out
    std::vector<std::vector<Label>> buckets_;  ///< keys of later buckets, unordered
    std::vector<Label> front_;                 ///< keys the current bucket had when it was opened, sorted
    std::size_t next_ = 0;                     ///< in front_
    std::vector<Label> late_;                  ///< heap of keys pushed into the current bucket since
};

}  // namespace gradus::detail

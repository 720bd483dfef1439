#include "gradus/quality/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace gradus {

namespace {

/// Order statistics of values that are partitioned a little more with every rank asked for, in growing order.
class Quantiles {
  public:
    explicit Quantiles(std::vector<double>& values) : values_(values) {}

    /// @pre q in [0, 1], not below the one asked before
    double at(double q) {
        const double rank = q * static_cast<double>(values_.size() - 1);
        const auto below = static_cast<std::size_t>(rank);
        const double fraction = rank - static_cast<double>(below);
        const double low = order(below);
        // Equal neighbours may be infinite, whose difference is not a number.
        if (fraction == 0 || below + 1 == values_.size()) return low;
        const double high = order(below + 1);
        return low == high ? low : low + fraction * (high - low);
    }

  private:
    double order(std::size_t rank) {
        if (rank >= sorted_) {
            std::nth_element(values_.begin() + sorted_, values_.begin() + rank, values_.end());
            sorted_ = rank;
        }
        return values_[rank];
    }

    std::vector<double>& values_;
    std::size_t sorted_ = 0;  // everything before is not larger than everything after
};

bool worse(const Offender& a, const Offender& b) { return a.value != b.value ? a.value > b.value : a.index < b.index; }

}  // namespace

Summary summarise(std::vector<double> values) {
    std::erase_if(values, [](double x) { return std::isnan(x); });
    Summary s;
    s.count = values.size();
    if (values.empty()) return s;
    const auto [min, max] = std::minmax_element(values.begin(), values.end());
    s.min = *min;
    s.max = *max;
    s.mean = std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
    Quantiles quantiles(values);
    s.p001 = quantiles.at(.001);
    s.p01 = quantiles.at(.01);
    s.median = quantiles.at(.5);
    s.p99 = quantiles.at(.99);
    s.p999 = quantiles.at(.999);
    return s;
}

void Histogram::add(double value) {
    if (std::isnan(value)) return;
    const double bins = static_cast<double>(counts.size());
    const double place = std::floor((value - low) / (high - low) * bins);
    ++counts[static_cast<std::size_t>(std::clamp(place, 0.0, bins - 1))];
}

std::size_t Histogram::total() const { return std::accumulate(counts.begin(), counts.end(), std::size_t{0}); }

void Worst::add(int index, double value) {
    if (keep_ == 0 || std::isnan(value)) return;
    const Offender candidate{index, value};
    if (heap_.size() == keep_) {
        if (!worse(candidate, heap_.front())) return;
        std::pop_heap(heap_.begin(), heap_.end(), worse);
        heap_.pop_back();
    }
    heap_.push_back(candidate);
    std::push_heap(heap_.begin(), heap_.end(), worse);
}

std::vector<Offender> Worst::sorted() const {
    std::vector<Offender> list = heap_;
    std::sort(list.begin(), list.end(), worse);
    return list;
}

}  // namespace gradus

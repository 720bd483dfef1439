/// Summaries of many numbers: quantiles, histograms and the worst few.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <vector>

namespace gradus {

/// Extremes, mean and quantiles (linear between order statistics); not a number throughout where count is 0.
struct Summary {
    std::size_t count = 0;
    double min = std::numeric_limits<double>::quiet_NaN();
    double p001 = min;  ///< .1 % of the values lie below
    double p01 = min;   ///< 1 %
    double median = min;
    double mean = min;
    double p99 = min;
    double p999 = min;
    double max = min;
};

/// Summary in linear time; values may be infinite, and those that are not numbers are left out. Takes the values
/// because it reorders them.
Summary summarise(std::vector<double> values);

/// Counts in bins of equal width over [low, high]; a value outside counts in the nearest bin.
struct Histogram {
    double low = 0;
    double high = 1;
    std::vector<std::size_t> counts;

    Histogram() = default;
    /// @pre bins > 0, low < high
    Histogram(double from, double to, int bins) : low(from), high(to), counts(bins, 0) {}
    /// Values that are not numbers are left out.
    void add(double value);
    std::size_t total() const;
};

/// Something bad and where it is.
struct Offender {
    int index = -1;
    double value = 0;
};

/// Keeps the few with the largest values; ties go to the smaller index.
class Worst {
  public:
    explicit Worst(std::size_t keep) : keep_(keep) {}
    void add(int index, double value);
    /// Largest value first.
    std::vector<Offender> sorted() const;

  private:
    std::size_t keep_;
    std::vector<Offender> heap_;
};

}  // namespace gradus

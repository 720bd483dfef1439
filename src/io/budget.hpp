/// Bounds the memory that a file can ask for: some formats let the same bytes count again and again.
#pragma once

#include <string>

#include "gradus/io/error.hpp"

namespace gradus::io {

class Budget {
  public:
    /// @param numbers  that may be made of the file
    Budget(const std::string& path, std::size_t numbers) : path_(path), numbers_(numbers), left_(numbers) {}

    /// To be called before so many numbers are stored. @throws IoError if that is too many
    void take(std::size_t numbers) {
        if (numbers > left_)
            throw IoError(path_, 0,
                          "asks for more than " + std::to_string(numbers_) +
                              " numbers, which is beyond what a file of its size means");
        left_ -= numbers;
    }

  private:
    const std::string& path_;
    std::size_t numbers_, left_;
};

/// A polygon of many corners gives its values to each of its triangles, and a field may have few entries.
inline constexpr std::size_t kNumbersPerByte = 64;
/// The best that zlib can do.
inline constexpr std::size_t kPackedNumbersPerByte = 1040;

}  // namespace gradus::io

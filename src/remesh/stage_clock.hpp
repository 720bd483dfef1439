// Times the stages of a job, one after the other.
#pragma once

#include <chrono>
#include <string>
#include <utility>
#include <vector>

namespace gradus {

class StageClock {
  public:
    using Stages = std::vector<std::pair<std::string, double>>;
    explicit StageClock(Stages& stages) : stages_(stages), last_(std::chrono::steady_clock::now()) {}
    // The stage that began where the last one ended ends here.
    void done(const std::string& stage) {
        const auto now = std::chrono::steady_clock::now();
        stages_.emplace_back(stage, std::chrono::duration<double>(now - last_).count());
        last_ = now;
    }

  private:
    Stages& stages_;
    std::chrono::steady_clock::time_point last_;
};

}  // namespace gradus

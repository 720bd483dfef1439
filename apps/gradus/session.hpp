/// What every command shares: how it talks, how it fails, how long its stages take.
#pragma once

#include <chrono>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "gradus/quality/report.hpp"

namespace gradus::app {

/// Exit codes.
inline constexpr int kMet = 0;     ///< what was asked was met
inline constexpr int kFailed = 1;  ///< it was not, or an error said why
inline constexpr int kUsage = 2;   ///< the command line made no sense

/// A command line that makes no sense. what() is one line: what is wrong; the cure.
class UsageError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// Anything else that cannot be done. what() is one line: what is wrong; the cure.
class Failure : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// Options that every command has.
struct Session {
    bool json = false;
    bool quiet = false;
    int threads = 0;  ///< 0: all

    /// Text for people: nothing with --json or --quiet.
    bool talks() const { return !json && !quiet; }
    /// Prints a text for people as it is.
    void say(const std::string& text) const;
    /// Prints what is to be noticed whatever is done with the output: a line on standard error.
    void warn(const std::string& line) const;
};

/// Times the stages of a command, and shows the one at work where standard error is a terminal.
class Stages {
  public:
    explicit Stages(const Session& session);
    ~Stages();
    Stages(const Stages&) = delete;
    Stages& operator=(const Stages&) = delete;

    /// Runs a stage, or goes on with one of that name. @returns what it returns
    template <class Work>
    auto run(const std::string& name, Work&& work) {
        const Running running(*this, name);
        return work();
    }
    /// Says more about the stage at work.
    void detail(const std::string& text) const;
    const std::vector<StageTime>& times() const { return times_; }
    double total() const;

  private:
    using Clock = std::chrono::steady_clock;
    struct Running {
        Stages& stages;
        Clock::time_point start = Clock::now();
        Running(Stages& owner, const std::string& name);
        ~Running();
    };

    bool shows_;
    Clock::time_point start_ = Clock::now();
    std::string name_;
    std::vector<StageTime> times_;
};

/// 12345 as "12 345".
std::string grouped(long long number);
inline std::string grouped(std::size_t number) { return grouped(static_cast<long long>(number)); }
/// The same of a number that may be too large for that: with three digits then.
std::string about(double number);
inline std::string grouped(int number) { return grouped(static_cast<long long>(number)); }

/// Rows of cells with aligned columns, the first to the left, the others to the right; two spaces between.
std::string aligned(const std::vector<std::vector<std::string>>& rows, const std::string& indent = "  ");

/// Runs work on the session's number of threads.
int with_threads(const Session& session, const std::function<int()>& work);

/// Runs a command and turns what it throws into one line on standard error. @returns the exit code
int guarded(const std::function<int()>& command);

}  // namespace gradus::app

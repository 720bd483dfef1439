#include "session.hpp"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <new>
#include <optional>

#include "gradus/io/error.hpp"

namespace gradus::app {

namespace {

int fail(int code, std::string what) {
    // One line, whatever a library wrote.
    std::replace(what.begin(), what.end(), '\n', ' ');
    std::fprintf(stderr, "gradus: error: %s\n", what.c_str());
    return code;
}

}  // namespace

void Session::warn(const std::string& line) const { std::fprintf(stderr, "gradus: note: %s\n", line.c_str()); }

void Session::say(const std::string& text) const {
    if (talks()) std::fputs(text.c_str(), stdout);
}

Stages::Stages(const Session& session) : shows_(!session.quiet && ::isatty(STDERR_FILENO) == 1) {}

Stages::~Stages() {
    if (shows_) std::fputs("\r\033[K", stderr);
}

void Stages::detail(const std::string& text) const {
    if (shows_) std::fprintf(stderr, "\r\033[K%s: %s", name_.c_str(), text.c_str());
}

double Stages::total() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

Stages::Running::Running(Stages& owner, const std::string& name) : stages(owner) {
    stages.name_ = name;
    if (stages.shows_) std::fprintf(stderr, "\r\033[K%s ...", name.c_str());
}

Stages::Running::~Running() {
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    const auto same = std::find_if(stages.times_.begin(), stages.times_.end(),
                                   [&](const StageTime& time) { return time.name == stages.name_; });
    if (same != stages.times_.end())
        same->seconds += seconds;
    else
        stages.times_.push_back({stages.name_, seconds});
    if (stages.shows_) std::fputs("\r\033[K", stderr);
}

std::string grouped(long long number) {
    std::string digits = std::to_string(number);
    const int first = number < 0 ? 1 : 0;
    for (int i = static_cast<int>(digits.size()) - 3; i > first; i -= 3)
        digits.insert(static_cast<std::size_t>(i), 1, ' ');
    return digits;
}

std::string about(double number) {
    constexpr double kMostDigits = 1e15;
    return std::abs(number) < kMostDigits ? grouped(std::llround(number)) : fmt::format("{:.3g}", number);
}

std::string aligned(const std::vector<std::vector<std::string>>& rows, const std::string& indent) {
    std::vector<std::size_t> width;
    for (const auto& row : rows) {
        width.resize(std::max(width.size(), row.size()), 0);
        for (std::size_t i = 0; i < row.size(); ++i) width[i] = std::max(width[i], row[i].size());
    }
    std::string text;
    for (const auto& row : rows) {
        std::string line = indent;
        for (std::size_t i = 0; i < row.size(); ++i)
            line += i == 0 ? fmt::format("{:<{}}", row[i], width[i]) : fmt::format("  {:>{}}", row[i], width[i]);
        line.resize(line.find_last_not_of(' ') + 1);
        text += line + '\n';
    }
    return text;
}

int with_threads(const Session& session, const std::function<int()>& work) {
    std::optional<tbb::global_control> limit;
    if (session.threads > 0) limit.emplace(tbb::global_control::max_allowed_parallelism, session.threads);
    return work();
}

int guarded(const std::function<int()>& command) {
    try {
        const int code = command();
        // A full disk or a closed pipe shows when the last text leaves.
        if (std::fflush(stdout) != 0) return fail(kFailed, "standard output cannot be written");
        return code;
    } catch (const UsageError& error) {
        return fail(kUsage, error.what());
    } catch (const IoError& error) {
        return fail(kFailed, error.what());
    } catch (const std::length_error& error) {
        return fail(kFailed, std::string(error.what()) + "; ask for larger sizes or raise --max-triangles");
    } catch (const std::bad_alloc&) {
        return fail(kFailed, "not enough memory; ask for larger sizes");
    } catch (const std::exception& error) {
        return fail(kFailed, error.what());
    }
}

}  // namespace gradus::app

/// Options that several commands share: what they mean, and what they may be.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "gradus/control/sizing.hpp"
#include "gradus/gradation/grade.hpp"
#include "session.hpp"

namespace gradus::app {

/// What a command does once its options are known. @returns the exit code
using Run = std::function<int()>;

/// --json, --quiet, --threads.
void add_session(CLI::App& app, Session& session);

/// How sizes follow from curvature, as given.
struct SizingOptions {
    std::optional<double> alpha, relative_chord_error, chord_error, normal_angle, hmin, hmax;
    std::vector<std::string> at;
    std::optional<double> feature_gap, gap;  // on triangulations only, as the next
    std::vector<std::string> regions;
};

/// Clamps where none are given; lengths in the unit of the model.
struct SizeLimits {
    double hmin, hmax;
};
/// @param limits  defaults to name in the help, where they do not depend on the model
void add_sizing(CLI::App& app, SizingOptions& options, const std::optional<SizeLimits>& limits = {});
/// What else bounds the sizes of triangulations.
void add_clearances(CLI::App& app, SizingOptions& options);
/// @throws UsageError naming an option that is for triangulations only
void check_for_patches(const SizingOptions& options);
/// 1/1000 and 1/16 of a diagonal.
SizeLimits limits_for(double diagonal);

/// @throws UsageError naming the option that makes no sense
void check(const SizingOptions& options);
SizingRule rule_of(const SizingOptions& options, const SizeLimits& defaults);
/// "h = 0.3 rho in [0.01, 0.5]"
std::string to_text(const SizingRule& rule);

/// How fast sizes may change, as given.
struct GradationChoice {
    std::optional<double> shock, growth, variation;
    std::string method = "full";
    bool none = false;
};
enum class GradationNeeded {
    Yes,          ///< a bound must be given
    WithDefault,  ///< shock 1.5 where none is
    No            ///< the same, and --no-gradation
};
void add_gradation(CLI::App& app, GradationChoice& choice, GradationNeeded needed);
/// Nothing with --no-gradation. @param default_shock  taken where no bound is given; none: one must be given
/// @throws UsageError naming the option that makes no sense
std::optional<GradationOptions> gradation_of(const GradationChoice& choice, std::optional<double> default_shock);
/// "H-shock at most 1.5, by edges and triangles"
std::string to_text(const GradationOptions& options);
std::string name_of(GradationMethod method);

}  // namespace gradus::app

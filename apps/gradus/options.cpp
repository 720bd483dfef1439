#include "options.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <numbers>

namespace gradus::app {

namespace {

void require(bool holds, const std::string& option, double value, const std::string& range) {
    if (!holds) throw UsageError(fmt::format("{} is {:g}; it must be {}", option, value, range));
}

void require_positive(const std::optional<double>& value, const std::string& option) {
    if (value) require(*value > 0 && std::isfinite(*value), option, *value, "positive and finite");
}

/// "x,y,z=h"
SizingRule::At prescribed_size(const std::string& text) {
    double number[4];
    const char* at = text.data();
    const char* const end = text.data() + text.size();
    for (int k = 0; k < 4; ++k) {
        const auto [after, error] = std::from_chars(at, end, number[k]);
        const char wanted = k < 2 ? ',' : '=';
        const bool follows = k == 3 ? after == end : after != end && *after == wanted;
        if (error != std::errc() || !std::isfinite(number[k]) || !follows)
            throw UsageError("--size-at \"" + text + "\" is not a point and a size; write x,y,z=h, as in 0,1.5,2=0.01");
        at = after + 1;
    }
    require(number[3] > 0, "--size-at \"" + text + "\": the size", number[3], "positive");
    return {{number[0], number[1], number[2]}, number[3]};
}

/// "LABEL=H"
SizingRule::Region region_size(const std::string& text) {
    SizingRule::Region region{};
    const char* const end = text.data() + text.size();
    const auto [equals, bad_label] = std::from_chars(text.data(), end, region.label);
    bool read = bad_label == std::errc() && equals != end && *equals == '=';
    if (read) {
        const auto [after, bad_size] = std::from_chars(equals + 1, end, region.size);
        read = bad_size == std::errc() && after == end && std::isfinite(region.size);
    }
    if (!read)
        throw UsageError("--size-region \"" + text + "\" is not a label and a size; write LABEL=H, as in 3=0.01");
    require(region.size > 0, "--size-region \"" + text + "\": the size", region.size, "positive");
    return region;
}

void require_fraction(const std::optional<double>& value, const std::string& option) {
    if (value) require(*value >= 0 && std::isfinite(*value), option, *value, "0 or more, and finite");
}

GradationMethod method_of(const std::string& name) {
    if (name == "full") return GradationMethod::Full;
    if (name == "exact") return GradationMethod::Exact;
    if (name == "gradient") return GradationMethod::Gradient;
    if (name == "paper") return GradationMethod::Paper;
    throw UsageError("--method \"" + name + "\" is none of full, exact, gradient, paper");
}

}  // namespace

void add_session(CLI::App& app, Session& session) {
    app.add_flag("--json", session.json, "Print one JSON object instead of text");
    app.add_flag("-q,--quiet", session.quiet, "Print nothing but errors");
    app.add_option("--threads", session.threads,
                   "Number of threads; results are the same for any number (default: all)")
        ->check(CLI::Range(1, 1024).description(""))
        ->type_name("N");
}

void add_sizing(CLI::App& app, SizingOptions& options, const std::optional<SizeLimits>& limits) {
    const std::string group = "Sizes from curvature (rho: smallest radius of curvature)";
    auto* alpha =
        app.add_option("--alpha", options.alpha, "Size h = A rho (default: 0.3)")->type_name("A")->group(group);
    auto* relative = app.add_option("--relative-chord-error", options.relative_chord_error,
                                    "Gap between chord and arc, over rho, in (0, 1]")
                         ->type_name("D")
                         ->group(group);
    auto* chord = app.add_option("--chord-error", options.chord_error, "Gap between chord and arc, a length")
                      ->type_name("E")
                      ->group(group);
    auto* angle = app.add_option("--normal-angle", options.normal_angle,
                                 "Angle between normals at the ends of an edge, in (0, 180]")
                      ->type_name("DEG")
                      ->group(group);
    const std::vector<CLI::Option*> rules{alpha, relative, chord, angle};
    for (CLI::Option* rule : rules)
        for (CLI::Option* other : rules)
            if (rule != other) rule->excludes(other);
    app.add_option("--hmin", options.hmin,
                   "Smallest size from curvature (default: " +
                       (limits ? fmt::format("{:g}", limits->hmin) : "diagonal / 1000") + ")")
        ->type_name("H")
        ->group(group);
    app.add_option("--hmax", options.hmax,
                   "Largest size (default: " + (limits ? fmt::format("{:g}", limits->hmax) : "diagonal / 16") + ")")
        ->type_name("H")
        ->group(group);
    app.add_option("--size-at", options.at, "Size at a point, \"x,y,z=h\"; may be repeated")
        ->type_name("X,Y,Z=H")
        ->type_size(1)
        ->allow_extra_args(false)
        ->take_all()
        ->group(group);
}

void add_clearances(CLI::App& app, SizingOptions& options) {
    const std::string group = "Sizes from clearances (triangulations)";
    app.add_option("--feature-gap", options.feature_gap,
                   "Sizes at most F times the distance along the surface between features that face each other; 0: any "
                   "(default: 1.5)")
        ->type_name("F")
        ->group(group);
    app.add_option("--gap", options.gap,
                   "Sizes at most F times the distance to the opposite sheet, through material or void (default: any)")
        ->type_name("F")
        ->group(group);
    app.add_option("--size-region", options.regions,
                   "Sizes at most H in the triangles of a label, \"LABEL=H\"; may be repeated")
        ->type_name("LABEL=H")
        ->type_size(1)
        ->allow_extra_args(false)
        ->take_all()
        ->group(group);
}

void check_for_patches(const SizingOptions& options) {
    const auto refuse = [](bool given, const std::string& option) {
        if (given)
            throw UsageError(
                option +
                " is for triangulations; leave it out for patches, or mesh them first and remesh that with it");
    };
    refuse(options.feature_gap.has_value(), "--feature-gap");
    refuse(options.gap.has_value(), "--gap");
    refuse(!options.regions.empty(), "--size-region");
}

SizeLimits limits_for(double diagonal) { return {diagonal / 1000, diagonal / 16}; }

void check(const SizingOptions& options) {
    require_positive(options.alpha, "--alpha");
    require_positive(options.chord_error, "--chord-error");
    if (options.relative_chord_error)
        require(*options.relative_chord_error > 0 && *options.relative_chord_error <= 1, "--relative-chord-error",
                *options.relative_chord_error, "in (0, 1]");
    if (options.normal_angle)
        require(*options.normal_angle > 0 && *options.normal_angle <= 180, "--normal-angle", *options.normal_angle,
                "in (0, 180] degrees");
    require_positive(options.hmin, "--hmin");
    require_positive(options.hmax, "--hmax");
    if (options.hmin && options.hmax)
        require(*options.hmin <= *options.hmax, "--hmin", *options.hmin,
                fmt::format("at most --hmax {:g}", *options.hmax));
    for (const std::string& text : options.at) prescribed_size(text);
    require_fraction(options.feature_gap, "--feature-gap");
    require_fraction(options.gap, "--gap");
    for (const std::string& text : options.regions) region_size(text);
}

SizingRule rule_of(const SizingOptions& options, const SizeLimits& defaults) {
    check(options);
    SizingRule rule;
    using Kind = SizingRule::Kind;
    if (options.alpha) rule.kind = Kind::Proportional, rule.value = *options.alpha;
    if (options.relative_chord_error) rule.kind = Kind::RelativeChordError, rule.value = *options.relative_chord_error;
    if (options.chord_error) rule.kind = Kind::ChordError, rule.value = *options.chord_error;
    if (options.normal_angle)
        rule.kind = Kind::NormalAngle, rule.value = *options.normal_angle * std::numbers::pi / 180;
    // A limit that is given moves the default of the other out of its way.
    rule.hmin = options.hmin.value_or(std::min(defaults.hmin, options.hmax.value_or(defaults.hmin)));
    rule.hmax = options.hmax.value_or(std::max(defaults.hmax, rule.hmin));
    rule.hmin_by_part = !options.hmin;
    rule.hmax_by_part = !options.hmax;
    for (const std::string& text : options.at) rule.at.push_back(prescribed_size(text));
    rule.feature_clearance = options.feature_gap.value_or(rule.feature_clearance);
    rule.sheet_clearance = options.gap.value_or(rule.sheet_clearance);
    for (const std::string& text : options.regions) rule.regions.push_back(region_size(text));
    return rule;
}

std::string to_text(const SizingRule& rule) {
    std::string text;
    switch (rule.kind) {
        case SizingRule::Kind::Proportional:
            text = fmt::format("h = {:g} rho", rule.value);
            break;
        case SizingRule::Kind::RelativeChordError:
            text = fmt::format("chord error {:g} rho", rule.value);
            break;
        case SizingRule::Kind::ChordError:
            text = fmt::format("chord error {:g}", rule.value);
            break;
        case SizingRule::Kind::NormalAngle:
            text = fmt::format("normal angle {:g} degrees", rule.value * 180 / std::numbers::pi);
            break;
    }
    text += fmt::format(" in [{:.4g}, {:.4g}]", rule.hmin, rule.hmax);
    if (rule.sheet_clearance > 0) text += fmt::format(", at most {:g} of the gap", rule.sheet_clearance);
    for (const SizingRule::Region& region : rule.regions)
        text += fmt::format(", at most {:g} in label {}", region.size, region.label);
    if (!rule.at.empty()) text += fmt::format(", {} prescribed at points", rule.at.size());
    return text;
}

void add_gradation(CLI::App& app, GradationChoice& choice, GradationNeeded needed) {
    const std::string group = "Gradation";
    auto* shock =
        app.add_option("--shock", choice.shock,
                       needed != GradationNeeded::Yes ? "Largest H-shock, > 1 (default: 1.5)" : "Largest H-shock, > 1")
            ->type_name("B")
            ->group(group);
    auto* growth = app.add_option("--growth", choice.growth,
                                  "Largest growth rate between successive elements, > 1: the same as a shock")
                       ->type_name("G")
                       ->group(group);
    auto* variation = app.add_option("--variation", choice.variation, "Largest H-variation |h(P) - h(Q)| / |PQ|, > 0")
                          ->type_name("A")
                          ->group(group);
    auto* method = app.add_option("--method", choice.method,
                                  "full: edges and triangles (default); exact: edges; gradient: distance on triangles; "
                                  "paper: its iteration")
                       ->type_name("M")
                       ->group(group);
    shock->excludes(growth);
    if (needed != GradationNeeded::No) return;
    auto* none = app.add_flag("--no-gradation", choice.none, "Take the sizes as they are")->group(group);
    for (CLI::Option* option : {shock, growth, variation, method}) none->excludes(option);
}

std::optional<GradationOptions> gradation_of(const GradationChoice& choice, std::optional<double> default_shock) {
    if (choice.none) return std::nullopt;
    if (choice.shock)
        require(*choice.shock > 1 && std::isfinite(*choice.shock), "--shock", *choice.shock, "more than 1, as 1.5");
    if (choice.growth)
        require(*choice.growth > 1 && std::isfinite(*choice.growth), "--growth", *choice.growth, "more than 1, as 1.2");
    require_positive(choice.variation, "--variation");
    GradationOptions options;
    options.method = method_of(choice.method);
    options.shock = choice.growth ? choice.growth : choice.shock;
    options.variation = choice.variation;
    if (!options.shock && !options.variation) options.shock = default_shock;
    if (!options.shock && !options.variation)
        throw UsageError("no bound is given; add --shock 1.5, --growth 1.2 or --variation 0.3");
    return options;
}

std::string name_of(GradationMethod method) {
    switch (method) {
        case GradationMethod::Full:
            return "full";
        case GradationMethod::Exact:
            return "exact";
        case GradationMethod::Gradient:
            return "gradient";
        case GradationMethod::Paper:
            return "paper";
    }
    return "";
}

std::string to_text(const GradationOptions& options) {
    std::string text;
    if (options.shock) text = fmt::format("H-shock at most {:g}", *options.shock);
    if (options.variation)
        text += fmt::format("{}H-variation at most {:g}", text.empty() ? "" : ", ", *options.variation);
    switch (options.method) {
        case GradationMethod::Full:
            return text + ", by edges and triangles";
        case GradationMethod::Exact:
            return text + ", by edges";
        case GradationMethod::Gradient:
            return text + ", by distance on the surface";
        case GradationMethod::Paper:
            return text + ", by the paper's iteration";
    }
    return text;
}

}  // namespace gradus::app

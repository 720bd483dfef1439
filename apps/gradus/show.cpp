#include "show.hpp"

#include <fmt/format.h>

#include <cmath>

#include "options.hpp"

namespace gradus::app {

namespace {

std::string number(double value) { return fmt::format("{:.4g}", value); }
std::string bound(const std::optional<double>& value) { return value ? fmt::format("{:g}", *value) : ""; }

}  // namespace

std::string shock_text(double shock) {
    constexpr double kBeyondTelling = 1000;
    return shock < kBeyondTelling ? number(shock) : fmt::format("> {:g}", kBeyondTelling);
}

std::string text_of(const std::string& path, const SurfaceModel& model) {
    if (model.num_patches() == 1) return fmt::format("{}: one patch, diagonal {:.4g}\n", path, model.diagonal());
    return fmt::format("{}: {} patches in {} component{}, diagonal {:.4g}\n", path, model.num_patches(),
                       model.num_components(), model.num_components() == 1 ? "" : "s", model.diagonal());
}

std::string text_of(const GradationOptions& options, const GradationResult& result, std::size_t vertices) {
    const GradationReport &before = result.before, &after = result.after;
    const auto gradient = options.method == GradationMethod::Full ? std::optional(result.gradient_bound) : std::nullopt;
    std::string text = fmt::format("gradation: {}\n", to_text(options));
    text += aligned(
        {{"", "before", "after", "bound"},
         {"H-shock, largest", shock_text(before.shock_max), shock_text(after.shock_max), bound(options.shock)},
         {"         99.9 %", shock_text(before.shock_p999), shock_text(after.shock_p999), ""},
         {"H-variation, largest", number(before.variation_max), number(after.variation_max), bound(options.variation)},
         {"gradient, largest", number(before.gradient_max), number(after.gradient_max),
          gradient ? number(*gradient) : ""},
         {"          99.9 %", number(before.gradient_p999), number(after.gradient_p999), ""}});
    text += fmt::format("  {} of {} vertices lowered ({:.1f} %)", grouped(result.lowered), grouped(vertices),
                        100.0 * result.lowered / static_cast<double>(std::max<std::size_t>(vertices, 1)));
    if (result.lowered > 0)
        text += std::isfinite(result.largest_factor)
                    ? fmt::format(", by a factor of {:.3g} at most", result.largest_factor)
                    : ", some of them unset before";
    text += "\n";
    if (!result.conflicts.empty())
        text += fmt::format("  {} required sizes stand against the bound\n", result.conflicts.size());
    if (result.coarse_edges > 0)
        text += fmt::format(
            "  {} edges of the background are too coarse for their sizes: a finer one would allow larger sizes\n",
            grouped(result.coarse_edges));
    if (!result.converged) text += "  NOT converged\n";
    text += result.met ? "  the bound is met\n" : "  the bound is NOT met\n";
    return text;
}

std::string text_of(const std::vector<StageTime>& stages) {
    constexpr double kWorthSaying = 0.02;  // seconds
    std::string text;
    double total = 0;
    for (const StageTime& stage : stages) {
        if (stage.seconds >= kWorthSaying)
            text += fmt::format("{} {} {:.2f}", text.empty() ? ":" : ";", stage.name, stage.seconds);
        total += stage.seconds;
    }
    return fmt::format("{:.2f} s{}\n", total, text);
}

}  // namespace gradus::app

#include "source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "files.hpp"

namespace gradus::app {

void add_source(CLI::App& app, SourceChoice& choice) {
    add_sizing(app, choice.sizing);
    add_clearances(app, choice.sizing);
    add_triangulation(app, choice.surface);
    add_cages(app, choice.cage);
}

std::unique_ptr<Source> source_of(const SourceChoice& choice, const Session& session) {
    check(choice.sizing);
    check(choice.cage);
    if (is_triangulation(choice.in, choice.cage)) return triangle_source(choice, session);
    check_for_patches(choice.sizing);
    check_for_patches(choice.surface);
    return model_source(choice);
}

void require_finite(const std::string& path, std::span<const double> sizes) {
    const auto unset = std::find_if(sizes.begin(), sizes.end(), [](double h) { return !std::isfinite(h); });
    if (unset != sizes.end())
        throw Failure(fmt::format("{}: vertex {} has no size; leave out --no-gradation, or grade the map first", path,
                                  unset - sizes.begin() + 1));
}

}  // namespace gradus::app

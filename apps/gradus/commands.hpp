/// The commands. Each declares its options and, when the command line names it, sets what is to be run.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

#include "options.hpp"

namespace gradus::app {

void add_teapot(CLI::App& app, Run& run);
void add_sizemap(CLI::App& app, Run& run);
void add_grade(CLI::App& app, Run& run);
void add_remesh(CLI::App& app, Run& run);
void add_report(CLI::App& app, Run& run);
void add_adapt(CLI::App& app, Run& run);
void add_example(CLI::App& app, Run& run);
void add_quad(CLI::App& app, Run& run);
void add_metric(CLI::App& app, Run& run);
void add_info(CLI::App& app, Run& run);

/// A command whose options live in `options` from now on, and which runs `work` on them. Its session sets the number of
/// threads.
template <class Options>
void run_with(CLI::App& command, Run& run, const std::shared_ptr<Options>& options, int (*work)(const Options&)) {
    command.callback([&run, options, work] {
        run = [options, work] { return with_threads(options->session, [&] { return work(*options); }); };
    });
}

}  // namespace gradus::app

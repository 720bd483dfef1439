#include <clocale>
#include <csignal>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "commands.hpp"
#include "version.hpp"

namespace {

/// Help without the parser's own remarks: what excludes what is in the descriptions.
class Formatter : public CLI::Formatter {
  public:
    std::string make_option_opts(const CLI::Option* option) const override {
        const std::string type = option->get_positional() ? "" : option->get_type_name();
        return (type.empty() ? "" : " " + type) +
               (option->get_required() && !option->get_positional() ? " (required)" : "");
    }
};

/// Errors of the command line in one line, in the words of the parser.
[[noreturn]] void fail_usage(const CLI::App& app, const CLI::ParseError& error) {
    const auto named = app.get_subcommands();
    throw gradus::app::UsageError(std::string(error.what()) + "; see gradus " +
                                  (named.empty() ? "" : named.front()->get_name() + " ") + "--help");
}

}  // namespace

int main(int argc, char** argv) {
    using namespace gradus::app;
    std::signal(SIGPIPE, SIG_DFL);
#ifdef __GLIBC__
    // Memory that a stage gives back serves the next one, instead of going to the system and coming back zeroed; but
    // not the large arrays of models with millions of triangles, between which others would leave gaps that none fits
    // into.
    mallopt(M_MMAP_THRESHOLD, 1 << 25);
    mallopt(M_TRIM_THRESHOLD, 1 << 27);
#endif
    return guarded([&] {
        CLI::App app{
            "Surface mesh gradation: sizes from curvature, how fast they may change, and the mesh that follows",
            "gradus"};
        app.require_subcommand(1);
        // So that a script's options can be replaced by those that follow.
        app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
        app.set_version_flag("--version", kVersion);
        app.formatter(std::make_shared<Formatter>());
        app.get_formatter()->column_width(30);
        Run run;
        add_teapot(app, run);
        add_sizemap(app, run);
        add_grade(app, run);
        add_remesh(app, run);
        add_metric(app, run);
        add_adapt(app, run);
        add_quad(app, run);
        add_example(app, run);
        add_report(app, run);
        add_info(app, run);
        // An unset variable of a script.
        for (int i = 1; i < argc; ++i)
            if (argv[i][0] == '\0')
                throw UsageError(std::string("an argument is empty") +
                                 (i > 1 ? std::string(", after ") + argv[i - 1] : ""));
        try {
            app.parse(argc, argv);
        } catch (const CLI::Success& help) {
            return app.exit(help);
        } catch (const CLI::ParseError& error) {
            if (app.get_subcommands().empty() && argc > 1 && argv[1][0] != '-')
                throw UsageError(std::string("there is no command \"") + argv[1] + "\"; see gradus --help");
            fail_usage(app, error);
        }
        return run();
    });
}

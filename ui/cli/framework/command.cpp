#include "ui/cli/framework/command.h"

#include "fem/linear_algebra/parallel.h"
#include "mesh/base/error.h"
#include "ui/cli/framework/field_options.h"
#include "ui/cli/framework/misspelling.h"
#include "ui/cli/framework/number_range.h"
#include "ui/cli/framework/progress_line.h"

#include <CLI/CLI.hpp>

#include <tbb/global_control.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <exception>
#include <iostream>
#include <new>
#include <string_view>
#include <thread>

namespace retractor::ui::cli {

namespace {

    std::atomic<bool> interrupted { false };

    void interrupt(int) { interrupted.store(true); }

    Json profile_document(const Ledger& ledger)
    {
        Json parts = Json::array();
        for (const BuiltPart& part : ledger.parts())
            parts.push_back({ { "part", part.name }, { "seconds", part.seconds }, { "bytes", part.bytes } });
        return parts;
    }

    void print_profile(const Ledger& ledger)
    {
        std::fprintf(stderr, "%-36s %9s %9s\n", "part built", "seconds", "MB");
        for (const BuiltPart& part : ledger.parts())
            std::fprintf(
                stderr, "%-36s %9.3f %9.1f\n", part.name.c_str(), part.seconds, static_cast<double>(part.bytes) / 1e6);
    }

    /// The text of a document. File names and damaged files may contain bytes that are not UTF-8; such bytes become
    /// U+FFFD.
    std::string document_text(const Json& document)
    {
        return document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
    }

    int print_failure(const Program& program, const GlobalOptions& options, const std::string& what,
        const std::string& where, int exit_code)
    {
        if (options.json)
            std::cout << document_text({ { "error", what }, { "where", where } });
        std::cerr << program.name << ": " << (where.empty() ? "" : where + ": ") << what << '\n';
        return exit_code;
    }

    void print_outcome(const GlobalOptions& options, Outcome& outcome, const Ledger& ledger)
    {
        if (options.profile && options.json)
            outcome.document["profile"] = profile_document(ledger);
        if (options.json)
            std::cout << document_text(outcome.document);
        else
            std::cout << outcome.text;
        std::cout.flush();
        if (options.profile && !options.json)
            print_profile(ledger);
    }

    int run_chosen(const Program& program, const Commands& commands, const GlobalOptions& options)
    {
        Ledger ledger;
        ProgressLine progress;
        Job job;
        job.ledger = &ledger;
        job.cancel = &interrupted;
        job.on_progress = [&](std::string_view stage, double fraction) { progress.update(stage, fraction); };
        const auto threads = options.threads > 0 ? static_cast<std::size_t>(options.threads)
                                                 : std::max<std::size_t>(1, std::thread::hardware_concurrency());
        job.threads = static_cast<int>(threads);
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        fem::set_solver_threads(job.threads);
        try {
            Outcome outcome = commands.run(job);
            progress.clear();
            print_outcome(options, outcome, ledger);
            return outcome.exit_code;
        } catch (const InputError& error) {
            progress.clear();
            return print_failure(
                program, options, error.what() + option_hint(commands.app, error.fields()), error.where(), 2);
        } catch (const Error& error) {
            progress.clear();
            return print_failure(
                program, options, error.what() + option_hint(commands.app, error.fields()), error.where(), 1);
        } catch (const std::bad_alloc&) {
            progress.clear();
            return print_failure(program, options, "out of memory", "", 1);
        } catch (const std::exception& error) {
            progress.clear();
            return print_failure(program, options, error.what(), "", 1);
        }
    }

} // namespace

void Commands::on(CLI::App* command, const std::function<Outcome(const Job&)>& action)
{
    command->callback([this, action] { run = action; });
}

void Commands::require_one() { app.require_subcommand(1); }

int run_command_line(const Program& program, int argc, char** argv)
{
    CLI::App app { program.about, program.name };
    app.set_version_flag("--version", program.name + " " RETRACTOR_VERSION);
    app.fallthrough();
    GlobalOptions options;
    app.add_flag("--json", options.json, "Print one JSON document to standard output and nothing else there");
    app.add_flag("--profile", options.profile, "List the parts built, with time and memory");
    app.add_option("--threads", options.threads, "Number of threads (default: all cores)")
        ->check(in_range(1.0, 1024.0));

    Commands commands { app, options, argv, {} };
    program.add_commands(commands);

    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        const bool asked_for_help = error.get_exit_code() == 0;
        // Parsing stopped before the flag was stored, so the flag is searched for in the arguments.
        const bool json
            = std::any_of(argv, argv + argc, [](const char* text) { return std::string_view(text) == "--json"; });
        if (asked_for_help)
            return app.exit(error);
        // The parser reports missing options first, but the usual reason is a misspelt word.
        const std::string misspelt = misspelling(app, { argv + 1, argv + argc });
        if (json)
            std::cout << document_text(
                { { "error", misspelt.empty() ? error.what() : misspelt }, { "where", "command line" } });
        if (misspelt.empty())
            app.exit(error);
        else
            std::cerr << "retractor: " << misspelt << "\nRun with --help for more information.\n";
        return 2;
    }
    std::signal(SIGINT, interrupt);
    std::signal(SIGTERM, interrupt);
    return run_chosen(program, commands, options);
}

} // namespace retractor::ui::cli

// retractor-verify: errors of known problems with run times, outcomes of extreme cases, and comparisons of solvers,
// as tables, JSON, CSV and a chart.

#include "tests/verification/cli/verify_command.h"

#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "tests/verification/cli/retraction_problem.h"
#include "tests/verification/cli/touch_cases.h"
#include "tests/verification/cli/verify_tables.h"
#include "tests/verification/cli/viscous_problem.h"
#include "tests/verification/problem_list.h"
#include "ui/cli/framework/command.h"
#include "ui/cli/framework/out_folder.h"
#include "ui/results/field_files.h"
#include "ui/scene/vtk/render.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <set>
#include <string_view>

namespace retractor::verification {

namespace {

    struct VerifyOptions {
        std::string suite = "analytic";
        std::vector<std::string> problems;
        std::filesystem::path out;
        std::filesystem::path shared_data;
        bool fine = false;
    };

    std::filesystem::path shared_data(const VerifyOptions& options)
    {
        if (!options.shared_data.empty())
            return options.shared_data;
        const char* set = std::getenv("RETRACTOR_SHARED_DATA");
        return set != nullptr ? std::filesystem::path(set) : std::filesystem::path();
    }

    struct Chosen {
        std::vector<VerificationProblem> problems;
        std::vector<StabilityCase> cases;
    };

    Chosen suite(const std::string& name)
    {
        Chosen chosen;
        const auto add = [&](const std::vector<VerificationProblem>& more) {
            chosen.problems.insert(chosen.problems.end(), more.begin(), more.end());
        };
        if (name == "analytic" || name == "all") {
            add(verification_problems());
            add({ viscous_problem(), retraction_problem() }); // problems of modules that use the finite elements
        }
        if (name == "ladder" || name == "all")
            add(ladder_problems());
        if (name == "stability" || name == "all") {
            chosen.cases = stability_cases();
            const std::vector<StabilityCase> touch = touch_cases(); // cases of modules that use the finite elements
            chosen.cases.insert(chosen.cases.end(), touch.begin(), touch.end());
        }
        return chosen;
    }

    /// The items whose names are in `names`. These names are removed from `names`.
    template <class Item> std::vector<Item> named(const std::vector<Item>& all, std::set<std::string>& names)
    {
        std::vector<Item> some;
        for (const Item& item : all)
            if (names.erase(item.name) > 0)
                some.push_back(item);
        return some;
    }

    Chosen chosen(const VerifyOptions& options)
    {
        if (options.problems.empty())
            return suite(options.suite);
        const Chosen all = suite("all");
        std::set<std::string> names(options.problems.begin(), options.problems.end());
        Chosen some { named(all.problems, names), named(all.cases, names) };
        if (names.empty())
            return some;
        std::string known;
        for (const VerificationProblem& problem : all.problems)
            known += (known.empty() ? "" : ", ") + problem.name;
        for (const StabilityCase& c : all.cases)
            known += ", " + c.name;
        throw InputError("there is no problem '" + *names.begin() + "'; there are: " + known, "--problem");
    }

    struct Found {
        std::vector<VerificationRow> rows;
        std::vector<StabilityRow> cases;
    };

    template <class Row> int count(const std::vector<Row>& rows, const std::string& which)
    {
        return static_cast<int>(
            std::count_if(rows.begin(), rows.end(), [&](const Row& row) { return verdict(row) == which; }));
    }

    /// Comparisons with measurements, which neither pass nor fail; empty without any.
    std::string measured_line(const std::vector<VerificationRow>& rows)
    {
        const int inside = count(rows, "inside"), outside = count(rows, "outside"),
                  undecided = count(rows, "undecided");
        if (inside + outside + undecided == 0)
            return {};
        return "compared with measurements on bodies: " + std::to_string(inside) + " inside the measured range, "
            + std::to_string(outside) + " outside, " + std::to_string(undecided)
            + " undecided (the bar reaches across an end of the range)\n";
    }

    std::string summary(const Found& found)
    {
        std::string text;
        if (!found.rows.empty())
            text += "\n" + std::to_string(count(found.rows, "ok")) + " within their bounds, "
                + std::to_string(count(found.rows, "series")) + " on coarser meshes of series that these judge, "
                + std::to_string(count(found.rows, "shown")) + " only shown, each with the reason, "
                + std::to_string(count(found.rows, "FAILED")) + " failed, "
                + std::to_string(count(found.rows, "skipped")) + " skipped\n" + measured_line(found.rows);
        if (!found.cases.empty())
            text += "\n" + std::to_string(count(found.cases, "ok")) + " extreme cases ended as they must, "
                + std::to_string(count(found.cases, "FAILED")) + " did not\n";
        return text;
    }

    /// What was not checked, with the number of rows and the reason, each reason once; empty when everything was
    /// checked. This text is printed last, so that an incomplete run is not taken for a pass.
    std::string skip_line(const std::vector<VerificationRow>& rows)
    {
        const int number = count(rows, "skipped");
        if (number == 0)
            return {};
        constexpr std::string_view kPrefix = "skipped: ";
        std::set<std::string> said;
        std::string reasons;
        for (const VerificationRow& row : rows)
            if (verdict(row) == "skipped" && said.insert(row.note).second)
                reasons += (reasons.empty() ? "" : "; ")
                    + (row.note.starts_with(kPrefix) ? row.note.substr(kPrefix.size()) : row.note);
        return "NOT CHECKED: " + std::to_string(number) + " of " + std::to_string(rows.size()) + " rows: " + reasons
            + ". --data or RETRACTOR_SHARED_DATA names the folder with the published model files\n";
    }

    /// @return the names of the files.
    std::string write_files(
        const std::filesystem::path& folder, const Found& found, const ui::cli::Json& document, const Job& job)
    {
        write_file_atomically(folder / "verify.json", document.dump(2) + "\n");
        std::string names = (folder / "verify.json").string();
        if (!found.rows.empty()) {
            write_file_atomically(folder / "verify.csv", csv(found.rows));
            names += ", verify.csv";
        }
        if (!found.cases.empty()) {
            write_file_atomically(folder / "stability.csv", csv(found.cases));
            names += ", stability.csv";
        }
        const ui::ChartPicture picture = charts(found.rows);
        if (picture.panels.empty())
            return names;
        ui::OffscreenRenderer renderer(ui::make_offscreen_context(), job);
        ui::write_png(folder / "error_against_time.png", renderer.render(picture));
        return names + ", error_against_time.png";
    }

    /// For each problem, the elements and laws that do not apply.
    std::string reduction_error_text(const std::vector<VerificationProblem>& problems)
    {
        std::string text;
        for (const VerificationProblem& problem : problems)
            if (!problem.omitted.empty())
                text += "  " + problem.name + ": " + problem.omitted + "\n";
        return text.empty() ? text : "\nNot solved, and why:\n" + text;
    }

    ui::cli::Json omitted_document(const std::vector<VerificationProblem>& problems)
    {
        ui::cli::Json all = ui::cli::Json::object();
        for (const VerificationProblem& problem : problems)
            if (!problem.omitted.empty())
                all[problem.name] = problem.omitted;
        return all;
    }

    template <class Row> ui::cli::Json documents(const std::vector<Row>& rows)
    {
        ui::cli::Json all = ui::cli::Json::array();
        for (const Row& row : rows)
            all.push_back(row_document(row));
        return all;
    }

    ui::cli::Outcome verify(const VerifyOptions& options, const Job& job)
    {
        const Chosen asked = chosen(options);
        // report a folder that cannot be written before the long work
        if (!options.out.empty())
            ui::cli::make_folder(options.out);
        const Found found { run_verification(asked.problems, { shared_data(options), options.fine }, job),
            run_stability(asked.cases, job) };
        const int failed = count(found.rows, "FAILED") + count(found.cases, "FAILED");
        ui::cli::Outcome outcome;
        outcome.document
            = { { "suite", options.suite }, { "units", "mm, N, MPa, s" }, { "results", documents(found.rows) },
                  { "not_solved", omitted_document(asked.problems) }, { "stability", documents(found.cases) },
                  { "failed", failed }, { "skipped", count(found.rows, "skipped") }, { "cancelled", job.cancelled() } };
        if (!found.rows.empty())
            outcome.text += table(found.rows);
        if (!found.cases.empty())
            outcome.text += table(found.cases);
        outcome.text += reduction_error_text(asked.problems);
        outcome.text += summary(found) + (job.cancelled() ? "cancelled\n" : "");
        if (!options.out.empty())
            outcome.text += "Written: " + write_files(options.out, found, outcome.document, job) + "\n";
        outcome.text += skip_line(found.rows);
        outcome.exit_code = failed > 0 || job.cancelled() ? 1 : 0;
        return outcome;
    }

} // namespace

void add_verification(ui::cli::Commands& commands)
{
    auto options = std::make_shared<VerifyOptions>();
    commands.app.footer(
        "Example: retractor-verify --out verification\n"
        "'series': a coarser mesh; the finest one of its series is judged, by its error and by the order. "
        "'shown': nothing judges the row, and it says why.\n"
        "An extreme case ends in a right answer or in a refusal that says why.");
    commands.app
        .add_option("--suite", options->suite,
            "analytic: problems with known answers; stability: stiff and extreme cases; ladder: solvers against the "
            "finest answer")
        ->check(CLI::IsMember({ "analytic", "stability", "ladder", "all" }))
        ->capture_default_str();
    commands.app.add_option("--problem", options->problems, "Only these, by name, of all suites");
    commands.app.add_option(
        "--out", options->out, "Folder for verify.json, verify.csv, stability.csv and error_against_time.png");
    commands.app.add_option("--data", options->shared_data,
        "Folder with the published model files (default: $RETRACTOR_SHARED_DATA; without it their problems are "
        "skipped)");
    commands.app.add_flag("--fine", options->fine, "One more refinement of each series");
    commands.app.callback(
        [&commands, options] { commands.run = [options](const Job& job) { return verify(*options, job); }; });
}

} // namespace retractor::verification

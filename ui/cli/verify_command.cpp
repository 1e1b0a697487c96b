// retractor verify: errors of known problems beside run times, as a table, JSON, CSV and a chart.

#include "fem/verification/problem.h"
#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "ui/cli/command.h"
#include "ui/scene/render.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>
#include <sstream>

namespace retractor::cli {

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
        return set != nullptr ? std::filesystem::path(set) : std::filesystem::path("../shared/data");
    }

    std::vector<VerificationProblem> chosen(const VerifyOptions& options)
    {
        std::vector<VerificationProblem> all = verification_problems();
        if (options.problems.empty())
            return all;
        std::vector<VerificationProblem> some;
        for (const std::string& name : options.problems) {
            const auto at = std::find_if(all.begin(), all.end(), [&](const auto& p) { return p.name == name; });
            if (at == all.end()) {
                std::string known;
                for (const VerificationProblem& problem : all)
                    known += (known.empty() ? "" : ", ") + problem.name;
                throw InputError("there is no problem '" + name + "'; there are: " + known, "--problem");
            }
            some.push_back(*at);
        }
        return some;
    }

    bool skipped(const VerificationRow& row) { return row.note.starts_with("skipped"); }

    /// JSON has no NaN and no infinity.
    Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

    std::string verdict(const VerificationRow& row)
    {
        if (skipped(row))
            return "skipped";
        if (!row.passed())
            return "FAILED";
        return std::isfinite(row.bound) ? "ok" : "shown";
    }

    Json row_document(const VerificationRow& row)
    {
        return { { "problem", row.problem }, { "element", row.element }, { "law", row.law },
            { "quantity", row.quantity }, { "nodes", row.nodes }, { "tets", row.tets }, { "size", row.size },
            { "value", number(row.value) }, { "expected", number(row.expected) }, { "error", number(row.error) },
            { "bound", number(row.bound) }, { "order", number(row.order) },
            { "expected_order", number(row.expected_order) }, { "residual", number(row.residual) },
            { "seconds", row.seconds }, { "outcome", verdict(row) }, { "note", row.note } };
    }

    std::string quoted(const std::string& text)
    {
        std::string result = "\"";
        for (const char c : text)
            result += c == '"' ? std::string("\"\"") : std::string(1, c);
        return result + "\"";
    }

    std::string csv(const std::vector<VerificationRow>& rows)
    {
        std::ostringstream text;
        text.precision(10);
        text << "problem,element,law,quantity,nodes,tets,size,value,expected,error,bound,order,expected_order,residual,"
                "seconds,outcome,note\n";
        for (const VerificationRow& row : rows)
            text << quoted(row.problem) << ',' << quoted(row.element) << ',' << quoted(row.law) << ','
                 << quoted(row.quantity) << ',' << row.nodes << ',' << row.tets << ',' << row.size << ',' << row.value
                 << ',' << row.expected << ',' << row.error << ',' << row.bound << ',' << row.order << ','
                 << row.expected_order << ',' << row.residual << ',' << row.seconds << ',' << verdict(row) << ','
                 << quoted(row.note) << '\n';
        return text.str();
    }

    template <class... Values> std::string format(const char* pattern, Values... values)
    {
        const int size = std::snprintf(nullptr, 0, pattern, values...);
        std::string text(static_cast<std::size_t>(size), '\0');
        (void)std::snprintf(text.data(), text.size() + 1, pattern, values...);
        return text;
    }

    std::string order_text(const VerificationRow& row)
    {
        return std::isfinite(row.order) ? format("%.1f (%.1f)", row.order, row.expected_order) : std::string();
    }

    std::string table(const std::vector<VerificationRow>& rows)
    {
        std::string text;
        std::string heading;
        for (const VerificationRow& row : rows) {
            const std::string this_heading = row.problem + ": " + row.quantity;
            if (this_heading != heading) {
                heading = this_heading;
                text += "\n" + heading + "\n";
                text += format("  %-16s %-22s %8s %12s %12s %9s %10s %8s  %s\n", "element", "law", "tets", "value",
                    "expected", "error", "order", "seconds", "");
            }
            if (skipped(row)) {
                text += "  " + row.note + "\n";
                continue;
            }
            text += format("  %-16s %-22s %8zu %12.6g %12.6g %9.2e %10s %8.3f  %s%s%s\n", row.element.c_str(),
                row.law.c_str(), row.tets, row.value, row.expected, row.error, order_text(row).c_str(), row.seconds,
                verdict(row).c_str(), row.note.empty() ? "" : ": ", row.note.c_str());
        }
        return text;
    }

    /// Problems with a series of meshes, one panel each.
    ChartPicture charts(const std::vector<VerificationRow>& rows)
    {
        ChartPicture picture { .x_title = "run time, s", .y_title = "relative error", .panels = {}, .columns = 4 };
        std::map<std::string, std::size_t> panel_of;
        for (const VerificationRow& row : rows) {
            if (row.size == 0.0 || skipped(row))
                continue;
            const std::string title = row.problem + (row.quantity.starts_with("error") ? ", " + row.quantity : "");
            const auto [at, added] = panel_of.try_emplace(title, picture.panels.size());
            if (added)
                picture.panels.push_back({ title, {} });
            auto& series = picture.panels[at->second].series;
            if (series.empty() || series.back().name != row.element)
                series.push_back({ row.element, {}, {} });
            series.back().x.push_back(row.seconds);
            series.back().y.push_back(row.error);
        }
        return picture;
    }

    void write_files(const std::filesystem::path& folder, const std::vector<VerificationRow>& rows,
        const Json& document, const Job& job)
    {
        std::filesystem::create_directories(folder);
        write_file_atomically(folder / "verify.json", document.dump(2) + "\n");
        write_file_atomically(folder / "verify.csv", csv(rows));
        const ChartPicture picture = charts(rows);
        if (picture.panels.empty())
            return;
        OffscreenRenderer renderer(make_offscreen_context(), job);
        write_png(folder / "error_against_time.png", renderer.render(picture));
    }

    Outcome verify(const VerifyOptions& options, const Job& job)
    {
        const std::vector<VerificationProblem> problems = chosen(options);
        const std::vector<VerificationRow> rows
            = run_verification(problems, { shared_data(options), options.fine }, job);
        Outcome outcome;
        Json results = Json::array();
        std::map<std::string, int> count;
        for (const VerificationRow& row : rows) {
            results.push_back(row_document(row));
            ++count[verdict(row)];
        }
        outcome.document = { { "suite", options.suite }, { "units", "mm, N, MPa, s" }, { "results", results },
            { "failed", count["FAILED"] }, { "skipped", count["skipped"] }, { "cancelled", job.cancelled() } };
        outcome.text = table(rows)
            + format("\n%d within their bounds, %d shown without one, %d failed, %d skipped%s\n", count["ok"],
                count["shown"], count["FAILED"], count["skipped"], job.cancelled() ? "; cancelled" : "");
        if (!options.out.empty()) {
            write_files(options.out, rows, outcome.document, job);
            outcome.text
                += "Written: " + (options.out / "verify.json").string() + ", verify.csv, error_against_time.png\n";
        }
        outcome.exit_code = count["FAILED"] > 0 || job.cancelled() ? 1 : 0;
        return outcome;
    }

} // namespace

void add_verify_command(Commands& commands)
{
    CLI::App* command = commands.app.add_subcommand(
        "verify", "Solve problems with known answers: error against run time, for each element and law");
    auto options = std::make_shared<VerifyOptions>();
    command->footer("Example: retractor verify --out verification\n"
                    "Values without a bound are shown for comparison: plain P1 locks, and is meant to be seen to.");
    command->add_option("--suite", options->suite, "Which problems")
        ->check(CLI::IsMember({ "analytic", "all" }))
        ->capture_default_str();
    command->add_option("--problem", options->problems, "Only these, by name");
    command->add_option("--out", options->out, "Folder for verify.json, verify.csv and error_against_time.png");
    command->add_option("--data", options->shared_data,
        "Folder with the published model files (default: $RETRACTOR_SHARED_DATA, else ../shared/data)");
    command->add_flag("--fine", options->fine, "One more refinement of each series");
    command->callback(
        [&commands, options] { commands.run = [options](const Job& job) { return verify(*options, job); }; });
}

} // namespace retractor::cli

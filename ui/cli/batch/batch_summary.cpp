#include "ui/cli/batch/batch_summary.h"

#include "datasets/tables/csv_reader.h"
#include "mesh/base/atomic_file.h"
#include "mesh/base/text_format.h"
#include "planner/measures/metric_table.h"
#include "planner/measures/report/html_text.h"
#include "ui/results/metrics_csv.h"

#include <array>
#include <cctype>
#include <fstream>
#include <sstream>
#include <string_view>

namespace retractor::ui::cli {

namespace {

    namespace fs = std::filesystem;

    constexpr double kMegabyte = 1e6;
    /// The numbers of the page's table.
    constexpr std::array<std::string_view, 5> kShown { "seen_best_eye", "reached_by_two_instruments",
        "opening_width_mm", "incision_length_mm", "hook_force_N" };

    constexpr std::string_view kStyle = R"css(
body { font: 15px/1.4 system-ui, "DejaVu Sans", sans-serif; margin: 20px; color: #1c2733; background: #f4f6f8; }
table { border-collapse: collapse; background: #fff; } th, td { border: 1px solid #d3dce4; padding: 4px 8px; text-align: right; }
th:first-child, td:first-child, td.words { text-align: left; } .failed td { color: #a61b1b; }
.sheet { display: grid; grid-template-columns: repeat(auto-fill, minmax(300px, 1fr)); gap: 12px; margin-top: 20px; }
figure { margin: 0; background: #fff; border: 1px solid #d3dce4; } img { width: 100%; display: block; } figcaption { padding: 4px 8px; }
)css";

    std::string state_of(const BatchRow& row)
    {
        return row.status ? to_string(row.status->state) : std::string("not begun");
    }

    bool is_done(const BatchRow& row) { return row.status && row.status->state == JobStatus::State::done; }

    std::string csv_of(const BatchRow& row)
    {
        const Json& numbers = row.numbers;
        const JobStatus status = row.status.value_or(JobStatus {});
        return datasets::csv_quoted(row.job.name) + "," + datasets::csv_quoted(row.job.case_file.string()) + ","
            + datasets::csv_quoted(row.job.variant) + "," + state_of(row) + "," + datasets::csv_quoted(status.reason)
            + formatted(
                ",%.1f,%.0f,%.1f,", status.seconds, status.peak_bytes / kMegabyte, status.disk_bytes / kMegabyte)
            + (numbers.is_object() ? metrics_csv_row(numbers) : metrics_csv_empty_row(row.job.approach)) + "\n";
    }

    std::string table_row(const BatchRow& row)
    {
        const Json& numbers = row.numbers;
        const JobStatus status = row.status.value_or(JobStatus {});
        std::string text = std::string(status.state == JobStatus::State::failed ? "<tr class=\"failed\">" : "<tr>")
            + "<td>" + planner::escaped(row.job.name) + "</td><td>" + state_of(row) + "</td>";
        for (const std::string_view key : kShown) {
            const planner::MetricField& metric = planner::metric_field(key);
            text += "<td>";
            if (numbers.is_object() && numbers.contains(metric.key))
                text += planner::escaped(planner::metric_text(metric, numbers[metric.key].get<double>()));
            text += "</td>";
        }
        return text + formatted("<td>%.0f s</td><td>%.0f MB</td>", status.seconds, status.peak_bytes / kMegabyte)
            + "<td class=\"words\">" + planner::escaped(status.reason) + "</td></tr>\n";
    }

    /// A relative path as a part of an address (RFC 3986).
    std::string in_address(const std::string& path)
    {
        std::string address;
        for (const char c : path)
            if (std::isalnum(static_cast<unsigned char>(c)) != 0
                || std::string_view("-._~/").find(c) != std::string::npos)
                address += c;
            else
                address += formatted("%%%02X", static_cast<unsigned>(static_cast<unsigned char>(c)));
        return address;
    }

    /// The picture of a job that is done, which leads to its report.
    std::string figure_of(const fs::path& inside, const fs::path& folder, const BatchRow& row)
    {
        const std::string picture = row.job.approach + "-surgeon.png";
        if (!is_done(row) || !fs::exists(folder / picture))
            return {};
        const auto link = [&](const std::string& file) { return in_address((inside / file).generic_string()); };
        return "<figure><a href=\"" + link("report.html") + "\"><img loading=\"lazy\" alt=\""
            + planner::escaped(row.job.name) + "\" src=\"" + link(picture) + "\"/></a><figcaption>"
            + planner::escaped(row.job.name) + "</figcaption></figure>\n";
    }

} // namespace

Json numbers_in(const fs::path& job_folder)
{
    std::ifstream in(job_folder / "metrics.json");
    const Json json = Json::parse(in, nullptr, false);
    const bool has_numbers = json.is_object() && json.contains("approaches") && !json["approaches"].empty();
    return has_numbers ? json["approaches"][0] : Json();
}

void read_numbers(BatchRow& row, const fs::path& jobs_folder)
{
    row.numbers = is_done(row) ? numbers_in(jobs_folder / row.job.name) : Json();
}

void write_batch_summary(const fs::path& folder, const fs::path& jobs_folder, const std::vector<BatchRow>& rows)
{
    std::string csv = "job,case,variant,state,reason,seconds,peak_MB,disk_MB," + metrics_csv_header() + "\n";
    std::ostringstream page;
    page << "<!DOCTYPE html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>Batch</title><style>" << kStyle
         << "</style></head><body><h1>Batch</h1><table><thead><tr><th>Job</th><th>State</th>";
    for (const std::string_view key : kShown)
        page << "<th>" << planner::escaped(planner::metric_field(key).caption) << "</th>";
    page << "<th>Time</th><th>Memory</th><th>Reason</th></tr></thead><tbody>\n";
    std::string sheet;
    for (const BatchRow& row : rows) {
        const fs::path job_folder = jobs_folder / row.job.name;
        csv += csv_of(row);
        page << table_row(row);
        sheet += figure_of(fs::relative(job_folder, folder), job_folder, row);
    }
    page << "</tbody></table><div class=\"sheet\">" << sheet << "</div></body></html>\n";
    write_file_atomically(folder / "summary.csv", csv);
    write_file_atomically(folder / "summary.html", page.str());
}

} // namespace retractor::ui::cli

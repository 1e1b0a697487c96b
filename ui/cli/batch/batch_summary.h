#pragma once
// The summary of a batch: a table for other programs, and a page with a picture of every job.

#include "ui/cli/batch/job_status.h"
#include "ui/cli/batch/sweep.h"
#include "ui/cli/framework/command.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace retractor::ui::cli {

/// A job with what became of it; no status: it has not begun.
struct BatchRow {
    BatchJob job;
    std::optional<JobStatus> status;
    Json numbers {}; ///< the approach's entry of the job's metrics.json; null: the job has none
};

/// The approach's entry of metrics.json in a job's folder; null where there is none.
Json numbers_in(const std::filesystem::path& job_folder);

/// Reads the numbers of a job that is done.
void read_numbers(BatchRow& row, const std::filesystem::path& jobs_folder);

/// Writes summary.csv and summary.html, each in one step. Numbers are those of the jobs that are done.
/// @param jobs_folder with one folder per job, inside `folder`
/// @throws IoError
void write_batch_summary(
    const std::filesystem::path& folder, const std::filesystem::path& jobs_folder, const std::vector<BatchRow>& rows);

} // namespace retractor::ui::cli

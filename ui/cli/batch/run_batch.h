#pragma once
// Runs many plans, several at a time, each as a process of its own, and goes on where an earlier run ended.

#include "mesh/base/job.h"
#include "ui/cli/batch/batch_summary.h"
#include "ui/cli/batch/sweep.h"

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace retractor::ui::cli {

struct BatchSettings {
    int processes = 0; ///< 0: one per core
    double limit_s = 6.0 * 3600.0; ///< of one job
    bool retry = false; ///< also do failed jobs again
};

struct BatchRun {
    std::vector<BatchRow> rows; ///< one per job
    std::size_t skipped = 0; ///< jobs whose status is of an earlier run
    double seconds = 0.0;
};

/// Runs the jobs that have no status yet, in `folder`/jobs, and writes the summaries after every job. A cancelled run
/// leaves jobs without a status.
/// @throws InputError when another batch is at work in this folder; IoError
BatchRun run_batch(const std::vector<BatchJob>& jobs, const std::filesystem::path& folder,
    const BatchSettings& settings, const Job& job);

/// Runs one job of a sweep, unless it has ended already, and writes its status. The summaries stay as they are. This is
/// what a task of a cluster does for the batch that submitted it, which holds the folder.
/// @throws InputError when the sweep has no such job; IoError
BatchRow run_batch_job(const std::vector<BatchJob>& jobs, const std::string& name, const std::filesystem::path& folder,
    const BatchSettings& settings, const Job& job);

} // namespace retractor::ui::cli

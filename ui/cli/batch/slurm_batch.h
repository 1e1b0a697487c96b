#pragma once
// A batch on a Slurm cluster: the jobs go into its queue as an array, and this process follows them. The cluster's
// machines read and write the batch's folder and run this same program, both under the paths that they have here.
//
// What the batch knows lies in the folder and in the queue, so that it goes on after this process, a task or the
// cluster's controller was killed:
//
//   slurm/NAME.txt     the jobs of the array NAME, one a line
//   slurm/NAME.sh      the script that each of its tasks runs
//   slurm/NAME-I.txt   what task I printed

#include "ui/cli/batch/run_batch.h"

#include <filesystem>
#include <string>
#include <vector>

namespace retractor::ui::cli {

/// Does what run_batch() does, by the cluster. Jobs that an earlier call put into the queue are followed, not submitted
/// again. A task that vanishes (killed, its machine lost) is submitted again, at most twice; one that was cancelled, or
/// went over a limit of the cluster, has failed. A cancelled call leaves the jobs in the queue.
/// @param sweep file of the sweep, which the tasks read
/// @param settings processes: tasks at a time, 0: as many as the cluster gives
/// @param sbatch further options of sbatch
/// @throws as run_batch(); InputError where there is no Slurm, or it refuses the jobs
BatchRun run_slurm_batch(const std::vector<BatchJob>& jobs, const std::filesystem::path& sweep,
    const std::filesystem::path& folder, const BatchSettings& settings, const std::vector<std::string>& sbatch,
    const Job& job);

} // namespace retractor::ui::cli

#pragma once
// The queue of a Slurm cluster, through the programs sbatch and squeue.

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace retractor::ui::cli {

struct SlurmArray {
    std::string name; ///< by which the array is found again
    std::filesystem::path script; ///< run by every task, with its number as SLURM_ARRAY_TASK_ID
    std::filesystem::path logs; ///< folder for what the tasks print
    std::size_t tasks = 0; ///< numbered from 0
    int at_a_time = 0; ///< 0: as many as the cluster gives
    std::vector<std::string> options; ///< further options of sbatch; those above count where both are given
};

/// @param stop ends the program of Slurm when it returns true
/// @returns false when the cluster's controller did not answer: it may have taken the array
/// @throws InputError where this machine has no sbatch, on options that a batch cannot have, and where sbatch refuses
/// the array: the message is its own
bool submit(const SlurmArray& array, const std::function<bool()>& stop);

struct SlurmTask {
    std::string array; ///< SlurmArray::name
    std::optional<std::size_t> number; ///< not set: the tasks of an array that ended before they began
    std::string state; ///< Slurm's word, such as PENDING
};

struct SlurmQueue {
    bool answered = false;
    std::string said; ///< why there is no answer
    std::vector<SlurmTask> tasks; ///< this user's: those that wait, run, or ended minutes ago
};

/// @param stop as of submit()
SlurmQueue ask_queue(const std::function<bool()>& stop);

/// Whether a task in this state has not ended.
bool is_active(const std::string& state);

} // namespace retractor::ui::cli

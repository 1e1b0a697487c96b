#pragma once
// What became of a job of a batch, as status.json in the job's folder has it.

#include <filesystem>
#include <optional>
#include <string>

namespace retractor::ui::cli {

struct JobStatus {
    enum class State { running, done, failed };
    State state = State::running;
    std::string inputs; ///< what the job was made from; other inputs make another job
    std::string reason {}; ///< of a failed job
    /// Of a failed job: the same again would fail in the same way. A full disk, a lack of memory or a signal passes.
    bool lasting = true;
    double seconds = 0.0;
    double peak_bytes = 0.0; ///< largest memory of the process
    double disk_bytes = 0.0; ///< of the job's files
};

/// "running", "done", "failed".
std::string to_string(JobStatus::State state);

/// The status of a job; nothing where there is none that can be read.
std::optional<JobStatus> read_job_status(const std::filesystem::path& folder);

/// Writes status.json in one step. @throws IoError
void write_job_status(const std::filesystem::path& folder, const JobStatus& status);

} // namespace retractor::ui::cli

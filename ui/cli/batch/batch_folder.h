#pragma once
// The folder of a batch: its lock, and what an earlier run left in it.

#include "ui/cli/batch/batch_summary.h"
#include "ui/cli/batch/sweep.h"

#include <filesystem>
#include <string>
#include <vector>

namespace retractor::ui::cli {

/// Holds a folder for one batch at a time, until this object or its process ends.
class FolderLock {
public:
    /// @throws InputError when another batch holds the folder; IoError where it cannot be written
    explicit FolderLock(const std::filesystem::path& folder);
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;
    ~FolderLock();

private:
    int file_;
};

/// What the result of each job depends on. @throws IoError when a case cannot be read
std::vector<std::string> inputs_of(const std::vector<BatchJob>& jobs);

/// Size of the files in a folder, bytes.
double size_of(const std::filesystem::path& folder);

/// Whether a status is the end of a job with these inputs: done, or failed in a way that would come again.
bool is_end(const JobStatus& status, const std::string& inputs);

/// The rows of a sweep, with the statuses of an earlier run that still hold.
/// @param inputs as inputs_of()
/// @param retry failed jobs hold no status
std::vector<BatchRow> rows_of(const std::vector<BatchJob>& jobs, const std::vector<std::string>& inputs,
    const std::filesystem::path& jobs_folder, bool retry);

} // namespace retractor::ui::cli

#pragma once
// The output folder of a command.

#include "mesh/base/job.h"

#include <filesystem>
#include <vector>

namespace retractor::ui::cli {

/// Creates the folder. @throws IoError naming the folder
void make_folder(const std::filesystem::path& folder);

/// Makes a folder as make_folder() does. The destructor removes folders that were made and stayed empty, so a refused
/// command leaves nothing on disk.
class OutFolder {
public:
    explicit OutFolder(const std::filesystem::path& folder);
    OutFolder(const OutFolder&) = delete;
    OutFolder& operator=(const OutFolder&) = delete;
    ~OutFolder();

private:
    std::vector<std::filesystem::path> made_; ///< folders that were made, innermost first
};

/// @throws SolverError "cancelled" when the job was cancelled, so that an unfinished run replaces no earlier results
void refuse_if_cancelled(const Job& job);

} // namespace retractor::ui::cli

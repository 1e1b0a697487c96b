#pragma once
// The folder that a command writes its results to.

#include "mesh/base/job.h"

#include <filesystem>
#include <vector>

namespace retractor::ui::cli {

/// Creates the folder. @throws IoError naming it.
void make_folder(const std::filesystem::path& folder);

/// Makes a folder as make_folder() does, and at its end takes away again what was made and stayed empty: a command that
/// is refused leaves nothing behind.
class OutFolder {
public:
    explicit OutFolder(const std::filesystem::path& folder);
    OutFolder(const OutFolder&) = delete;
    OutFolder& operator=(const OutFolder&) = delete;
    ~OutFolder();

private:
    std::vector<std::filesystem::path> made_; ///< the innermost first
};

/// @throws SolverError "cancelled" when it was: nothing of an unfinished run replaces earlier results.
void refuse_if_cancelled(const Job& job);

} // namespace retractor::ui::cli

#include "ui/cli/framework/out_folder.h"

#include "mesh/base/error.h"

#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

#include <unistd.h>

namespace retractor::ui::cli {

void make_folder(const std::filesystem::path& folder)
{
    std::error_code code;
    std::filesystem::create_directories(folder, code);
    if (code)
        throw IoError("cannot make the folder: " + code.message(), folder.string());
}

OutFolder::OutFolder(const std::filesystem::path& folder)
{
    std::error_code none;
    std::filesystem::path at = std::filesystem::absolute(folder).lexically_normal();
    if (!at.has_filename()) // "out/"
        at = at.parent_path();
    for (; at.has_relative_path() && !std::filesystem::exists(at, none); at = at.parent_path())
        made_.push_back(at);
    make_folder(folder);
    if (::access(folder.c_str(), W_OK | X_OK) != 0) // reported before the long work
        throw IoError(std::string("cannot write into the folder: ") + std::strerror(errno), folder.string());
}

OutFolder::~OutFolder()
{
    std::error_code kept; // a folder with content stays
    for (const std::filesystem::path& folder : made_)
        std::filesystem::remove(folder, kept);
}

void refuse_if_cancelled(const Job& job)
{
    if (job.cancelled())
        throw SolverError("cancelled; the earlier results are unchanged");
}

} // namespace retractor::ui::cli

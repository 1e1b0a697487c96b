#include "ui/cli/framework/open_case.h"

#include "mesh/base/error.h"
#include "planner/case/case_io.h"

namespace retractor::ui::cli {

planner::Case open_case(const std::string& path)
{
    try {
        return planner::read_case(path);
    } catch (const InputError& error) {
        if (error.where().rfind('/', 0) != 0) // not a JSON pointer
            throw;
        throw InputError(error.what(), path + "#" + error.where());
    }
}

} // namespace retractor::ui::cli

#include "ui/cli/framework/staged_results.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <cerrno>
#include <charconv>
#include <csignal>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <unistd.h>

namespace retractor::ui::cli {

namespace {

    namespace fs = std::filesystem;

    constexpr std::string_view kPrefix = ".retractor-results-"; // the number of the process follows

    bool is_running(std::string_view number)
    {
        pid_t process = 0;
        const auto [end, code] = std::from_chars(number.data(), number.data() + number.size(), process);
        if (code != std::errc() || end != number.data() + number.size() || process <= 0)
            return true; // not a folder of ours
        return ::kill(process, 0) == 0 || errno != ESRCH;
    }

    void remove_abandoned(const fs::path& out)
    {
        std::error_code none;
        std::vector<fs::path> abandoned;
        for (const fs::directory_entry& entry : fs::directory_iterator(out, none)) {
            const std::string name = entry.path().filename().string();
            if (name.starts_with(kPrefix) && !is_running(std::string_view(name).substr(kPrefix.size())))
                abandoned.push_back(entry.path());
        }
        for (const fs::path& folder : abandoned)
            fs::remove_all(folder, none);
    }

    void move_file(const fs::path& from, const fs::path& to)
    {
        std::error_code code;
        fs::rename(from, to, code);
        if (code)
            throw IoError("cannot put the new file in place: " + code.message(), to.string());
    }

} // namespace

StagedResults::StagedResults(fs::path out)
    : out_(std::move(out))
    , staged_(out_ / (std::string(kPrefix) + std::to_string(::getpid())))
{
    remove_abandoned(out_);
    std::error_code code;
    fs::remove_all(staged_, code); // of an earlier process with this number
    fs::create_directory(staged_, code);
    if (code)
        throw IoError("cannot make a folder for new files: " + code.message(), staged_.string());
}

StagedResults::~StagedResults()
{
    std::error_code kept;
    fs::remove_all(staged_, kept);
}

fs::path StagedResults::published(const fs::path& staged_file) const
{
    RETRACTOR_ASSERT(staged_file.parent_path() == staged_);
    return out_ / staged_file.filename();
}

void StagedResults::publish(const fs::path& summary)
{
    std::vector<fs::path> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(staged_))
        if (entry.path().filename() != summary)
            files.push_back(entry.path());
    std::error_code none;
    const bool has_earlier = fs::exists(out_ / summary, none);
    const fs::path earlier = staged_ / ("earlier-" + summary.string());
    if (has_earlier)
        move_file(out_ / summary, earlier);
    try {
        for (const fs::path& file : files)
            move_file(file, published(file));
    } catch (const IoError&) {
        if (has_earlier)
            fs::rename(earlier, out_ / summary, none); // as much as possible stays as it was
        throw;
    }
    move_file(staged_ / summary, out_ / summary);
}

} // namespace retractor::ui::cli

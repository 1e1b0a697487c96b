#include "ui/cli/batch/batch_folder.h"

#include "mesh/base/error.h"
#include "planner/case/case_io.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <map>
#include <utility>

namespace retractor::ui::cli {

namespace {

    namespace fs = std::filesystem;

    std::string inputs_of(const BatchJob& job, const std::string& case_sum)
    {
        std::string text = "retractor " RETRACTOR_VERSION " " + case_sum + " " + job.approach;
        for (const std::string& option : job.options)
            text += " " + option;
        return text;
    }

} // namespace

FolderLock::FolderLock(const fs::path& folder)
    : file_(::open((folder / ".batch.lock").c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0644))
{
    if (file_ < 0)
        throw IoError("cannot write into the folder", folder.string());
    if (::flock(file_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
        ::close(file_);
        throw InputError("another batch is at work in this folder", folder.string());
    } // a file system without locks cannot tell
}

FolderLock::~FolderLock() { ::close(file_); }

std::vector<std::string> inputs_of(const std::vector<BatchJob>& jobs)
{
    std::map<fs::path, std::string> sums;
    std::vector<std::string> inputs;
    for (const BatchJob& one : jobs) {
        std::string& sum = sums[one.case_file];
        if (sum.empty())
            sum = planner::checksum(one.case_file);
        inputs.push_back(inputs_of(one, sum));
    }
    return inputs;
}

double size_of(const fs::path& folder)
{
    double bytes = 0.0;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
        if (entry.is_regular_file())
            bytes += static_cast<double>(entry.file_size());
    return bytes;
}

bool is_end(const JobStatus& status, const std::string& inputs)
{
    return status.inputs == inputs && status.state != JobStatus::State::running
        && (status.state == JobStatus::State::done || status.lasting);
}

std::vector<BatchRow> rows_of(
    const std::vector<BatchJob>& jobs, const std::vector<std::string>& inputs, const fs::path& jobs_folder, bool retry)
{
    std::vector<BatchRow> rows;
    for (std::size_t n = 0; n < jobs.size(); ++n) {
        BatchRow row { .job = jobs[n], .status = read_job_status(jobs_folder / jobs[n].name) };
        const bool again = row.status && row.status->state == JobStatus::State::failed && retry;
        if (!row.status || again || !is_end(*row.status, inputs[n]))
            row.status.reset();
        read_numbers(row, jobs_folder);
        rows.push_back(std::move(row));
    }
    return rows;
}

} // namespace retractor::ui::cli

#include "ui/cli/batch/slurm.h"

#include "mesh/base/error.h"
#include "ui/cli/framework/run_program.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <sstream>
#include <string_view>
#include <utility>

namespace retractor::ui::cli {

namespace {

    constexpr std::chrono::minutes kPatience { 2 }; // with a controller that is busy

    /// Runs a program of Slurm; what it prints as an error is part of the output.
    ProgramRun run_slurm(
        const char* program, const std::vector<std::string>& arguments, const std::function<bool()>& stop)
    {
        const std::filesystem::path found = program_on_path(program);
        if (found.empty())
            throw InputError("this machine has no " + std::string(program)
                    + ": a batch goes to a cluster from a machine where Slurm's programs are on the PATH",
                "--slurm");
        std::vector<std::string> words { "/bin/sh", "-c", R"(exec "$@" 2>&1)", "sh", found.string() };
        words.insert(words.end(), arguments.begin(), arguments.end());
        return run_program(words, kPatience, {}, stop);
    }

    /// What a program printed, on one line.
    std::string in_one_line(std::string text)
    {
        while (text.ends_with('\n'))
            text.pop_back();
        std::ranges::replace(text, '\n', ' ');
        return text;
    }

    void refuse_option(const std::string& option)
    {
        constexpr std::array<std::string_view, 6> kRefused { "--wait", "-W", "--wrap", "--test-only", "--clusters",
            "-M" };
        if (std::ranges::find(kRefused, option.substr(0, option.find('='))) != kRefused.end())
            throw InputError("a batch cannot have this option of sbatch: " + option, "--slurm-args");
    }

    bool is_passing(const std::string& said)
    {
        constexpr std::array<std::string_view, 4> kPassing { "Unable to contact slurm controller", "Socket timed out",
            "Zero Bytes were transmitted", "temporarily" };
        return std::ranges::any_of(
            kPassing, [&](std::string_view words) { return said.find(words) != std::string::npos; });
    }

} // namespace

bool submit(const SlurmArray& array, const std::function<bool()>& stop)
{
    std::ranges::for_each(array.options, refuse_option);
    std::string tasks = "0-" + std::to_string(array.tasks - 1);
    if (array.at_a_time > 0)
        tasks += "%" + std::to_string(array.at_a_time);
    std::vector<std::string> arguments = array.options;
    for (const std::string& own : { std::string("--parsable"), "--job-name=" + array.name, "--array=" + tasks,
             "--output=" + (array.logs / (array.name + "-%a.txt")).string(), array.script.string() })
        arguments.push_back(own);
    const ProgramRun run = run_slurm("sbatch", arguments, stop);
    if (run.exit_code == 0)
        return true;
    const std::string said = in_one_line(run.out);
    if (run.stopped || run.timed_out || is_passing(said))
        return false;
    throw InputError(
        "the cluster does not take the jobs: " + (said.empty() ? "sbatch gave no reason" : said), "--slurm");
}

SlurmQueue ask_queue(const std::function<bool()>& stop)
{
    const ProgramRun run
        = run_slurm("squeue", { "--noheader", "--me", "--array", "--states=all", "--format=%j|%K|%T" }, stop);
    if (run.exit_code != 0)
        return { .said = in_one_line(run.out), .tasks = {} };
    SlurmQueue queue { .answered = true, .said = {}, .tasks = {} };
    std::istringstream lines(run.out);
    for (std::string line; std::getline(lines, line);) {
        const std::size_t state = line.rfind('|');
        const std::size_t number = state == std::string::npos || state == 0 ? state : line.rfind('|', state - 1);
        if (number == std::string::npos)
            continue;
        SlurmTask task {
            .array = line.substr(0, number), .number = std::size_t { 0 }, .state = line.substr(state + 1)
        };
        const char* const end = line.data() + state;
        if (std::from_chars(line.data() + number + 1, end, *task.number).ptr != end)
            task.number.reset();
        queue.tasks.push_back(std::move(task));
    }
    return queue;
}

bool is_active(const std::string& state)
{
    constexpr std::array<std::string_view, 10> kEnded { "COMPLETED", "CANCELLED", "FAILED", "TIMEOUT", "NODE_FAIL",
        "BOOT_FAIL", "DEADLINE", "OUT_OF_MEMORY", "PREEMPTED", "REVOKED" };
    return std::ranges::find(kEnded, state) == kEnded.end();
}

} // namespace retractor::ui::cli

#include "ui/cli/framework/run_program.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <sstream>
#include <system_error>

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace retractor::ui::cli {

namespace {

    using Clock = std::chrono::steady_clock;

    /// Runs in the child. Other threads may have held locks at the fork, so only system calls are allowed.
    [[noreturn]] void become(char* const* words, const char* folder, int out)
    {
        if (*folder != '\0' && ::chdir(folder) != 0)
            ::_exit(127);
        ::prctl(PR_SET_PDEATHSIG, SIGKILL); // nobody would read its answer
        ::setpgid(0, 0); // a process group of its own, so that its children can be killed too
        const int nothing = ::open("/dev/null", O_RDWR);
        ::dup2(nothing, STDIN_FILENO);
        ::dup2(out, STDOUT_FILENO);
        ::dup2(nothing, STDERR_FILENO);
        ::execv(words[0], words);
        ::_exit(127);
    }

    constexpr int kAskAgain_ms = 100; // interval of the calls of `stop`

    /// Reads to the end of the stream. @returns false when `end` comes first, or `stop` returns true
    bool read_until(int fd, Clock::time_point end, const std::function<bool()>& stop, ProgramRun& run)
    {
        std::array<char, 4096> buffer {};
        for (;;) {
            const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
            run.stopped = stop && stop();
            if (left <= 0 || run.stopped)
                return false;
            pollfd waiting { .fd = fd, .events = POLLIN, .revents = 0 };
            const int patience = stop ? static_cast<int>(std::min<long>(left, kAskAgain_ms)) : static_cast<int>(left);
            const int ready = ::poll(&waiting, 1, patience);
            if (ready == 0 || (ready < 0 && errno == EINTR))
                continue;
            const ssize_t n = ready < 0 ? -1 : ::read(fd, buffer.data(), buffer.size());
            if (n > 0)
                run.out.append(buffer.data(), static_cast<std::size_t>(n));
            else if (n == 0 || errno != EINTR)
                return true;
        }
    }

    /// Waits for the end of the child and takes its status. @returns false when `end` comes first
    bool wait_until(pid_t child, Clock::time_point end, int& status, rusage& use)
    {
        constexpr useconds_t kPause_us = 2000; // the child has closed its output and is about to end
        while (::wait4(child, &status, WNOHANG, &use) == 0) {
            if (Clock::now() >= end)
                return false;
            ::usleep(kPause_us);
        }
        return true;
    }

} // namespace

ProgramRun run_program(const std::vector<std::string>& words, std::chrono::milliseconds limit,
    const std::filesystem::path& folder, const std::function<bool()>& stop)
{
    ProgramRun run;
    std::array<int, 2> ends {};
    if (words.empty() || ::pipe2(ends.data(), O_CLOEXEC) != 0)
        return run;
    std::vector<char*> pointers;
    for (const std::string& word : words)
        pointers.push_back(const_cast<char*>(word.c_str()));
    pointers.push_back(nullptr);
    const Clock::time_point end = Clock::now() + limit;
    const pid_t child = ::fork();
    if (child == 0)
        become(pointers.data(), folder.c_str(), ends[1]);
    ::close(ends[1]);
    if (child > 0) {
        ::setpgid(child, child); // parent and child both do this; the first call counts
        int status = 0;
        rusage use {};
        if (!read_until(ends[0], end, stop, run) || !wait_until(child, end, status, use)) {
            run.timed_out = !run.stopped;
            ::kill(-child, SIGKILL);
            ::wait4(child, &status, 0, &use);
        }
        run.peak_bytes = 1024.0 * static_cast<double>(use.ru_maxrss); // Linux counts kilobytes
        run.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }
    ::close(ends[0]);
    return run;
}

std::filesystem::path program_on_path(const std::string& name)
{
    const char* set = std::getenv("PATH");
    std::istringstream folders(set != nullptr ? set : "");
    for (std::string folder; std::getline(folders, folder, ':');) {
        const std::filesystem::path program = std::filesystem::path(folder.empty() ? "." : folder) / name;
        std::error_code error;
        if (std::filesystem::is_regular_file(program, error) && ::access(program.c_str(), X_OK) == 0)
            return std::filesystem::absolute(program);
    }
    return {};
}

} // namespace retractor::ui::cli

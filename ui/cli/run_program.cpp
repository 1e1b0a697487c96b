#include "ui/cli/run_program.h"

#include <algorithm>
#include <array>
#include <cerrno>

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

namespace retractor::cli {

namespace {

    using Clock = std::chrono::steady_clock;

    /// In the child. Other threads may have held locks when it was forked: system calls only.
    [[noreturn]] void become(char* const* words, int out)
    {
        ::setpgid(0, 0); // so that what it starts can be killed with it
        const int nothing = ::open("/dev/null", O_RDWR);
        ::dup2(nothing, STDIN_FILENO);
        ::dup2(out, STDOUT_FILENO);
        ::dup2(nothing, STDERR_FILENO);
        ::execv(words[0], words);
        ::_exit(127);
    }

    /// Reads to the end of the stream; false when that has not come by `end`.
    bool read_until(int fd, Clock::time_point end, std::string& text)
    {
        std::array<char, 4096> buffer {};
        for (;;) {
            const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
            if (left <= 0)
                return false;
            pollfd waiting { .fd = fd, .events = POLLIN, .revents = 0 };
            const int ready = ::poll(&waiting, 1, static_cast<int>(left));
            if (ready == 0 || (ready < 0 && errno == EINTR))
                continue;
            const ssize_t n = ready < 0 ? -1 : ::read(fd, buffer.data(), buffer.size());
            if (n > 0)
                text.append(buffer.data(), static_cast<std::size_t>(n));
            else if (n == 0 || errno != EINTR)
                return true;
        }
    }

    /// Its status once it has ended; false when it has not by `end`.
    bool wait_until(pid_t child, Clock::time_point end, int& status)
    {
        constexpr useconds_t kPause_us = 2000; // it has closed its output: it is about to end
        while (::waitpid(child, &status, WNOHANG) == 0) {
            if (Clock::now() >= end)
                return false;
            ::usleep(kPause_us);
        }
        return true;
    }

} // namespace

ProgramRun run_program(const std::vector<std::string>& words, std::chrono::milliseconds limit)
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
        become(pointers.data(), ends[1]);
    ::close(ends[1]);
    if (child > 0) {
        ::setpgid(child, child); // whoever comes first
        int status = 0;
        if (!read_until(ends[0], end, run.out) || !wait_until(child, end, status)) {
            run.timed_out = true;
            ::kill(-child, SIGKILL);
            ::waitpid(child, &status, 0);
        }
        run.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }
    ::close(ends[0]);
    return run;
}

} // namespace retractor::cli

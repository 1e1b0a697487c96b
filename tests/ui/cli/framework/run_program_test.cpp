#include "ui/cli/framework/run_program.h"

#include <gtest/gtest.h>

#include <csignal>
#include <string>

#include <unistd.h>

namespace retractor::ui::cli {
namespace run_program_test {

    using namespace std::chrono_literals;

    constexpr auto kPlenty = 60s; // for programs that end by themselves

    ProgramRun shell(const std::string& script, std::chrono::milliseconds limit = kPlenty)
    {
        return run_program({ "/bin/sh", "-c", script }, limit);
    }

    TEST(RunProgram, GivesOutputAndExitCode)
    {
        const ProgramRun run = shell("echo one; echo unseen >&2; printf two; exit 3");
        EXPECT_EQ(run.out, "one\ntwo");
        EXPECT_EQ(run.exit_code, 3);
        EXPECT_FALSE(run.timed_out);
    }

    TEST(RunProgram, LargeOutputComesWhole)
    {
        EXPECT_EQ(shell("head -c 300000 /dev/zero").out.size(), 300000u); // more than a pipe holds
    }

    TEST(RunProgram, ArgumentsAreTakenAsTheyAre)
    {
        EXPECT_EQ(run_program({ "/bin/sh", "-c", "printf %s \"$1\"", "x", "it's $HOME" }, kPlenty).out, "it's $HOME");
    }

    TEST(RunProgram, DeathIsTold)
    {
        EXPECT_EQ(shell("kill -SEGV $$").exit_code, -1);
        EXPECT_EQ(run_program({ "/nothing/here" }, kPlenty).exit_code, 127);
        EXPECT_EQ(run_program({}, kPlenty).exit_code, -1);
    }

    TEST(RunProgram, IsKilledAtTheLimitWithWhatItStarted)
    {
        // The shell's child holds the output open; without a limit this would take a minute.
        const ProgramRun run = shell("sleep 60 & echo $!; wait", 500ms);
        EXPECT_TRUE(run.timed_out);
        EXPECT_EQ(run.exit_code, -1);
        // Also when the output is closed long before the end.
        EXPECT_TRUE(shell("exec >&-; sleep 60", 500ms).timed_out);
    }

    TEST(RunProgram, RunsInTheFolderItIsGiven)
    {
        EXPECT_EQ(run_program({ "/bin/pwd" }, kPlenty, "/usr").out, "/usr\n");
        EXPECT_EQ(run_program({ "/bin/pwd" }, kPlenty, "/nothing/here").exit_code, 127);
    }

    TEST(RunProgram, IsKilledWhenToldToStop)
    {
        int asked = 0;
        const ProgramRun run = run_program({ "/bin/sleep", "60" }, kPlenty, {}, [&] { return ++asked == 3; });
        EXPECT_TRUE(run.stopped);
        EXPECT_FALSE(run.timed_out);
        EXPECT_EQ(run.exit_code, -1);
    }

} // namespace run_program_test
} // namespace retractor::ui::cli

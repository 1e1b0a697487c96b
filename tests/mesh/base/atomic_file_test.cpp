#include "mesh/base/atomic_file.h"

#include "mesh/base/error.h"

#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

namespace retractor {
namespace atomic_file_test {

    namespace fs = std::filesystem;

    class AtomicFile : public testing::Test {
    protected:
        void SetUp() override
        {
            const auto* info = testing::UnitTest::GetInstance()->current_test_info();
            folder_ = fs::path(testing::TempDir()) / ("retractor_atomic_" + std::string(info->name()));
            fs::remove_all(folder_);
            fs::create_directories(folder_);
        }
        void TearDown() override { fs::remove_all(folder_); }
        fs::path file() const { return folder_ / "case.json"; }
        std::string content(const fs::path& path) const
        {
            std::ifstream in(path, std::ios::binary);
            return { std::istreambuf_iterator<char>(in), {} };
        }
        std::size_t file_count() const
        {
            return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
        }
        std::string message_of(const std::function<void()>& action) const
        {
            try {
                action();
            } catch (const IoError& error) {
                EXPECT_EQ(error.where(), file().string());
                return error.what();
            }
            return "no error";
        }
        fs::path folder_;
    };

    TEST_F(AtomicFile, ReplacesTheContentAndLeavesNothingElse)
    {
        write_file_atomically(file(), "one");
        write_file_atomically(file(), std::string("t\0wo", 4));
        EXPECT_EQ(content(file()), std::string("t\0wo", 4));
        write_file_atomically(file(), "");
        EXPECT_EQ(content(file()), "");
        write_file_atomically(file(), [](const fs::path& temporary) { std::ofstream(temporary) << "three"; });
        EXPECT_EQ(content(file()), "three");
        EXPECT_EQ(file_count(), 1u);
    }

    TEST_F(AtomicFile, AFailedWriterLeavesTheOldFileAndNothingElse)
    {
        write_file_atomically(file(), "old");
        EXPECT_THROW(write_file_atomically(file(),
                         [](const fs::path& temporary) {
                             std::ofstream(temporary) << "half";
                             std::ofstream(temporary.string() + ".gz") << "a library's own";
                             throw InputError("no");
                         }),
            InputError);
        EXPECT_EQ(message_of([&] { write_file_atomically(file(), [](const fs::path&) {}); }), "nothing was written");
        EXPECT_EQ(content(file()), "old");
        EXPECT_EQ(file_count(), 1u);
    }

    TEST_F(AtomicFile, SaysWhyAFolderCannotBeWritten)
    {
        fs::remove_all(folder_);
        EXPECT_EQ(message_of([&] { write_file_atomically(file(), "x"); }), "cannot write: No such file or directory");
        EXPECT_EQ(message_of([&] { write_file_atomically(file(), [](const fs::path&) {}); }),
            "cannot write: No such file or directory");
    }

    TEST_F(AtomicFile, LeftoversOfKilledWritersAreRemovedButNotFilesInUse)
    {
        const fs::path left = folder_ / ".case.retractor-123456-0.json";
        const fs::path left_by_library = folder_ / ".ct.retractor-123456-1.gz.nii.gz";
        const fs::path in_use = folder_ / ".case.retractor-123457-0.json";
        const fs::path in_use_by_library = folder_ / ".case.retractor-123457-0.json.tmp"; // which nobody locks
        const fs::path foreign = folder_ / ".case.swp";
        for (const fs::path& path : { left, left_by_library, in_use, in_use_by_library, foreign })
            std::ofstream(path) << "{";
        const int other = ::open(in_use.c_str(), O_RDWR);
        ASSERT_EQ(::flock(other, LOCK_EX), 0);
        write_file_atomically(file(), "x");
        EXPECT_FALSE(fs::exists(left));
        EXPECT_FALSE(fs::exists(left_by_library));
        EXPECT_TRUE(fs::exists(in_use));
        EXPECT_TRUE(fs::exists(in_use_by_library));
        EXPECT_TRUE(fs::exists(foreign));
        ::close(other);
    }

    /// Runs `action` in a child that may write files of `bytes` at most.
    int exit_code_with_limit(rlim_t bytes, const std::function<int()>& action)
    {
        const pid_t child = ::fork();
        if (child == 0) {
            std::signal(SIGXFSZ, SIG_IGN);
            const rlimit limit { bytes, bytes };
            ::_exit(::setrlimit(RLIMIT_FSIZE, &limit) == 0 ? action() : 99);
        }
        int status = 0;
        ::waitpid(child, &status, 0);
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }

    TEST_F(AtomicFile, WithoutRoomTheOldFileStaysAndTheReasonIsGiven)
    {
        write_file_atomically(file(), "old");
        const std::string large(100000, 'x');
        const auto reason_is_given = [&](const std::function<void()>& action) {
            return exit_code_with_limit(
                50000, [&] { return message_of(action).find("File too large") != std::string::npos ? 0 : 1; });
        };
        EXPECT_EQ(reason_is_given([&] { write_file_atomically(file(), large); }), 0);
        const auto library = [&](const fs::path& temporary, bool notices) {
            std::ofstream out(temporary);
            out << large;
            if (!out.flush() && notices)
                throw IoError("the library failed", temporary.string());
        };
        for (const bool notices : { true, false })
            EXPECT_EQ(reason_is_given([&] {
                write_file_atomically(file(), [&](const fs::path& temporary) { library(temporary, notices); });
            }),
                0)
                << notices;
        EXPECT_EQ(content(file()), "old");
        EXPECT_EQ(file_count(), 1u);
    }

    TEST_F(AtomicFile, AWholeFileIsKeptWhenLittleRoomIsLeftBehindIt)
    {
        const std::string most(49990, 'x');
        EXPECT_EQ(exit_code_with_limit(50000,
                      [&] {
                          write_file_atomically(
                              file(), [&](const fs::path& temporary) { std::ofstream(temporary) << most; });
                          return 0;
                      }),
            0);
        EXPECT_EQ(content(file()), most);
    }

    TEST_F(AtomicFile, LibrariesAreGivenTheWholeSuffixAndTheLockedFileItself)
    {
        for (const char* name : { "ct.nii.gz", "ct.nrrd", "v1.2.gz", "bare" }) {
            const fs::path target = folder_ / name;
            write_file_atomically(target, [&](const fs::path& temporary) {
                std::string found = temporary.filename().string();
                EXPECT_EQ(found.find(fs::path(name).stem().stem().string()), 1u) << found;
                const std::string suffix = std::string(name).find('.') == std::string::npos
                    ? ""
                    : std::string(name).substr(std::string(name).find('.'));
                EXPECT_TRUE(found.ends_with(suffix)) << found;
                const int other = ::open(temporary.c_str(), O_RDWR);
                EXPECT_NE(::flock(other, LOCK_EX | LOCK_NB), 0) << found;
                ::close(other);
                std::ofstream(temporary) << name;
            });
            EXPECT_EQ(content(target), name);
        }
    }

    TEST_F(AtomicFile, AWriterKilledAtAnyMomentLeavesAWholeFile)
    {
        const std::string first(300000, 'a');
        const std::string second(400000, 'b');
        write_file_atomically(file(), first);
        constexpr int kRounds = 20;
        for (int round = 0; round < kRounds; ++round) {
            const pid_t child = ::fork();
            if (child == 0) {
                for (;;) { // until it is killed
                    write_file_atomically(file(), second);
                    write_file_atomically(file(), first);
                }
            }
            // The time is what is tested: the child is killed somewhere within its writing, wherever that is.
            ::usleep(static_cast<useconds_t>(500 + 700 * round));
            ::kill(child, SIGKILL);
            ::waitpid(child, nullptr, 0);
            const std::string found = content(file());
            ASSERT_TRUE(found == first || found == second) << found.size() << " bytes";
        }
    }

} // namespace atomic_file_test
} // namespace retractor

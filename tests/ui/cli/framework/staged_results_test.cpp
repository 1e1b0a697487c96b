#include "ui/cli/framework/staged_results.h"

#include "mesh/base/error.h"
#include "tests/support/temporary_folder.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <set>
#include <string>

#include <csignal>
#include <sys/wait.h>
#include <unistd.h>

namespace retractor::ui::cli {
namespace staged_results_test {

    namespace fs = std::filesystem;

    void write(const fs::path& file, const std::string& text) { std::ofstream(file) << text; }

    std::string text_of(const fs::path& file)
    {
        std::ifstream in(file);
        return { std::istreambuf_iterator<char>(in), {} };
    }

    std::set<std::string> names_in(const fs::path& folder)
    {
        std::set<std::string> names;
        for (const fs::directory_entry& entry : fs::directory_iterator(folder))
            names.insert(entry.path().filename().string());
        return names;
    }

    /// An earlier run, and a file that is none of ours.
    void write_earlier(const fs::path& out)
    {
        write(out / "metrics.json", "earlier");
        write(out / "a.png", "earlier");
        write(out / "notes.txt", "mine");
    }

    TEST(StagedResults, ReplaceTheEarlierFilesTogether)
    {
        const test_support::TemporaryFolder out;
        write_earlier(out.path);
        {
            StagedResults staged(out.path);
            write(staged.folder() / "metrics.json", "new");
            write(staged.folder() / "a.png", "new");
            write(staged.folder() / "b.png", "new");
            EXPECT_EQ(staged.published(staged.folder() / "b.png"), out.path / "b.png");
            EXPECT_EQ(text_of(out.path / "a.png"), "earlier") << "until they are published";
            staged.publish("metrics.json");
        }
        EXPECT_EQ(names_in(out.path), (std::set<std::string> { "metrics.json", "a.png", "b.png", "notes.txt" }));
        for (const char* name : { "metrics.json", "a.png", "b.png" })
            EXPECT_EQ(text_of(out.path / name), "new") << name;
        EXPECT_EQ(text_of(out.path / "notes.txt"), "mine");
    }

    TEST(StagedResults, ARunThatFailsLeavesTheEarlierFiles)
    {
        const test_support::TemporaryFolder out;
        write_earlier(out.path);
        {
            StagedResults staged(out.path);
            write(staged.folder() / "a.png", "new");
        }
        EXPECT_EQ(names_in(out.path), (std::set<std::string> { "metrics.json", "a.png", "notes.txt" }));
        EXPECT_EQ(text_of(out.path / "a.png"), "earlier");
    }

    TEST(StagedResults, ARunThatIsKilledLeavesTheEarlierFilesAndTheNextOneTidiesUp)
    {
        const test_support::TemporaryFolder out;
        write_earlier(out.path);
        const pid_t child = ::fork();
        if (child == 0) {
            const StagedResults staged(out.path);
            write(staged.folder() / "a.png", "new");
            ::kill(::getpid(), SIGKILL);
        }
        ASSERT_EQ(::waitpid(child, nullptr, 0), child);
        EXPECT_EQ(text_of(out.path / "a.png"), "earlier");
        EXPECT_EQ(names_in(out.path).size(), 4U) << "the killed run's hidden folder is there";
        {
            const StagedResults next(out.path);
        }
        EXPECT_EQ(names_in(out.path), (std::set<std::string> { "metrics.json", "a.png", "notes.txt" }));
    }

    TEST(StagedResults, AFileThatCannotBePlacedIsNamedAndTheSummaryStays)
    {
        const test_support::TemporaryFolder out;
        write_earlier(out.path);
        fs::create_directory(out.path / "b.png"); // a folder in the way
        write(out.path / "b.png" / "inside", "");
        StagedResults staged(out.path);
        write(staged.folder() / "metrics.json", "new");
        write(staged.folder() / "b.png", "new");
        try {
            staged.publish("metrics.json");
            FAIL() << "published over a folder";
        } catch (const IoError& error) {
            EXPECT_EQ(error.where(), (out.path / "b.png").string());
        }
        EXPECT_EQ(text_of(out.path / "metrics.json"), "earlier");
    }

} // namespace staged_results_test
} // namespace retractor::ui::cli

// A case folder under accidents: the program killed at any moment, a full disk, damaged files. The built executable is
// run as a process of its own.

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace case_survival_test {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using Milliseconds = std::chrono::duration<double, std::milli>;

struct ProgramRun {
    int exit_code = -1; ///< -1: killed
    Json document; ///< of --json
};

pid_t start(const std::vector<std::string>& arguments, const fs::path& out, const std::function<void()>& prepare = {})
{
    const pid_t child = ::fork();
    if (child != 0)
        return child;
    const int file = ::open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    const int nothing = ::open("/dev/null", O_WRONLY);
    ::dup2(file, STDOUT_FILENO);
    ::dup2(nothing, STDERR_FILENO);
    std::vector<char*> words { const_cast<char*>(RETRACTOR_PROGRAM), const_cast<char*>("--json") };
    for (const std::string& argument : arguments)
        words.push_back(const_cast<char*>(argument.c_str()));
    words.push_back(nullptr);
    if (prepare)
        prepare();
    ::execv(RETRACTOR_PROGRAM, words.data());
    ::_exit(127);
}

std::string content(const fs::path& path)
{
    std::ifstream in(path, std::ios::binary);
    return { std::istreambuf_iterator<char>(in), {} };
}

class CaseSurvival : public testing::Test {
protected:
    static void SetUpTestSuite()
    {
        folder = fs::path(testing::TempDir()) / "case_survival";
        fs::remove_all(folder);
        fs::create_directories(folder);
        // Two patients, so that a case that is half of one and half of the other is noticed by its checksums.
        for (const char* seed : { "1", "2" })
            ASSERT_EQ(run({ "phantom", "block", "--nrrd", "--seed", seed, "--turn", std::string("0,0,") + seed, "--out",
                              patient(seed).string() })
                          .exit_code,
                0);
    }
    static void TearDownTestSuite() { fs::remove_all(folder); }

    static fs::path patient(const std::string& seed) { return folder / ("patient" + seed); }
    static std::vector<std::string> import_words(const std::string& seed, const fs::path& case_folder)
    {
        return { "import", (patient(seed) / "ct.nrrd").string(), "--labels", (patient(seed) / "labels.nrrd").string(),
            "--no-contact-sheet", "--out", (case_folder / "case.json").string() };
    }

    static ProgramRun run(const std::vector<std::string>& arguments, const std::function<void()>& prepare = {})
    {
        const fs::path out = folder / "out.json";
        int status = 0;
        ::waitpid(start(arguments, out, prepare), &status, 0);
        std::ifstream in(out);
        return { WIFEXITED(status) ? WEXITSTATUS(status) : -1, Json::parse(in, nullptr, false) };
    }
    /// Reads the case and verifies its checksums.
    static ProgramRun read_case(const fs::path& case_folder)
    {
        return run({ "approach", "list", (case_folder / "case.json").string() });
    }

    /// Starts an import and kills it after `delay`, unless it was done before.
    static void kill_import(const std::string& seed, const fs::path& case_folder, Milliseconds delay)
    {
        const pid_t child = start(import_words(seed, case_folder), folder / "killed.json");
        std::this_thread::sleep_for(delay); // the time is what is tested: an import killed wherever it then is
        ::kill(child, SIGKILL);
        ::waitpid(child, nullptr, 0);
    }
    static Milliseconds time_of_import()
    {
        const auto begin = std::chrono::steady_clock::now();
        EXPECT_EQ(run(import_words("1", folder / "timed")).exit_code, 0);
        return std::chrono::steady_clock::now() - begin;
    }

    static std::size_t hidden_entries(const fs::path& case_folder)
    {
        return static_cast<std::size_t>(std::count_if(fs::directory_iterator(case_folder), fs::directory_iterator(),
            [](const auto& entry) { return entry.path().filename().string().front() == '.'; }));
    }

    static inline fs::path folder;
};

/// Kills imports at times spread evenly over the time that a whole one takes, and on until one was finished in time,
/// since a busy machine may take longer than when it was measured. `finished(delay)` runs one and says whether it was.
void kill_at_all_times(Milliseconds whole, const std::function<bool(Milliseconds delay)>& finished)
{
    constexpr int kRounds = 16; // an import takes a few tenths of a second
    constexpr int kMostRounds = 8 * kRounds;
    int rounds = 0;
    int whole_cases = 0;
    while (rounds < kRounds || (whole_cases == 0 && rounds < kMostRounds && !testing::Test::HasFatalFailure()))
        whole_cases += finished((++rounds - 0.5) / kRounds * 1.1 * whole) ? 1 : 0;
    std::printf("%d imports killed, %d of them had finished their case\n", rounds, whole_cases);
    // Or they were all killed too late, or too early, to show anything.
    EXPECT_GT(whole_cases, 0);
    EXPECT_LT(whole_cases, rounds);
}

TEST_F(CaseSurvival, KilledImportLeavesNoCaseOrAWholeOne)
{
    const fs::path made = folder / "killed";
    kill_at_all_times(time_of_import(), [&](Milliseconds delay) {
        fs::remove_all(made);
        kill_import("1", made, delay);
        const bool is_whole = fs::exists(made / "case.json");
        if (is_whole)
            EXPECT_EQ(read_case(made).exit_code, 0) << delay.count() << " ms";
        else if (fs::exists(made) && hidden_entries(made) > 0) {
            EXPECT_EQ(run(import_words("1", made)).exit_code, 0) << delay.count() << " ms";
            EXPECT_EQ(read_case(made).exit_code, 0) << delay.count() << " ms";
            EXPECT_EQ(hidden_entries(made), 0u); // what the killed one left is gone
        }
        return is_whole;
    });
}

TEST_F(CaseSurvival, KilledImportLeavesTheEarlierCaseWhole)
{
    const fs::path made = folder / "earlier";
    ASSERT_EQ(run(import_words("1", made)).exit_code, 0);
    std::string there = "1";
    kill_at_all_times(time_of_import(), [&](Milliseconds delay) {
        const std::string before = content(made / "case.json");
        const std::string other = there == "1" ? "2" : "1";
        kill_import(other, made, delay);
        const ProgramRun read = read_case(made);
        EXPECT_EQ(read.exit_code, 0) << delay.count() << " ms: " << read.document;
        const bool is_replaced = content(made / "case.json") != before;
        if (is_replaced)
            there = other;
        return is_replaced;
    });
}

void expect_earlier_case_stays(const ProgramRun& failed, const ProgramRun& read, const std::string& reason)
{
    EXPECT_EQ(failed.exit_code, 1) << failed.document;
    ASSERT_TRUE(failed.document.is_object());
    EXPECT_NE(failed.document.at("error").get<std::string>().find(reason), std::string::npos) << failed.document;
    const std::string where = failed.document.at("where").get<std::string>();
    EXPECT_TRUE(where.find("ct") != std::string::npos || where.find("labels") != std::string::npos) << where;
    EXPECT_EQ(read.exit_code, 0) << read.document;
}

TEST_F(CaseSurvival, WithoutRoomTheEarlierCaseStaysAndTheReasonIsGiven)
{
    const fs::path made = folder / "limited";
    ASSERT_EQ(run(import_words("1", made)).exit_code, 0);
    const auto limit_file_size = [] {
        std::signal(SIGXFSZ, SIG_IGN);
        constexpr rlim_t kBytes = 100000; // the labels fit, the CT does not
        const rlimit limit { kBytes, kBytes };
        if (::setrlimit(RLIMIT_FSIZE, &limit) != 0)
            ::_exit(126);
    };
    const ProgramRun failed = run(import_words("2", made), limit_file_size);
    expect_earlier_case_stays(failed, read_case(made), "File too large");
    EXPECT_EQ(hidden_entries(made), 0u);
}

/// A file system with room for one case of these tests, but not for two.
class SmallDisk {
public:
    explicit SmallDisk(fs::path at)
        : at_(std::move(at))
        , mounted_(::mount("tmpfs", at_.c_str(), "tmpfs", 0, "size=300k") == 0)
    {
    }
    SmallDisk(const SmallDisk&) = delete;
    SmallDisk& operator=(const SmallDisk&) = delete;
    ~SmallDisk()
    {
        if (mounted_)
            ::umount2(at_.c_str(), MNT_DETACH);
    }
    bool mounted() const { return mounted_; }

private:
    fs::path at_;
    bool mounted_;
};

TEST_F(CaseSurvival, OnAFullDiskTheEarlierCaseStaysAndTheReasonIsGiven)
{
    const fs::path made = folder / "full";
    fs::create_directories(made);
    const SmallDisk disk(made);
    if (!disk.mounted())
        GTEST_SKIP() << "a small file system can be mounted by root only";
    const ProgramRun first = run(import_words("1", made));
    EXPECT_EQ(first.exit_code, 0) << first.document; // one case fits, two do not
    const ProgramRun failed = run(import_words("2", made));
    expect_earlier_case_stays(failed, read_case(made), "No space left on device");
    EXPECT_EQ(hidden_entries(made), 0u);
}

TEST_F(CaseSurvival, ADamagedCaseSaysWhichPart)
{
    const fs::path made = folder / "damaged";
    ASSERT_EQ(run(import_words("1", made)).exit_code, 0);
    const std::string description = content(made / "case.json");
    const std::string labels = content(made / "labels.nrrd");
    const std::string ct = content(made / "ct.nrrd");
    const auto restore = [&] {
        std::ofstream(made / "case.json", std::ios::binary) << description;
        std::ofstream(made / "labels.nrrd", std::ios::binary) << labels;
        std::ofstream(made / "ct.nrrd", std::ios::binary) << ct;
    };
    const auto put = [&](const char* file, std::string text) { std::ofstream(made / file, std::ios::binary) << text; };
    const auto flipped = [](std::string text) {
        text[text.size() / 2] = static_cast<char>(text[text.size() / 2] ^ 1);
        return text;
    };
    struct Damage {
        std::function<void()> act;
        std::string pointer, word;
    };
    const std::vector<Damage> damages {
        { [&] { put("case.json", description.substr(0, description.size() / 2)); }, "/", "JSON" },
        { [&] { put("case.json", ""); }, "/", "JSON" },
        { [&] {
             const Json whole = Json::parse(description);
             Json changed = whole;
             changed["labels"]["table"][1]["role"] = "wal";
             put("case.json", changed.dump());
         },
            "/labels/table/1/role", "wal" },
        { [&] { put("labels.nrrd", flipped(labels)); }, "/labels/sha256", "labels.nrrd" },
        { [&] { put("labels.nrrd", labels.substr(0, labels.size() - 1)); }, "/labels/sha256", "labels.nrrd" },
        { [&] { fs::remove(made / "labels.nrrd"); }, "/labels/path", "labels.nrrd" },
        { [&] { put("ct.nrrd", flipped(ct)); }, "/ct/sha256", "ct.nrrd" },
        { [&] { put("ct.nrrd", ""); }, "/ct/sha256", "ct.nrrd" },
        { [&] { fs::remove(made / "ct.nrrd"); }, "/ct/path", "ct.nrrd" },
    };
    for (const Damage& damage : damages) {
        restore();
        ASSERT_EQ(read_case(made).exit_code, 0);
        damage.act();
        const ProgramRun read = read_case(made);
        EXPECT_EQ(read.exit_code, 2) << read.document;
        EXPECT_EQ(read.document.at("where"), (made / "case.json").string() + "#" + damage.pointer);
        EXPECT_NE(read.document.at("error").get<std::string>().find(damage.word), std::string::npos) << read.document;
    }
}

} // namespace case_survival_test

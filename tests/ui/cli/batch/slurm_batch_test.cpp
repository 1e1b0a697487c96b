// Batches on a Slurm cluster of one machine, which this test starts. It needs root and Debian's slurmctld, slurmd,
// slurm-client and munge; elsewhere it is skipped.

#include "tests/support/command_run.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <arpa/inet.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

namespace slurm_batch_test {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using retractor::test_support::CommandRun;
using retractor::test_support::run_line;

std::string text_of(const fs::path& file)
{
    std::ifstream in(file);
    return { std::istreambuf_iterator<char>(in), {} };
}

Json read(const fs::path& file) { return Json::parse(text_of(file), nullptr, false); }

bool wait_for(std::chrono::seconds limit, const auto& holds)
{
    const auto end = std::chrono::steady_clock::now() + limit;
    while (!holds()) {
        if (std::chrono::steady_clock::now() > end)
            return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return true;
}

int free_port()
{
    const int fd = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address {};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    int port = 0;
    if (::bind(fd, reinterpret_cast<sockaddr*>(&address), size) == 0
        && ::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size) == 0)
        port = ntohs(address.sin_port);
    ::close(fd);
    return port;
}

/// A cluster of this machine, with its own key, ports and folders.
class Cluster {
public:
    /// @returns why it does not run; empty: it does
    std::string start(const fs::path& folder)
    {
        if (::geteuid() != 0)
            return "only root can start the services";
        for (const char* program : { "munged", "slurmctld", "slurmd", "sbatch", "squeue" })
            if (run_line(std::string("PATH=$PATH:/usr/sbin command -v ") + program).exit_code != 0)
                return std::string("there is no ") + program;
        folder_ = folder;
        fs::create_directories(folder / "state");
        fs::create_directories(folder / "spool");
        std::string key(1024, '\0');
        std::random_device random;
        std::ranges::generate(key, [&] { return static_cast<char>(random()); });
        std::ofstream(folder / "key", std::ios::binary) << key;
        fs::permissions(folder / "key", fs::perms::owner_read | fs::perms::owner_write);
        const std::string cores = std::to_string(std::max(1U, std::thread::hardware_concurrency()));
        const auto host = run_line("hostname -s | tr -d '\\n'").out;
        std::ofstream(folder / "slurm.conf")
            << "ClusterName=retractor\nSlurmctldHost=" << host << "(127.0.0.1)\nSlurmUser=root\nAuthType=auth/munge\n"
            << "AuthInfo=socket=" << at("munge.socket") << "\nCredType=cred/munge\nSlurmctldPort=" << free_port()
            << "\nSlurmdPort=" << free_port() << "\nStateSaveLocation=" << at("state")
            << "\nSlurmdSpoolDir=" << at("spool") << "\nSlurmctldPidFile=" << at("slurmctld.pid")
            << "\nSlurmdPidFile=" << at("slurmd.pid") << "\nSlurmctldLogFile=" << at("slurmctld.log")
            << "\nSlurmdLogFile=" << at("slurmd.log")
            << "\nProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\nMpiDefault=none\n"
            << "SelectType=select/cons_tres\nSelectTypeParameters=CR_Core\nReturnToService=2\nNodeName=" << host
            << " NodeAddr=127.0.0.1 CPUs=" << cores << " State=UNKNOWN\n"
            << "PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP\n";
        ::setenv("SLURM_CONF", at("slurm.conf").c_str(), 1);
        if (run_line("munged --force --key-file=" + at("key") + " --socket=" + at("munge.socket") + " --pid-file="
                + at("munged.pid") + " --log-file=" + at("munged.log") + " --seed-file=" + at("seed") + " 2>&1")
                .exit_code
            != 0)
            return "munged does not start: " + text_of(at("munged.log"));
        start_controller();
        (void)run_line("slurmd >/dev/null 2>&1");
        const bool idle = wait_for(std::chrono::seconds(60),
            [] { return run_line("sinfo --noheader --format=%t 2>/dev/null").out.starts_with("idle"); });
        return idle ? std::string()
                    : "the cluster does not start: " + text_of(at("slurmctld.log")) + text_of(at("slurmd.log"));
    }
    void stop() const
    {
        if (folder_.empty())
            return;
        (void)run_line("scancel --user=root >/dev/null 2>&1");
        for (const char* service : { "slurmd", "slurmctld", "munged" })
            end(service, SIGTERM);
    }
    void start_controller() const { (void)run_line("slurmctld >/dev/null 2>&1"); }
    /// Ends a service, and waits for its end.
    void end(const std::string& service, int signal) const
    {
        const pid_t pid = std::atoi(text_of(at(service + ".pid")).c_str());
        if (pid > 1 && ::kill(pid, signal) == 0)
            (void)wait_for(std::chrono::seconds(20), [pid] { return ::kill(pid, 0) != 0; });
    }

private:
    std::string at(const std::string& name) const { return (folder_ / name).string(); }
    fs::path folder_;
};

CommandRun run(const std::string& arguments)
{
    return run_line(std::string(RETRACTOR_PROGRAM) + " " + arguments + " 2>/dev/null");
}

std::size_t jobs_in_state(const fs::path& batch, const std::string& state)
{
    std::size_t count = 0;
    if (fs::exists(batch / "jobs"))
        for (const fs::directory_entry& job : fs::directory_iterator(batch / "jobs"))
            if (const Json status = read(job.path() / "status.json"); status.is_object() && status["state"] == state)
                ++count;
    return count;
}

/// Kills the task that does a job. @returns the job's name; empty: no task runs
std::string kill_one_task(const fs::path& batch)
{
    constexpr std::string_view kOption = "--job";
    for (const fs::directory_entry& process : fs::directory_iterator("/proc")) {
        const pid_t pid = std::atoi(process.path().filename().c_str());
        std::string words = pid > 1 ? text_of(process.path() / "cmdline") : std::string();
        const std::size_t option = words.find(std::string("\0--job\0", 7));
        if (option == std::string::npos || words.find(batch.string()) == std::string::npos)
            continue;
        const std::string name = words.c_str() + option + kOption.size() + 2;
        if (!name.empty() && ::kill(pid, SIGKILL) == 0)
            return name;
    }
    return {};
}

/// A batch that follows its jobs in a process of its own; it is killed with this object.
class FollowingBatch {
public:
    FollowingBatch(const std::string& sweep, const std::string& out, const std::string& more)
        : pid_(::fork())
    {
        if (pid_ != 0)
            return;
        ::execl("/bin/sh", "sh", "-c",
            ("exec " + std::string(RETRACTOR_PROGRAM) + " batch " + sweep + " --out " + out + " --slurm " + more
                + " >/dev/null 2>&1")
                .c_str(),
            static_cast<char*>(nullptr));
        ::_exit(127);
    }
    FollowingBatch(const FollowingBatch&) = delete;
    FollowingBatch& operator=(const FollowingBatch&) = delete;
    ~FollowingBatch() { end(); }
    void end()
    {
        if (pid_ > 0)
            ::kill(pid_, SIGKILL);
        (void)exit_code();
    }
    /// Waits for the end. @returns -1: it was killed
    int exit_code()
    {
        int status = 0;
        if (pid_ > 0)
            ::waitpid(std::exchange(pid_, 0), &status, 0);
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }

private:
    pid_t pid_;
};

/// A block with one approach, and a cluster.
class SlurmBatch : public testing::Test {
protected:
    static void SetUpTestSuite()
    {
        folder = fs::path(testing::TempDir()) / "slurm_batch";
        fs::remove_all(folder);
        const std::string p = (folder / "p").string(), file = (folder / "c" / "case.json").string();
        ASSERT_EQ(run("phantom block --out " + p).exit_code, 0);
        ASSERT_EQ(run("import " + p + "/ct --labels " + p + "/labels.nrrd --out " + file).exit_code, 0);
        ASSERT_EQ(run("approach add " + file
                      + " --points 0,0,-25 0,0,25 --target target --retract cavity --name straight --hooks 2 "
                        "--opening 6")
                      .exit_code,
            0);
        why_not = cluster.start(folder / "cluster");
    }
    static void TearDownTestSuite() { cluster.stop(); }
    void SetUp() override
    {
        if (!why_not.empty())
            GTEST_SKIP() << "no Slurm cluster on this machine: " << why_not;
    }
    static std::string sweep(const std::string& name, std::size_t variants)
    {
        Json text { { "cases", { "c/case.json" } }, { "variants", Json::object() }, { "render", true } };
        for (std::size_t n = 0; n < variants; ++n)
            text["variants"]["v" + std::to_string(n)] = { "--draft", "--mesh-seed", std::to_string(n) };
        const fs::path file = folder / name;
        std::ofstream(file) << text.dump();
        return file.string();
    }
    static inline fs::path folder;
    static inline Cluster cluster;
    static inline std::string why_not;
};

TEST_F(SlurmBatch, EndsAfterTheBatchATaskAndTheControllerWereKilled)
{
    constexpr std::size_t kJobs = 20;
    const std::string file = sweep("many.json", kJobs), out = (folder / "many").string();
    FollowingBatch follower(file, out, "");
    constexpr std::chrono::minutes kLimit { 5 };
    ASSERT_TRUE(wait_for(kLimit, [&] { return jobs_in_state(out, "done") >= 3; }));
    EXPECT_EQ(run("batch " + file + " --out " + out + " --slurm").exit_code, 2); // one batch at a time
    follower.end();
    std::string killed;
    ASSERT_TRUE(wait_for(kLimit, [&] { return !(killed = kill_one_task(out)).empty(); }));
    // Tasks end while there is no controller. One that cannot even write its state (SIGKILL) takes Slurm minutes to
    // mend, and nothing of ours is in that.
    cluster.end("slurmctld", SIGTERM);
    std::this_thread::sleep_for(std::chrono::seconds(6));
    EXPECT_NE(run_line("squeue 2>/dev/null").exit_code, 0);
    cluster.start_controller();

    const CommandRun resumed = run("--json batch " + file + " --out " + out + " --slurm");
    EXPECT_EQ(resumed.exit_code, 0) << resumed.out;
    const Json document = Json::parse(resumed.out);
    EXPECT_EQ(document["counts"]["done"], kJobs);
    EXPECT_GE(document["skipped"], 3);
    EXPECT_EQ(jobs_in_state(out, "done"), kJobs);
    EXPECT_TRUE(fs::exists(fs::path(out) / "jobs" / killed / "report.html")) << killed;
    const std::string table = text_of(fs::path(out) / "summary.csv");
    EXPECT_EQ(std::ranges::count(table, '\n'), static_cast<std::ptrdiff_t>(kJobs + 1));
}

TEST_F(SlurmBatch, NamesACancelledArrayAndDoesItWhenAskedAgain)
{
    const std::string file = sweep("cancelled.json", 2), out = (folder / "cancelled").string();
    FollowingBatch follower(file, out, "--slurm-args --hold");
    const auto waiting = [] { return run_line("squeue --noheader --array --states=PENDING").out; };
    ASSERT_TRUE(wait_for(std::chrono::minutes(1), [&] { return std::ranges::count(waiting(), '\n') == 2; }));
    (void)run_line("scancel --user=root");
    EXPECT_EQ(follower.exit_code(), 1);
    EXPECT_EQ(jobs_in_state(out, "failed"), 2U);
    for (const fs::directory_entry& job : fs::directory_iterator(fs::path(out) / "jobs"))
        EXPECT_EQ(read(job.path() / "status.json")["reason"], "cancelled in the cluster's queue");
    EXPECT_EQ(run("batch " + file + " --out " + out + " --slurm").exit_code, 0);
    EXPECT_EQ(jobs_in_state(out, "done"), 2U);

    // The queue still lists the arrays of the folder that was there.
    fs::remove_all(out);
    EXPECT_EQ(run("batch " + file + " --out " + out + "/ --slurm").exit_code, 0);
    EXPECT_EQ(jobs_in_state(out, "done"), 2U);

    const std::string to_refuse = "--json batch " + file + " --out " + (folder / "refused").string() + " --slurm ";
    EXPECT_NE(run(to_refuse + "--slurm-args=--wait").error().find("cannot have this option"), std::string::npos);
    const CommandRun refused = run(to_refuse + "--slurm-args=--partition=nowhere");
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_NE(refused.error().find("nowhere"), std::string::npos) << refused.out;
}

TEST(SlurmBatchWithoutACluster, SaysWhatIsMissing)
{
    const fs::path folder = fs::path(testing::TempDir()) / "slurm_batch_alone";
    fs::remove_all(folder);
    fs::create_directories(folder);
    const std::string p = (folder / "p").string(), file = (folder / "c" / "case.json").string();
    ASSERT_EQ(run("phantom block --out " + p).exit_code, 0);
    ASSERT_EQ(run("import " + p + "/ct --labels " + p + "/labels.nrrd --out " + file).exit_code, 0);
    ASSERT_EQ(
        run("approach add " + file + " --points 0,0,-25 0,0,25 --target target --name straight --hooks 2 --opening 14")
            .exit_code,
        0);
    std::ofstream(folder / "sweep.json") << R"({"cases": ["c/case.json"]})";
    const std::string line = std::string("PATH=/nowhere ") + RETRACTOR_PROGRAM + " --json batch "
        + (folder / "sweep.json").string() + " --out " + (folder / "out").string() + " --slurm 2>/dev/null";
    const CommandRun refused = run_line(line);
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_NE(refused.error().find("this machine has no squeue"), std::string::npos) << refused.out;
    const std::string alone
        = "--json batch " + (folder / "sweep.json").string() + " --out " + (folder / "out").string() + " --job ";
    EXPECT_EQ(run(alone + "nobody").exit_code, 2);
    EXPECT_EQ(run(alone + "''").exit_code, 2);
}

} // namespace slurm_batch_test

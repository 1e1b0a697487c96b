// Batches as scripts see them: the built executable is run.

#include "tests/support/command_run.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace batch_test {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using retractor::test_support::CommandRun;

CommandRun run(const std::string& arguments)
{
    return retractor::test_support::run_line(std::string(RETRACTOR_PROGRAM) + " " + arguments + " 2>/dev/null");
}

Json read(const fs::path& file)
{
    std::ifstream in(file);
    return Json::parse(in, nullptr, false);
}

std::vector<std::string> lines_of(const fs::path& file)
{
    std::ifstream in(file);
    std::vector<std::string> lines;
    for (std::string line; std::getline(in, line);)
        lines.push_back(line);
    return lines;
}

/// A block with one approach that opens, and one whose opening no tissue bears.
class Batch : public testing::Test {
protected:
    static void SetUpTestSuite()
    {
        folder = fs::path(testing::TempDir()) / "batch";
        fs::remove_all(folder);
        const std::string p = (folder / "p").string(), file = (folder / "c" / "case.json").string();
        ASSERT_EQ(run("phantom block --out " + p).exit_code, 0);
        ASSERT_EQ(run("import " + p + "/ct --labels " + p + "/labels.nrrd --out " + file).exit_code, 0);
        const std::string add = "approach add " + file + " --points 0,0,-25 0,0,25 --target target --retract cavity ";
        ASSERT_EQ(run(add + "--name straight --hooks 2 --opening 14").exit_code, 0);
        ASSERT_EQ(run(add + "--name torn --hooks 2 --opening 60").exit_code, 0);
    }
    static std::string sweep(const std::string& name, const std::string& text)
    {
        const fs::path file = folder / name;
        std::ofstream(file) << text;
        return file.string();
    }
    static std::string out(const std::string& name) { return (folder / name).string(); }
    static inline fs::path folder;
};

const char* const kSweep = R"({"cases": ["c/case.json"], "variants": {"draft": ["--draft"]}, "render": false})";

TEST_F(Batch, DoesEveryJobAndListsTheFailedOnes)
{
    const std::string file = sweep("all.json", kSweep);
    const CommandRun first = run("--json batch " + file + " --out " + out("all"));
    EXPECT_EQ(first.exit_code, 1); // one of two fails
    const Json document = Json::parse(first.out);
    EXPECT_EQ(document["counts"]["done"], 1);
    EXPECT_EQ(document["counts"]["failed"], 1);
    EXPECT_EQ(document["skipped"], 0);
    EXPECT_EQ(document["jobs"][1]["name"], "c-torn-draft");
    EXPECT_NE(document["jobs"][1]["reason"].get<std::string>().find("do not use"), std::string::npos);
    const fs::path job = fs::path(out("all")) / "jobs" / "c-straight-draft";
    EXPECT_EQ(read(job / "status.json")["state"], "done");
    EXPECT_GT(read(job / "status.json")["peak_bytes"].get<double>(), 1e6);

    // The table has the numbers of the job's metrics.json, in the columns of its metrics.csv.
    const std::vector<std::string> summary = lines_of(fs::path(out("all")) / "summary.csv"),
                                   metrics = lines_of(job / "metrics.csv");
    ASSERT_EQ(summary.size(), 3U);
    ASSERT_EQ(metrics.size(), 2U);
    EXPECT_TRUE(summary[0].ends_with(metrics[0]));
    EXPECT_TRUE(summary[1].ends_with(metrics[1]));
    const double width = read(job / "metrics.json")["approaches"][0]["opening_width_mm"];
    EXPECT_NE(metrics[1].find(Json(width).dump()), std::string::npos);
    EXPECT_EQ(
        std::count(summary[1].begin(), summary[1].end(), ','), std::count(summary[0].begin(), summary[0].end(), ','));
    std::ifstream page(fs::path(out("all")) / "summary.html");
    const std::string html { std::istreambuf_iterator<char>(page), {} };
    EXPECT_NE(html.find("c-straight-draft"), std::string::npos);

    // The same again does nothing; a job that was killed half-way is done again, and only this one.
    const Json again = Json::parse(run("--json batch " + file + " --out " + out("all")).out);
    EXPECT_EQ(again["skipped"], 2);
    Json status = read(job / "status.json");
    status["state"] = "running";
    std::ofstream(job / "status.json") << status.dump();
    std::ofstream(job / "half-written.vtu") << "<";
    const auto untouched = fs::last_write_time(fs::path(out("all")) / "jobs" / "c-torn-draft" / "status.json");
    const Json resumed = Json::parse(run("--json batch " + file + " --out " + out("all")).out);
    EXPECT_EQ(resumed["skipped"], 1);
    EXPECT_EQ(resumed["counts"]["done"], 1);
    EXPECT_FALSE(fs::exists(job / "half-written.vtu"));
    EXPECT_EQ(fs::last_write_time(fs::path(out("all")) / "jobs" / "c-torn-draft" / "status.json"), untouched);

    // Other options make another job under the same name.
    const std::string other = sweep("other.json",
        R"({"cases": ["c/case.json"], "approaches": ["straight"], "variants": {"draft": ["--draft", "--edge", "9"]},
            "render": false})");
    EXPECT_EQ(Json::parse(run("--json batch " + other + " --out " + out("all")).out)["skipped"], 0);
}

TEST_F(Batch, GoesOnAfterItWasKilled)
{
    const std::string file = sweep("killed.json",
        R"({"cases": ["c/case.json"], "approaches": ["straight"], "render": false,
            "variants": {"a": ["--draft"], "b": ["--draft"], "c": ["--draft"]}})");
    const std::string folder_out = out("killed");
    const pid_t child = ::fork();
    if (child == 0) {
        ::execl(RETRACTOR_PROGRAM, RETRACTOR_PROGRAM, "batch", file.c_str(), "--out", folder_out.c_str(), "--jobs", "1",
            static_cast<char*>(nullptr));
        ::_exit(127);
    }
    const fs::path first = fs::path(folder_out) / "jobs" / "c-straight-a" / "status.json";
    for (int n = 0; n < 3000 && !fs::exists(first); ++n)
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    ASSERT_TRUE(fs::exists(first));
    EXPECT_EQ(run("batch " + file + " --out " + folder_out).exit_code, 2); // one batch at a time
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    const CommandRun resumed = run("--json batch " + file + " --out " + folder_out);
    EXPECT_EQ(resumed.exit_code, 0) << resumed.out;
    EXPECT_EQ(Json::parse(resumed.out)["counts"]["done"], 3);
    for (const char* name : { "a", "b", "c" })
        EXPECT_EQ(
            read(fs::path(folder_out) / "jobs" / (std::string("c-straight-") + name) / "status.json")["state"], "done");
}

TEST_F(Batch, PlansWithManyValuesOfStiffness)
{
    fs::copy(folder / "c", folder / "s", fs::copy_options::recursive);
    const std::string file = (folder / "s" / "case.json").string();
    ASSERT_EQ(run("approach remove " + file + " --name straight").exit_code, 0);
    ASSERT_EQ(run("approach remove " + file + " --name torn").exit_code, 0);
    const std::string add
        = "approach add " + file + " --points 0,0,-25 0,0,25 --target target --retract cavity --hooks 2 --region 0 ";
    ASSERT_EQ(run(add + "--name straight --opening 6").exit_code, 0);
    ASSERT_EQ(run(add + "--name narrow --opening 3").exit_code, 0);
    const CommandRun first
        = run("--json sensitivity " + file + " --out " + out("samples") + " --draft --samples 3 --seed 5");
    EXPECT_EQ(first.exit_code, 0) << first.out;
    const Json document = Json::parse(first.out);
    const Json& measures = document["approaches"][0]["measures"];
    EXPECT_EQ(measures["hook_force_N"]["samples"], 3);
    const double low = measures["hook_force_N"]["p5"], high = measures["hook_force_N"]["p95"];
    EXPECT_LT(low, high) << "softer and stiffer tissue";
    EXPECT_EQ(document["failed"], 0);
    EXPECT_EQ(document["ranking"]["samples"], 3);
    EXPECT_EQ(document["ranking"]["same_leader"], 3) << "a narrow opening shows less in tissue of any stiffness";
    // The force of a sample is the force of a plan with its factors.
    const fs::path sample = fs::path(out("samples")) / "jobs" / "sample_002-straight" / "metrics.json";
    ASSERT_TRUE(fs::exists(sample));
    const std::string factors = read(sample)["computed"]["stiffness_factors"];
    const CommandRun alone = run(
        "--json plan " + file + " --approach straight --draft --stiffness '" + factors + "' --out " + out("alone"));
    const double there = read(sample)["approaches"][0]["hook_force_N"],
                 here = Json::parse(alone.out)["approaches"][0]["hook_force_N"];
    constexpr double kSolver = 1e-3; // relative: what the solver leaves of the forces, from another start
    EXPECT_NEAR(there, here, kSolver * here);
    EXPECT_EQ(lines_of(fs::path(out("samples")) / "sensitivity.csv").size(), 1U + 4U * 2U);
    EXPECT_EQ(run("sensitivity " + file + " --out " + out("samples") + " --samples 0").exit_code, 2);
    // The case's own elements are the default, and drafts do not stand for them.
    ASSERT_EQ(run("approach remove " + file + " --name narrow").exit_code, 0);
    const CommandRun own = run("sensitivity " + file + " --out " + out("samples") + " --samples 1 --seed 5");
    EXPECT_EQ(own.exit_code, 0) << own.out;
    EXPECT_NE(own.out.find("0 plans of earlier runs"), std::string::npos) << own.out;
    EXPECT_EQ(read(fs::path(out("samples")) / "sensitivity.json")["draft"], false);
    EXPECT_EQ(read(fs::path(out("samples")) / "jobs" / "as_planned-straight"
                  / "metrics.json")["approaches"][0]["region"]["ended_by"],
        "given");
    const CommandRun wrong = run("--json plan " + file + " --draft --stiffness nothing=2 --out " + out("wrong"));
    EXPECT_EQ(wrong.exit_code, 2);
    EXPECT_NE(wrong.out.find("--stiffness nothing=2"), std::string::npos) << wrong.out;
}

TEST_F(Batch, SamplesGoOnAfterAProcessWasKilled)
{
    fs::copy(folder / "c", folder / "k", fs::copy_options::recursive);
    const std::string file = (folder / "k" / "case.json").string(), folder_out = out("killed_samples");
    ASSERT_EQ(run("approach remove " + file + " --name torn").exit_code, 0);
    ASSERT_EQ(run("approach remove " + file + " --name straight").exit_code, 0);
    ASSERT_EQ(run("approach add " + file
                  + " --points 0,0,-25 0,0,25 --target target --retract cavity --hooks 2 --name straight --opening 6")
                  .exit_code,
        0);
    const pid_t child = ::fork();
    if (child == 0) {
        const int nothing = ::open("/dev/null", O_RDWR);
        ::dup2(nothing, STDOUT_FILENO);
        ::dup2(nothing, STDERR_FILENO);
        ::execl(RETRACTOR_PROGRAM, RETRACTOR_PROGRAM, "sensitivity", file.c_str(), "--out", folder_out.c_str(),
            "--draft", "--samples", "3", "--seed", "5", "--jobs", "1", static_cast<char*>(nullptr));
        ::_exit(127);
    }
    const fs::path jobs = fs::path(folder_out) / "jobs", first = jobs / "as_planned-straight" / "status.json";
    for (int n = 0; n < 3000 && !fs::exists(first); ++n)
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    ASSERT_TRUE(fs::exists(first));
    // Its process plans the first sample.
    std::ifstream children("/proc/" + std::to_string(child) + "/task/" + std::to_string(child) + "/children");
    pid_t planning = 0;
    ASSERT_TRUE(children >> planning);
    ::kill(planning, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    ASSERT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 1) << "one is missing";
    std::size_t failed = 0;
    for (const fs::directory_entry& job : fs::directory_iterator(jobs))
        failed += read(job.path() / "status.json")["state"] == "failed" ? 1 : 0;
    EXPECT_EQ(failed, 1U) << "the others were planned by another process";
    const CommandRun again
        = run("--json sensitivity " + file + " --out " + folder_out + " --draft --samples 3 --seed 5 --jobs 1");
    EXPECT_EQ(again.exit_code, 0) << again.out;
    EXPECT_EQ(Json::parse(again.out)["failed"], 0);
    EXPECT_EQ(Json::parse(again.out)["approaches"][0]["measures"]["hook_force_N"]["samples"], 3);
}

TEST_F(Batch, RecordsChoicesAndAnswers)
{
    const std::string file = (folder / "c" / "case.json").string();
    EXPECT_EQ(run("choose " + file + " nobody --by A --why b").exit_code, 2);
    EXPECT_EQ(run("choose " + file + " straight --by A").exit_code, 2);
    EXPECT_FALSE(fs::exists(folder / "c" / "case.decisions.json"));
    EXPECT_EQ(run("choose " + file + " torn --by 'A. B.' --why 'first thought'").exit_code, 0);
    EXPECT_EQ(run("choose " + file + " straight --by 'A. B.' --why 'holds'").exit_code, 0);
    const Json choices = Json::parse(run("--json choose " + file).out)["choices"];
    ASSERT_EQ(choices.size(), 2U);
    EXPECT_EQ(choices[1]["approach"], "straight");
    const std::string points = "--points shape=4,location=5,quality=3,planning=4,crisis=4,necessity=";
    EXPECT_EQ(run("questionnaire " + file + " --by A " + points + "6").exit_code, 2);
    EXPECT_EQ(run("questionnaire " + file + " " + points + "5").exit_code, 2);
    EXPECT_EQ(run("questionnaire " + file + " --by A " + points + "5").exit_code, 0);
    EXPECT_EQ(run("questionnaire " + file + " --by B " + points + "1").exit_code, 0);
    const Json summary = Json::parse(run("--json questionnaire " + file).out);
    EXPECT_EQ(summary["questions"][5]["mean"], 3.0);
    EXPECT_EQ(run("questionnaire " + file + " --sheet " + out("sheet.html")).exit_code, 0);
    std::ifstream page(out("sheet.html"));
    const std::string html { std::istreambuf_iterator<char>(page), {} };
    EXPECT_NE(html.find("Crisis recognition"), std::string::npos);
    EXPECT_NE(html.find("Chosen: "), std::string::npos);
}

TEST_F(Batch, WritesAPlanAsDicom)
{
    const std::string file = (folder / "c" / "case.json").string(), plan = out("drawn");
    ASSERT_EQ(run("plan " + file + " --approach straight --draft --render --out " + plan).exit_code, 0);
    const CommandRun written = run("--json dicom " + file + " --plan " + plan + " --out " + out("dicom"));
    EXPECT_EQ(written.exit_code, 0) << written.out;
    EXPECT_TRUE(fs::exists(fs::path(out("dicom")) / "labels.dcm"));
    EXPECT_TRUE(fs::exists(fs::path(out("dicom")) / "straight-surgeon.dcm"));
    // The report needs a browser, which the tests do not install.
    EXPECT_TRUE(
        fs::exists(fs::path(out("dicom")) / "report.dcm") != Json::parse(written.out).contains("report_missing"));
    EXPECT_EQ(run("dicom " + file + " --plan " + plan + " --out " + out("other") + " --with-identity").exit_code, 2);
    // The labels come back by the import of labels.
    const CommandRun again = run("--json import " + (folder / "p" / "ct").string() + " --labels "
        + (fs::path(out("dicom")) / "labels.dcm").string() + " --out " + out("again/case.json"));
    EXPECT_EQ(again.exit_code, 0) << again.out;
}

TEST_F(Batch, NamesWhatIsWrongInASweep)
{
    struct Wrong {
        const char* text;
        const char* says;
    };
    for (const Wrong& wrong :
        { Wrong { "[]", "a sweep is a JSON object" }, Wrong { "{\"cases\": [", "a sweep is a JSON" },
            Wrong { R"({"aproaches": []})", "unknown key" }, Wrong { R"({"approaches": []})", "names no case" },
            Wrong { R"({"cases": ["d/case.json"]})", "d/case.json: " },
            Wrong { R"({"cases": [7]})", "a text is expected" },
            Wrong { R"({"cases": ["c/case.json"], "approaches": ["nobody"]})", "there is no approach \"nobody\"" },
            Wrong { R"({"cases": ["c/case.json"], "variants": {"a": ["--out=x"]}})", "gives the option" },
            Wrong { R"({"cases": ["c/case.json"], "render": 1})", "true or false" },
            Wrong { R"({"cases": []})", "no job" } }) {
        const CommandRun refused = run("--json batch " + sweep("wrong.json", wrong.text) + " --out " + out("wrong"));
        EXPECT_EQ(refused.exit_code, 2) << wrong.text;
        EXPECT_NE(refused.error().find(wrong.says), std::string::npos) << refused.out;
        EXPECT_FALSE(fs::exists(out("wrong")));
    }
    // A wrong option of a plan fails its own job only.
    const Json document = Json::parse(run("--json batch "
        + sweep("option.json",
            R"({"cases": ["c/case.json"], "approaches": ["straight"], "render": false,
                "variants": {"good": ["--draft"], "bad": ["--drft"]}})")
        + " --out " + out("option"))
                                          .out);
    EXPECT_EQ(document["counts"]["done"], 1);
    EXPECT_EQ(document["counts"]["failed"], 1);
    EXPECT_NE(document["jobs"][1]["reason"].get<std::string>().find("did you mean '--draft'"), std::string::npos);
}

} // namespace batch_test

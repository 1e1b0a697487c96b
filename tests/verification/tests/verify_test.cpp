// `retractor-verify` as scripts use it: its output, its files, and its exit code when an answer is wrong.

#include "tests/support/command_run.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace verify_test {

namespace fs = std::filesystem;
using retractor::test_support::CommandRun;
using Json = nlohmann::json;

CommandRun run(const std::string& arguments)
{
    return retractor::test_support::run_line(std::string(RETRACTOR_VERIFY_PROGRAM) + " " + arguments + " 2>/dev/null");
}

CommandRun verify(const std::string& arguments) { return run("--json " + arguments); }

fs::path empty_folder(const char* name)
{
    const fs::path folder = fs::path(testing::TempDir()) / "verify_command" / name;
    fs::remove_all(folder);
    fs::create_directories(folder);
    return folder;
}

std::string content(const fs::path& file)
{
    std::ifstream in(file, std::ios::binary);
    return { std::istreambuf_iterator<char>(in), {} };
}

/// FEBio's te01 with this shear parameter: one element, whose published displacement belongs to the parameter 1.
void write_te01(const fs::path& data, const std::string& c1)
{
    const auto held = [](const std::string& set, const std::string& axis) {
        std::string text = "<bc node_set=\"" + set + "\" type=\"zero displacement\">";
        for (const std::string other : { "x", "y", "z" })
            text += "<" + other + "_dof>" + (other == axis ? "1" : "0") + "</" + other + "_dof>";
        return text + "</bc>";
    };
    fs::create_directories(data / "fem" / "febio");
    std::ofstream(data / "fem" / "febio" / "te01.feb")
        << "<febio_spec version=\"4.0\"><Material><material id=\"1\" name=\"M\" type=\"Mooney-Rivlin\">"
        << "<density>1</density><k>1000</k><c1>" << c1 << "</c1><c2>0</c2></material></Material>"
        << "<Mesh><Nodes name=\"N\"><node id=\"1\">0,0,0</node><node id=\"2\">1,0,0</node><node id=\"3\">0,1,0</node>"
        << "<node id=\"4\">0,0,1</node></Nodes><Elements type=\"tet4\" name=\"P\"><elem "
           "id=\"1\">1,2,3,4</elem></Elements>"
        << "<NodeSet name=\"Z\">1, 2, 3</NodeSet><NodeSet name=\"Y\">1, 2, 4</NodeSet><NodeSet name=\"X\">1, 3, "
           "4</NodeSet>"
        << "<NodeSet name=\"F\">4</NodeSet></Mesh>"
        << "<MeshDomains><SolidDomain name=\"P\" mat=\"M\"/></MeshDomains><Boundary>" << held("Z", "z")
        << held("Y", "y") << held("X", "x")
        << "</Boundary><Loads><nodal_load name=\"L\" node_set=\"F\" type=\"nodal_force\">"
        << "<relative>0</relative><value lc=\"1\">0,0,1</value></nodal_load></Loads>"
        << "<LoadData><load_controller id=\"1\" name=\"LC\" type=\"loadcurve\"><interpolate>LINEAR</interpolate>"
        << "<extend>CONSTANT</extend><points><pt>0,0</pt><pt>1,-0.5</pt></points></load_controller></LoadData>"
        << "</febio_spec>";
}

TEST(VerifyCommand, WritesATableAsJsonAndCsvAndAChart)
{
    const fs::path out = empty_folder("cook");
    const CommandRun run = verify("--problem \"Cook's membrane\" --out " + out.string());
    ASSERT_EQ(run.exit_code, 0) << run.out;
    EXPECT_EQ(run.json().at("failed"), 0);
    const Json rows = Json::parse(content(out / "verify.json")).at("results");
    constexpr std::size_t kRows = 12; // four elements, three meshes each
    ASSERT_EQ(rows.size(), kRows);
    for (std::size_t i = 2; i < kRows; i += 3) {
        EXPECT_EQ(rows[i].at("outcome"), "ok") << rows[i].dump();
        EXPECT_NE(rows[i].at("order_verdict"), "") << rows[i].dump();
        EXPECT_GT(rows[i].at("seconds").get<double>(), 0.0);
        // a finer mesh has a smaller error
        EXPECT_LT(rows[i].at("error").get<double>(), rows[i - 2].at("error").get<double>());
    }
    const std::string csv = content(out / "verify.csv");
    EXPECT_EQ(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')), kRows + 1);
    EXPECT_EQ(csv.substr(0, 8), "problem,");
    const std::string picture = content(out / "error_against_time.png");
    EXPECT_EQ(picture.substr(1, 3), "PNG");
    EXPECT_EQ(picture.substr(picture.size() - 8, 4), "IEND");
}

TEST(VerifyCommand, ExitsWithOneWhenAnAnswerIsNotWithinItsBound)
{
    const fs::path good = empty_folder("good"), wrong = empty_folder("wrong");
    write_te01(good, "1");
    write_te01(wrong, "1.001");
    const CommandRun right = verify("--problem FEBio --data " + good.string());
    EXPECT_EQ(right.exit_code, 0) << right.out;
    EXPECT_EQ(right.json().at("results").at(0).at("outcome"), "ok");
    const CommandRun failed = verify("--problem FEBio --data " + wrong.string());
    EXPECT_EQ(failed.exit_code, 1) << failed.out;
    EXPECT_EQ(failed.json().at("failed"), 1);
    EXPECT_EQ(failed.json().at("results").at(0).at("outcome"), "FAILED");
}

TEST(VerifyCommand, MissingFilesAreSkippedByNameAndUnknownProblemsRefused)
{
    const CommandRun none
        = verify("--problem FEBio --problem \"CalculiX beam10p\" --data " + empty_folder("none").string());
    EXPECT_EQ(none.exit_code, 0) << none.out;
    EXPECT_EQ(none.json().at("skipped"), none.json().at("results").size());
    EXPECT_NE(none.out.find("te02.feb is not there"), std::string::npos);
    const CommandRun unknown = verify("--problem nothing");
    EXPECT_EQ(unknown.exit_code, 2);
    EXPECT_NE(unknown.error().find("Cook's membrane"), std::string::npos) << "says what there is";
}

TEST(VerifyCommand, HelpHasAnExample)
{
    const CommandRun help = run("--help");
    EXPECT_EQ(help.exit_code, 0);
    EXPECT_NE(help.out.find("Example: retractor-verify"), std::string::npos) << help.out;
    EXPECT_EQ(run("--suite nothing").exit_code, 2);
}

TEST(VerifyCommand, SaysLastWhatItDidNotCheckAndWhy)
{
    const CommandRun skipped = run("--problem FEBio --data " + empty_folder("no_files").string());
    EXPECT_EQ(skipped.exit_code, 0) << "nothing failed";
    const std::size_t end = skipped.out.find_last_not_of('\n');
    const std::string last = skipped.out.substr(skipped.out.rfind('\n', end) + 1);
    EXPECT_EQ(last.rfind("NOT CHECKED: 4 of 4 rows: te01.feb is not there", 0), 0U) << last;
    EXPECT_EQ(run("--problem \"patch test\"").out.find("NOT CHECKED"), std::string::npos);
}

} // namespace verify_test

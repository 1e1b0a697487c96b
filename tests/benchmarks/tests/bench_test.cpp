// retractor-bench as scripts use it: its measurements, its output and its exit code.

#include "tests/support/command_run.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <map>
#include <set>
#include <string>

namespace bench_test {

using retractor::test_support::CommandRun;
using Json = nlohmann::json;

CommandRun run(const std::string& arguments)
{
    return retractor::test_support::run_line(std::string(RETRACTOR_BENCH_PROGRAM) + " " + arguments + " 2>/dev/null");
}

TEST(BenchCommand, HelpHasAnExampleForEveryCommand)
{
    for (const char* command : { "palpate", "cut", "gape", "open", "drag", "springs", "spheres", "servo", "segment" }) {
        const CommandRun help = run(std::string(command) + " --help");
        EXPECT_EQ(help.exit_code, 0) << command;
        EXPECT_NE(help.out.find(std::string("Example: retractor-bench ") + command), std::string::npos) << command;
    }
}

TEST(BenchCommand, ListsOfSizesAreWrittenWithCommasOrSpaces)
{
    for (const char* sizes : { "12k,9k", "12k 9k" })
        EXPECT_EQ(run(std::string("--json open --sizes ") + sizes).error().rfind("--sizes: 9k not in", 0), 0U) << sizes;
}

TEST(BenchCommand, CutMeasuresWhatTheCutReports)
{
    const CommandRun bench = run("cut --small --no-thorax --repeats 1 --json");
    ASSERT_EQ(bench.exit_code, 0) << bench.out;
    const Json rows = bench.json().at("results");
    ASSERT_EQ(rows.size(), 2u); // two boxes
    for (const Json& row : rows) {
        EXPECT_GT(row.at("cut_elements").get<int>(), 100);
        EXPECT_NEAR(row.at("min_dihedral_before_deg").get<double>(), 45.0, 1e-6);
        EXPECT_GT(row.at("stroke_ms").get<double>(), 0.0);
        EXPECT_GT(row.at("step_ms_median").get<double>(), 0.0);
        EXPECT_LE(row.at("lip_to_blade_max").get<double>(), 0.1);
        EXPECT_LE(row.at("mean_increase").get<double>(), 3.6);
        EXPECT_GE(row.at("min_dihedral_deg").get<double>(), 5.0);
        EXPECT_GE(row.at("p01_dihedral_deg").get<double>(), 8.0);
    }
    // The cut is the same in every box.
    EXPECT_EQ(rows[0].at("cut_elements"), rows[1].at("cut_elements"));
    EXPECT_EQ(rows[0].at("mean_increase"), rows[1].at("mean_increase"));
    EXPECT_EQ(run("cut --repeats 0").exit_code, 2);
    EXPECT_EQ(run("").exit_code, 2);
}

TEST(BenchCommand, SegmentMeasuresTheOverlapWithTheTruth)
{
    const CommandRun bench = run("segment --quick --json");
    ASSERT_EQ(bench.exit_code, 0) << bench.out;
    const Json row = bench.json().at("results").at(0);
    EXPECT_EQ(row.at("dice").size(), 31U) << "24 ribs and 7 other structures";
    double least = 1.0, sum = 0.0;
    for (const auto& [name, dice] : row.at("dice").items()) {
        EXPECT_LE(dice.get<double>(), 1.0) << name;
        if (!name.starts_with("rib_"))
            continue;
        least = std::min(least, dice.get<double>());
        sum += dice.get<double>();
    }
    EXPECT_EQ(row.at("least_rib").get<double>(), least);
    EXPECT_EQ(row.at("dice").at(row.at("worst_rib").get<std::string>()).get<double>(), least);
    constexpr double kRoundOff = 1e-12;
    EXPECT_NEAR(row.at("mean_rib").get<double>(), sum / 24.0, kRoundOff);
    EXPECT_GT(row.at("dice").at("lung_left").get<double>(), 0.9);
    EXPECT_GT(row.at("mean_rib").get<double>(), 0.5) << "on a grid of 3 mm, where ribs are three voxels high";
}

TEST(BenchCommand, OpenAgreesWithAFullRebuildOfItsOwnProcess)
{
    const CommandRun bench = run("open --sizes 12k --repeats 1 --json");
    ASSERT_EQ(bench.exit_code, 0) << bench.out;
    const Json row = bench.json().at("results").at(0);
    EXPECT_EQ(row.at("tets").get<int>(), 12000);
    EXPECT_LE(row.at("rel_diff").get<double>(), 1e-6);
    EXPECT_LE(row.at("residual").get<double>(), 1e-8);
    EXPECT_LE(row.at("drag_residual").get<double>(), 1e-8);
    for (const char* key : { "step_ms_median", "step_ms_p95", "stroke_ms_median", "full_rebuild_ms_median",
             "step_speedup", "stroke_speedup", "attach_ms", "drag_ms_4", "drag_ms_8", "assemble_ms", "rss_mb",
             "nonlinear_fps", "nonlinear_rel_diff", "nonlinear_opening_diff", "final_ms" })
        EXPECT_GT(row.at(key).get<double>(), 0.0) << key;
    EXPECT_LE(row.at("nonlinear_rel_diff").get<double>(), 0.02); // relative to the fully nonlinear answer
    EXPECT_TRUE(row.at("final_settled").get<bool>());
    EXPECT_LE(row.at("final_residual").get<double>(), 1e-6);
    EXPECT_EQ(run("open --sizes 5k").exit_code, 2);
}

TEST(BenchCommand, GapeComparesSpringsAndFiniteElementsWithTheClosedForm)
{
    const CommandRun bench = run("gape --quick --json");
    ASSERT_EQ(bench.exit_code, 0) << bench.out;
    const Json rows = bench.json().at("results");
    std::map<std::string, std::set<double>> strains;
    for (const Json& row : rows) {
        const double strain = row.at("strain"), right = row.at("closed_form_mm");
        EXPECT_NEAR(right, 160.0 * strain, 1e-9);
        EXPECT_NEAR(row.at("gape_mm").get<double>(), right, 0.03 * right) << row;
        EXPECT_GT(row.at("ms").get<double>(), 0.0);
        strains[row.at("model")].insert(strain);
    }
    EXPECT_EQ(strains.at("springs"), (std::set<double> { 0.02, 0.04, 0.06 }));
    EXPECT_EQ(strains.at("fem_linear"), strains.at("springs"));
}

TEST(BenchCommand, CutSoakTakesEveryCutBack)
{
    const CommandRun soak = run("cut --soak 30 --soak-body 12k --json");
    const Json json = soak.json();
    EXPECT_EQ(json.at("cuts"), 30);
    ASSERT_EQ(json.at("flatness").size(), 3u);
    bool flat = true; // depends on the load of the machine; the exit code must agree
    for (const Json& line : json.at("flatness")) {
        EXPECT_GT(line.at("first").get<double>() + line.at("last").get<double>(), 0.0) << line.dump();
        EXPECT_EQ(line.at("met").get<bool>(), line.at("growth").get<double>() <= 0.25) << line.dump();
        flat = flat && line.at("met").get<bool>();
    }
    EXPECT_EQ(json.at("flat").get<bool>(), flat);
    EXPECT_EQ(soak.exit_code, flat ? 0 : 1) << soak.out;
    EXPECT_EQ(json.at("results").size(), 10u);
    EXPECT_TRUE(json.at("undo_exact").get<bool>());
    EXPECT_TRUE(json.at("redo_exact").get<bool>());
    EXPECT_GT(json.at("results").back().at("tets").get<int>(), 12000);
    EXPECT_GT(json.at("results").back().at("journal_MiB").get<double>(), 0.0);
    EXPECT_EQ(run("cut --soak 30 --soak-body heart").exit_code, 2);
}

} // namespace bench_test

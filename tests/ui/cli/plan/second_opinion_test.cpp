#include "ui/cli/plan/second_opinion.h"

#include "mesh/base/error.h"
#include "tests/support/wounds/hooked_block.h"
#include "ui/cli/framework/run_program.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

namespace retractor::ui::cli {
namespace second_opinion_test {

    namespace fs = std::filesystem;
    using namespace std::chrono_literals;

    constexpr auto kPlenty = 300s;

    fs::path empty_folder(const std::string& name)
    {
        fs::path folder = fs::path(::testing::TempDir()) / ("second_opinion_" + name);
        fs::remove_all(folder);
        fs::create_directories(folder);
        return folder;
    }

    /// A program that stands in for a ccx that goes wrong.
    fs::path script(const fs::path& folder, const std::string& text)
    {
        const fs::path file = folder / "ccx";
        std::ofstream(file) << "#!/bin/sh\n" << text << "\n";
        fs::permissions(file, fs::perms::owner_all);
        return file;
    }

    TEST(SecondOpinionTest, CalculixAgreesToItsSevenDigits)
    {
        const fs::path ccx = program_on_path("ccx");
        if (ccx.empty())
            GTEST_SKIP() << "CalculiX (ccx) is not installed: apt install calculix-ccx";
        const fs::path folder = empty_folder("agrees");
        for (const int nodes_per_tet : { 4, 10 }) { // two tissues, two beds, two hooks
            const fem::ElasticProblem problem = retractor::test_support::hooked_block(2, nodes_per_tet);
            const planner::SecondOpinion opinion = second_opinion(problem, ccx, folder, "block", kPlenty, {});
            EXPECT_EQ(opinion.status, "agrees") << opinion.message;
            EXPECT_LE(opinion.displacement_difference, kReferenceAgreement);
            EXPECT_LE(opinion.force_difference, kReferenceAgreement);
            EXPECT_GT(opinion.displacement_difference, 0.0); // two programs, not one
            EXPECT_GT(opinion.largest_displacement_mm, 4.0);
            ASSERT_EQ(opinion.hook_forces_N.size(), 2u);
            EXPECT_GT(opinion.hook_forces_N[0], 0.1);
            EXPECT_FALSE(fs::exists(folder / "block-ccx"));
        }
    }

    TEST(SecondOpinionTest, CalculixIsGivenTheHingesOfBones)
    {
        const fs::path ccx = program_on_path("ccx");
        if (ccx.empty())
            GTEST_SKIP() << "CalculiX (ccx) is not installed: apt install calculix-ccx";
        for (const int nodes_per_tet : { 4, 10 }) {
            fem::ElasticProblem problem = retractor::test_support::hooked_block(2, nodes_per_tet);
            const planner::SecondOpinion free
                = second_opinion(problem, ccx, empty_folder("hinges"), "block", kPlenty, {});
            fem::Hinge hinge { .name = "rib", .axis = Vec3(0.6, 0.0, 0.8), .stiffness = 1e4, .toe = 0.01, .edges = {} };
            for (TetId t = 0; t < static_cast<TetId>(problem.mesh.tet_count()); ++t)
                for (const auto& [a, b] : { std::pair(0, 1), std::pair(2, 3) }) {
                    const auto nodes = problem.mesh.tet(t);
                    const VertexId from = nodes[static_cast<std::size_t>(a)], to = nodes[static_cast<std::size_t>(b)];
                    const Vec3 d = point_at(problem.mesh.vertices, to) - point_at(problem.mesh.vertices, from);
                    if (hinge.axis.cross(d).norm() > 0.5 * d.norm())
                        hinge.edges.push_back({ from, to, 1.0 });
                }
            for (fem::HingeEdge& edge : hinge.edges)
                edge.share = 1.0 / static_cast<double>(hinge.edges.size());
            problem.supports.hinges = { hinge };
            const planner::SecondOpinion opinion
                = second_opinion(problem, ccx, empty_folder("hinges"), "block", kPlenty, {});
            EXPECT_EQ(opinion.status, "agrees") << opinion.message << opinion.displacement_difference;
            EXPECT_LE(opinion.displacement_difference, kReferenceAgreement);
            EXPECT_LE(opinion.force_difference, kReferenceAgreement);
            EXPECT_GT(std::abs(opinion.hook_forces_N[0] - free.hook_forces_N[0]), 0.01);
        }
    }

    TEST(SecondOpinionTest, CalculixIsGivenTheTensionThatTheCutSetFree)
    {
        const fs::path ccx = program_on_path("ccx");
        if (ccx.empty())
            GTEST_SKIP() << "CalculiX (ccx) is not installed: apt install calculix-ccx";
        for (const int nodes_per_tet : { 4, 10 }) { // on all of the surface: held, hooked and free
            fem::ElasticProblem problem = retractor::test_support::hooked_block(2, nodes_per_tet);
            const planner::SecondOpinion slack
                = second_opinion(problem, ccx, empty_folder("loads"), "block", kPlenty, {});
            for (const mesh::TetFace& face : mesh::boundary_faces(problem.mesh))
                problem.loads.push_back({ face, Vec3(0.001, 0.0, 0.002) });
            const planner::SecondOpinion opinion
                = second_opinion(problem, ccx, empty_folder("loads"), "block", kPlenty, {});
            EXPECT_EQ(opinion.status, "agrees") << opinion.message << opinion.displacement_difference;
            EXPECT_LE(opinion.force_difference, kReferenceAgreement);
            EXPECT_GT(std::abs(opinion.hook_forces_N[0] - slack.hook_forces_N[0]), 0.01);
        }
    }

    TEST(SecondOpinionTest, CalculixIsGivenPressureAsAtRest)
    {
        const fs::path ccx = program_on_path("ccx");
        if (ccx.empty())
            GTEST_SKIP() << "CalculiX (ccx) is not installed: apt install calculix-ccx";
        for (const int nodes_per_tet : { 4, 10 }) {
            fem::ElasticProblem problem = retractor::test_support::hooked_block(2, nodes_per_tet);
            const planner::SecondOpinion slack
                = second_opinion(problem, ccx, empty_folder("pressed"), "block", kPlenty, {});
            std::vector<mesh::TetFace> faces = mesh::boundary_faces(problem.mesh);
            faces.resize(faces.size() / 2);
            problem.pressures = { { "gas", std::move(faces), 0.002 } };
            const planner::SecondOpinion opinion
                = second_opinion(problem, ccx, empty_folder("pressed"), "block", kPlenty, {});
            EXPECT_EQ(opinion.status, "agrees") << opinion.message << opinion.displacement_difference;
            EXPECT_LE(opinion.force_difference, kReferenceAgreement);
            EXPECT_GT(std::abs(opinion.hook_forces_N[0] - slack.hook_forces_N[0]), 0.01);
        }
    }

    TEST(SecondOpinionTest, ADifferenceIsSeen)
    {
        const fs::path ccx = program_on_path("ccx");
        if (ccx.empty())
            GTEST_SKIP() << "CalculiX (ccx) is not installed: apt install calculix-ccx";
        // A ccx that is given a stiffer tissue than we are.
        const fs::path folder = empty_folder("differs");
        const fs::path liar
            = script(folder, "sed -i 's/^0.04,0.45/0.0401,0.45/' wound.inp; exec " + ccx.string() + " \"$@\"");
        const planner::SecondOpinion opinion
            = second_opinion(retractor::test_support::hooked_block(2, 4), liar, folder, "block", kPlenty, {});
        EXPECT_EQ(opinion.status, "differs") << opinion.message;
        EXPECT_GT(opinion.force_difference, 1e-4);
    }

    TEST(SecondOpinionTest, AProgramThatFailsIsAStatusThatSaysWhy)
    {
        const fem::ElasticProblem problem = retractor::test_support::hooked_block(2, 4);
        const fs::path folder = empty_folder("fails");
        const auto ask = [&](const std::string& text, std::chrono::milliseconds limit) {
            return second_opinion(problem, script(folder, text), folder, "block", limit, {});
        };
        planner::SecondOpinion opinion = ask("echo ' *ERROR in something: singular'; echo bye; exit 3", kPlenty);
        EXPECT_EQ(opinion.status, "failed");
        EXPECT_NE(opinion.message.find("exit code 3: *ERROR in something: singular"), std::string::npos)
            << opinion.message;
        EXPECT_TRUE(fs::exists(folder / "block-ccx" / "ccx.log"));
        EXPECT_TRUE(fs::exists(folder / "block-ccx" / "wound.inp"));
        opinion = ask("echo stopped; exit 0", kPlenty); // as ccx does after many errors
        EXPECT_EQ(opinion.status, "failed");
        EXPECT_NE(opinion.message.find("no displacement for node"), std::string::npos) << opinion.message;
        EXPECT_NE(opinion.message.find("stopped"), std::string::npos) << opinion.message;
        opinion = ask("kill -SEGV $$", kPlenty);
        EXPECT_EQ(opinion.status, "failed");
        EXPECT_NE(opinion.message.find("died"), std::string::npos) << opinion.message;
        opinion = ask("sleep 60", 300ms);
        EXPECT_EQ(opinion.status, "failed");
        EXPECT_NE(
            opinion.message.find("did not end within 0.3 s: give it more with --reference-limit"), std::string::npos)
            << opinion.message;
    }

    TEST(SecondOpinionTest, CancellingEndsTheOtherProgram)
    {
        const fs::path folder = empty_folder("cancelled");
        const fs::path slow = script(folder, "touch started; sleep 60");
        std::atomic<bool> cancel { false };
        Job job;
        job.cancel = &cancel;
        job.on_progress = [&](std::string_view stage, double done) {
            if (stage == "second opinion" && done > 0.0)
                cancel = true; // just before ccx begins
        };
        EXPECT_THROW(
            (void)second_opinion(retractor::test_support::hooked_block(2, 4), slow, folder, "block", kPlenty, job),
            SolverError);
    }

    TEST(SecondOpinionTest, AMissingProgramSaysHowToGetIt)
    {
        const std::string path = std::getenv("PATH");
        ::setenv("PATH", "/nothing/here", 1);
        try {
            (void)find_calculix();
            ADD_FAILURE() << "found";
        } catch (const IoError& error) {
            EXPECT_NE(std::string(error.what()).find("apt install calculix-ccx"), std::string::npos);
        }
        ::setenv("PATH", path.c_str(), 1);
        EXPECT_TRUE(program_on_path("sh").is_absolute());
        EXPECT_TRUE(program_on_path("no-such-program").empty());
    }

    TEST(SecondOpinionTest, ExportsAreWrittenBesideEachOther)
    {
        const fs::path folder = empty_folder("exports");
        const fem::ElasticProblem problem = retractor::test_support::hooked_block(2, 10);
        EXPECT_EQ(export_problem(problem, "ccx", folder, "block"), folder / "block.inp");
        EXPECT_EQ(export_problem(problem, "feb", folder, "block"), folder / "block.feb");
        EXPECT_GT(fs::file_size(folder / "block.inp"), 10000u);
        EXPECT_GT(fs::file_size(folder / "block.feb"), 10000u);
        EXPECT_THROW((void)export_problem(problem, "feb", folder / "none", "block"), IoError);
    }

} // namespace second_opinion_test
} // namespace retractor::ui::cli

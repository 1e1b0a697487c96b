// A journal that ends in the middle of a freehand stroke, as a crash leaves it, replayed by the built executable.

#include "tests/support/command_run.h"

#include "mesh/cutting/cut_journal.h"
#include "mesh/generation/hybrid_model.h"
#include "planner/case/case_io.h"
#include "planner/case/patient.h"
#include "tests/support/block_case.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>

namespace retractor::ui {
namespace cut_replay_test {

    namespace fs = std::filesystem;

    class CutReplay : public testing::Test {
    protected:
        /// Three steps of 5 mm along the planned line, 12 mm deep.
        void SetUp() override
        {
            const datasets::Phantom phantom = datasets::make_block_phantom(test_support::small_block());
            planner::Case planned_case = test_support::block_case("open_stroke", phantom);
            planner::Approach approach
                = test_support::block_approach(phantom.labels, Eigen::Isometry3d::Identity(), 20.0);
            approach.hooks.clear(); // the mesh would be finer round their patches
            planned_case.approaches = { approach };
            planner::write_case(planned_case);
            case_file_ = (planned_case.folder / "case.json").string();
            journal_ = (planned_case.folder / "open.jsonl").string();
            out_ = (planned_case.folder / "out").string();
            fs::remove(journal_);
            fs::remove_all(out_);
            planner::Patient patient(planned_case);
            const mesh::HybridModel model = mesh::build_hybrid_model(
                *patient.labels(), planner::mesh_sizing_of(approach, planned_case.label_table));
            ASSERT_EQ(model.status, mesh::MeshStatus::done);
            wall_ = model.wall;
            uncut_ = wall_.tet_count();
            mesh::CutSession session = mesh::start_journal(journal_, wall_);
            blade_ = { .line = { approach.incision[1] }, .directions = { approach.directions[1] } };
            blade_.depth_mm = 12.0;
            for (int step = 0; step < 3; ++step) {
                grow(5.0);
                (void)session.extend_stroke(blade_);
            }
            ASSERT_TRUE(session.stroke_open());
        }
        void grow(double mm)
        {
            blade_.line.push_back(blade_.line.back() + Vec3(0.0, 0.0, mm));
            blade_.directions.push_back(blade_.directions.back());
        }
        std::string journal_bytes() const
        {
            std::ifstream file(journal_, std::ios::binary);
            return { std::istreambuf_iterator<char>(file), {} };
        }
        test_support::CommandRun replay(const std::string& rest) const
        {
            return test_support::run_line(std::string(RETRACTOR_PROGRAM) + " --json cut " + case_file_
                + " --approach straight --out " + out_ + " --replay " + journal_ + " " + rest + " 2>/dev/null");
        }
        std::string case_file_, journal_, out_;
        mesh::TetMesh wall_;
        mesh::Blade blade_;
        std::size_t uncut_ = 0;
    };

    TEST_F(CutReplay, SaysThatAStrokeIsOpenAndHowToEndIt)
    {
        const test_support::CommandRun as_it_is = replay("");
        ASSERT_EQ(as_it_is.exit_code, 0) << as_it_is.out;
        const std::string message = as_it_is.json().at("message").get<std::string>();
        EXPECT_NE(message.find("--finish"), std::string::npos) << message;
        EXPECT_NE(message.find("--abandon"), std::string::npos) << message;
        EXPECT_EQ(as_it_is.json().at("cuts").get<int>(), 0);
        EXPECT_GT(as_it_is.json().at("tets").get<std::size_t>(), uncut_);
        const test_support::CommandRun undone = replay("--undo 1");
        EXPECT_EQ(undone.exit_code, 2);
        EXPECT_NE(undone.error().find("add --finish or --abandon"), std::string::npos) << undone.out;
        EXPECT_EQ(replay("--finish --abandon").exit_code, 2);
    }

    TEST_F(CutReplay, FinishesItAndTheJournalToo)
    {
        const test_support::CommandRun finished = replay("--finish");
        ASSERT_EQ(finished.exit_code, 0) << finished.out;
        EXPECT_EQ(finished.json().at("cuts").get<int>(), 1);
        // 15 x 12 mm; the knife's promise is a tenth of an edge, of 5 mm.
        EXPECT_NEAR(finished.json().at("report").at("lip_area_mm2").get<double>(), 180.0, 0.5 * (15.0 + 2.0 * 12.0));
        EXPECT_EQ(replay("").json().at("cuts").get<int>(), 0) << "without --journal the file stays as it is";
        const test_support::CommandRun kept = replay("--journal " + journal_ + " --finish --undo 1");
        ASSERT_EQ(kept.exit_code, 0) << kept.out;
        EXPECT_EQ(kept.json().at("tets").get<std::size_t>(), uncut_);
        EXPECT_EQ(replay("--finish").exit_code, 2) << "it is finished";
    }

    TEST_F(CutReplay, RefusesToUndoMoreCutsThanThereAreBeforeItWrites)
    {
        const std::string before = journal_bytes();
        ASSERT_FALSE(before.empty());
        for (const auto& [rest, refusal] : { std::pair { " --finish --undo 2", "there is only 1 cut to undo" },
                 { " --abandon --undo 1", "there is no cut to undo" } }) {
            const test_support::CommandRun run = replay("--journal " + journal_ + rest);
            EXPECT_EQ(run.exit_code, 2) << run.out;
            EXPECT_NE(run.error().find(refusal), std::string::npos) << run.out;
            EXPECT_EQ(journal_bytes(), before) << rest;
        }
    }

    TEST_F(CutReplay, SaysHowToGoOnWhenItCannotBeFinished)
    {
        {
            mesh::ReplayedJournal on = mesh::open_journal(journal_, wall_);
            grow(0.01); // crosses nothing more; but its end has to divide elements
            ASSERT_EQ(on.session.extend_stroke(blade_, { .element_limit = 1 }).status, mesh::CutStatus::done);
        }
        const std::string before = journal_bytes();
        const test_support::CommandRun run = replay("--finish --journal " + journal_);
        EXPECT_NE(run.exit_code, 0);
        EXPECT_NE(run.error().find("element_limit"), std::string::npos) << run.out;
        EXPECT_NE(run.error().find("--abandon takes the stroke back"), std::string::npos) << run.out;
        EXPECT_EQ(journal_bytes(), before);
        EXPECT_EQ(replay("--abandon --journal " + journal_).exit_code, 0) << "as it says";
    }

    TEST_F(CutReplay, AStrokeThatMissedIsOverWhenItIsFinished)
    {
        fs::remove(journal_);
        {
            mesh::CutSession session = mesh::start_journal(journal_, wall_);
            for (Vec3& p : blade_.line)
                p.x() += 1000.0;
            ASSERT_EQ(session.extend_stroke(blade_).status, mesh::CutStatus::done);
            ASSERT_TRUE(session.stroke_open());
        }
        const test_support::CommandRun run = replay("--finish --journal " + journal_);
        EXPECT_NE(run.exit_code, 0);
        EXPECT_NE(run.error().find("misses the body"), std::string::npos) << run.out;
        EXPECT_EQ(run.error().find("--abandon"), std::string::npos) << run.out;
        EXPECT_NE(replay("--abandon").error().find("no stroke is open"), std::string::npos);
    }

    TEST_F(CutReplay, TakesItBackAndTheJournalToo)
    {
        const test_support::CommandRun abandoned = replay("--abandon --journal " + journal_);
        ASSERT_EQ(abandoned.exit_code, 0) << abandoned.out;
        EXPECT_EQ(abandoned.json().at("cuts").get<int>(), 0);
        EXPECT_EQ(abandoned.json().at("tets").get<std::size_t>(), uncut_);
        const test_support::CommandRun again = replay("--abandon");
        EXPECT_EQ(again.exit_code, 2);
        EXPECT_NE(again.error().find("no stroke is open"), std::string::npos) << again.out;
    }

} // namespace cut_replay_test
} // namespace retractor::ui

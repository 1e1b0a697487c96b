// A journal that ends in the middle of a freehand stroke, as a crash leaves it, replayed by the built executable.

#include "command_run.h"

#include "mesh/cut_journal.h"
#include "mesh/hybrid_model.h"
#include "planner/case_io.h"
#include "planner/patient.h"
#include "tests/planner/block_case.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

namespace retractor {
namespace {

    namespace fs = std::filesystem;

    class CutReplay : public testing::Test {
    protected:
        /// Three steps of 5 mm along the planned line, 12 mm deep.
        void SetUp() override
        {
            const Phantom phantom = make_block_phantom(small_block());
            Case planned_case = block_case("open_stroke", phantom);
            const Approach approach = block_approach(phantom.labels, Eigen::Isometry3d::Identity(), 20.0);
            planned_case.approaches = { approach };
            write_case(planned_case);
            case_file_ = (planned_case.folder / "case.json").string();
            journal_ = (planned_case.folder / "open.jsonl").string();
            out_ = (planned_case.folder / "out").string();
            fs::remove(journal_);
            fs::remove_all(out_);
            Patient patient(planned_case);
            const HybridModel model
                = build_hybrid_model(*patient.labels(), mesh_sizing_of(approach, planned_case.label_table));
            ASSERT_EQ(model.status, MeshStatus::done);
            uncut_ = model.wall.tet_count();
            CutSession session = start_journal(journal_, model.wall);
            Blade blade { .line = { approach.incision[1] }, .directions = { approach.directions[1] } };
            blade.depth_mm = 12.0;
            for (int step = 0; step < 3; ++step) {
                blade.line.push_back(blade.line.back() + Vec3(0.0, 0.0, 5.0));
                blade.directions.push_back(approach.directions[1]);
                (void)session.extend_stroke(blade);
            }
            ASSERT_TRUE(session.stroke_open());
        }
        CommandRun replay(const std::string& rest) const
        {
            return run_line(std::string(RETRACTOR_PROGRAM) + " --json cut " + case_file_ + " --approach straight --out "
                + out_ + " --replay " + journal_ + " " + rest + " 2>/dev/null");
        }
        std::string case_file_, journal_, out_;
        std::size_t uncut_ = 0;
    };

    TEST_F(CutReplay, SaysThatAStrokeIsOpenAndHowToEndIt)
    {
        const CommandRun as_it_is = replay("");
        ASSERT_EQ(as_it_is.exit_code, 0) << as_it_is.out;
        const std::string message = as_it_is.json().at("message").get<std::string>();
        EXPECT_NE(message.find("--finish"), std::string::npos) << message;
        EXPECT_NE(message.find("--abandon"), std::string::npos) << message;
        EXPECT_EQ(as_it_is.json().at("cuts").get<int>(), 0);
        EXPECT_GT(as_it_is.json().at("tets").get<std::size_t>(), uncut_);
        const CommandRun undone = replay("--undo 1");
        EXPECT_EQ(undone.exit_code, 2);
        EXPECT_NE(undone.error().find("add --finish or --abandon"), std::string::npos) << undone.out;
        EXPECT_EQ(replay("--finish --abandon").exit_code, 2);
    }

    TEST_F(CutReplay, FinishesItAndTheJournalToo)
    {
        const CommandRun finished = replay("--finish");
        ASSERT_EQ(finished.exit_code, 0) << finished.out;
        EXPECT_EQ(finished.json().at("cuts").get<int>(), 1);
        // 15 x 12 mm; the knife's promise is a tenth of an edge, of 5 mm.
        EXPECT_NEAR(finished.json().at("report").at("lip_area_mm2").get<double>(), 180.0, 0.5 * (15.0 + 2.0 * 12.0));
        EXPECT_EQ(replay("").json().at("cuts").get<int>(), 0) << "without --journal the file stays as it is";
        const CommandRun kept = replay("--journal " + journal_ + " --finish --undo 1");
        ASSERT_EQ(kept.exit_code, 0) << kept.out;
        EXPECT_EQ(kept.json().at("tets").get<std::size_t>(), uncut_);
        EXPECT_EQ(replay("--finish").exit_code, 2) << "it is finished";
    }

    TEST_F(CutReplay, TakesItBackAndTheJournalToo)
    {
        const CommandRun abandoned = replay("--abandon --journal " + journal_);
        ASSERT_EQ(abandoned.exit_code, 0) << abandoned.out;
        EXPECT_EQ(abandoned.json().at("cuts").get<int>(), 0);
        EXPECT_EQ(abandoned.json().at("tets").get<std::size_t>(), uncut_);
        const CommandRun again = replay("--abandon");
        EXPECT_EQ(again.exit_code, 2);
        EXPECT_NE(again.error().find("no stroke is open"), std::string::npos) << again.out;
    }

} // namespace
} // namespace retractor

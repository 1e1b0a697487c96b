#include "planner/session/saved_cuts.h"

#include "mesh/base/error.h"
#include "planner/session/knife_worker.h"
#include "tests/planner/session/layered_wall.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>

namespace retractor::planner {
namespace kept_cuts_test {

    namespace fs = std::filesystem;

    class KeptCutsTest : public testing::Test {
    protected:
        void SetUp() override
        {
            folder_ = fs::temp_directory_path() / "kept_cuts_test"
                / testing::UnitTest::GetInstance()->current_test_info()->name();
            fs::remove_all(folder_);
            fs::create_directories(folder_);
        }
        SurgerySetup table() const
        {
            SurgerySetup made = layered_wall();
            made.journal = journal();
            return made;
        }
        fs::path journal() const { return cuts_journal(folder_ / "case.json", "median"); }

        static Touch at(SurgerySession& desk, double x, double z) { return *touch(*desk.picture(), ray_down(x, z)); }
        static void begin(SurgerySession& desk, double z)
        {
            ASSERT_TRUE(desk.begin_stroke(at(desk, 20.0, z), {}).done);
            for (double x = 24.0; x <= 80.0; x += 4.0)
                ASSERT_TRUE(desk.draw_to(at(desk, x, z)).done);
        }
        static void cut(SurgerySession& desk, double z)
        {
            begin(desk, z);
            ASSERT_TRUE(desk.finish_stroke().done);
        }
        static bool same(const mesh::TetMesh& a, const mesh::TetMesh& b)
        {
            return a.vertices.rows() == b.vertices.rows() && (a.vertices.array() == b.vertices.array()).all()
                && a.nodes == b.nodes && a.labels == b.labels;
        }
        static bool same(const WallSurface& a, const WallSurface& b)
        {
            // In what order faces come depends on the way there.
            const auto sorted = [](const WallSurface& s) {
                std::vector<std::array<VertexId, 5>> faces;
                for (std::size_t t = 0; t < s.triangles.size(); ++t) {
                    auto v = s.triangles[t];
                    std::sort(v.begin(), v.end());
                    faces.push_back({ v[0], v[1], v[2], s.labels[t], s.is_lip[t] });
                }
                std::sort(faces.begin(), faces.end());
                return faces;
            };
            return sorted(a) == sorted(b);
        }

        fs::path folder_;
    };

    TEST_F(KeptCutsTest, AJournalIsNamedAfterItsApproach)
    {
        const fs::path file = fs::path("case") / "case.json";
        EXPECT_EQ(cuts_journal(file, "intercostal_4"), fs::path("case") / "cuts" / "intercostal_4.jsonl");
        EXPECT_EQ(cuts_journal(file, "a/b ü"), fs::path("case") / "cuts" / "a%2Fb%20%C3%BC.jsonl");
        EXPECT_EQ(cuts_journal("case/second.json", "median"), fs::path("case") / "second.cuts" / "median.jsonl");
    }

    TEST_F(KeptCutsTest, ADeskIsRestoredAsItWas)
    {
        mesh::TetMesh left;
        std::shared_ptr<const WallSurface> surface;
        {
            SurgerySession desk = fresh_desk(table());
            for (const double z : { 30.0, 62.0, 91.0 })
                cut(desk, z);
            desk.undo();
            left = desk.session().compact_mesh();
            surface = desk.picture()->surface;
        }
        const SavedCuts kept = read_kept_cuts(journal(), table().wall);
        EXPECT_EQ(kept.deltas.size(), 2U);
        EXPECT_TRUE(kept.more);
        SurgerySession desk = restore_desk(table(), kept);
        EXPECT_TRUE(same(desk.session().compact_mesh(), left));
        EXPECT_TRUE(same(*desk.picture()->surface, *surface));
        ASSERT_EQ(desk.cuts().size(), 2U);
        EXPECT_TRUE(desk.cuts()[0].restored);
        EXPECT_NEAR(desk.cuts()[0].report.lip_area_mm2, 60.0 * 15.0, 0.1 * kSlabEdgeMm * 90.0);
        desk.set_tension(0.04);
        while (desk.moving())
            desk.relax(50.0);
        EXPECT_GT(desk.gape_mm(), 0.5) << "restored wounds gape too";
        desk.redo();
        EXPECT_EQ(desk.cuts().size(), 3U);
        desk.undo();
        desk.undo();
        desk.undo();
        EXPECT_TRUE(same(desk.session().compact_mesh(), table().wall));
    }

    TEST_F(KeptCutsTest, WhatWasTakenOutIsRestoredAsThat)
    {
        // Sums of some 100 elements' volumes, in another order.
        constexpr double kRounding = 1e-9;
        mesh::CutReport report;
        {
            SurgerySession desk = fresh_desk(table());
            cut(desk, 30.0);
            ASSERT_TRUE(desk.take_out(at(desk, 60.0, 80.0), 12.0).done);
            report = desk.cuts().back().report;
            cut(desk, 100.0);
        }
        const auto check = [&](const CutEntry& taken) {
            EXPECT_TRUE(taken.restored);
            EXPECT_EQ(taken.taken_out, "skin");
            EXPECT_FALSE(taken.several_tissues);
            EXPECT_NEAR(
                taken.report.removed_volume_mm3, report.removed_volume_mm3, kRounding * report.removed_volume_mm3);
        };
        {
            SurgerySession desk = restore_desk(table(), read_kept_cuts(journal(), table().wall));
            ASSERT_EQ(desk.cuts().size(), 3U);
            EXPECT_EQ(desk.cuts()[0].taken_out, "");
            check(desk.cuts()[1]);
            EXPECT_EQ(desk.cuts()[2].taken_out, "");
            desk.undo();
            desk.undo();
        }
        SurgerySession desk = restore_desk(table(), read_kept_cuts(journal(), table().wall));
        ASSERT_EQ(desk.cuts().size(), 1U);
        desk.redo();
        desk.redo();
        ASSERT_EQ(desk.cuts().size(), 3U);
        check(desk.cuts()[1]);
        EXPECT_EQ(desk.cuts()[2].taken_out, "");
    }

    TEST_F(KeptCutsTest, AStrokeThatACrashCutOffIsKept)
    {
        mesh::TetMesh left;
        {
            auto desk = std::make_unique<SurgerySession>(fresh_desk(table()));
            cut(*desk, 30.0);
            begin(*desk, 62.0); // the desk ends without finishing it, as a crash would
            left = desk->session().compact_mesh();
        }
        const SavedCuts kept = read_kept_cuts(journal(), table().wall);
        ASSERT_EQ(kept.deltas.size(), 2U);
        SurgerySession desk = restore_desk(table(), kept);
        EXPECT_FALSE(desk.stroke_open());
        EXPECT_GE(desk.session().tet_count(), left.tet_count());
        desk.undo();
        EXPECT_EQ(desk.session().cut_count(), 1U);
    }

    TEST_F(KeptCutsTest, AnotherWallOrADamagedFileIsRefused)
    {
        {
            SurgerySession desk = fresh_desk(table());
            cut(desk, 30.0);
        }
        EXPECT_THROW((void)fresh_desk(table()), IoError) << "what is kept is not written over";
        EXPECT_THROW((void)read_kept_cuts(journal(), layered_wall({ 0.0, 0.0, 1.0 }).wall), InputError);
        const fs::path first = set_aside(journal());
        EXPECT_EQ(first, journal().string() + ".1");
        EXPECT_FALSE(fs::exists(journal()));
        std::ofstream(journal()) << "no journal\n";
        EXPECT_THROW((void)read_kept_cuts(journal(), table().wall), InputError);
        EXPECT_EQ(set_aside(journal()), journal().string() + ".2");
        EXPECT_THROW((void)set_aside(journal()), IoError);
        EXPECT_EQ(read_kept_cuts(first, table().wall).deltas.size(), 1U) << "set aside, not lost";
    }

    /// What a worker says once it is not preparing any more.
    SessionSnapshot settled(KnifeWorker& worker)
    {
        while (!worker.idle() || worker.snapshot()->phase == SessionSnapshot::Phase::preparing)
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        return *worker.snapshot();
    }

    TEST_F(KeptCutsTest, TheWorkerAsksBeforeItRestores)
    {
        {
            KnifeWorker worker([&](const Job&) { return table(); }, [] {});
            const SessionSnapshot snapshot = settled(worker);
            ASSERT_EQ(snapshot.phase, SessionSnapshot::Phase::ready) << "nothing was kept: nothing is asked";
            worker.restore(true); // no question
            worker.run(surgery::BeginStroke { *touch(*snapshot.picture, ray_down(20.0, 62.0)) });
            for (double x = 24.0; x <= 80.0; x += 4.0)
                worker.run(surgery::DrawTo { *touch(*snapshot.picture, ray_down(x, 62.0)) });
        } // ends in the middle of the stroke
        {
            KnifeWorker worker([&](const Job&) { return table(); }, [] {});
            const SessionSnapshot snapshot = settled(worker);
            EXPECT_EQ(snapshot.phase, SessionSnapshot::Phase::asking);
            EXPECT_EQ(snapshot.saved_cuts, 1U);
        } // ends without an answer
        {
            KnifeWorker worker([&](const Job&) { return table(); }, [] {});
            ASSERT_EQ(settled(worker).phase, SessionSnapshot::Phase::asking);
            worker.restore(true);
            while (worker.snapshot()->phase != SessionSnapshot::Phase::ready)
                std::this_thread::sleep_for(std::chrono::milliseconds(2));
            EXPECT_EQ(worker.snapshot()->cuts.size(), 1U);
        }
        {
            KnifeWorker worker([&](const Job&) { return table(); }, [] {});
            ASSERT_EQ(settled(worker).phase, SessionSnapshot::Phase::asking);
            worker.restore(false);
            while (worker.snapshot()->phase != SessionSnapshot::Phase::ready)
                std::this_thread::sleep_for(std::chrono::milliseconds(2));
            EXPECT_TRUE(worker.snapshot()->cuts.empty());
            EXPECT_TRUE(fs::exists(journal().string() + ".1"));
            // Another window on the same case cuts, but not into the same file.
            KnifeWorker second([&](const Job&) { return table(); }, [] {});
            const SessionSnapshot snapshot = settled(second);
            EXPECT_EQ(snapshot.phase, SessionSnapshot::Phase::ready);
            EXPECT_TRUE(snapshot.refused);
            EXPECT_NE(snapshot.answer.find("not kept on disk"), std::string::npos) << snapshot.answer;
        }
    }

    TEST_F(KeptCutsTest, CommandsWaitForTheAnswer)
    {
        {
            KnifeWorker worker([&](const Job&) { return table(); }, [] {});
            const SessionSnapshot snapshot = settled(worker);
            worker.run(surgery::BeginStroke { *touch(*snapshot.picture, ray_down(20.0, 62.0)) });
            for (double x = 24.0; x <= 80.0; x += 4.0)
                worker.run(surgery::DrawTo { *touch(*snapshot.picture, ray_down(x, 62.0)) });
        }
        KnifeWorker worker([&](const Job&) { return table(); }, [] {});
        ASSERT_EQ(settled(worker).phase, SessionSnapshot::Phase::asking);
        worker.run(surgery::SetTension { 0.04 });
        EXPECT_FALSE(worker.idle()) << "the command waits";
        worker.restore(true);
        const SessionSnapshot ready = settled(worker);
        EXPECT_EQ(ready.phase, SessionSnapshot::Phase::ready);
        EXPECT_EQ(ready.cuts.size(), 1U);
        EXPECT_EQ(ready.tension, 0.04);
        EXPECT_GT(ready.gape_mm, 0.0) << "the restored cut gapes under it";
    }

    TEST_F(KeptCutsTest, TheWorkerSaysWhatTheTableDoesNotFeel)
    {
        KnifeWorker worker(
            [&](const Job&) {
                SurgerySetup laid = table();
                laid.caution = "nothing presses here";
                return laid;
            },
            [] {});
        const SessionSnapshot snapshot = settled(worker);
        EXPECT_EQ(snapshot.answer, "nothing presses here");
        EXPECT_EQ(snapshot.answers, 1U);
        EXPECT_FALSE(snapshot.refused);
    }

    TEST_F(KeptCutsTest, TheWorkerSetsAsideWhatDoesNotFit)
    {
        fs::create_directories(journal().parent_path());
        std::ofstream(journal()) << "no journal\n";
        KnifeWorker worker([&](const Job&) { return table(); }, [] {});
        const SessionSnapshot snapshot = settled(worker);
        EXPECT_EQ(snapshot.phase, SessionSnapshot::Phase::ready);
        EXPECT_NE(snapshot.answer.find("median.jsonl.1"), std::string::npos) << snapshot.answer;
        EXPECT_TRUE(fs::exists(journal().string() + ".1"));
        EXPECT_TRUE(fs::exists(journal()));
    }

} // namespace kept_cuts_test
} // namespace retractor::planner

#include "planner/session/saved_cuts.h"

#include "mesh/base/error.h"
#include "planner/session/surgery_worker.h"
#include "tests/planner/session/layered_wall.h"
#include "tests/support/wait_until.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

namespace retractor::planner {
namespace saved_cuts_test {

    namespace fs = std::filesystem;

    class SavedCutsTest : public testing::Test {
    protected:
        void SetUp() override
        {
            folder_ = fs::temp_directory_path() / "saved_cuts_test"
                / testing::UnitTest::GetInstance()->current_test_info()->name();
            fs::remove_all(folder_);
            fs::create_directories(folder_);
        }
        SurgerySetup setup() const
        {
            SurgerySetup made = layered_wall();
            made.journal = journal();
            return made;
        }
        fs::path journal() const { return cuts_journal(folder_ / "case.json", "median"); }

        static Touch at(SurgerySession& live_session, double x, double z)
        {
            return *touch(*live_session.picture(), ray_down(x, z));
        }
        static void begin(SurgerySession& live_session, double z)
        {
            ASSERT_TRUE(live_session.begin_stroke(at(live_session, 20.0, z), {}).done);
            for (double x = 24.0; x <= 80.0; x += 4.0)
                ASSERT_TRUE(live_session.draw_to(at(live_session, x, z)).done);
        }
        static void cut(SurgerySession& live_session, double z)
        {
            begin(live_session, z);
            ASSERT_TRUE(live_session.finish_stroke().done);
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

    TEST_F(SavedCutsTest, AJournalIsNamedAfterItsApproach)
    {
        const fs::path file = fs::path("case") / "case.json";
        EXPECT_EQ(cuts_journal(file, "intercostal_4"), fs::path("case") / "cuts" / "intercostal_4.jsonl");
        EXPECT_EQ(cuts_journal(file, "a/b ü"), fs::path("case") / "cuts" / "a%2Fb%20%C3%BC.jsonl");
        EXPECT_EQ(cuts_journal("case/second.json", "median"), fs::path("case") / "second.cuts" / "median.jsonl");
    }

    TEST_F(SavedCutsTest, ADeskIsRestoredAsItWas)
    {
        mesh::TetMesh left;
        std::shared_ptr<const WallSurface> surface;
        {
            SurgerySession live_session = new_session(setup());
            for (const double z : { 30.0, 62.0, 91.0 })
                cut(live_session, z);
            live_session.undo();
            left = live_session.session().compact_mesh();
            surface = live_session.picture()->surface;
        }
        const SavedCuts kept = read_saved_cuts(journal(), setup().wall);
        EXPECT_EQ(kept.deltas.size(), 2U);
        EXPECT_TRUE(kept.more);
        SurgerySession live_session = restored_session(setup(), kept);
        EXPECT_TRUE(same(live_session.session().compact_mesh(), left));
        EXPECT_TRUE(same(*live_session.picture()->surface, *surface));
        ASSERT_EQ(live_session.cuts().size(), 2U);
        EXPECT_TRUE(live_session.cuts()[0].restored);
        EXPECT_NEAR(live_session.cuts()[0].report.lip_area_mm2, 60.0 * 15.0, 0.1 * kSlabEdgeMm * 90.0);
        live_session.set_tension(0.04);
        while (live_session.moving())
            live_session.relax(50.0);
        EXPECT_GT(live_session.gape_mm(), 0.5) << "restored wounds gape too";
        live_session.redo();
        EXPECT_EQ(live_session.cuts().size(), 3U);
        live_session.undo();
        live_session.undo();
        live_session.undo();
        EXPECT_TRUE(same(live_session.session().compact_mesh(), setup().wall));
    }

    /// The setup with a planned incision that stops short of one side, and a stroke beyond its end.
    SurgerySetup planned(SurgerySetup made, double z)
    {
        made.approach.incision = { { 30.0, 0.0, z }, { 70.0, 0.0, z } };
        made.approach.directions.assign(2, Vec3::UnitY());
        made.approach.depth_mm = kSlabThicknessMm + 3.0;
        return made;
    }

    TEST_F(SavedCutsTest, ThePlannedIncisionIsRecognisedAmongThem)
    {
        CutEntry made;
        {
            SurgerySession live_session = new_session(planned(setup(), 60.0));
            ASSERT_TRUE(live_session.cut_as_planned().done);
            made = live_session.cuts().front();
            cut(live_session, 91.0);
            live_session.undo();
            cut(live_session, 95.0);
        }
        const SavedCuts kept = read_saved_cuts(journal(), setup().wall);
        ASSERT_EQ(kept.deltas.size(), 2U);
        {
            const SurgerySession live_session = restored_session(planned(setup(), 60.0), kept);
            const CutEntry& first = live_session.cuts().at(0);
            EXPECT_TRUE(first.as_planned);
            EXPECT_FALSE(first.restored) << "all is known of it";
            EXPECT_EQ(first.length_mm, made.length_mm);
            EXPECT_EQ(first.depth_mm, made.depth_mm);
            EXPECT_EQ(first.report.tets_crossed, made.report.tets_crossed);
            EXPECT_EQ(first.blade.line.size(), made.blade.line.size());
            EXPECT_FALSE(live_session.cuts().at(1).as_planned);
            EXPECT_TRUE(live_session.cuts().at(1).restored);
        }
        const SurgerySession moved = restored_session(planned(setup(), 61.0), kept);
        EXPECT_FALSE(moved.cuts().at(0).as_planned) << "the plan has changed";
        EXPECT_TRUE(moved.cuts().at(0).restored);
    }

    TEST_F(SavedCutsTest, WhatWasTakenOutIsRestoredAsThat)
    {
        // Sums of some 100 elements' volumes, in another order.
        constexpr double kRounding = 1e-9;
        mesh::CutReport report;
        {
            SurgerySession live_session = new_session(setup());
            cut(live_session, 30.0);
            ASSERT_TRUE(live_session.take_out(at(live_session, 60.0, 80.0), 12.0).done);
            report = live_session.cuts().back().report;
            cut(live_session, 100.0);
        }
        const auto check = [&](const CutEntry& taken) {
            EXPECT_TRUE(taken.restored);
            EXPECT_EQ(taken.taken_out, "skin");
            EXPECT_FALSE(taken.several_tissues);
            EXPECT_NEAR(
                taken.report.removed_volume_mm3, report.removed_volume_mm3, kRounding * report.removed_volume_mm3);
        };
        {
            SurgerySession live_session = restored_session(setup(), read_saved_cuts(journal(), setup().wall));
            ASSERT_EQ(live_session.cuts().size(), 3U);
            EXPECT_EQ(live_session.cuts()[0].taken_out, "");
            check(live_session.cuts()[1]);
            EXPECT_EQ(live_session.cuts()[2].taken_out, "");
            live_session.undo();
            live_session.undo();
        }
        SurgerySession live_session = restored_session(setup(), read_saved_cuts(journal(), setup().wall));
        ASSERT_EQ(live_session.cuts().size(), 1U);
        live_session.redo();
        live_session.redo();
        ASSERT_EQ(live_session.cuts().size(), 3U);
        check(live_session.cuts()[1]);
        EXPECT_EQ(live_session.cuts()[2].taken_out, "");
    }

    TEST_F(SavedCutsTest, AStrokeThatACrashCutOffIsKept)
    {
        mesh::TetMesh left;
        {
            auto live_session = std::make_unique<SurgerySession>(new_session(setup()));
            cut(*live_session, 30.0);
            begin(*live_session, 62.0); // the session ends without finishing it, as a crash would
            left = live_session->session().compact_mesh();
        }
        const SavedCuts kept = read_saved_cuts(journal(), setup().wall);
        ASSERT_EQ(kept.deltas.size(), 2U);
        SurgerySession live_session = restored_session(setup(), kept);
        EXPECT_FALSE(live_session.stroke_open());
        EXPECT_GE(live_session.session().tet_count(), left.tet_count());
        live_session.undo();
        EXPECT_EQ(live_session.session().cut_count(), 1U);
    }

    TEST_F(SavedCutsTest, AnotherWallOrADamagedFileIsRefused)
    {
        {
            SurgerySession live_session = new_session(setup());
            cut(live_session, 30.0);
        }
        EXPECT_THROW((void)new_session(setup()), IoError) << "what is kept is not written over";
        EXPECT_THROW((void)read_saved_cuts(journal(), layered_wall({ 0.0, 0.0, 1.0 }).wall), InputError);
        const fs::path first = set_aside(journal());
        EXPECT_EQ(first, journal().string() + ".1");
        EXPECT_FALSE(fs::exists(journal()));
        std::ofstream(journal()) << "no journal\n";
        EXPECT_THROW((void)read_saved_cuts(journal(), setup().wall), InputError);
        EXPECT_EQ(set_aside(journal()), journal().string() + ".2");
        EXPECT_THROW((void)set_aside(journal()), IoError);
        EXPECT_EQ(read_saved_cuts(first, setup().wall).deltas.size(), 1U) << "set aside, not lost";
    }

    /// What a worker says once it is not preparing any more.
    SurgerySnapshot settled(SurgeryWorker& worker)
    {
        EXPECT_TRUE(test_support::wait_until(
            [&] { return worker.idle() && worker.snapshot()->phase != SurgerySnapshot::Phase::preparing; }));
        return *worker.snapshot();
    }

    TEST_F(SavedCutsTest, TheWorkerAsksBeforeItRestores)
    {
        {
            SurgeryWorker worker([&](const Job&) { return setup(); }, [] {});
            const SurgerySnapshot snapshot = settled(worker);
            ASSERT_EQ(snapshot.phase, SurgerySnapshot::Phase::ready) << "nothing was kept: nothing is asked";
            worker.restore(true); // no question
            worker.run(surgery::BeginStroke { *touch(*snapshot.picture, ray_down(20.0, 62.0)) });
            for (double x = 24.0; x <= 80.0; x += 4.0)
                worker.run(surgery::DrawTo { *touch(*snapshot.picture, ray_down(x, 62.0)) });
        } // ends in the middle of the stroke
        {
            SurgeryWorker worker([&](const Job&) { return setup(); }, [] {});
            const SurgerySnapshot snapshot = settled(worker);
            EXPECT_EQ(snapshot.phase, SurgerySnapshot::Phase::asking);
            EXPECT_EQ(snapshot.saved_cuts, 1U);
        } // ends without an answer
        {
            SurgeryWorker worker([&](const Job&) { return setup(); }, [] {});
            ASSERT_EQ(settled(worker).phase, SurgerySnapshot::Phase::asking);
            worker.restore(true);
            ASSERT_TRUE(
                test_support::wait_until([&] { return worker.snapshot()->phase == SurgerySnapshot::Phase::ready; }));
            EXPECT_EQ(worker.snapshot()->cuts.size(), 1U);
        }
        {
            SurgeryWorker worker([&](const Job&) { return setup(); }, [] {});
            ASSERT_EQ(settled(worker).phase, SurgerySnapshot::Phase::asking);
            worker.restore(false);
            ASSERT_TRUE(
                test_support::wait_until([&] { return worker.snapshot()->phase == SurgerySnapshot::Phase::ready; }));
            EXPECT_TRUE(worker.snapshot()->cuts.empty());
            EXPECT_TRUE(fs::exists(journal().string() + ".1"));
            // Another window on the same case cuts, but not into the same file.
            SurgeryWorker second([&](const Job&) { return setup(); }, [] {});
            const SurgerySnapshot snapshot = settled(second);
            EXPECT_EQ(snapshot.phase, SurgerySnapshot::Phase::ready);
            EXPECT_TRUE(snapshot.refused);
            EXPECT_NE(snapshot.answer.find("not kept on disk"), std::string::npos) << snapshot.answer;
        }
    }

    TEST_F(SavedCutsTest, CutsWaitForADiskThatRefusesThem)
    {
        fs::create_directories(folder_);
        const fs::path in_the_way = journal().parent_path(); // a file where the folder must be
        std::ofstream(in_the_way) << "a file\n";
        {
            SurgeryWorker worker([&](const Job&) { return setup(); }, [] {});
            const SurgerySnapshot before = settled(worker);
            EXPECT_NE(before.cuts_not_saved, "");
            const auto stroke = [&](double z) {
                worker.run(surgery::BeginStroke { *touch(*before.picture, ray_down(20.0, z)) });
                for (double x = 24.0; x <= 80.0; x += 4.0)
                    worker.run(surgery::DrawTo { *touch(*before.picture, ray_down(x, z)) });
                worker.run(surgery::FinishStroke {});
                return settled(worker);
            };
            EXPECT_EQ(stroke(62.0).cuts.size(), 1U) << "the knife goes on";
            worker.run(surgery::SaveCuts {});
            const SurgerySnapshot refused = settled(worker);
            EXPECT_TRUE(refused.refused);
            EXPECT_NE(refused.cuts_not_saved, "");
            fs::remove(in_the_way);
            worker.run(surgery::SaveCuts {});
            const SurgerySnapshot saved = settled(worker);
            EXPECT_FALSE(saved.refused) << saved.answer;
            EXPECT_EQ(saved.cuts_not_saved, "");
        }
        EXPECT_EQ(read_saved_cuts(journal(), setup().wall).deltas.size(), 1U);
        std::ofstream(journal(), std::ios::trunc).flush(); // as a full disk leaves it: no line at all
        SurgeryWorker worker([&](const Job&) { return setup(); }, [] {});
        const SurgerySnapshot anew = settled(worker);
        EXPECT_EQ(anew.phase, SurgerySnapshot::Phase::ready);
        EXPECT_FALSE(anew.refused) << anew.answer;
    }

    TEST_F(SavedCutsTest, CommandsWaitForTheAnswer)
    {
        {
            SurgeryWorker worker([&](const Job&) { return setup(); }, [] {});
            const SurgerySnapshot snapshot = settled(worker);
            worker.run(surgery::BeginStroke { *touch(*snapshot.picture, ray_down(20.0, 62.0)) });
            for (double x = 24.0; x <= 80.0; x += 4.0)
                worker.run(surgery::DrawTo { *touch(*snapshot.picture, ray_down(x, 62.0)) });
        }
        SurgeryWorker worker([&](const Job&) { return setup(); }, [] {});
        ASSERT_EQ(settled(worker).phase, SurgerySnapshot::Phase::asking);
        worker.run(surgery::SetTension { 0.04 });
        EXPECT_FALSE(worker.idle()) << "the command waits";
        worker.restore(true);
        const SurgerySnapshot ready = settled(worker);
        EXPECT_EQ(ready.phase, SurgerySnapshot::Phase::ready);
        EXPECT_EQ(ready.cuts.size(), 1U);
        EXPECT_EQ(ready.tension, 0.04);
        EXPECT_GT(ready.gape_mm, 0.0) << "the restored cut gapes under it";
    }

    TEST_F(SavedCutsTest, TheWorkerSaysWhatTheTableDoesNotFeel)
    {
        SurgeryWorker worker(
            [&](const Job&) {
                SurgerySetup cautioned = setup();
                cautioned.caution = "nothing presses here";
                return cautioned;
            },
            [] {});
        const SurgerySnapshot snapshot = settled(worker);
        EXPECT_EQ(snapshot.answer, "nothing presses here");
        EXPECT_EQ(snapshot.answers, 1U);
        EXPECT_FALSE(snapshot.refused);
    }

    TEST_F(SavedCutsTest, TheWorkerSetsAsideWhatDoesNotFit)
    {
        fs::create_directories(journal().parent_path());
        std::ofstream(journal()) << "no journal\n";
        SurgeryWorker worker([&](const Job&) { return setup(); }, [] {});
        const SurgerySnapshot snapshot = settled(worker);
        EXPECT_EQ(snapshot.phase, SurgerySnapshot::Phase::ready);
        EXPECT_NE(snapshot.answer.find("median.jsonl.1"), std::string::npos) << snapshot.answer;
        EXPECT_TRUE(fs::exists(journal().string() + ".1"));
        EXPECT_TRUE(fs::exists(journal()));
    }

} // namespace saved_cuts_test
} // namespace retractor::planner

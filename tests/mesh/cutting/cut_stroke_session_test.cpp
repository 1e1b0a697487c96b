// Freehand strokes of a session that go wrong: given up, cancelled, thrown out of.

#include "mesh/base/error.h"
#include "mesh/cutting/cut_session.h"
#include "mesh/cutting/stroke/cut_extent.h"
#include "mesh/cutting/stroke/cut_retry.h"
#include "tests/support/session_state.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace retractor::mesh {
namespace cut_stroke_session_test {

    const Vec3 kExtent(24.0, 24.0, 12.0);

    CutSession cut_box()
    {
        CutSession session(test_support::three_layers(8, 8, 4, 3.0));
        const Blade blade {
            .line = { { 2.2, 3.1, 12 }, { 20.3, 4.4, 12 } }, .directions = { { 0, 0.1, -1 } }, .depth_mm = 7.0
        };
        EXPECT_EQ(session.cut(blade).status, CutStatus::done);
        EXPECT_EQ(
            session.cut({ .line = { { 3, 20, 12 }, { 9, 18, 12 } }, .directions = { { 0, 0, -1 } }, .depth_mm = 5 })
                .status,
            CutStatus::done);
        static_cast<void>(session.undo()); // so that there is something to redo
        return session;
    }

    Blade drawn(std::size_t points)
    {
        Blade blade { .line
            = { { 4.1, 9.3, 12 }, { 8.2, 10.8, 12 }, { 13.1, 12.9, 12 }, { 17.4, 13.6, 12 }, { 21.9, 13.3, 12 } },
            .directions = { { 0.1, 0.1, -1.0 } },
            .depth_mm = 6.5 };
        blade.line.resize(points);
        return blade;
    }

    TEST(FreehandStroke, AbandonedItIsAsIfItHadNeverBeen)
    {
        for (std::size_t most = 2; most <= 5; ++most) {
            CutSession session = cut_box();
            CutSession other = cut_box();
            const test_support::SessionState before(session);
            std::size_t born = 0;
            for (std::size_t points = 2; points <= most; ++points) {
                const CutResult step = session.extend_stroke(drawn(points));
                ASSERT_EQ(step.status, CutStatus::done) << step.message;
                born += step.delta.vertices_born.size();
            }
            ASSERT_GT(born, 0u);
            EXPECT_FALSE(test_support::SessionState(session) == before);
            const MeshDelta back = session.abandon_stroke();
            EXPECT_EQ(back.vertices_gone.size(), born);
            EXPECT_FALSE(session.stroke_open());
            EXPECT_TRUE(test_support::SessionState(session) == before);
            EXPECT_TRUE(session.can_redo());
            // What comes after gets the same ids and places.
            static_cast<void>(session.redo());
            static_cast<void>(other.redo());
            EXPECT_EQ(session.cut(drawn(5)).status, CutStatus::done);
            EXPECT_EQ(other.cut(drawn(5)).status, CutStatus::done);
            EXPECT_TRUE(test_support::SessionState(session) == test_support::SessionState(other));
        }
    }

    TEST(FreehandStroke, WithoutAStepThatCutAnythingItIsAbandonedToo)
    {
        CutSession session = cut_box();
        const test_support::SessionState before(session);
        EXPECT_THROW(static_cast<void>(session.abandon_stroke()), InputError);
        Blade beside = drawn(3);
        for (Vec3& p : beside.line)
            p.y() += 200.0;
        ASSERT_EQ(session.extend_stroke(beside).status, CutStatus::done);
        ASSERT_TRUE(session.stroke_open());
        const MeshDelta back = session.abandon_stroke();
        EXPECT_TRUE(back.tets_born.empty() && back.vertices_gone.empty());
        EXPECT_TRUE(test_support::SessionState(session) == before);
    }

    TEST(FreehandStroke, IsAsItWasAfterAStepThatThrows)
    {
        CutSession session = cut_box(), clean = cut_box();
        ASSERT_EQ(session.extend_stroke(drawn(3)).status, CutStatus::done);
        ASSERT_EQ(clean.extend_stroke(drawn(3)).status, CutStatus::done);
        const test_support::SessionState before(session);
        Blade malformed = drawn(4);
        malformed.depth_mm = -1.0;
        EXPECT_THROW(static_cast<void>(session.extend_stroke(malformed)), InputError);
        EXPECT_THROW(static_cast<void>(session.extend_stroke(drawn(4), { .snap = 2.0 })), InputError);
        EXPECT_TRUE(test_support::SessionState(session) == before);
        session.set_witness([](const CutEvent&) { throw std::runtime_error("no"); });
        EXPECT_THROW(static_cast<void>(session.extend_stroke(drawn(4))), std::runtime_error);
        EXPECT_TRUE(test_support::SessionState(session) == before);
        EXPECT_THROW(static_cast<void>(session.finish_stroke()), std::runtime_error);
        EXPECT_TRUE(test_support::SessionState(session) == before);
        EXPECT_THROW(static_cast<void>(session.abandon_stroke()), std::runtime_error);
        EXPECT_TRUE(test_support::SessionState(session) == before);
        session.set_witness({});
        ASSERT_EQ(session.extend_stroke(drawn(5)).status, CutStatus::done);
        ASSERT_EQ(clean.extend_stroke(drawn(5)).status, CutStatus::done);
        ASSERT_EQ(session.finish_stroke().status, CutStatus::done);
        ASSERT_EQ(clean.finish_stroke().status, CutStatus::done);
        EXPECT_TRUE(test_support::SessionState(session) == test_support::SessionState(clean));
    }

    TEST(FreehandStroke, StaysOpenWhenItsEndIsCancelled)
    {
        CutSession session = cut_box();
        ASSERT_EQ(session.extend_stroke(drawn(4)).status, CutStatus::done);
        const test_support::SessionState before(session);
        const std::atomic<bool> cancel { true };
        Job job;
        job.cancel = &cancel;
        EXPECT_EQ(session.finish_stroke(job).status, CutStatus::cancelled);
        EXPECT_TRUE(session.stroke_open());
        EXPECT_TRUE(test_support::SessionState(session) == before);
        EXPECT_EQ(session.finish_stroke().status, CutStatus::done);
        EXPECT_EQ(session.cut_count(), 2u);
    }

    /// Swings and turns as a hand does, with a point every 5 mm, over a box of 4 mm cells.
    Blade swinging(std::size_t points)
    {
        Blade blade { .line = {}, .directions = {}, .depth_mm = 12.0 };
        for (std::size_t i = 0; i < points; ++i) {
            const double share = static_cast<double>(i) / 12.0, phase = 2.0 * std::numbers::pi * share;
            blade.line.push_back({ 11.8 + 59.5 * share, 37.3 + 7.6 * share + 4.0 * std::sin(1.3 * phase), 20.0 });
            const double turn = 0.0873 * std::sin(2.0 * phase);
            blade.directions.push_back(Vec3(0.03 * turn, 0.17 + turn, -1.0).normalized());
        }
        return blade;
    }

    TEST(FreehandStroke, DrawnByAHandItLeavesHealthyElements)
    {
        CutSession session(kuhn_box(20, 20, 5, 4.0));
        for (std::size_t points = 2; points <= 13; ++points) {
            const CutResult step = session.extend_stroke(swinging(points));
            ASSERT_EQ(step.status, CutStatus::done) << step.message;
        }
        const CutReport report = session.finish_stroke().report;
        EXPECT_EQ(report.attempts, 1);
        EXPECT_GE(report.worst_dihedral_deg, 10.0); // once 5: faces with every corner on the rim were halved on and on
        EXPECT_GE(report.p01_dihedral_deg, 12.0);
        EXPECT_LE(report.mean_increase(), 3.0);
    }

    TEST(CutSession, AWitnessThatThrowsTakesTheOperationBack)
    {
        CutSession session = cut_box();
        const test_support::SessionState before(session);
        session.set_witness([](const CutEvent&) { throw std::runtime_error("the disk is full"); });
        EXPECT_THROW(static_cast<void>(session.cut(drawn(5))), std::runtime_error);
        EXPECT_THROW(static_cast<void>(session.undo()), std::runtime_error);
        EXPECT_THROW(static_cast<void>(session.redo()), std::runtime_error);
        const std::vector<TetId> some { 3, 4 };
        EXPECT_THROW(static_cast<void>(session.ablate(some)), std::runtime_error);
        EXPECT_THROW(static_cast<void>(session.extend_stroke(drawn(5))), std::runtime_error);
        EXPECT_TRUE(test_support::SessionState(session) == before);
    }

    /// Elements of very different sizes side by side: what is looked at first matters.
    TetMesh graded_layers()
    {
        TetMesh box = test_support::three_layers(8, 8, 4, 3.0);
        for (Eigen::Index v = 0; v < box.vertices.rows(); ++v)
            for (int axis = 0; axis < 2; ++axis)
                box.vertices(v, axis) *= 0.2 + 0.8 * box.vertices(v, axis) / 24.0;
        return box;
    }

    TEST(CutSession, WhatWasTakenBackDecidesNothing)
    {
        std::mt19937 random(11);
        std::size_t bent_cuts = 0;
        for (int round = 0; round < 12; ++round) {
            CutSession lived(graded_layers()), fresh(graded_layers());
            const test_support::SessionState untouched(fresh);
            for (int i = 0; i < 4; ++i) { // in the fresh session none of this happens
                std::atomic<bool> cancel { false };
                Job job;
                job.cancel = &cancel;
                job.on_progress = [&](std::string_view, double fraction) { cancel = cancel || fraction >= 1.0; };
                EXPECT_NE(lived.cut(test_support::random_stroke(random, kExtent), {}, job).status, CutStatus::done);
                lived.set_witness([](const CutEvent&) { throw std::runtime_error("refused"); });
                try {
                    static_cast<void>(lived.cut(test_support::random_stroke(random, kExtent)));
                } catch (const std::exception&) { // refused by the witness, or because of the blade
                }
                lived.set_witness({});
            }
            EXPECT_TRUE(test_support::SessionState(lived) == untouched);
            for (int i = 0; i < 2; ++i) {
                const Blade blade = test_support::random_stroke(random, kExtent);
                const auto outcome = [&](CutSession& session) {
                    try {
                        const CutResult result = session.cut(blade);
                        bent_cuts += blade.line.size() > 2 && result.status == CutStatus::done ? 1 : 0;
                        return result.message + " after attempts: " + std::to_string(result.report.attempts);
                    } catch (const Error& error) {
                        return error.what() + error.where();
                    }
                };
                EXPECT_EQ(outcome(lived), outcome(fresh));
                EXPECT_TRUE(test_support::SessionState(lived) == test_support::SessionState(fresh))
                    << "round " << round << ", cut " << i;
            }
        }
        EXPECT_GT(bent_cuts, 12u);
    }

    TEST(CutRetry, TheLocalEdgeOfAWoundForgetsWhatWasTakenBack)
    {
        CutStore store(graded_layers());
        const SweptBlade blade(drawn(3));
        const CutOptions options;
        StrokeState stroke { .store = store, .blade = blade, .options = options, .marks = BladeMarks(store, blade) };
        for (TetId t = 0; t < static_cast<TetId>(store.counts().tet_slots); t += 7)
            stroke.cut_faces.insert(store.tet(t), t % 4);
        const double edge = wound_edge(stroke);
        ASSERT_GT(edge, 0.0);
        store.begin();
        for (TetId t = 0; t < static_cast<TetId>(store.counts().tet_slots); t += 3)
            store.remove_tet(t);
        store.rollback();
        EXPECT_EQ(wound_edge(stroke), edge);
    }

    TEST(CutRetry, ARefusalNamesTheLimitAndTheAttempts)
    {
        EXPECT_EQ(
            quality_message("lie", 0.098, "off"), "the wound would lie more than 0.098 local edges off the blade");
        const CutQualityError broken(CutQualityError::Kind::shape, "a face was lost", "vertex 3");
        EXPECT_STREQ(final_error(broken, 1).what(), "a face was lost; try another blade");
        const CutQualityError refusal = final_error(broken, kMostAttempts);
        EXPECT_STREQ(refusal.what(),
            "a face was lost; 6 attempts were made, with less snapping or more bends followed; try another blade");
        EXPECT_EQ(refusal.where(), "vertex 3");
        EXPECT_EQ(refusal.kind(), CutQualityError::Kind::shape);
        const CutQualityError growth(CutQualityError::Kind::growth, "too many; mesh finer", "3 elements crossed");
        EXPECT_STREQ(final_error(growth, 3).what(), "too many; mesh finer");
        EXPECT_EQ(final_error(growth, 3).kind(), CutQualityError::Kind::growth);
    }

    TEST(CutSession, CutsThatCrossInOneSpotEndAtTheElementLimit)
    {
        CutSession session(test_support::three_layers(8, 8, 4, 3.0));
        CutOptions options;
        EXPECT_EQ(options.element_limit, 20'000'000u);
        options.element_limit = 4000;
        std::string refusal;
        for (int i = 0; i < 40 && refusal.empty(); ++i) {
            const double turn = 0.4 + 0.31 * i;
            const Vec3 way(8.0 * std::cos(turn), 8.0 * std::sin(turn), 0.0), middle(12.1, 11.8, 12.0);
            const test_support::SessionState before(session);
            const Blade blade {
                .line = { middle - way, middle + way }, .directions = { { 0.05, 0.02, -1.0 } }, .depth_mm = 8.0
            };
            try {
                static_cast<void>(session.cut(blade, options));
            } catch (const SolverError& error) {
                if (error.where() != "element_limit")
                    continue; // another guarantee
                refusal = error.what();
                EXPECT_TRUE(test_support::SessionState(session) == before);
            }
            EXPECT_LE(session.tet_count(), 4000u);
        }
        EXPECT_NE(refusal.find("more than 4000 elements"), std::string::npos) << refusal;
        CutSession small(test_support::three_layers(2, 2, 2, 3.0));
        EXPECT_THROW(static_cast<void>(small.cut(drawn(2), { .element_limit = 0 })), InputError);
    }

    TEST(CutSession, MemoryFollowsWhatWasCut)
    {
        CutSession session(test_support::three_layers(8, 8, 4, 3.0));
        EXPECT_EQ(session.bytes().journal, 0u);
        std::mt19937 random(5);
        std::vector<std::size_t> journal, mesh;
        const Blade blade = drawn(5);
        for (int i = 0; i < 12; ++i) { // the same cut, taken back again and again
            ASSERT_EQ(session.cut(blade).status, CutStatus::done);
            journal.push_back(session.bytes().journal);
            mesh.push_back(session.bytes().mesh);
            static_cast<void>(session.undo());
        }
        EXPECT_EQ(journal.front(), journal.back());
        EXPECT_EQ(mesh[1], mesh.back()); // the first round fills what the others use again
        // A large hole in the free list is not copied into every record.
        ASSERT_EQ(session.ablate(test_support::random_marks(random, session, kExtent, 10.0)).status, CutStatus::done);
        const std::size_t first = session.bytes().journal;
        Blade small { .line = { { 1.1, 1.2, 12 }, { 2.7, 1.9, 12 } }, .directions = { { 0, 0, -1 } }, .depth_mm = 1.5 };
        for (int i = 0; i < 4; ++i) {
            const std::size_t last = session.bytes().journal;
            for (Vec3& p : small.line)
                p.y() += 3.0;
            const CutResult result = session.cut(small);
            if (result.status == CutStatus::done) {
                EXPECT_LT(session.bytes().journal - last, first + 4 * sizeof(TetId) * result.delta.tets_born.size());
            }
        }
    }

} // namespace cut_stroke_session_test
} // namespace retractor::mesh

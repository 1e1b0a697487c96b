#include "planner/session/surgery_session.h"

#include "mesh/base/error.h"
#include "planner/session/surgery_worker.h"
#include "tests/planner/session/layered_wall.h"
#include "tests/support/session_state.h"
#include "tests/support/wait_until.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <new>
#include <thread>

namespace retractor::planner {
namespace surgery_session_test {

    // Positions of some 100 mm, a few operations each.
    constexpr double kRoundingMm = 1e-10;
    // The knife's own promise: depth, ends and lips are right to a tenth of the local edge.
    constexpr double kCutToleranceMm = 0.1 * kSlabEdgeMm;

    Touch at(SurgerySession& live_session, double x, double z)
    {
        const auto found = touch(*live_session.picture(), ray_down(x, z));
        if (!found)
            throw InputError("the ray misses the slab");
        return *found;
    }

    /// Press, draw with a point every 2 mm, release.
    KnifeAnswer draw(SurgerySession& live_session, const Vec3& from, const Vec3& to, const KnifeSettings& settings)
    {
        if (KnifeAnswer begun = live_session.begin_stroke(at(live_session, from.x(), from.z()), settings); !begun.done)
            return begun;
        const int points = std::max(1, static_cast<int>((to - from).norm() / 2.0));
        for (int i = 1; i <= points; ++i) {
            const Vec3 p = from + (to - from) * i / points;
            if (const auto found = touch(*live_session.picture(), ray_down(p.x(), p.z())))
                (void)live_session.draw_to(*found);
        }
        return live_session.finish_stroke();
    }

    bool same_mesh(const mesh::TetMesh& a, const mesh::TetMesh& b)
    {
        return a.vertices.rows() == b.vertices.rows() && (a.vertices.array() == b.vertices.array()).all()
            && a.nodes == b.nodes && a.labels == b.labels;
    }

    TEST(WallPicture, ATouchOfTheMovedSurfaceIsMappedBackToRest)
    {
        SurgerySession live_session(layered_wall());
        WallPicture moved = *live_session.picture();
        for (Eigen::Index v = 0; v < moved.shown.rows(); ++v) // affine: exact within each face
            moved.shown.row(v) += Eigen::RowVector3d(0.1 * moved.shown(v, 2) + 3.0, 2.0, -0.05 * moved.shown(v, 0));
        const Vec3 rest(31.0, 0.0, 47.0);
        const Vec3 shown = rest + Vec3(0.1 * rest.z() + 3.0, 2.0, -0.05 * rest.x());
        const auto found = touch(moved, ray_down(shown.x(), shown.z()));
        ASSERT_TRUE(found);
        EXPECT_LT((found->rest - rest).norm(), kRoundingMm);
        EXPECT_LT((found->shown - shown).norm(), kRoundingMm);
        EXPECT_LT((found->inward - Vec3::UnitY()).norm(), kRoundingMm);
        EXPECT_NEAR(found->distance, 52.0, kRoundingMm);
        EXPECT_EQ(found->label, kSkin);
        EXPECT_FALSE(found->on_lip);
        EXPECT_FALSE(touch(moved, ray_down(-50.0, 47.0)));
        EXPECT_FALSE(touch(moved, { { 31.0, -50.0, 47.0 }, -Vec3::UnitY() })) << "behind the eye";
    }

    TEST(WallPicture, TheWallIsAsThickAsItIs)
    {
        SurgerySession live_session(layered_wall());
        const auto thick = thickness_near(*live_session.picture()->surface, at(live_session, 60.0, 60.0));
        ASSERT_TRUE(thick);
        EXPECT_NEAR(*thick, kSlabThicknessMm, 0.1); // the rays start 0.01 mm under the skin
        EXPECT_FALSE(thickness_near(*live_session.picture()->surface, at(live_session, 60.0, 60.0), 40.0, 20.0));
    }

    TEST(SurgerySession, CutsWhereItIsDrawnAsDeepAsAsked)
    {
        SurgerySession live_session(layered_wall());
        EXPECT_TRUE(wound_rims(*live_session.picture()->surface).empty());
        const KnifeAnswer answer = draw(live_session, { 20.0, 0.0, 62.0 }, { 90.0, 0.0, 62.0 }, { .depth_mm = 12.0 });
        ASSERT_TRUE(answer.done) << answer.reason;
        EXPECT_EQ(answer.reason, "");
        ASSERT_EQ(live_session.cuts().size(), 1U);
        const CutEntry& cut = live_session.cuts().front();
        EXPECT_NEAR(cut.length_mm, 70.0, kRoundingMm);
        EXPECT_EQ(cut.depth_mm, 12.0);
        EXPECT_NEAR(cut.report.lip_area_mm2, 70.0 * 12.0, (70.0 + 2.0 * 12.0) * kCutToleranceMm);
        const std::shared_ptr<const WallPicture> picture = live_session.picture();
        const WallSurface& surface = *picture->surface;
        double west = 1e9, east = -1e9, deepest = 0.0;
        std::size_t lips = 0;
        for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
            if (surface.is_lip[t] == 0)
                continue;
            ++lips;
            for (const VertexId v : surface.triangles[t]) {
                EXPECT_NEAR(surface.rest(v, 2), 62.0, kCutToleranceMm);
                west = std::min(west, surface.rest(v, 0));
                east = std::max(east, surface.rest(v, 0));
                deepest = std::max(deepest, surface.rest(v, 1));
            }
        }
        EXPECT_GT(lips, 0U);
        EXPECT_NEAR(west, 20.0, kCutToleranceMm);
        EXPECT_NEAR(east, 90.0, kCutToleranceMm);
        EXPECT_NEAR(deepest, 12.0, kCutToleranceMm);
        // The rim is the two lips' edges on the skin: twice the length of the wound.
        double rim = 0.0;
        for (const auto& edge : wound_rims(surface))
            if (surface.rest(edge[0], 1) == 0.0 && surface.rest(edge[1], 1) == 0.0)
                rim += (surface.rest.row(edge[0]) - surface.rest.row(edge[1])).norm();
        EXPECT_NEAR(rim, 2.0 * 70.0, 4.0 * kCutToleranceMm);
        EXPECT_EQ(live_session.picture(), picture) << "made once while nothing changes";
    }

    TEST(SurgerySession, OpensWhileTheKnifeMoves)
    {
        SurgerySession live_session(layered_wall());
        ASSERT_TRUE(live_session.begin_stroke(at(live_session, 20.0, 62.0), {}).done);
        std::size_t steps = 0, before = live_session.session().tet_count();
        for (double x = 22.0; x <= 80.0; x += 2.0) {
            ASSERT_TRUE(live_session.draw_to(at(live_session, x, 62.0)).done);
            if (live_session.session().tet_count() != before)
                ++steps;
            before = live_session.session().tet_count();
        }
        EXPECT_GE(steps, 8U) << "60 mm are 12 steps";
        EXPECT_FALSE(live_session.can_undo()) << "a stroke is open";
        EXPECT_TRUE(live_session.finish_stroke().done);
        EXPECT_TRUE(live_session.can_undo());
    }

    TEST(SurgerySession, UndoAndRedoAreExact)
    {
        SurgerySession live_session(layered_wall());
        std::vector<mesh::TetMesh> states { live_session.session().compact_mesh() };
        for (const double z : { 30.0, 62.0, 91.0 }) {
            ASSERT_TRUE(draw(live_session, { 20.0, 0.0, z }, { 80.0, 0.0, z + 4.0 }, {}).done);
            states.push_back(live_session.session().compact_mesh());
        }
        for (std::size_t n = 3; n-- > 0;) {
            live_session.undo();
            EXPECT_TRUE(same_mesh(live_session.session().compact_mesh(), states[n]));
            EXPECT_FALSE(live_session.cuts()[n].in_force);
        }
        EXPECT_FALSE(live_session.can_undo());
        EXPECT_THROW(live_session.undo(), InputError);
        live_session.redo();
        live_session.redo();
        EXPECT_TRUE(same_mesh(live_session.session().compact_mesh(), states[2]));
        ASSERT_EQ(live_session.cuts().size(), 3U);
        EXPECT_TRUE(live_session.cuts()[1].in_force);
        // Another cut now takes the place of the one that could still be redone.
        ASSERT_TRUE(draw(live_session, { 20.0, 0.0, 100.0 }, { 60.0, 0.0, 100.0 }, {}).done);
        EXPECT_EQ(live_session.cuts().size(), 3U);
        EXPECT_TRUE(live_session.cuts()[2].in_force);
        EXPECT_FALSE(live_session.can_redo());
    }

    TEST(SurgerySession, AnAbandonedStrokeLeavesNothingBehind)
    {
        SurgerySession live_session(layered_wall());
        ASSERT_TRUE(draw(live_session, { 20.0, 0.0, 30.0 }, { 80.0, 0.0, 30.0 }, {}).done);
        live_session.undo();
        const mesh::TetMesh before = live_session.session().compact_mesh();
        ASSERT_TRUE(live_session.begin_stroke(at(live_session, 20.0, 62.0), {}).done);
        for (double x = 22.0; x <= 60.0; x += 2.0)
            ASSERT_TRUE(live_session.draw_to(at(live_session, x, 62.0)).done);
        ASSERT_FALSE(same_mesh(live_session.session().compact_mesh(), before));
        live_session.abandon_stroke();
        EXPECT_TRUE(same_mesh(live_session.session().compact_mesh(), before));
        EXPECT_FALSE(live_session.stroke_open());
        EXPECT_TRUE(live_session.can_redo());
        live_session.abandon_stroke(); // nothing to do
        EXPECT_TRUE(same_mesh(live_session.session().compact_mesh(), before));
    }

    TEST(SurgerySession, GoesThroughTheWallWhenAsked)
    {
        SurgerySession live_session(layered_wall());
        ASSERT_TRUE(draw(live_session, { 20.0, 0.0, 62.0 }, { 80.0, 0.0, 62.0 }, { .through_wall = true }).done);
        EXPECT_GT(live_session.cuts().front().depth_mm, kSlabThicknessMm);
        EXPECT_NEAR(live_session.cuts().front().report.lip_area_mm2, 60.0 * kSlabThicknessMm,
            2.0 * kSlabThicknessMm * kCutToleranceMm);
    }

    TEST(SurgerySession, CrossesAnEarlierWound)
    {
        SurgerySession live_session(layered_wall());
        ASSERT_TRUE(draw(live_session, { 20.0, 0.0, 62.0 }, { 90.0, 0.0, 62.0 }, {}).done);
        const KnifeAnswer second = draw(live_session, { 53.0, 0.0, 30.0 }, { 56.0, 0.0, 95.0 }, {});
        ASSERT_TRUE(second.done) << second.reason;
        EXPECT_NEAR(live_session.cuts()[1].report.lip_area_mm2, std::hypot(3.0, 65.0) * 15.0, 80.0 * kCutToleranceMm);
        mesh::check_mesh(live_session.session().compact_mesh());
    }

    /// Four strokes through the wall that cross near their ends, round (60, 60): what lies between them hangs on
    /// nothing.
    void cut_a_square_free(SurgerySession& live_session, double half_side)
    {
        const double near = 60.0 - half_side, far = 60.0 + half_side, over = 6.0;
        for (const double side : { near, far }) {
            const KnifeSettings through { .through_wall = true };
            ASSERT_TRUE(draw(live_session, { side, 0.0, near - over }, { side, 0.0, far + over }, through).done);
            ASSERT_TRUE(draw(live_session, { near - over, 0.0, side }, { far + over, 0.0, side }, through).done);
        }
    }

    TEST(SurgerySession, TakesOutAPieceThatWasCutFreeAndGivesItBack)
    {
        for (const double tension : { 0.0, 0.04 }) {
            SurgerySession live_session(layered_wall());
            live_session.set_tension(tension);
            const KnifeAnswer whole = live_session.take_out(at(live_session, 60.0, 60.0), 0.0);
            EXPECT_FALSE(whole.done);
            EXPECT_NE(whole.reason.find("cut it free first"), std::string::npos) << whole.reason;
            cut_a_square_free(live_session, 16.0);
            const mesh::TetMesh before = live_session.session().compact_mesh();
            const KnifeAnswer answer = live_session.take_out(at(live_session, 60.0, 60.0), 0.0);
            ASSERT_TRUE(answer.done) << answer.reason;
            ASSERT_EQ(live_session.cuts().size(), 5U);
            const CutEntry& taken = live_session.cuts().back();
            EXPECT_EQ(taken.taken_out, "muscle") << "half of the wall's thickness";
            EXPECT_TRUE(taken.several_tissues);
            EXPECT_NEAR(taken.report.removed_volume_mm3, 32.0 * 32.0 * kSlabThicknessMm,
                4.0 * 32.0 * kSlabThicknessMm * kCutToleranceMm);
            EXPECT_FALSE(touch(*live_session.picture(), ray_down(60.0, 60.0))) << "one looks through the wall";
            live_session.relax(10.0);
            const mesh::TetMesh after = live_session.session().compact_mesh();
            live_session.undo();
            EXPECT_TRUE(same_mesh(live_session.session().compact_mesh(), before));
            EXPECT_TRUE(touch(*live_session.picture(), ray_down(60.0, 60.0)));
            EXPECT_FALSE(live_session.cuts().back().in_force);
            live_session.redo();
            EXPECT_TRUE(same_mesh(live_session.session().compact_mesh(), after));
            EXPECT_EQ(live_session.take_remark(), "");
        }
    }

    TEST(SurgerySession, TakesOutOneTissueRoundAPlace)
    {
        SurgerySession live_session(layered_wall());
        EXPECT_THROW((void)live_session.take_out(at(live_session, 110.0, 60.0), -1.0), InputError);
        EXPECT_THROW(
            (void)live_session.take_out(at(live_session, 110.0, 60.0), std::numeric_limits<double>::infinity()),
            InputError);
        const KnifeAnswer little = live_session.take_out(at(live_session, 110.0, 62.5), 0.1);
        EXPECT_FALSE(little.done);
        EXPECT_NE(little.reason.find("smaller than the elements"), std::string::npos) << little.reason;
        ASSERT_TRUE(live_session.take_out(at(live_session, 110.0, 60.0), 15.0).done);
        EXPECT_EQ(live_session.cuts().back().taken_out, "rib");
        // The bone is 10 mm thick and 20 mm wide, the ball half as much: a segment of a sphere's half.
        const double half_ball = 2.0 / 3.0 * 3.14159265 * std::pow(15.0, 3.0);
        EXPECT_GT(live_session.cuts().back().report.removed_volume_mm3, 0.5 * half_ball);
        EXPECT_LT(live_session.cuts().back().report.removed_volume_mm3, half_ball);
        const auto bed = touch(*live_session.picture(), ray_down(110.0, 60.0));
        ASSERT_TRUE(bed);
        EXPECT_NE(bed->label, kBone) << "what lay under it is seen";
        EXPECT_TRUE(bed->on_lip);
        const KnifeAnswer everything = live_session.take_out(*bed, 1000.0);
        EXPECT_TRUE(everything.done) << "one tissue is never everything here";
    }

    Vec3 centroid(const mesh::TetMesh& mesh, TetId t)
    {
        Vec3 middle = Vec3::Zero();
        for (const VertexId v : mesh.tet(t))
            middle += 0.25 * mesh.vertices.row(v).transpose();
        return middle;
    }

    TEST(SurgerySession, LeavesWhatIsBeyondTheOutlineOrHeldWhereItIs)
    {
        SurgerySetup setup = layered_wall();
        setup.region = { .corridor = { { 60.0, 0.0, 20.0 }, { 60.0, 0.0, 100.0 } }, .meshed_mm = 40.0 };
        SurgerySession live_session(std::move(setup));
        const auto beyond = [&] { // and an edge further: elements at the border are divided
            const mesh::TetMesh mesh = live_session.session().compact_mesh();
            std::size_t count = 0;
            for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
                count += centroid(mesh, t).x() > 60.0 + 40.0 - kRimMarginMm + kSlabEdgeMm ? 1U : 0U;
            return count;
        };
        const std::size_t before = beyond();
        const KnifeAnswer over = live_session.take_out(at(live_session, 84.0, 60.0), 20.0);
        EXPECT_TRUE(over.done);
        EXPECT_EQ(over.reason, "a part of the ball was not taken out: tissue lies outside the region that can be cut");
        EXPECT_EQ(live_session.cuts().back().omitted, "tissue lies outside the region that can be cut");
        EXPECT_EQ(beyond(), before);
        EXPECT_FALSE(live_session.cuts().back().several_tissues);
        const KnifeAnswer outside = live_session.take_out(at(live_session, 96.0, 20.0), 20.0);
        EXPECT_FALSE(outside.done);
        EXPECT_EQ(outside.reason.find("nothing can be taken out here: the wall is modelled"), 0U) << outside.reason;

        const SurgerySetup whole = layered_wall();
        SurgerySession held(whole);
        const KnifeAnswer side = held.take_out(at(held, 10.0, 60.0), 15.0);
        EXPECT_TRUE(side.done);
        EXPECT_EQ(side.reason, "a part of the ball was not taken out: tissue is held by a support of the wall");
        for (const VertexId v : whole.held)
            EXPECT_TRUE(held.session().has_vertex(v));
        const KnifeAnswer nothing = held.take_out(at(held, 1.0, 30.0), 4.0);
        EXPECT_FALSE(nothing.done);
        EXPECT_EQ(nothing.reason, "nothing can be taken out here: tissue is held by a support of the wall");
        EXPECT_EQ(held.session().cut_count(), 1U);
    }

    TEST(SurgerySession, NeverTakesOutEverythingNorWhatIsNoLongerThere)
    {
        SurgerySetup setup = layered_wall();
        setup.held.clear();
        std::fill(setup.wall.labels.begin(), setup.wall.labels.end(), kMuscle);
        SurgerySession live_session(std::move(setup));
        const KnifeAnswer everything = live_session.take_out(at(live_session, 60.0, 60.0), 1000.0);
        EXPECT_FALSE(everything.done);
        EXPECT_EQ(everything.reason, "this would remove the whole wall");
        const Touch former = at(live_session, 61.0, 63.0);
        ASSERT_TRUE(draw(live_session, { 50.0, 0.0, 63.0 }, { 70.0, 0.0, 63.0 }, {}).done);
        const KnifeAnswer changed = live_session.take_out(former, 0.0);
        EXPECT_FALSE(changed.done);
        EXPECT_EQ(changed.reason, "the tissue has changed since the click: click again");
        EXPECT_EQ(live_session.session().cut_count(), 1U);
    }

    /// A wound at z = 60 and, taken out where asked, the wall's side from x = 0 to 15 beside it, which is held and lies
    /// on a bed as all of it does.
    SurgerySession wounded_session(bool without_side)
    {
        SurgerySetup setup = layered_wall();
        std::vector<char> held(setup.wall.vertex_count(), 0);
        for (const VertexId v : setup.held)
            held[static_cast<std::size_t>(v)] = 1;
        for (Eigen::Index v = 0; v < setup.wall.vertices.rows(); ++v)
            if (setup.wall.vertices(v, 1) == kSlabThicknessMm && held[static_cast<std::size_t>(v)] == 0)
                setup.bedded.push_back({ static_cast<VertexId>(v), 1.0 });
        mesh::CutSession session(setup.wall);
        const mesh::Blade blade { .line = { { 20.0, 0.0, 61.0 }, { 50.0, 0.0, 61.0 }, { 80.0, 0.0, 61.0 } },
            .directions = { Vec3::UnitY(), Vec3::UnitY(), Vec3::UnitY() },
            .depth_mm = 15.0 };
        std::vector<mesh::MeshDelta> cuts { session.cut(blade).delta };
        if (without_side)
            cuts.push_back(
                session.ablate(test_support::elements_in(session, { Vec3(0.0, 0.0, 30.0), Vec3(15.0, 30.0, 90.0) }))
                    .delta);
        return { std::move(setup), std::move(session), cuts };
    }

    double largest_move_of_held(SurgerySession& live_session)
    {
        const std::shared_ptr<const WallPicture> picture = live_session.picture();
        double largest = 0.0;
        for (const VertexId v : layered_wall().held)
            largest = std::max(largest, (picture->shown.row(v) - picture->surface->rest.row(v)).norm());
        return largest;
    }

    /// Of the vertices that there are, by id.
    Points shown_vertices(SurgerySession& live_session)
    {
        const mesh::CutSession& session = live_session.session();
        Points shown(static_cast<Eigen::Index>(session.vertex_count()), 3);
        Eigen::Index row = 0;
        for (VertexId v = 0; v < static_cast<VertexId>(session.vertex_slots()); ++v)
            if (session.has_vertex(v))
                shown.row(row++) = live_session.picture()->shown.row(v);
        return shown;
    }

    TEST(SurgerySession, HooksFindTheSupportsOfTissueThatIsPutBackAfterThem)
    {
        // Displacements of some mm, solved to a residual of 1e-8.
        constexpr double kSolvedMm = 1e-5;
        std::vector<Points> shown;
        for (const bool without_side : { true, false }) {
            SurgerySession live_session = wounded_session(without_side);
            ASSERT_TRUE(live_session.place_hook(at(live_session, 35.0, 63.0)).done);
            ASSERT_TRUE(live_session.place_hook(at(live_session, 35.0, 59.0)).done);
            live_session.pull_all_hooks(6.0);
            if (without_side) {
                EXPECT_EQ(live_session.cuts().back().taken_out, "muscle");
                EXPECT_TRUE(live_session.cuts().back().several_tissues);
                live_session.undo();
            }
            while (live_session.moving())
                live_session.relax(10.0);
            EXPECT_EQ(live_session.take_remark(), "");
            EXPECT_EQ(live_session.hooks().hooks.size(), 2U);
            EXPECT_EQ(live_session.hooks().refusal, "");
            EXPECT_EQ(largest_move_of_held(live_session), 0.0);
            shown.push_back(shown_vertices(live_session));
        }
        ASSERT_EQ(shown[0].rows(), shown[1].rows());
        EXPECT_LT((shown[0] - shown[1]).rowwise().norm().maxCoeff(), kSolvedMm);
    }

    TEST(SurgerySession, SpringsFindTheSupportsOfTissueThatIsPutBackAfterThem)
    {
        SurgerySession live_session = wounded_session(true);
        live_session.set_tension(0.06);
        live_session.undo();
        while (live_session.moving())
            live_session.relax(50.0);
        EXPECT_GT(live_session.gape_mm(), 0.5);
        EXPECT_EQ(largest_move_of_held(live_session), 0.0);
        EXPECT_EQ(live_session.take_remark(), "");
    }

    TEST(SurgerySession, ABedGoesWithTheTissueThatLayOnIt)
    {
        SurgerySetup setup = layered_wall();
        const Vec3 middle(35.0, 0.0, 35.0);
        std::vector<VertexId> gone;
        for (Eigen::Index v = 0; v < setup.wall.vertices.rows(); ++v)
            if ((setup.wall.vertices.row(v).transpose() - middle).norm() < 15.0 && setup.wall.vertices(v, 1) == 0.0)
                gone.push_back(static_cast<VertexId>(v));
        std::vector<Points> shown;
        for (const bool bedded : { true, false }) {
            SurgerySetup same = setup;
            if (bedded)
                for (const VertexId v : gone)
                    same.bedded.push_back({ v, 1e3 });
            SurgerySession live_session(std::move(same));
            ASSERT_TRUE(live_session.take_out(at(live_session, middle.x(), middle.z()), 25.0).done);
            for (const VertexId v : gone)
                ASSERT_FALSE(live_session.session().has_vertex(v));
            ASSERT_TRUE(draw(live_session, { 20.0, 0.0, 91.0 }, { 90.0, 0.0, 91.0 }, {}).done);
            ASSERT_TRUE(std::any_of(gone.begin(), gone.end(), [&](VertexId v) {
                return live_session.session().has_vertex(v);
            })) << "ids are used again";
            ASSERT_TRUE(live_session.place_hook(at(live_session, 50.0, 93.0)).done);
            live_session.pull_all_hooks(4.0);
            shown.push_back(shown_vertices(live_session));
        }
        ASSERT_EQ(shown[0].rows(), shown[1].rows());
        EXPECT_LT((shown[0] - shown[1]).rowwise().norm().maxCoeff(), kRoundingMm);
    }

    TEST(SurgerySession, HooksOutliveTissueThatIsTakenOut)
    {
        SurgerySession live_session(layered_wall());
        ASSERT_TRUE(draw(live_session, { 20.0, 0.0, 90.0 }, { 80.0, 0.0, 90.0 }, {}).done);
        ASSERT_TRUE(live_session.place_hook(at(live_session, 50.0, 92.0)).done);
        ASSERT_TRUE(live_session.place_hook(at(live_session, 50.0, 88.0)).done);
        live_session.pull_all_hooks(4.0);
        ASSERT_TRUE(live_session.take_out(at(live_session, 60.0, 40.0), 10.0).done);
        EXPECT_EQ(live_session.hooks().hooks.size(), 2U);
        EXPECT_EQ(live_session.hooks().refusal, "");
        EXPECT_LT(live_session.hooks().residual, 1e-8);
        live_session.undo();
        EXPECT_EQ(live_session.hooks().hooks.size(), 2U);
        EXPECT_LT(live_session.hooks().residual, 1e-8);
        EXPECT_EQ(live_session.take_remark(), "");
    }

    TEST(SurgerySession, DoesNotCutBoneUnlessItIsASaw)
    {
        SurgerySession live_session(layered_wall());
        const KnifeAnswer refused = draw(live_session, { 110.0, 0.0, 30.0 }, { 110.0, 0.0, 90.0 }, {});
        EXPECT_FALSE(refused.done);
        EXPECT_NE(refused.reason.find("rib"), std::string::npos) << refused.reason;
        EXPECT_FALSE(live_session.stroke_open());
        // From skin over bone: the bone stays whole.
        ASSERT_TRUE(draw(live_session, { 60.0, 0.0, 62.0 }, { 115.0, 0.0, 62.0 }, { .depth_mm = 8.0 }).done);
        const double scalpel = live_session.cuts().front().report.lip_area_mm2;
        EXPECT_LT(scalpel, 45.0 * 8.0);
        live_session.undo();
        ASSERT_TRUE(
            draw(live_session, { 60.0, 0.0, 62.0 }, { 115.0, 0.0, 62.0 }, { .depth_mm = 8.0, .cuts_bone = true }).done);
        EXPECT_NEAR(live_session.cuts().front().report.lip_area_mm2, 55.0 * 8.0, 70.0 * kCutToleranceMm);
    }

    TEST(SurgerySession, RefusesWhatIsNoStrokeAndSaysWhy)
    {
        SurgerySession live_session(layered_wall());
        const mesh::TetMesh before = live_session.session().compact_mesh();
        ASSERT_TRUE(live_session.begin_stroke(at(live_session, 60.0, 60.0), {}).done);
        EXPECT_THROW((void)live_session.begin_stroke(at(live_session, 60.0, 60.0), {}), InputError);
        EXPECT_THROW(live_session.undo(), InputError);
        const KnifeAnswer click = live_session.finish_stroke();
        EXPECT_FALSE(click.done);
        EXPECT_EQ(click.reason, "the knife did not move: draw a line on the skin");

        ASSERT_TRUE(live_session.begin_stroke(at(live_session, 20.0, 60.0), {}).done);
        const KnifeAnswer jump = live_session.draw_to(at(live_session, 90.0, 60.0));
        EXPECT_FALSE(jump.done);
        EXPECT_NE(jump.reason.find("jumps"), std::string::npos);
        EXPECT_FALSE(live_session.finish_stroke().done);
        EXPECT_TRUE(same_mesh(live_session.session().compact_mesh(), before));
        EXPECT_TRUE(live_session.cuts().empty());

        EXPECT_THROW((void)live_session.finish_stroke(), InputError);
        EXPECT_THROW((void)live_session.draw_to(at(live_session, 20.0, 60.0)), InputError);
        for (const double depth : { 0.0, -3.0, std::numeric_limits<double>::quiet_NaN() })
            EXPECT_THROW(
                (void)live_session.begin_stroke(at(live_session, 60.0, 60.0), { .depth_mm = depth }), InputError);

        ASSERT_TRUE(draw(live_session, { 20.0, 0.0, 62.0 }, { 90.0, 0.0, 62.0 }, {}).done);
        Touch in_wound = at(live_session, 60.0, 60.0);
        in_wound.on_lip = true;
        EXPECT_FALSE(live_session.begin_stroke(in_wound, {}).done);
    }

    TEST(SurgerySession, CutsOnlyWhereThereIsAWallAndSaysWhatItLeftOut)
    {
        SurgerySetup setup = layered_wall();
        setup.region = { .corridor = { { 60.0, 0.0, 20.0 }, { 60.0, 0.0, 100.0 } }, .meshed_mm = 40.0 };
        SurgerySession live_session(std::move(setup));
        const KnifeAnswer outside = live_session.begin_stroke(at(live_session, 96.0, 60.0), {});
        EXPECT_FALSE(outside.done);
        EXPECT_NE(outside.reason.find("inside the outline"), std::string::npos) << outside.reason;
        EXPECT_FALSE(live_session.take_out(at(live_session, 96.0, 60.0), 10.0).done);
        // Out over the border, at x = 88, and off the slab.
        ASSERT_TRUE(live_session.begin_stroke(at(live_session, 60.0, 62.0), {}).done);
        std::string said;
        for (double x = 62.0; x < 118.0; x += 2.0)
            if (const KnifeAnswer answer = live_session.draw_to(at(live_session, x, 62.0)); !answer.reason.empty())
                said += answer.reason + "\n";
        EXPECT_EQ(said, "the line is not cut here: the line left the region that can be cut\n") << "once";
        const KnifeAnswer end = live_session.finish_stroke();
        EXPECT_TRUE(end.done);
        EXPECT_EQ(
            end.reason, "cut over 28 mm; a part of the line was not cut: the line left the region that can be cut");
        ASSERT_EQ(live_session.cuts().size(), 1U);
        EXPECT_NEAR(live_session.cuts().front().length_mm, 28.0, kRoundingMm);
        EXPECT_EQ(live_session.cuts().front().omitted, "the line left the region that can be cut");

        ASSERT_TRUE(live_session.begin_stroke(at(live_session, 60.0, 30.0), {}).done);
        ASSERT_TRUE(live_session.draw_to(at(live_session, 80.0, 30.0)).done);
        live_session.leave_wall();
        EXPECT_NE(live_session.finish_stroke().reason.find("cut over 20 mm"), std::string::npos);
        EXPECT_THROW(live_session.leave_wall(), InputError);
        // A gap that is soon behind her, a wound for example, is bridged: nothing is left out.
        ASSERT_TRUE(live_session.begin_stroke(at(live_session, 60.0, 90.0), {}).done);
        live_session.leave_wall();
        ASSERT_TRUE(live_session.draw_to(at(live_session, 80.0, 90.0)).done);
        EXPECT_EQ(live_session.finish_stroke().reason, "");
    }

    TEST(SurgerySession, ALineThatTurnsBackIsCutAsFarAsItCanBe)
    {
        SurgerySession live_session(layered_wall());
        ASSERT_TRUE(live_session.begin_stroke(at(live_session, 20.0, 62.0), {}).done);
        for (double x = 22.0; x <= 60.0; x += 2.0)
            ASSERT_TRUE(live_session.draw_to(at(live_session, x, 62.0)).done);
        std::string reason;
        for (double x = 58.0; x >= 30.0; x -= 2.0)
            if (const KnifeAnswer answer = live_session.draw_to(at(live_session, x, 62.0)); !answer.done)
                reason = answer.reason;
        EXPECT_NE(reason, "");
        const KnifeAnswer end = live_session.finish_stroke();
        ASSERT_TRUE(end.done) << end.reason;
        EXPECT_NE(end.reason, "") << "the surgeon is told that a part was left out";
        mesh::check_mesh(live_session.session().compact_mesh());
    }

    /// A surgery session that is refused what the test chooses, as by a full disk or by the cut itself.
    class RefusedStroke : public testing::Test {
    protected:
        SurgerySession make_session()
        {
            SurgerySetup setup = layered_wall();
            mesh::CutSession session(setup.wall);
            session.set_witness([refuse = refuse_](const mesh::CutEvent& event) {
                if (*refuse)
                    (*refuse)(event.kind);
            });
            return { std::move(setup), std::move(session), {} };
        }
        /// 60 mm, of which the last 3 are left to finish_stroke().
        static void draw_open_stroke(SurgerySession& live_session)
        {
            ASSERT_TRUE(live_session.begin_stroke(at(live_session, 20.0, 62.0), {}).done);
            for (double x = 25.0; x <= 75.0; x += 5.0)
                ASSERT_TRUE(live_session.draw_to(at(live_session, x, 62.0)).done);
            ASSERT_TRUE(live_session.draw_to(at(live_session, 78.0, 62.0)).done);
        }
        using Refusal = std::function<void(mesh::CutEvent::Kind)>;
        std::shared_ptr<Refusal> refuse_ = std::make_shared<Refusal>();
    };

    TEST_F(RefusedStroke, AFullDiskLeavesItOpenToBeFinishedAgainOrAbandoned)
    {
        for (const bool again : { true, false }) {
            SurgerySession live_session = make_session();
            const mesh::TetMesh before = live_session.session().compact_mesh();
            draw_open_stroke(live_session);
            *refuse_ = [](mesh::CutEvent::Kind) { throw IoError("the disk is full"); };
            EXPECT_THROW((void)live_session.finish_stroke(), IoError);
            EXPECT_TRUE(live_session.stroke_open());
            EXPECT_FALSE(live_session.can_undo());
            EXPECT_THROW(live_session.abandon_stroke(), IoError);
            EXPECT_TRUE(live_session.stroke_open());
            *refuse_ = {};
            if (again) {
                const KnifeAnswer answer = live_session.finish_stroke();
                EXPECT_TRUE(answer.done) << answer.reason;
                ASSERT_EQ(live_session.cuts().size(), 1U);
                EXPECT_NEAR(live_session.cuts().front().length_mm, 58.0, kRoundingMm);
                live_session.undo();
            } else {
                live_session.abandon_stroke();
                EXPECT_TRUE(live_session.cuts().empty());
            }
            EXPECT_FALSE(live_session.stroke_open());
            EXPECT_TRUE(same_mesh(live_session.session().compact_mesh(), before));
            EXPECT_TRUE(draw(live_session, { 20.0, 0.0, 30.0 }, { 80.0, 0.0, 30.0 }, {}).done);
            EXPECT_EQ(live_session.session().cut_count(), 1U);
        }
    }

    TEST_F(RefusedStroke, ATipThatCannotBeCutIsLeftOut)
    {
        SurgerySession live_session = make_session();
        draw_open_stroke(live_session);
        *refuse_ = [](mesh::CutEvent::Kind kind) {
            if (kind == mesh::CutEvent::Kind::stroke_step)
                throw SolverError("try it with another point");
        };
        const KnifeAnswer step = live_session.draw_to(at(live_session, 82.0, 62.0));
        EXPECT_FALSE(step.done);
        EXPECT_EQ(step.reason, "try it with another point");
        const KnifeAnswer answer = live_session.finish_stroke();
        ASSERT_TRUE(answer.done) << answer.reason;
        EXPECT_EQ(answer.reason, "cut over 55 mm; a part of the line was not cut: try it with another point");
        ASSERT_EQ(live_session.cuts().size(), 1U);
        EXPECT_NEAR(live_session.cuts().front().length_mm, 55.0, kRoundingMm);
        EXPECT_TRUE(live_session.can_undo());
    }

    TEST_F(RefusedStroke, OneThatCannotBeFinishedIsTakenBackAloud)
    {
        SurgerySession live_session = make_session();
        const mesh::TetMesh before = live_session.session().compact_mesh();
        draw_open_stroke(live_session);
        *refuse_ = [](mesh::CutEvent::Kind kind) {
            if (kind == mesh::CutEvent::Kind::stroke_end)
                throw SolverError("the lips hang together");
        };
        const KnifeAnswer answer = live_session.finish_stroke();
        EXPECT_FALSE(answer.done);
        EXPECT_EQ(answer.reason, "the stroke cannot be finished and was undone: the lips hang together");
        EXPECT_FALSE(live_session.stroke_open());
        EXPECT_TRUE(live_session.cuts().empty());
        EXPECT_TRUE(same_mesh(live_session.session().compact_mesh(), before));
    }

    void come_to_rest(SurgerySession& live_session)
    {
        while (live_session.moving())
            live_session.relax(50.0);
    }

    TEST(SurgerySession, AWoundGapesWithTheTensionItIsUnder)
    {
        double narrower = 0.0, per_strain = 0.0;
        for (const double strain : { 0.02, 0.04, 0.06 }) {
            SurgerySession live_session(layered_wall());
            live_session.set_tension(strain);
            EXPECT_FALSE(live_session.moving()) << "nothing moves before it is cut";
            ASSERT_TRUE(draw(live_session, { 20.0, 0.0, 62.0 }, { 90.0, 0.0, 62.0 }, {}).done);
            EXPECT_TRUE(live_session.moving());
            come_to_rest(live_session);
            EXPECT_GT(live_session.gape_mm(), narrower);
            narrower = live_session.gape_mm();
            // Never wider than in a free sheet, 2 e L / (1 - nu): the deeper tissue holds the wound.
            EXPECT_LT(live_session.gape_mm(), 2.0 * strain * 70.0 / (1.0 - 0.48));
            // Near rest it is nearly linear.
            constexpr double kNonlinearity = 0.1;
            if (per_strain > 0.0) {
                EXPECT_NEAR(live_session.gape_mm() / strain, per_strain, kNonlinearity * per_strain);
            }
            per_strain = live_session.gape_mm() / strain;
            // The lips part across the blade, each to its own side, and nothing moves where the wall is held.
            const WallPicture& picture = *live_session.picture();
            double up = 0.0, down = 0.0;
            for (std::size_t t = 0; t < picture.surface->triangles.size(); ++t)
                for (const VertexId v : picture.surface->triangles[t]) {
                    const double by = picture.shown(v, 2) - picture.surface->rest(v, 2);
                    if (picture.surface->is_lip[t] != 0) {
                        up = std::max(up, by);
                        down = std::min(down, by);
                    }
                    if (const double x = picture.surface->rest(v, 0); x == 0.0 || x == 120.0) {
                        EXPECT_EQ(by, 0.0);
                    }
                }
            EXPECT_GT(up, 0.3 * live_session.gape_mm());
            EXPECT_LT(down, -0.3 * live_session.gape_mm());
        }
    }

    TEST(SurgerySession, AWoundThatIsTakenBackClosesAndTensionMayChangeAtAnyTime)
    {
        SurgerySession live_session(layered_wall());
        ASSERT_TRUE(draw(live_session, { 20.0, 0.0, 62.0 }, { 90.0, 0.0, 62.0 }, {}).done);
        EXPECT_EQ(live_session.gape_mm(), 0.0);
        EXPECT_EQ((live_session.picture()->shown - live_session.picture()->surface->rest).norm(), 0.0)
            << "no tension, no gape";
        const mesh::TetMesh cut = live_session.session().compact_mesh();
        live_session.set_tension(0.04);
        come_to_rest(live_session);
        const double gape = live_session.gape_mm();
        EXPECT_GT(gape, 0.5);
        EXPECT_TRUE(same_mesh(live_session.session().compact_mesh(), cut)) << "tension cuts nothing";
        live_session.set_tension(0.06);
        come_to_rest(live_session);
        EXPECT_GT(live_session.gape_mm(), gape);
        live_session.undo();
        come_to_rest(live_session);

        EXPECT_EQ((live_session.picture()->shown - live_session.picture()->surface->rest).norm(), 0.0)
            << "as it lay before";
        EXPECT_EQ(live_session.gape_mm(), 0.0);
        live_session.redo();
        live_session.set_tension(0.0);
        EXPECT_FALSE(live_session.moving());
        EXPECT_EQ((live_session.picture()->shown - live_session.picture()->surface->rest).norm(), 0.0);
        for (const double bad : { -0.01, 2.0, std::numeric_limits<double>::quiet_NaN() })
            EXPECT_THROW(live_session.set_tension(bad), InputError);
    }

    TEST(SurgerySession, AWoundStaysOpenWhenTheTensionChangesAfterAnUndo)
    {
        SurgerySession live_session(layered_wall());
        live_session.set_tension(0.04);
        ASSERT_TRUE(draw(live_session, { 20.0, 0.0, 30.0 }, { 90.0, 0.0, 30.0 }, {}).done);
        ASSERT_TRUE(draw(live_session, { 20.0, 0.0, 91.0 }, { 90.0, 0.0, 91.0 }, {}).done);
        live_session.undo();
        come_to_rest(live_session);
        const double gape = live_session.gape_mm();
        ASSERT_GT(gape, 0.5);
        live_session.set_tension(0.05);
        EXPECT_EQ(live_session.gape_mm(), gape) << "it goes on from where it stands";
        EXPECT_TRUE(live_session.moving());
        come_to_rest(live_session);
        EXPECT_GT(live_session.gape_mm(), gape);
        EXPECT_EQ(live_session.take_remark(), "");
    }

    TEST(SurgerySession, WithoutSpringsTheTensionStaysAsItWas)
    {
        SurgerySetup setup = layered_wall();
        setup.materials.clear();
        SurgerySession live_session(std::move(setup));
        for (int again = 0; again < 2; ++again)
            EXPECT_THROW(live_session.set_tension(0.04), InputError);
        EXPECT_EQ(live_session.tension(), 0.0);
        ASSERT_TRUE(draw(live_session, { 20.0, 0.0, 62.0 }, { 90.0, 0.0, 62.0 }, {}).done);
        EXPECT_FALSE(live_session.moving());
    }

    TEST(SurgerySession, AStrokeOnTheOpenWoundIsCutWhereTheTissueLies)
    {
        SurgerySession live_session(layered_wall());
        live_session.set_tension(0.06);
        ASSERT_TRUE(draw(live_session, { 20.0, 0.0, 62.0 }, { 90.0, 0.0, 62.0 }, {}).done);
        come_to_rest(live_session);
        // Across the gaping wound, as shown.
        const KnifeAnswer second = draw(live_session, { 55.0, 0.0, 30.0 }, { 55.0, 0.0, 95.0 }, {});
        ASSERT_TRUE(second.done) << second.reason;
        come_to_rest(live_session);
        EXPECT_EQ(live_session.session().cut_count(), 2U);
        mesh::check_mesh(live_session.session().compact_mesh());
    }

    void wait_for(const SurgeryWorker& worker)
    {
        ASSERT_TRUE(test_support::wait_until([&] { return worker.idle(); }));
    }

    TEST(SurgeryWorker, CutsOnItsOwnThreadAndTellsWhatCameOfIt)
    {
        std::atomic<int> told { 0 };
        SurgeryWorker worker(
            [](const Job& job) {
                job.report("mesh", 0.5);
                return layered_wall();
            },
            [&] { ++told; });
        wait_for(worker);
        const std::shared_ptr<const SurgerySnapshot> held = worker.snapshot();
        const SurgerySnapshot& snapshot = *held;
        ASSERT_EQ(snapshot.phase, SurgerySnapshot::Phase::ready);
        EXPECT_EQ(snapshot.labels.size(), 4U);
        const auto touched = [&](double x, double z) { return *touch(*snapshot.picture, ray_down(x, z)); };
        worker.run(surgery::BeginStroke { touched(20.0, 62.0) });
        for (double x = 24.0; x <= 80.0; x += 4.0)
            worker.run(surgery::DrawTo { touched(x, 62.0) });
        worker.run(surgery::FinishStroke {});
        wait_for(worker);
        const SurgerySnapshot cut = *worker.snapshot();
        ASSERT_EQ(cut.cuts.size(), 1U);
        EXPECT_EQ(cut.to_undo, "cut");
        EXPECT_NE(cut.picture->surface, snapshot.picture->surface);
        EXPECT_TRUE(held->cuts.empty()) << "a snapshot that was handed out stays as it was";
        worker.run(surgery::Undo {});
        worker.run(surgery::Undo {}); // one too many: nothing happens
        wait_for(worker);
        EXPECT_EQ(worker.snapshot()->to_undo, "");
        worker.run(surgery::GoTo { 1 });
        wait_for(worker);
        EXPECT_TRUE(worker.snapshot()->cuts.front().in_force);
        EXPECT_EQ(worker.snapshot()->answers, 0U);
        worker.run(surgery::BeginStroke { .at = touched(110.0, 62.0), .number = 2 });
        worker.run(surgery::DrawTo { touched(110.0, 70.0) }); // of a stroke that was refused
        worker.run(surgery::FinishStroke {});
        wait_for(worker);
        EXPECT_EQ(worker.snapshot()->answers, 1U);
        EXPECT_TRUE(worker.snapshot()->refused);
        EXPECT_EQ(worker.snapshot()->refused_stroke, 2U);
        worker.run(surgery::BeginStroke { .at = touched(20.0, 30.0), .number = 3 });
        wait_for(worker);
        EXPECT_EQ(worker.snapshot()->refused_stroke, 0U);
        EXPECT_TRUE(worker.snapshot()->stroke_open);
        worker.run(surgery::AbandonStroke {});
        EXPECT_GT(told, 0);
    }

    TEST(SurgeryWorker, GoesOnWhenASnapshotCannotBeAnnounced)
    {
        std::atomic<bool> fail { false };
        SurgeryWorker worker([](const Job&) { return layered_wall(); },
            [&] {
                if (fail.exchange(false))
                    throw std::bad_alloc();
            });
        wait_for(worker);
        const SurgerySnapshot snapshot = *worker.snapshot();
        fail = true;
        worker.run(surgery::BeginStroke { *touch(*snapshot.picture, ray_down(20.0, 62.0)) });
        for (double x = 24.0; x <= 80.0; x += 4.0)
            worker.run(surgery::DrawTo { *touch(*snapshot.picture, ray_down(x, 62.0)) });
        worker.run(surgery::FinishStroke {});
        wait_for(worker);
        EXPECT_FALSE(fail) << "it was thrown";
        EXPECT_NE(worker.snapshot()->answer.find("could not be brought up to date"), std::string::npos);
        EXPECT_EQ(worker.snapshot()->cuts.size(), 1U);
        worker.run(surgery::Undo {});
        wait_for(worker);
        EXPECT_EQ(worker.snapshot()->to_undo, "");
    }

    TEST(SurgeryWorker, SavesTheWallByTheFunctionOfItsSetup)
    {
        mesh::TetMesh saved;
        SurgeryWorker worker(
            [&](const Job&) {
                SurgerySetup setup = layered_wall();
                setup.write_wall = [&](const std::filesystem::path&, const mesh::TetMesh& wall) { saved = wall; };
                return setup;
            },
            [] {});
        worker.run(surgery::ExportWall { "wall.vtu" });
        wait_for(worker);
        EXPECT_TRUE(same_mesh(saved, layered_wall().wall));
        EXPECT_EQ(worker.snapshot()->answer, "Saved wall.vtu");
        SurgeryWorker without([](const Job&) { return layered_wall(); }, [] {});
        without.run(surgery::ExportWall { "wall.vtu" });
        wait_for(without);
        EXPECT_TRUE(without.snapshot()->refused);
    }

    TEST(SurgeryWorker, SaysWhyThereIsNoSetup)
    {
        SurgeryWorker worker([](const Job&) -> SurgerySetup { throw InputError("no wall", "approach x"); }, [] {});
        wait_for(worker);
        EXPECT_EQ(worker.snapshot()->phase, SurgerySnapshot::Phase::failed);
        EXPECT_EQ(worker.snapshot()->failure, "approach x: no wall");
        worker.run(surgery::Undo {}); // without a session
        wait_for(worker);
        EXPECT_EQ(worker.snapshot()->phase, SurgerySnapshot::Phase::failed);
    }

    TEST(SurgeryWorker, EndsInTheMiddleOfAStrokeAndOfPreparing)
    {
        {
            SurgeryWorker worker([](const Job&) { return layered_wall(); }, [] {});
            wait_for(worker);
            const SurgerySnapshot snapshot = *worker.snapshot();
            worker.run(surgery::BeginStroke { *touch(*snapshot.picture, ray_down(20.0, 62.0)) });
            for (double x = 24.0; x <= 80.0; x += 4.0)
                worker.run(surgery::DrawTo { *touch(*snapshot.picture, ray_down(x, 62.0)) });
        }
        {
            SurgeryWorker worker(
                [](const Job& job) -> SurgerySetup {
                    while (!job.cancelled())
                        std::this_thread::sleep_for(std::chrono::milliseconds(2));
                    throw InputError("cancelled");
                },
                [] {});
        }
        SUCCEED() << "both ended";
    }

} // namespace surgery_session_test
} // namespace retractor::planner

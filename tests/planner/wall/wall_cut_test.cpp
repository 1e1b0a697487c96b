#include "fem/statics/opening.h"
#include "planner/wall/wall_cut.h"

#include "datasets/phantoms/phantom.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/approach/approach_templates.h"
#include "planner/plan/plan.h"
#include "planner/wall/supports.h"
#include "tests/support/block_case.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>
#include <set>
#include <string_view>
#include <utility>

namespace retractor::planner {
namespace wall_cut_test {

    constexpr double kRoundOff = 1e-9; // of volumes and areas of some 1000 mm^3 that a flat blade divides

    const mesh::LabelTable kTable { { 1, "muscle", "muscle", mesh::Role::wall },
        { 7, "rib", "bone", mesh::Role::wall } };

    /// 48 x 32 x 16 mm of muscle; a rib of 4 x 4 mm along x through its middle.
    mesh::TetMesh wall()
    {
        mesh::TetMesh box = mesh::kuhn_box(12, 8, 4, 4.0);
        for (TetId t = 0; t < static_cast<TetId>(box.tet_count()); ++t) {
            Vec3 c = Vec3::Zero();
            for (const VertexId v : box.tet(t))
                c += 0.25 * box.vertices.row(v).transpose();
            if (c.y() > 16 && c.y() < 20 && c.z() > 4 && c.z() < 8)
                box.labels[static_cast<std::size_t>(t)] = 7;
        }
        return box;
    }

    /// Across the rib at x = `x`, along +y, to a depth below the skin (z = 16).
    Approach across(double x, double depth, double from = -2.0, double to = 34.0)
    {
        Approach approach;
        approach.name = "across";
        approach.incision = { { x, from, 16.0 }, { x, to, 16.0 } };
        approach.directions = { { 0, 0, -1 }, { 0, 0, -1 } };
        approach.depth_mm = depth;
        return approach;
    }

    /// The face x = 0 is held.
    fem::Supports held_at_start(const mesh::TetMesh& mesh)
    {
        fem::Supports supports;
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v)
            if (mesh.vertices(v, 0) == 0.0)
                supports.fixed.push_back(v);
        return supports;
    }

    double volume(const mesh::TetMesh& mesh)
    {
        double sum = 0.0;
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            sum += mesh::tet_volume(mesh, t);
        return sum;
    }

    // The part of the box beyond x = 32: on a grid plane, so that its size is known.
    constexpr double kLoose = 16.0 * 32.0 * 16.0;

    CutWall severed(LoosePieces policy)
    {
        Approach approach = across(32.0, 20.0);
        approach.loose_pieces = policy;
        const mesh::TetMesh uncut = wall();
        return cut_wall(uncut, approach, kTable, held_at_start(uncut), {});
    }

    TEST(WallCut, APieceWithoutSupportIsFoundAndNamed)
    {
        const CutWall cut = severed(LoosePieces::held);
        ASSERT_EQ(cut.status, mesh::CutStatus::done) << cut.message;
        ASSERT_EQ(cut.pieces.size(), 2u);
        EXPECT_TRUE(cut.pieces[0].held);
        EXPECT_EQ(cut.pieces[0].fixed, 9u * 5u);
        EXPECT_FALSE(cut.pieces[1].held);
        EXPECT_EQ(cut.pieces[1].number, 2);
        EXPECT_EQ(cut.pieces[1].fixed, 0u);
        EXPECT_NEAR(cut.pieces[1].volume_mm3, kLoose, kRoundOff * kLoose);
        EXPECT_NEAR((cut.pieces[1].centroid - Vec3(40, 16, 8)).norm(), 0.0, 1e-6);
        ASSERT_EQ(cut.pieces[1].labels.size(), 2u);
        EXPECT_EQ(cut.pieces[1].labels[0].first, "muscle");
        EXPECT_NEAR(cut.pieces[1].labels[1].second, 16.0 * 4.0 * 4.0, 1e-6);
        ASSERT_EQ(cut.loose.size(), 1u);
        EXPECT_EQ(cut.loose[0], "piece 2: 8.2 cm3 of muscle at (40, 16, 8) mm has no support: held on a soft bed");
        EXPECT_NE(cut.message.find(cut.loose[0]), std::string::npos);
        EXPECT_TRUE(cut.removed.empty());
    }

    TEST(WallCut, AHeldPieceRestsOnABedOfItsSurface)
    {
        const CutWall cut = severed(LoosePieces::held);
        double stiffness = 0.0;
        for (const fem::BeddedVertex& bedded : cut.supports.bedded) {
            EXPECT_GE(cut.wall.vertices(bedded.vertex, 0), 32.0);
            stiffness += bedded.stiffness;
        }
        const double surface = 2.0 * (16.0 * 32.0 + 32.0 * 16.0 + 16.0 * 16.0);
        EXPECT_NEAR(stiffness, kBedModulus * surface, 1e-9);
        // The stiffness is regular: the body can be solved, and what nothing pulls at stays.
        const std::vector<fem::Material> materials(8,
            fem::Material { .name = "muscle",
                .youngs_modulus_MPa = 0.04,
                .poissons_ratio = 0.45,
                .density_tonne_per_mm3 = 1e-9,
                .source = "test" });
        fem::Opening opening(cut.wall, materials, cut.supports, { .elasticity = fem::Elasticity::linear });
        fem::HookPatch hook { .name = "pull", .side = 1, .nodes = {}, .displacement = Vec3(-1, 0, 0) };
        for (const VertexId v : std::set<VertexId>(cut.wall.nodes.begin(), cut.wall.nodes.end()))
            if (std::abs(cut.wall.vertices(v, 0) - 28.0) < 1e-9)
                hook.nodes.push_back(v);
        const fem::OpeningResult result = opening.open(std::vector<fem::HookPatch> { hook });
        EXPECT_EQ(result.status, fem::OpeningStatus::converged);
        for (const TetId t : cut.pieces[1].tets)
            for (const VertexId v : cut.wall.tet(t))
                EXPECT_NEAR(result.displacement.row(v).norm(), 0.0, 1e-9);
    }

    TEST(WallCut, ARemovedPieceIsGone)
    {
        const CutWall cut = severed(LoosePieces::removed);
        ASSERT_EQ(cut.status, mesh::CutStatus::done) << cut.message;
        ASSERT_EQ(cut.pieces.size(), 1u);
        EXPECT_NEAR(volume(cut.wall), 32.0 * 32.0 * 16.0, kRoundOff * kLoose);
        ASSERT_EQ(cut.removed.size(), 2u);
        EXPECT_EQ(cut.removed[0].what, "a loose piece");
        EXPECT_NEAR(cut.removed[0].volume_mm3 + cut.removed[1].volume_mm3, kLoose, kRoundOff * kLoose);
        EXPECT_EQ(cut.supports.fixed.size(), 9u * 5u);
        EXPECT_NE(cut.message.find("has no support: removed"), std::string::npos) << cut.message;
        for (const VertexId v : cut.supports.fixed)
            EXPECT_EQ(cut.wall.vertices(v, 0), 0.0);
        EXPECT_NO_THROW(mesh::check_mesh(cut.wall));
    }

    TEST(WallCut, ARigidPieceMovesAsOneBodyWithTheLipItTouches)
    {
        const CutWall cut = severed(LoosePieces::rigid);
        ASSERT_EQ(cut.rigid.size(), 1u);
        EXPECT_TRUE(cut.supports.bedded.empty());
        const std::set<VertexId> fixed(cut.supports.fixed.begin(), cut.supports.fixed.end());
        for (const VertexId v : cut.rigid[0])
            EXPECT_TRUE(fixed.contains(v));
        // The rest of the wall turns and shifts as a whole: the piece goes along.
        Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
        X.linear() = Eigen::AngleAxisd(0.3, Vec3(1, 2, -1).normalized()).toRotationMatrix();
        X.translation() = Vec3(3, -2, 7);
        Points displacement = Points::Zero(cut.wall.vertices.rows(), 3);
        for (TetId t : cut.pieces[0].tets)
            for (const VertexId v : cut.wall.tet(t)) {
                const Vec3 p = cut.wall.vertices.row(v).transpose();
                displacement.row(v) = (X * p - p).transpose();
            }
        move_rigid_pieces(cut.wall, cut.rigid, displacement);
        for (const VertexId v : cut.rigid[0]) {
            const Vec3 p = cut.wall.vertices.row(v).transpose();
            EXPECT_NEAR((displacement.row(v).transpose() - (X * p - p)).norm(), 0.0, 1e-10);
        }
        // A lip that stretches: the piece stays one body.
        for (const TetId t : cut.pieces[0].tets)
            for (const VertexId v : cut.wall.tet(t))
                displacement.row(v) = 0.2 * cut.wall.vertices.row(v) + Eigen::RowVector3d(0, 1, 0);
        move_rigid_pieces(cut.wall, cut.rigid, displacement);
        const auto moved
            = [&](VertexId v) { return Vec3((cut.wall.vertices.row(v) + displacement.row(v)).transpose()); };
        const VertexId a = cut.rigid[0].front(), b = cut.rigid[0].back();
        EXPECT_NEAR((moved(a) - moved(b)).norm(), (cut.wall.vertices.row(a) - cut.wall.vertices.row(b)).norm(), 1e-10);
        EXPECT_GT(displacement.row(a).norm(), 1.0);
    }

    TEST(WallCut, WhatHooksHoldIsNotLoose)
    {
        const mesh::TetMesh uncut = wall();
        Approach approach = across(32.0, 20.0);
        approach.loose_pieces = LoosePieces::removed;
        // On the far lip: to the right of a cut along +y, seen from above.
        approach.hooks
            = { { .name = "far", .side = -1, .along_mm = 18.0, .depth_mm = 8.0, .direction = Vec3(1, 0, 0) } };
        const CutWall cut = cut_wall(uncut, approach, kTable, held_at_start(uncut), {});
        ASSERT_EQ(cut.pieces.size(), 2u);
        EXPECT_TRUE(cut.pieces[1].held);
        EXPECT_EQ(cut.pieces[1].hooks, std::vector<std::string> { "far" });
        EXPECT_TRUE(cut.loose.empty());
    }

    TEST(WallCut, ARibSegmentIsAsLongAsItIsSaidToBe)
    {
        Approach approach = across(21.3, 16.0, 2.0, 30.0);
        approach.uncut_labels = { "rib" };
        approach.ablations = { { .label = "rib", .from_mm = -4.0, .to_mm = 9.0 } };
        const mesh::TetMesh uncut = wall();
        const CutWall cut = cut_wall(uncut, approach, kTable, held_at_start(uncut), {});
        ASSERT_EQ(cut.status, mesh::CutStatus::done) << cut.message;
        ASSERT_EQ(cut.removed.size(), 1u);
        EXPECT_EQ(cut.removed[0].label, "rib");
        // 13 mm of 4 x 4 mm; vertices that snap may move the saw's faces by 5 % of an edge where they lie in the
        // surface.
        EXPECT_NEAR(cut.removed[0].volume_mm3, 13.0 * 16.0, 0.02 * 13.0 * 16.0);
        EXPECT_NEAR(volume(cut.wall) + cut.removed[0].volume_mm3, 48.0 * 32.0 * 16.0, 0.01 * 48.0 * 32.0 * 16.0);
        // Positive sides lie to the left of a cut along +y, seen from above: towards -x.
        double least = 1e9, most = -1e9;
        for (TetId t = 0; t < static_cast<TetId>(cut.wall.tet_count()); ++t)
            if (cut.wall.labels[static_cast<std::size_t>(t)] == 7)
                for (const VertexId v : cut.wall.tet(t)) {
                    const double x = cut.wall.vertices(v, 0);
                    (x < 18.0 ? most : least) = x < 18.0 ? std::max(most, x) : std::min(least, x);
                }
        EXPECT_NEAR(most, 21.3 - 9.0, 0.4); // 0.1 of an edge
        EXPECT_NEAR(least, 21.3 + 4.0, 0.4);
        for (const mesh::LipFace& lip : cut.lips) { // of the incision only
            EXPECT_NE(lip.side, 0);
            EXPECT_EQ(lip.cut, 0);
        }
    }

    TEST(WallCut, ABallIsRemovedWithEveryTissueInIt)
    {
        Approach approach = across(21.3, 16.0);
        approach.ablations = { { .centre = Vec3(22, 18, 6), .radius_mm = 5.0 } };
        const mesh::TetMesh uncut = wall();
        const CutWall cut = cut_wall(uncut, approach, kTable, held_at_start(uncut), {});
        ASSERT_EQ(cut.removed.size(), 2u);
        const double removed = cut.removed[0].volume_mm3 + cut.removed[1].volume_mm3;
        EXPECT_NEAR(removed, 4.0 / 3.0 * M_PI * 125.0, 0.4 * removed); // by whole elements of 4 mm
        approach.ablations = { { .label = "rib", .centre = Vec3(22, 4, 12), .radius_mm = 3.0 } };
        try {
            static_cast<void>(cut_wall(uncut, approach, kTable, held_at_start(uncut), {}));
            FAIL() << "an ablation of nothing was accepted";
        } catch (const InputError& error) {
            EXPECT_EQ(error.where(), "ablations/0");
            EXPECT_NE(std::string(error.what()).find("there is no rib in a ball of 3.0 mm"), std::string::npos)
                << error.what();
        }
    }

    TEST(WallCut, WhatWasCutBeforeStaysWhenAnAblationIsCancelled)
    {
        const mesh::TetMesh uncut = wall();
        mesh::CutSession session(uncut);
        ASSERT_EQ(session.cut(blade_of(across(40.3, 6.0))).status, mesh::CutStatus::done);
        const mesh::TetMesh before = session.compact_mesh();
        Approach approach = across(21.3, 16.0);
        approach.ablations = { { .centre = Vec3(22, 18, 6), .radius_mm = 5.0 } };
        std::atomic<bool> cancel { false };
        Job job;
        job.cancel = &cancel;
        job.on_progress = [&](std::string_view stage, double) { cancel = cancel || stage == "ablate"; };
        const PlannedCut planned = cut_as_planned(session, approach, kTable, {}, job);
        EXPECT_EQ(planned.status, mesh::CutStatus::cancelled);
        EXPECT_TRUE(planned.deltas.empty());
        EXPECT_EQ(session.cut_count(), 1u);
        const mesh::TetMesh after = session.compact_mesh();
        EXPECT_EQ(after.nodes, before.nodes);
        EXPECT_TRUE((after.vertices.array() == before.vertices.array()).all());
    }

    TEST(WallCut, AFullDiskIsNoRemark)
    {
        mesh::CutSession session(wall());
        session.set_witness([](const mesh::CutEvent& event) {
            if (event.kind == mesh::CutEvent::Kind::cut && event.options->uncut_labels.size() != 1)
                return;
            throw IoError("the disk is full", "cuts.jsonl");
        });
        Approach approach = across(21.3, 16.0, 2.0, 30.0);
        approach.ablations = { { .label = "rib", .from_mm = -4.0, .to_mm = 9.0 } }; // saws leave one label uncut
        EXPECT_THROW(static_cast<void>(cut_as_planned(session, approach, kTable, {})), IoError);
        EXPECT_EQ(session.cut_count(), 1u);
    }

    TEST(WallCut, SupportsAreCarriedThroughEveryDelta)
    {
        // Along the wall, through the face that is held; a ball at that face is removed, and another cut takes the ids
        // that this set free. What is held is what lies in that face, copies and new vertices with it.
        const mesh::TetMesh uncut = wall();
        Approach along = across(0.0, 20.0);
        along.incision = { { -2.0, 13.3, 16.0 }, { 50.0, 13.3, 16.0 } };
        along.ablations = { { .centre = Vec3(0, 22, 12), .radius_mm = 6.0 } };
        mesh::CutSession session(uncut);
        PlannedCut planned = cut_as_planned(session, along, kTable, {});
        ASSERT_EQ(planned.status, mesh::CutStatus::done) << planned.message;
        ASSERT_EQ(planned.deltas.size(), 2u);
        ASSERT_FALSE(planned.deltas[1].vertices_gone.empty());
        mesh::CutResult again = session.cut(blade_of(across(21.3, 20.0)));
        ASSERT_EQ(again.status, mesh::CutStatus::done);
        planned.deltas.push_back(std::move(again.delta));
        mesh::SlotMap map;
        const mesh::TetMesh cut = session.compact_mesh(&map);
        const fem::Supports held = carried_supports(held_at_start(uncut), planned.deltas, map);
        std::set<VertexId> fixed(held.fixed.begin(), held.fixed.end());
        EXPECT_EQ(fixed.size(), held.fixed.size());
        std::set<VertexId> in_face;
        for (VertexId v = 0; v < static_cast<VertexId>(cut.vertex_count()); ++v)
            if (cut.vertices(v, 0) == 0.0)
                in_face.insert(v);
        EXPECT_EQ(fixed, in_face);
        const auto pieces = find_wall_pieces(cut, kTable, held, {});
        ASSERT_EQ(pieces.size(), 4u);
        EXPECT_EQ(std::count_if(pieces.begin(), pieces.end(), [](const WallPiece& p) { return p.held; }), 2);
    }

    TEST(WallCut, CrumbsAreCounted)
    {
        EXPECT_EQ(volume_text(966.2e3), "966.2 cm3");
        EXPECT_EQ(volume_text(8192.0), "8.2 cm3");
        EXPECT_EQ(volume_text(42.3), "42 mm3");
        EXPECT_EQ(volume_text(0.034), "0.034 mm3");
        WallPiece piece;
        piece.volume_mm3 = 0.9;
        EXPECT_TRUE(is_crumb(piece));
        piece.volume_mm3 = 1.1;
        EXPECT_FALSE(is_crumb(piece));
        EXPECT_EQ(crumbs_text(1), "1 crumb below 1 mm3");
        EXPECT_EQ(crumbs_text(12), "12 crumbs below 1 mm3");
    }

    TEST(WallCut, TheSkinThatIsRemovedIsMeasured)
    {
        // The half of the box beyond x = 32 has 16 x 32 mm of its top, and sides that are no skin.
        const CutWall severed_piece = severed(LoosePieces::removed);
        EXPECT_NEAR(severed_piece.removed_skin_mm2, 16.0 * 32.0, kRoundOff * kLoose);
        EXPECT_EQ(severed(LoosePieces::held).removed_skin_mm2, 0.0);
        // Below the skin nothing of it is taken, also when what is bared is ablated further.
        const mesh::TetMesh uncut = wall();
        Approach approach = across(21.3, 16.0);
        approach.ablations = { { .centre = Vec3(22, 18, 6), .radius_mm = 4.0 } };
        approach.ablations.push_back({ .centre = Vec3(22, 18, 3), .radius_mm = 4.0 });
        EXPECT_EQ(cut_wall(uncut, approach, kTable, held_at_start(uncut), {}).removed_skin_mm2, 0.0);
    }

    TEST(WallCut, ThePieceThatTookALipIsNamed)
    {
        const CutWall removed = severed(LoosePieces::removed);
        EXPECT_EQ(removed.took_lip[0], "");
        EXPECT_EQ(removed.took_lip[1], "piece 2: 8.2 cm3 of muscle at (40, 16, 8) mm");
        EXPECT_EQ(severed(LoosePieces::rigid).took_lip[1], "");
    }

    TEST(WallCut, APlanWhoseLipWasRemovedSaysWhoTookItAndWhatToDo)
    {
        // Three sides of a flap are cut; balls through the wall take its fourth, by which it was held.
        const datasets::Phantom phantom = datasets::make_block_phantom({});
        Case planned_case = test_support::block_case("took_lip", phantom);
        Patient patient(planned_case);
        ApproachRequest request;
        request.name = "flap";
        request.target.label = "target";
        request.sizing = { .corridor_edge_mm = 6.0, .coarse_edge_mm = 12.0, .region_mm = 35.0 };
        const std::vector<Vec3> points { { -20, 0, -20 }, { -20, 0, 20 }, { 20, 0, 20 }, { 20, 0, -20 } };
        Approach approach = approach_from_points(*patient.labels(), points, request).approach;
        approach.uncut_labels.clear();
        for (const double x : { -25.0, -15.0, -5.0, 5.0, 15.0, 25.0 })
            approach.ablations.push_back({ .centre = Vec3(x, 12, -20), .radius_mm = 18.0 });
        approach.loose_pieces = LoosePieces::removed;
        try {
            static_cast<void>(plan_approach(patient, approach));
            FAIL() << "a wound without a lip was accepted";
        } catch (const InputError& error) {
            const std::string text = error.what();
            EXPECT_EQ(
                text.find("the wound has no edge on the skin: this lip was part of a removed loose piece (piece 2: "),
                0u)
                << text;
            EXPECT_NE(text.find("keep loose pieces held or rigid (\"loose_pieces\" of the approach), or choose another "
                                "incision"),
                std::string::npos)
                << text;
            EXPECT_EQ(error.where(), "right lip"); // of a line that turns to the right
        }
    }

    TEST(WallCut, APlanShowsWhatWasRemoved)
    {
        datasets::BlockParameters block = test_support::small_block();
        block.bone_bar = true;
        const datasets::Phantom phantom = datasets::make_block_phantom(block);
        std::string bone;
        for (const mesh::LabelInfo& info : phantom.labels.table)
            if (info.material == "bone")
                bone = info.name;
        ASSERT_FALSE(bone.empty());
        Case planned_case = test_support::block_case("removed", phantom);
        Patient patient(planned_case);
        Approach approach = test_support::block_approach(*patient.labels(), Eigen::Isometry3d::Identity(), 10.0);
        approach.uncut_labels = { bone };
        const PlannedField whole = plan_approach(patient, approach);
        approach.ablations = { { .label = bone, .from_mm = -8.0, .to_mm = 8.0 } };
        const PlannedField resected = plan_approach(patient, approach);
        ASSERT_EQ(whole.status, PlanStatus::done) << whole.message;
        ASSERT_EQ(resected.status, PlanStatus::done) << resected.message;
        ASSERT_EQ(resected.metrics.removed.size(), 1u);
        double least = 1e9, most = -1e9;
        for (std::size_t t = 0; t < resected.wall.tet_count(); ++t)
            if (mesh::find_label(phantom.labels.table, resected.wall.labels[t])->name == bone)
                for (const VertexId v : resected.wall.tet(static_cast<TetId>(t))) {
                    const double x = resected.wall.vertices(v, 0);
                    (x < 0.0 ? most : least) = x < 0.0 ? std::max(most, x) : std::min(least, x);
                }
        // The incision crosses the bar at x = 0.9, see block_approach().
        EXPECT_NEAR(least - most, 16.0, 0.5);
        EXPECT_NEAR(0.5 * (least + most), 0.9, 0.3);
        double section = 0.0; // of the bar as meshed: voxels of 2 mm, smoothed
        for (const mesh::LabelFit& fit : resected.mesh_statistics.fit)
            if (mesh::find_label(phantom.labels.table, fit.label)->name == bone)
                section = fit.mesh_volume_mm3 / block.size_mm.x();
        EXPECT_NEAR(resected.metrics.removed[0].volume_mm3, 16.0 * section, 0.05 * 16.0 * section);
        EXPECT_LT(resected.metrics.hook_force_N, 0.7 * whole.metrics.hook_force_N); // no bone holds the lips together
        EXPECT_EQ(resected.metrics.inverted_elements, 0);
    }

} // namespace wall_cut_test
} // namespace retractor::planner

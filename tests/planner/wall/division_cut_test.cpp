#include "planner/wall/division_cut.h"

#include "mesh/base/error.h"
#include "mesh/generation/hybrid_model.h"
#include "mesh/tetrahedra/tet_grid.h"
#include "planner/approach/approach_templates.h"
#include "planner/approach/space_division.h"
#include "planner/wall/wall_cut.h"
#include "tests/support/synthetic_chest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <set>
#include <string>
#include <string_view>

namespace retractor::planner {
namespace division_cut_test {

    const mesh::LabelTable kTable { { 1, "skin", "skin", mesh::Role::wall },
        { 2, "muscle", "muscle", mesh::Role::wall }, { 3, "intercostal", "intercostal", mesh::Role::wall },
        { 7, "rib_left_4", "bone", mesh::Role::wall }, { 8, "rib_left_5", "bone", mesh::Role::wall } };
    constexpr Label kIntercostal = 3;

    /// Wounds may lie this far from their blade: 0.1 local edges (kLargestBladeDeviation) of 4 mm.
    constexpr double kOffBladeMm = 0.1 * 4.0;
    /// Moves onto the blade may change the area of a wound a little.
    constexpr double kAreaShare = 0.05;

    /// 96 x 32 x 24 mm: the chest lies below z = 0. Intercostal muscle between two ribs along x up to z = 8, muscle up
    /// to z = 20, skin above. The ribs are at y = 4 to 8 and y = 24 to 28.
    mesh::TetMesh wall(bool with_intercostal)
    {
        mesh::TetMesh box = mesh::kuhn_box(24, 8, 6, 4.0);
        for (TetId t = 0; t < static_cast<TetId>(box.tet_count()); ++t) {
            Vec3 c = Vec3::Zero();
            for (const VertexId v : box.tet(t))
                c += 0.25 * box.vertices.row(v).transpose();
            Label label = c.z() > 20.0 ? 1 : c.z() > 8.0 || !with_intercostal ? 2 : kIntercostal;
            if (c.z() < 8.0 && c.y() > 4.0 && c.y() < 8.0)
                label = 7;
            if (c.z() < 8.0 && c.y() > 24.0 && c.y() < 28.0)
                label = 8;
            box.labels[static_cast<std::size_t>(t)] = label;
        }
        return box;
    }

    mesh::LabelTable table(bool with_intercostal)
    {
        mesh::LabelTable all = kTable;
        if (!with_intercostal)
            std::erase_if(all, [](const mesh::LabelInfo& info) { return info.id == kIntercostal; });
        return all;
    }

    /// A stroke from x = `from` to x = `to` in the middle of the space, from 4 mm below the wall to a height.
    DivisionStroke stroke(bool forwards, double from, double to, double height)
    {
        DivisionStroke s { .way = forwards ? StrokeWay::forwards : StrokeWay::backwards,
            .severs = { "intercostal" },
            .depth_mm = 4.0 + height,
            .length_mm = std::abs(to - from) };
        for (const double x : { from, 0.5 * (from + to), to }) {
            s.line.emplace_back(x, 17.3, -4.0);
            s.directions.emplace_back(0, 0, 1);
        }
        return s;
    }

    /// The skin is cut from x = 37.3 to 58.7; the space is divided to x = 13 and x = 81.
    Approach between_ribs(double height)
    {
        Approach approach;
        approach.name = "between";
        approach.incision = { { 37.3, 17.3, 24.0 }, { 58.7, 17.3, 24.0 } };
        approach.directions = { { 0, 0, -1 }, { 0, 0, -1 } };
        approach.depth_mm = 28.0;
        approach.uncut_labels = { "rib_left_4", "rib_left_5" };
        approach.division = { .extent = DivisionExtent::full };
        approach.division.strokes = { stroke(false, 37.3, 13.0, height), stroke(true, 58.7, 81.0, height) };
        return approach;
    }

    struct Severed {
        double least_x = 1e9, most_x = -1e9, highest = -1e9;
    };

    /// The extent of the faces that the strokes opened (not the skin cut, which is cut 0), tested to lie on the blade.
    Severed severed_by_strokes(const mesh::CutSession& session)
    {
        Severed found;
        for (const mesh::LipFace& lip : session.lips()) {
            if (lip.cut == 0)
                continue;
            const mesh::MeshDelta::Tet tet = session.tet(lip.face.tet);
            for (int corner = 0; corner < 4; ++corner) {
                if (corner == lip.face.corner)
                    continue;
                const Vec3 p = session.position(tet.nodes[static_cast<std::size_t>(corner)]);
                EXPECT_NEAR(p.y(), 17.3, kOffBladeMm);
                found.least_x = std::min(found.least_x, p.x());
                found.most_x = std::max(found.most_x, p.x());
                found.highest = std::max(found.highest, p.z());
            }
        }
        return found;
    }

    TEST(DivisionCut, SeversIntercostalMuscleUnderIntactSkin)
    {
        mesh::CutSession session(wall(true));
        // Higher than the intercostal muscle: the labels keep the muscle over the ribs whole.
        const PlannedCut planned = cut_as_planned(session, between_ribs(12.0), kTable, {}, {});
        ASSERT_EQ(planned.status, mesh::CutStatus::done) << planned.message;
        ASSERT_EQ(planned.deltas.size(), 3U);
        ASSERT_TRUE(planned.divided);
        EXPECT_EQ(planned.divided->labels, std::vector<std::string> { "intercostal" });
        EXPECT_DOUBLE_EQ(planned.divided->backwards_mm, 37.3 - 13.0);
        EXPECT_DOUBLE_EQ(planned.divided->forwards_mm, 81.0 - 58.7);
        EXPECT_NEAR(planned.divided->length_mm, 81.0 - 13.0, 1e-9);
        // 8 mm of intercostal muscle along both strokes.
        const double area = 8.0 * (37.3 - 13.0 + 81.0 - 58.7);
        EXPECT_NEAR(planned.divided->severed_mm2, area, kAreaShare * area);
        const Severed severed = severed_by_strokes(session);
        EXPECT_NEAR(severed.least_x, 13.0, 2.0 * kOffBladeMm);
        EXPECT_NEAR(severed.most_x, 81.0, 2.0 * kOffBladeMm);
        EXPECT_NEAR(severed.highest, 8.0, kOffBladeMm);
        EXPECT_NO_THROW(mesh::check_mesh(session.compact_mesh()));
    }

    TEST(DivisionCut, WithoutALabelOfItsOwnTheDepthDecides)
    {
        mesh::CutSession session(wall(false));
        Approach approach = between_ribs(8.0);
        for (DivisionStroke& s : approach.division.strokes)
            s.severs = divided_labels(table(false)).names;
        const PlannedCut planned = cut_as_planned(session, approach, table(false), {}, {});
        ASSERT_EQ(planned.status, mesh::CutStatus::done) << planned.message;
        ASSERT_TRUE(planned.divided);
        EXPECT_EQ(planned.divided->labels, std::vector<std::string> { "muscle" });
        const double area = 8.0 * (37.3 - 13.0 + 81.0 - 58.7);
        EXPECT_NEAR(planned.divided->severed_mm2, area, kAreaShare * area);
        EXPECT_NEAR(severed_by_strokes(session).highest, 8.0, 2.0 * kOffBladeMm);
    }

    TEST(DivisionCut, JoinsTheWoundOfTheSkinCut)
    {
        // No strand of tissue is left at the incision's ends: a full ring of divided muscle makes two pieces of a wall
        // whose strokes reach its ends.
        mesh::CutSession session(wall(true));
        Approach approach = between_ribs(30.0);
        approach.division.strokes = { stroke(false, 37.3, -2.0, 30.0), stroke(true, 58.7, 98.0, 30.0) };
        const mesh::LabelTable all_muscle { { 1, "skin", "intercostal", mesh::Role::wall },
            { 2, "muscle", "intercostal", mesh::Role::wall }, { 3, "intercostal", "intercostal", mesh::Role::wall },
            { 7, "rib_left_4", "bone", mesh::Role::wall }, { 8, "rib_left_5", "bone", mesh::Role::wall } };
        for (DivisionStroke& s : approach.division.strokes)
            s.severs = divided_labels(all_muscle).names;
        const PlannedCut planned = cut_as_planned(session, approach, all_muscle, {}, {});
        ASSERT_EQ(planned.status, mesh::CutStatus::done) << planned.message;
        const std::vector<WallPiece> pieces = find_wall_pieces(session.compact_mesh(), all_muscle, {}, {});
        ASSERT_GE(pieces.size(), 2U);
        EXPECT_NEAR(pieces[0].volume_mm3 + pieces[1].volume_mm3, 96.0 * 32.0 * 24.0, 0.01 * 96.0 * 32.0 * 24.0);
        EXPECT_GT(pieces[1].volume_mm3, 0.4 * 96.0 * 32.0 * 24.0);
    }

    TEST(DivisionCut, ARoundChestIsDividedBetweenItsRibs)
    {
        const test_support::ChestShape shape;
        const mesh::LabelVolume labels = test_support::synthetic_chest(shape);
        const Anatomy anatomy = find_anatomy(labels);
        ApproachRequest request;
        request.template_name = "intercostal:4";
        request.target.label = "aneurysm";
        request.length_mm = 60.0;
        request.division = DivisionExtent::full;
        request.sizing = { .corridor_edge_mm = 8.0, .coarse_edge_mm = 15.0, .region_mm = 25.0 };
        Approach approach = approach_from_template(labels, anatomy, request);
        find_space_division(approach, labels, anatomy);
        ASSERT_EQ(approach.division.strokes.size(), 2U) << approach.division.words;
        const mesh::HybridModel model = mesh::build_hybrid_model(labels, mesh_sizing_of(approach, labels.table));
        ASSERT_EQ(model.status, mesh::MeshStatus::done) << model.message;
        mesh::CutSession session(model.wall);
        const PlannedCut planned
            = cut_as_planned(session, approach, labels.table, cut_options_of(approach, labels.table), {});
        ASSERT_EQ(planned.status, mesh::CutStatus::done) << planned.message;
        ASSERT_TRUE(planned.divided);
        // From the inner side of the wall at 96 mm to the ribs' outer side at 108 mm; lengths are those at 104 mm.
        const double inner = shape.radius - shape.wall, outer = shape.rib_radius + 0.5 * shape.rib_thickness;
        const double length = planned.divided->forwards_mm + planned.divided->backwards_mm;
        const double area = length / shape.rib_radius * 0.5 * (outer * outer - inner * inner);
        constexpr double kVoxelsAndFacets
            = 0.2; // of an area 12 mm high that is known to half a voxel of 3 mm at each side
        EXPECT_NEAR(planned.divided->severed_mm2, area, kVoxelsAndFacets * area);
        // A half voxel, and a tenth of the longest edges: the skin at 120 mm stays whole.
        const double highest = outer + 0.5 * shape.spacing + 0.1 * approach.sizing.coarse_edge_mm;
        for (const mesh::LipFace& lip : session.lips()) {
            if (lip.cut == 0)
                continue;
            const mesh::MeshDelta::Tet tet = session.tet(lip.face.tet);
            EXPECT_FALSE(mesh::find_label(labels.table, tet.label)->name.starts_with("rib")) << tet.label;
            for (int corner = 0; corner < 4; ++corner) {
                if (corner == lip.face.corner)
                    continue;
                const Vec3 p = session.position(tet.nodes[static_cast<std::size_t>(corner)]);
                EXPECT_LT(std::hypot(p.x(), p.y()), highest);
            }
        }
    }

    TEST(DivisionCut, HooksAndLipsBelongToTheSkinCutOnly)
    {
        const CutWall cut = cut_wall(wall(true), between_ribs(12.0), kTable, {}, {});
        ASSERT_EQ(cut.status, mesh::CutStatus::done) << cut.message;
        ASSERT_TRUE(cut.divided);
        EXPECT_GT(cut.wound.size(), cut.lips.size());
        for (const mesh::LipFace& lip : cut.lips)
            for (const VertexId v : mesh::face_vertices(cut.wall, lip.face)) {
                EXPECT_GT(cut.wall.vertices(v, 0), 37.3 - 2.0 * kOffBladeMm);
                EXPECT_LT(cut.wall.vertices(v, 0), 58.7 + 2.0 * kOffBladeMm);
            }
    }

    TEST(DivisionCut, WithoutStrokesNothingIsDivided)
    {
        mesh::CutSession session(wall(true));
        Approach approach = between_ribs(12.0);
        approach.division.strokes.clear();
        const PlannedCut planned = cut_as_planned(session, approach, kTable, {}, {});
        ASSERT_EQ(planned.status, mesh::CutStatus::done) << planned.message;
        EXPECT_FALSE(planned.divided);
        EXPECT_EQ(planned.deltas.size(), 1U);
    }

    TEST(DivisionCut, KeepsBoneSkinAndWhatTheApproachKeeps)
    {
        Approach approach = between_ribs(8.0);
        DivisionStroke one = approach.division.strokes.front();
        EXPECT_EQ(division_options(approach, one, kTable).uncut_labels, (std::vector<Label> { 1, 2, 7, 8 }));
        one.severs = divided_labels(table(false)).names;
        EXPECT_EQ(division_options(approach, one, table(false)).uncut_labels, (std::vector<Label> { 1, 7, 8 }));
        one.severs = { "intercostal" };
        approach.uncut_labels.push_back("intercostal");
        EXPECT_EQ(division_options(approach, one, kTable).uncut_labels, (std::vector<Label> { 1, 2, 3, 7, 8 }));
    }

    TEST(DivisionCut, AStrokeThatSeversNothingIsRefusedByName)
    {
        mesh::CutSession session(wall(true));
        Approach approach = between_ribs(8.0);
        for (Vec3& point : approach.division.strokes[1].line)
            point.z() -= 100.0;
        try {
            static_cast<void>(cut_as_planned(session, approach, kTable, {}, {}));
            FAIL() << "a stroke beside the wall was accepted";
        } catch (const SolverError& error) {
            EXPECT_EQ(error.where(), "division/forwards");
            EXPECT_EQ(
                std::string(error.what()).find("intercostal muscle and pleura could not be divided forwards: "), 0U)
                << error.what();
        }
    }

    TEST(DivisionCut, CancellingTakesEverythingBack)
    {
        mesh::CutSession session(wall(true));
        std::atomic<bool> cancel { false };
        int cuts = 0;
        Job job;
        job.cancel = &cancel;
        job.on_progress = [&](std::string_view stage, double share) {
            cuts += stage == "cut" && share == 0.0 ? 1 : 0;
            cancel = cancel || cuts == 2; // the first stroke
        };
        const PlannedCut planned = cut_as_planned(session, between_ribs(8.0), kTable, {}, job);
        EXPECT_EQ(planned.status, mesh::CutStatus::cancelled);
        EXPECT_TRUE(planned.deltas.empty());
        EXPECT_FALSE(planned.divided);
        EXPECT_EQ(session.cut_count(), 0U);
    }

} // namespace division_cut_test
} // namespace retractor::planner

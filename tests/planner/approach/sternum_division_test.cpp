#include "planner/approach/sternum_division.h"

#include "mesh/cutting/cut_session.h"
#include "mesh/generation/hybrid_model.h"
#include "planner/approach/approach_templates.h"
#include "planner/approach/find_division.h"
#include "planner/wall/division_cut.h"
#include "planner/wall/wall_cut.h"
#include "tests/support/synthetic_chest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace retractor::planner {
namespace sternum_division_test {

    const test_support::ChestShape kShape {};

    const mesh::LabelVolume& chest()
    {
        static const mesh::LabelVolume labels = test_support::synthetic_chest(kShape);
        return labels;
    }
    const Anatomy& anatomy()
    {
        static const Anatomy found = find_anatomy(chest());
        return found;
    }

    Approach hemisternotomy(const std::string& kind, const mesh::LabelVolume& labels, const Anatomy& landmarks)
    {
        ApproachRequest request;
        request.template_name = "hemisternotomy-" + kind;
        request.target.label = "aneurysm";
        request.sizing = { .corridor_edge_mm = 6.0, .coarse_edge_mm = 15.0, .region_mm = 25.0 };
        Approach approach = approach_from_template(labels, landmarks, request);
        find_sternum_division(approach, labels, landmarks);
        return approach;
    }

    Vec3 outer_end(const DivisionStroke& s, std::size_t n) { return s.line[n] + s.depth_mm * s.directions[n]; }

    TEST(SternumDivision, GoesFromTheIncisionToBeyondTheEdge)
    {
        const std::vector<std::pair<std::string, std::vector<StrokeWay>>> kinds {
            { "j", { StrokeWay::right } },
            { "j-left", { StrokeWay::left } },
            { "t", { StrokeWay::right, StrokeWay::left } },
        };
        for (const auto& [kind, ways] : kinds) {
            SCOPED_TRACE(kind);
            const Approach approach = hemisternotomy(kind, chest(), anatomy());
            ASSERT_EQ(approach.division.strokes.size(), ways.size()) << approach.division.words;
            for (std::size_t n = 0; n < ways.size(); ++n) {
                const DivisionStroke& stroke = approach.division.strokes[n];
                EXPECT_EQ(stroke.way, ways[n]);
                // It begins on the ray of the incision's lower end.
                const Vec3 from = stroke.line.front() - approach.incision.back();
                EXPECT_LT(from.cross(approach.directions.back()).norm(), 1e-9);
                // x of LPS grows to the patient's left.
                const double side = ways[n] == StrokeWay::right ? -1.0 : 1.0;
                double edge = 0.0;
                for (int i = 0; i < 400; ++i) // the sternum at this height, along the stroke's middle
                    for (double depth = 0.0; depth < 30.0; depth += 1.0) {
                        const double x = side * 0.2 * i;
                        Vec3 p = approach.incision.back() + depth * approach.directions.back();
                        p.x() += x;
                        if (const mesh::LabelInfo* info = mesh::find_label(chest().table, mesh::label_at(chest(), p));
                            info != nullptr && info->name == "sternum")
                            edge = std::max(edge, std::abs(x));
                    }
                ASSERT_GT(edge, 5.0);
                EXPECT_NEAR(side * (stroke.line.back().x() - stroke.line.front().x()), edge + kBeyondSternumEdgeMm, 1.5)
                    << "a step, and the slope of the ray";
                EXPECT_NEAR(stroke.length_mm, (stroke.line.back() - stroke.line.front()).norm(), kShape.spacing);
                for (std::size_t i = 0; i < stroke.line.size(); ++i) { // from the chest to the bone's outer side
                    EXPECT_LT(std::hypot(stroke.line[i].x(), stroke.line[i].y()), kShape.radius - kShape.wall);
                    const double out = std::hypot(outer_end(stroke, i).x(), outer_end(stroke, i).y());
                    EXPECT_LT(out, kShape.radius - 2.0) << "the skin stays whole";
                }
                EXPECT_TRUE(std::ranges::count(stroke.severs, "sternum"));
                EXPECT_FALSE(std::ranges::count(stroke.severs, "skin"));
                EXPECT_FALSE(std::ranges::count(stroke.severs, "rib_right_4"));
            }
            EXPECT_NE(approach.division.words.find(kind == "j-left" ? "left edge" : "right edge"), std::string::npos)
                << approach.division.words;
        }
    }

    TEST(SternumDivision, MovesWithThePatient)
    {
        const Mat3 turn = Eigen::AngleAxisd(0.5, Vec3(0.2, 0.3, 1.0).normalized()).toRotationMatrix();
        const Vec3 shift(12.0, -30.0, 7.0);
        const mesh::LabelVolume labels = test_support::moved(chest(), turn, shift);
        const Approach here = hemisternotomy("j", chest(), anatomy()),
                       there = hemisternotomy("j", labels, find_anatomy(labels));
        ASSERT_EQ(there.division.strokes.size(), 1U);
        const DivisionStroke &a = here.division.strokes[0], &b = there.division.strokes[0];
        ASSERT_EQ(a.line.size(), b.line.size());
        for (std::size_t n = 0; n < a.line.size(); ++n)
            EXPECT_LT((turn * a.line[n] + shift - b.line[n]).norm(), 1e-6);
    }

    TEST(SternumDivision, ADrawnIncisionOverTheSternumIsDividedAlike)
    {
        const Approach by_template = hemisternotomy("j", chest(), anatomy());
        ApproachRequest request;
        request.target.label = "aneurysm";
        Approach drawn
            = approach_from_points(chest(), { by_template.incision.front(), by_template.incision.back() }, request)
                  .approach;
        set_division(drawn, { .extent = DivisionExtent::sternum_right });
        find_sternum_division(drawn, chest(), anatomy());
        ASSERT_EQ(drawn.division.strokes.size(), 1U) << drawn.division.words;
        EXPECT_NEAR(drawn.division.strokes[0].length_mm, by_template.division.strokes[0].length_mm, 1.5);
        EXPECT_TRUE(std::ranges::count(drawn.division.strokes[0].severs, "sternum"));
    }

    TEST(SternumDivision, WithoutASternumUnderTheIncisionNothingIsDivided)
    {
        ApproachRequest request;
        request.template_name = "intercostal:4";
        request.target.label = "aneurysm";
        request.length_mm = 80.0;
        request.division = DivisionExtent::sternum_right;
        Approach approach = approach_from_template(chest(), anatomy(), request);
        find_sternum_division(approach, chest(), anatomy());
        EXPECT_TRUE(approach.division.strokes.empty());
        EXPECT_EQ(
            approach.division.words, "this approach leaves the sternum whole: nothing is divided beyond the skin");
        set_division(approach, { .extent = DivisionExtent::sternum_right });
        EXPECT_EQ(std::ranges::count(approach.uncut_labels, "sternum"), 0);
        find_sternum_division(approach, chest(), anatomy());
        EXPECT_TRUE(approach.division.strokes.empty());
        EXPECT_EQ(approach.division.words,
            "no sternum lies under the incision's lower end: nothing is divided beyond the skin");
    }

    TEST(SternumDivision, FreesTheUpperRightHalfOfTheBone)
    {
        const Approach approach = hemisternotomy("j", chest(), anatomy());
        const mesh::HybridModel model = mesh::build_hybrid_model(chest(), mesh_sizing_of(approach, chest().table));
        ASSERT_EQ(model.status, mesh::MeshStatus::done) << model.message;
        mesh::CutSession session(model.wall);
        const PlannedCut planned
            = cut_as_planned(session, approach, chest().table, cut_options_of(approach, chest().table), {});
        ASSERT_EQ(planned.status, mesh::CutStatus::done) << planned.message;
        ASSERT_TRUE(planned.divided);
        EXPECT_NEAR(planned.divided->right_mm, approach.division.strokes[0].length_mm, 1e-9);
        EXPECT_EQ(planned.divided->left_mm, 0.0);
        // At least the section of the bone from its midline to its edge.
        EXPECT_GT(planned.divided->severed_mm2, 0.9 * 8.0 * (approach.division.strokes[0].length_mm - 4.0));
    }

} // namespace sternum_division_test
} // namespace retractor::planner

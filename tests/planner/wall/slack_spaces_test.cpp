// Six ribs on a round left chest, 20 mm apart, with intercostal muscle everywhere between them.
#include "planner/wall/slack_spaces.h"

#include "datasets/phantoms/phantom.h"
#include "planner/approach/approach_templates.h"
#include "planner/approach/retractors.h"
#include "planner/approach/space_division.h"
#include "planner/case/draft_case.h"
#include "planner/plan/plan.h"
#include "tests/support/block_case.h"
#include "tests/support/label_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace retractor::planner {
namespace slack_spaces_test {

    constexpr Label kMuscle = 1, kIntercostal = 2, kBone = 3;
    constexpr double kRadiusMm = 100.0, kFirstRibMm = 80.0, kPitchMm = 20.0;

    mesh::LabelTable table()
    {
        using mesh::Role;
        return { { kMuscle, "muscle", "muscle", Role::wall },
            { kIntercostal, "intercostal", "intercostal", Role::wall }, { kBone, "rib_left_4", "bone", Role::wall } };
    }

    double rib_height(int number) { return kFirstRibMm - kPitchMm * (number - 1); }

    Anatomy six_ribs()
    {
        Anatomy anatomy { .frame
            = { .origin = Vec3::Zero(), .superior = Vec3::UnitZ(), .anterior = -Vec3::UnitY(), .left = Vec3::UnitX() },
            .sternum = {},
            .ribs = {} };
        for (int number = 1; number <= 6; ++number) {
            RibLine rib;
            rib.number = number;
            for (double angle = 20.0; angle <= 160.0; angle += 10.0) {
                const double turn = angle * std::numbers::pi / 180.0;
                rib.angle_deg.push_back(angle);
                rib.points.emplace_back(kRadiusMm * std::sin(turn), kRadiusMm * std::cos(turn), rib_height(number));
            }
            anatomy.ribs.push_back(rib);
        }
        return anatomy;
    }

    /// Intercostal muscle from x = 70 to 130 mm, 30 mm from front to back, from below rib 6 to above rib 1.
    mesh::TetMesh side_wall()
    {
        mesh::TetMesh wall = mesh::kuhn_box(6, 3, 15, 10.0);
        wall.vertices.rowwise() += Eigen::RowVector3d(70.0, -15.0, -46.0);
        std::ranges::fill(wall.labels, kIntercostal);
        return wall;
    }

    Vec3 middle_of(const mesh::TetMesh& mesh, TetId t)
    {
        Vec3 middle = Vec3::Zero();
        for (const Vec3& corner : mesh::tet_corners(mesh, t))
            middle += 0.25 * corner;
        return middle;
    }

    /// Voxels of 1 mm of the same block, intercostal muscle where `y` is at least `from_y`.
    mesh::LabelVolume side_labels(double from_y)
    {
        const Vec3 origin(70.0, -15.0, -45.0);
        mesh::LabelVolume labels = test_support::sampled_labels({ 60, 30, 150 }, Vec3::Ones(), table(),
            [&](const Vec3& p) { return p.y() + origin.y() >= from_y ? kIntercostal : kMuscle; });
        labels.grid.origin = origin;
        return labels;
    }

    /// An incision on the side of the chest, from one height in front to another at the back.
    Approach side_incision(double front_mm, double back_mm)
    {
        Approach approach;
        for (const double share : { 0.0, 0.25, 0.5, 0.75, 1.0 }) {
            approach.incision.emplace_back(125.0, -14.0 + 28.0 * share, front_mm + (back_mm - front_mm) * share);
            approach.directions.emplace_back(-Vec3::UnitX());
        }
        approach.depth_mm = 40.0;
        return approach;
    }

    std::vector<int> numbers(const std::vector<SpaceNumber>& spaces)
    {
        std::vector<int> found;
        for (const SpaceNumber& space : spaces) {
            EXPECT_TRUE(space.left);
            found.push_back(space.number);
        }
        return found;
    }

    TEST(SlackSpaces, OnlyTheOpenedSpaceStaysTight)
    {
        mesh::TetMesh wall = side_wall();
        const std::size_t changed = slacken_other_spaces(wall, table(), six_ribs(), { { true, 3 } });
        std::size_t muscle = 0;
        for (TetId t = 0; t < static_cast<TetId>(wall.tet_count()); ++t) {
            const double z = middle_of(wall, t).z();
            const bool in_opened = z < rib_height(3) && z > rib_height(4),
                       between_ribs = z < rib_height(1) && z > rib_height(6);
            const Label label = wall.labels[static_cast<std::size_t>(t)];
            EXPECT_EQ(label, between_ribs && !in_opened ? kMuscle : kIntercostal) << "at z = " << z;
            muscle += label == kMuscle ? 1 : 0;
        }
        EXPECT_EQ(changed, muscle);
        EXPECT_GT(changed, 0U);
    }

    TEST(SlackSpaces, TheOtherSideAndAWallThatOpensNoSpaceStayAsTheyAre)
    {
        mesh::TetMesh wall = side_wall();
        EXPECT_EQ(slacken_other_spaces(wall, table(), six_ribs(), { { false, 3 } }), 0U);
        EXPECT_EQ(slacken_other_spaces(wall, table(), six_ribs(), {}), 0U);
        mesh::LabelTable without_muscle = table();
        without_muscle.erase(without_muscle.begin());
        EXPECT_EQ(slacken_other_spaces(wall, without_muscle, six_ribs(), { { true, 3 } }), 0U);
        EXPECT_TRUE(std::ranges::all_of(wall.labels, [](Label label) { return label == kIntercostal; }));
    }

    TEST(SlackSpaces, AnIncisionOpensTheSpacesThatItPasses)
    {
        const mesh::LabelVolume labels = side_labels(-15.0);
        EXPECT_EQ(numbers(opened_spaces(labels, six_ribs(), side_incision(31.0, 29.0))), std::vector<int> { 3 });
        EXPECT_EQ(numbers(opened_spaces(labels, six_ribs(), side_incision(47.0, 33.0))), (std::vector<int> { 2, 3 }));
        Approach two_points = side_incision(47.0, 33.0);
        two_points.incision = { two_points.incision.front(), two_points.incision.back() };
        two_points.directions.resize(2);
        EXPECT_EQ(numbers(opened_spaces(labels, six_ribs(), two_points)), (std::vector<int> { 2, 3 }));
    }

    TEST(SlackSpaces, AnIncisionAcrossTheRibsOpensNoSpace)
    {
        EXPECT_TRUE(opened_spaces(side_labels(-15.0), six_ribs(), side_incision(52.0, 9.0)).empty());
    }

    TEST(SlackSpaces, AnIncisionThatHardlyLiesOverIntercostalMuscleOpensNoSpace)
    {
        EXPECT_TRUE(opened_spaces(side_labels(10.0), six_ribs(), side_incision(31.0, 29.0)).empty());
    }

    TEST(SlackSpaces, AStrokeBeyondTheIncisionOpensItsSpace)
    {
        Approach approach = side_incision(31.0, 29.0);
        approach.division.strokes.push_back({ .line = { Vec3(85.0, 0.0, 8.0), Vec3(85.0, 10.0, 8.0) },
            .directions = { Vec3::UnitX(), Vec3::UnitX() },
            .depth_mm = 30.0 });
        EXPECT_EQ(numbers(opened_spaces(side_labels(-15.0), six_ribs(), approach)), (std::vector<int> { 3, 4 }));
    }

    /// A chest with slanted ribs of different lengths on both sides, and intercostal muscle behind the sternum too.
    const datasets::Phantom& thorax()
    {
        static const datasets::Phantom made
            = datasets::make_thorax_phantom({ .spacing_mm = { 2.2, 2.2, 2.4 }, .noise_hu = 0.0 });
        return made;
    }

    Approach from_template(const std::string& name)
    {
        ApproachRequest request;
        request.template_name = name;
        request.target.label = "aneurysm";
        return approach_from_template(thorax().labels, request);
    }

    TEST(SlackSpaces, OnAChestTemplatesBetweenRibsOpenTheirSpace)
    {
        const Anatomy anatomy = find_anatomy(thorax().labels);
        const auto opened = [&](const std::string& name) {
            Approach approach = from_template(name);
            find_space_division(approach, thorax().labels, anatomy);
            return opened_spaces(thorax().labels, anatomy, approach);
        };
        EXPECT_EQ(numbers(opened("intercostal:4")), std::vector<int> { 4 });
        EXPECT_EQ(numbers(opened("intercostal:5")), std::vector<int> { 5 });
        const std::vector<SpaceNumber> right = opened("right-lateral");
        ASSERT_EQ(right.size(), 1U);
        EXPECT_FALSE(right.front().left);
        for (const char* sawn : { "median", "hemisternotomy-j", "hemisternotomy-t" })
            EXPECT_TRUE(opened(sawn).empty()) << sawn;
    }

    class SlackWall : public testing::Test {
    protected:
        static void SetUpTestSuite() { planned_case = test_support::block_case("slack_wall", thorax()); }

        SlackWall()
        {
            approach.hooks.push_back({});
            approach.hooks.front().bears_on = { "rib_left_4" };
            // A block round the side of the chest, where the space lies.
            const Vec3 from = approach.incision[approach.incision.size() / 2] - Vec3(60.0, 60.0, 100.0);
            wall = mesh::kuhn_box(12, 12, 20, 10.0, mesh::find_label(planned_case.label_table, "intercostal")->id);
            wall.vertices.rowwise() += from.transpose();
        }

        static inline planner::Case planned_case;
        Approach approach = from_template("intercostal:4");
        mesh::TetMesh wall;
    };

    TEST_F(SlackWall, APlanIsToldWhichMuscleIsSlack)
    {
        Patient patient(planned_case);
        const mesh::TetMesh before = wall;
        const std::string words = slacken_other_spaces(wall, patient, approach);
        EXPECT_NE(words.find("left intercostal space 4"), std::string::npos) << words;
        const Label muscle = mesh::find_label(planned_case.label_table, "muscle")->id;
        const auto slack = std::ranges::count(wall.labels, muscle);
        EXPECT_GT(slack, 0);
        EXPECT_LT(slack, std::ssize(wall.labels));
        for (TetId t = 0; t < static_cast<TetId>(wall.tet_count()); ++t) {
            const auto space = space_at(*patient.anatomy(), middle_of(wall, t));
            EXPECT_FALSE(space && space->number == 4 && wall.labels[static_cast<std::size_t>(t)] == muscle);
        }
    }

    TEST_F(SlackWall, APlanSolvesTheOtherSpacesWithMuscle)
    {
        planner::Case quick = planned_case;
        make_draft(quick);
        approach.hooks.clear();
        approach.sizing.corridor_edge_mm = 14.0;
        approach.sizing.coarse_edge_mm = 25.0;
        add_approach(quick, approach);
        set_retractor(
            quick, approach.name, find_retractor(built_in_retractors(), "finochietto"), { .opening_mm = 6.0 });
        Patient patient(quick);
        const PlannedField field
            = plan_approach(patient, find_approach(quick, approach.name), {}, { .error_bars = false, .draft = true });
        EXPECT_NE(field.message.find("is taken as slack"), std::string::npos) << field.message;
        const Label intercostal = mesh::find_label(planned_case.label_table, "intercostal")->id;
        int tight = 0;
        for (TetId t = 0; t < static_cast<TetId>(field.problem.mesh.tet_count()); ++t) {
            if (field.problem.mesh.labels[static_cast<std::size_t>(t)] != intercostal)
                continue;
            const auto space = space_at(*patient.anatomy(), middle_of(field.problem.mesh, t));
            EXPECT_FALSE(space && space->left && space->number != 4) << "space " << space->number;
            tight += space && space->number == 4 ? 1 : 0;
        }
        EXPECT_GT(tight, 0);
    }

    TEST_F(SlackWall, WithoutBoneBehindTheHooksNothingIsSlack)
    {
        Patient patient(planned_case);
        approach.hooks.front().bears_on.clear();
        EXPECT_EQ(slacken_other_spaces(wall, patient, approach), "");
    }

    TEST_F(SlackWall, StifferMuscleIsNotTakenForSlack)
    {
        planner::Case stiff = planned_case;
        for (fem::Material& material : stiff.materials)
            if (material.name == "muscle")
                material.youngs_modulus_MPa = 0.5;
        Patient patient(stiff);
        EXPECT_EQ(slacken_other_spaces(wall, patient, approach), "");
    }

    TEST(SlackSpaces, APlaceAboveTheFirstRibOrBeyondTheirEndsIsInNoSpace)
    {
        const Anatomy anatomy = six_ribs();
        ASSERT_TRUE(space_at(anatomy, Vec3(100.0, 0.0, 70.0)).has_value());
        EXPECT_EQ(space_at(anatomy, Vec3(100.0, 0.0, 70.0))->number, 1);
        EXPECT_EQ(space_at(anatomy, Vec3(100.0, 0.0, -10.0))->number, 5);
        EXPECT_FALSE(space_at(anatomy, Vec3(100.0, 0.0, 90.0)).has_value());
        EXPECT_FALSE(space_at(anatomy, Vec3(100.0, 0.0, -30.0)).has_value());
        EXPECT_FALSE(space_at(anatomy, Vec3(2.0, -100.0, 30.0)).has_value()); // in front of the ribs' ends
        EXPECT_FALSE(space_at(anatomy, Vec3(-100.0, 0.0, 30.0)).has_value()); // no ribs on the right
    }

} // namespace slack_spaces_test
} // namespace retractor::planner

#include "ui/plan_scene/field_map.h"

#include "mesh/base/error.h"
#include "planner/plan/plan.h"
#include "tests/support/block_case.h"
#include "ui/plan_scene/plan_scene.h"
#include "ui/scene/color_scale.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <set>

namespace retractor::ui {
namespace field_map_test {

    /// The words of the class whose colour a label of the map's first surface has.
    std::string words_of(const SceneMap& map, Label label, std::size_t surface = 0)
    {
        const Color color = map.surfaces.at(surface).look_of_label.at(label).color;
        for (const LegendLine& line : map.legend)
            if (line.swatch && line.swatch->r == color.r && line.swatch->g == color.g && line.swatch->b == color.b)
                return line.key;
        return {};
    }

    std::set<Label> labels_of(const SurfaceItem& item)
    {
        return { item.mesh->labels.begin(), item.mesh->labels.end() };
    }

    class FieldMap : public testing::Test {
    protected:
        static void SetUpTestSuite()
        {
            planner::Case planned_case
                = test_support::block_case("map", datasets::make_block_phantom(test_support::small_block()));
            patient = std::make_unique<planner::Patient>(planned_case);
            field = std::make_unique<planner::PlannedField>(planner::plan_approach(
                *patient, test_support::block_approach(*patient->labels(), Eigen::Isometry3d::Identity(), 16.0)));
        }
        static void TearDownTestSuite()
        {
            field.reset();
            patient.reset();
        }
        static inline std::unique_ptr<planner::Patient> patient;
        static inline std::unique_ptr<planner::PlannedField> field;
    };

    TEST_F(FieldMap, OfAPlanThatIsNotToBeUsedThereIsNone)
    {
        planner::PlannedField failed = *field;
        failed.metrics.mechanics_status = "not converged";
        for (const FieldMapName& map : kFieldMaps)
            EXPECT_FALSE(field_map(*patient, failed, map.kind)) << map.name;
    }

    TEST_F(FieldMap, ElongationIsThatOfGreensStrain)
    {
        ASSERT_EQ(field->status, planner::PlanStatus::done) << field->message;
        planner::PlannedField stretched = *field;
        const double stretch = 1.3;
        std::fill(stretched.opening.strain.begin(), stretched.opening.strain.end(), 0.5 * (stretch * stretch - 1.0));
        const auto map = field_map(*patient, stretched, FieldMapKind::strain);
        ASSERT_TRUE(map);
        ASSERT_EQ(map->surfaces.size(), 1U);
        EXPECT_EQ(map->surfaces[0].name, kWallName);
        ASSERT_EQ(labels_of(map->surfaces[0]).size(), 1U) << "30 % everywhere";
        EXPECT_EQ(words_of(*map, map->surfaces[0].mesh->labels.front()), "20 to 37 %");
        std::fill(stretched.opening.strain.begin(), stretched.opening.strain.end(), 0.0);
        const auto at_rest = field_map(*patient, stretched, FieldMapKind::strain);
        const TriMesh wall = drawn_wall(*patient, *field, field->opening.displacement);
        EXPECT_EQ(at_rest->surfaces[0].mesh->labels, wall.labels) << "tissue at rest keeps its colours";
        EXPECT_EQ(at_rest->surfaces[0].mesh->triangles, wall.triangles);
        stretched.opening.strain.clear();
        EXPECT_FALSE(field_map(*patient, stretched, FieldMapKind::strain));
    }

    TEST_F(FieldMap, ThePlannedFieldStrainsMostAtTheWound)
    {
        const auto map = field_map(*patient, *field, FieldMapKind::strain);
        EXPECT_GT(labels_of(map->surfaces[0]).size(), 2U);
        const Scene scene = with_map(surgeon_scene(*patient, *field), *map);
        EXPECT_NO_THROW(check_scene(scene));
        EXPECT_EQ(scene.legend.front().key, "largest elongation");
        EXPECT_NO_THROW(check_picture(map_picture(*patient, *field, *map, "Strain", 320, 240)));
    }

    TEST_F(FieldMap, ThirdsOfABladeHaveTheirMeanPressures)
    {
        EXPECT_FALSE(field_map(*patient, *field, FieldMapKind::pressure)) << "hooks have no pressure";
        planner::PlannedField bladed = *field;
        ASSERT_FALSE(bladed.hooks.empty());
        planner::BladeMetrics blade;
        blade.name = bladed.hooks.front().name;
        // 300 mm2 touch: 100 mm2 a third, so that 1 N is 10 kPa.
        blade.pressure
            = planner::BladePressure { .largest_kPa = 44.4, .touching_mm2 = 300.0, .thirds_N = { 0.5, 7.0, 90.0 } };
        bladed.metrics.retractor = planner::RetractorMetrics { .kind = "finochietto", .blades = { blade } };
        const auto map = field_map(*patient, bladed, FieldMapKind::pressure);
        ASSERT_TRUE(map);
        ASSERT_EQ(map->surfaces.size(), 1U);
        EXPECT_EQ(labels_of(map->surfaces[0]), (std::set<Label> { 0, 1, 2, 3 }));
        EXPECT_EQ(words_of(*map, 0), "below 50 kPa");
        EXPECT_EQ(words_of(*map, 1), "50 to 100 kPa");
        EXPECT_EQ(words_of(*map, 2), "800 or more kPa");
        EXPECT_EQ(map->surfaces[0].look_of_label.at(3).finish, Finish::metal);
        EXPECT_EQ(map->legend.rbegin()[1].value, "44 kPa");
        // The first third lies towards the start of the incision.
        double first = 0.0, last = 0.0;
        const TriMesh& mesh = *map->surfaces[0].mesh;
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
            const double along = mesh.vertices.row(mesh.triangles[t][0]).dot(field->geometry.along.transpose());
            if (mesh.labels[t] == 0)
                first = along;
            if (mesh.labels[t] == 2)
                last = along;
        }
        EXPECT_LT(first, last);
    }

    TEST_F(FieldMap, WhatIsNearAStructureAtRiskIsBright)
    {
        EXPECT_FALSE(field_map(*patient, *field, FieldMapKind::risk)) << "nothing is at risk";
        planner::Case risky = patient->planned_case();
        for (mesh::LabelInfo& info : risky.label_table)
            if (info.name == field->approach.target.label || info.role == mesh::Role::target)
                info.role = mesh::Role::at_risk;
        // A structure of the wall itself stands for one that the cut passes.
        risky.label_table.front().role = mesh::Role::at_risk;
        planner::Patient other(risky);
        const auto map = field_map(other, *field, FieldMapKind::risk);
        ASSERT_TRUE(map);
        EXPECT_EQ(map->surfaces.front().name, kWallName);
        EXPECT_EQ(map->surfaces.size(), 1U + field->hooks.size());
        std::set<std::string> words;
        for (const Label label : labels_of(map->surfaces.front()))
            words.insert(words_of(*map, label));
        EXPECT_TRUE(words.contains("below 2 mm"));
        EXPECT_FALSE(words.contains("30 or more mm")) << "what is far keeps the colours of its tissue";
        // A blade that leaves the body is far from everything at its end.
        const SurfaceItem& steel = map->surfaces.at(1);
        EXPECT_GT(labels_of(steel).size(), 1U);
        EXPECT_NO_THROW(check_scene(with_map(overview_scene(*patient, *field), *map)));
    }

    TEST_F(FieldMap, TheTargetShowsWhichPartIsSeen)
    {
        planner::PlannedField seen = *field;
        ASSERT_FALSE(seen.exposure.sample_points.empty());
        const Vec3 middle = seen.approach.target.centre;
        for (std::size_t n = 0; n < seen.exposure.sample_seen.size(); ++n)
            seen.exposure.sample_seen[n] = seen.exposure.sample_points[n].position.x() > middle.x() ? 0.9F : 0.0F;
        const auto map = field_map(*patient, seen, FieldMapKind::sight);
        ASSERT_TRUE(map);
        const TriMesh& target = *map->surfaces.front().mesh;
        int right = 0, wrong = 0;
        for (std::size_t t = 0; t < target.triangles.size(); ++t) {
            const double x = target.vertices.row(target.triangles[t][0]).x() - middle.x();
            const std::string expected = x > 0.0 ? "80 or more %" : "below 1 %";
            ++(words_of(*map, target.labels[t]) == expected ? right : wrong);
        }
        EXPECT_GT(right, 20 * wrong); // but for the triangles on the border
        const Scene scene = with_map(surgeon_scene(*patient, *field), *map);
        EXPECT_TRUE(std::none_of(
            scene.surfaces.begin(), scene.surfaces.end(), [](const SurfaceItem& item) { return item.target; }));
        EXPECT_EQ(scene.surfaces.size(), surgeon_scene(*patient, *field).surfaces.size()) << "in place of the target";
    }

    TEST_F(FieldMap, TheTargetShowsWhatFingerAndInstrumentsReach)
    {
        planner::PlannedField reached = *field;
        reached.best_eye.finger_touches.clear();
        reached.best_eye.two_instruments_reach.clear();
        const Vec3 middle = reached.approach.target.centre;
        for (std::size_t n = 0; n < reached.exposure.sample_points.size(); ++n) {
            const Vec3 from = reached.exposure.sample_points[n].position - middle;
            if (from.x() > 0.0)
                reached.best_eye.finger_touches.push_back(static_cast<std::uint32_t>(n));
            if (from.y() > 0.0)
                reached.best_eye.two_instruments_reach.push_back(static_cast<std::uint32_t>(n));
        }
        const auto map = field_map(*patient, reached, FieldMapKind::reach);
        ASSERT_TRUE(map);
        const TriMesh& target = *map->surfaces.front().mesh;
        int right = 0, wrong = 0;
        for (std::size_t t = 0; t < target.triangles.size(); ++t) {
            const Vec3 from = target.vertices.row(target.triangles[t][0]).transpose() - middle;
            const std::string expected = from.x() > 0.0 ? from.y() > 0.0 ? "finger and two instruments" : "a finger"
                : from.y() > 0.0                        ? "two instruments"
                                                        : "neither";
            ++(words_of(*map, target.labels[t]) == expected ? right : wrong);
        }
        EXPECT_GT(right, 10 * wrong); // but for the triangles on the two borders
        EXPECT_NO_THROW(check_scene(with_map(surgeon_scene(*patient, reached), *map)));
        reached.exposure = {};
        EXPECT_FALSE(field_map(*patient, reached, FieldMapKind::reach));
    }

    TEST_F(FieldMap, EveryEyeOfTheConeIsShownFromTheSide)
    {
        const auto map = field_map(*patient, *field, FieldMapKind::eyes);
        ASSERT_TRUE(map);
        const std::size_t balls = field->exposure.eyes.size() + 1; // and the best one
        EXPECT_EQ(map->surfaces.front().mesh->triangles.size() % balls, 0U);
        const Scene before = overview_scene(*patient, *field), after = with_map(before, *map);
        EXPECT_NO_THROW(check_scene(after));
        EXPECT_GT((after.camera.eye - before.camera.eye).norm(), 100.0);
        planner::PlannedField unmeasured = *field;
        unmeasured.exposure = {};
        EXPECT_FALSE(field_map(*patient, unmeasured, FieldMapKind::eyes));
        EXPECT_FALSE(field_map(*patient, unmeasured, FieldMapKind::sight));
    }

    TEST_F(FieldMap, NamesAreRead)
    {
        for (const FieldMapName& map : kFieldMaps)
            EXPECT_EQ(field_map_from_string(map.name), map.kind);
        EXPECT_THROW(field_map_from_string("heat"), InputError);
    }

    TEST(ColorClasses, CoverAllNumbersOnceAndBrightIsWhereToLook)
    {
        const ColorClasses high { .limits = { 5, 10 } };
        EXPECT_EQ(high.of(-1e9), 0U);
        EXPECT_EQ(high.of(5.0), 1U);
        EXPECT_EQ(high.of(9.999), 1U);
        EXPECT_EQ(high.of(1e9), 2U);
        EXPECT_EQ(high.words(0), "below 5");
        EXPECT_EQ(high.words(1), "5 to 10");
        EXPECT_EQ(high.words(2), "10 or more");
        const auto brightness = [](const Color& c) { return 0.21 * c.r + 0.72 * c.g + 0.07 * c.b; };
        EXPECT_LT(brightness(high.color(0)), brightness(high.color(1)));
        EXPECT_LT(brightness(high.color(1)), brightness(high.color(2)));
        const ColorClasses low { .limits = { 5, 10 }, .low_is_bright = true };
        EXPECT_GT(brightness(low.color(0)), brightness(low.color(2)));
        ASSERT_EQ(high.legend("mm").size(), 3U);
        EXPECT_EQ(high.legend("mm").front().key, "10 or more mm");
    }

} // namespace field_map_test
} // namespace retractor::ui

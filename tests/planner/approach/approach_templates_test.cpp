#include "planner/approach/approach_templates.h"

#include "datasets/phantoms/phantom.h"
#include "mesh/base/error.h"
#include "planner/anatomy/body_probe.h"
#include "planner/approach/approach_draft.h"
#include "planner/approach/intercostal_space.h"
#include "tests/support/synthetic_chest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace retractor::planner {
namespace approach_templates_test {

    using test_support::ChestShape;

    constexpr double kEquivarianceMm = 1e-6; // asked for; round-off is near 1e-12
    constexpr double kHalfVoxelMm
        = 1.5; // of the round chest: where its skin runs along the grid, labels know no better

    struct Patient {
        std::string name;
        mesh::LabelVolume labels;
    };

    const std::vector<Patient>& patients()
    {
        // The thorax coarser than the demo's, to save time, and another one of a different build.
        static const std::vector<Patient> all {
            { "round chest", test_support::synthetic_chest() },
            { "thorax", datasets::make_thorax_phantom({ .spacing_mm = { 2.2, 2.2, 2.4 }, .noise_hu = 0.0 }).labels },
            { "large thorax",
                datasets::make_thorax_phantom({ .width_mm = 400.0,
                                                  .depth_mm = 270.0,
                                                  .spacing_mm = { 2.6, 2.6, 2.6 },
                                                  .fat_mm = 20.0,
                                                  .noise_hu = 0.0 })
                    .labels },
        };
        return all;
    }

    ApproachRequest request(const std::string& template_name, const std::string& target = {})
    {
        ApproachRequest r;
        r.template_name = template_name;
        r.target.label = !target.empty()          ? target
            : template_name.starts_with("midcab") ? "coronary_target"
                                                  : "aneurysm";
        return r;
    }

    const std::vector<std::string> kTemplates { "median", "hemisternotomy-j", "hemisternotomy-t", "intercostal:4",
        "intercostal:5", "distal", "midcab", "right-anterior", "right-lateral" };

    double distance_to_bone(const mesh::LabelVolume& labels, const Approach& approach, std::string_view but_not)
    {
        double least = 1e300;
        std::vector<Vec3> blade;
        for (std::size_t n = 0; n < approach.incision.size(); ++n)
            for (double t = 0.0; t <= approach.depth_mm; t += 2.5)
                blade.push_back(approach.incision[n] + t * approach.directions[n]);
        Vec3 low = blade.front(), high = blade.front();
        for (const Vec3& p : blade) {
            low = low.cwiseMin(p);
            high = high.cwiseMax(p);
        }
        for (int k = 0; k < labels.grid.size[2]; ++k)
            for (int j = 0; j < labels.grid.size[1]; ++j)
                for (int i = 0; i < labels.grid.size[0]; ++i) {
                    const Label label = labels.voxels[labels.grid.offset(i, j, k)];
                    if (label == 0)
                        continue;
                    const Vec3 p = labels.grid.world(Vec3(i, j, k));
                    if (((low - p).array() > 6.0).any() || ((p - high).array() > 6.0).any())
                        continue;
                    const mesh::LabelInfo* info = mesh::find_label(labels.table, label);
                    if (info->material != "bone" || info->name == but_not)
                        continue;
                    for (const Vec3& q : blade)
                        least = std::min(least, (p - q).norm());
                }
        return least;
    }

    void expect_same(const Approach& a, const Approach& b, const Mat3& rotation, const Vec3& shift)
    {
        ASSERT_EQ(a.incision.size(), b.incision.size());
        for (std::size_t n = 0; n < a.incision.size(); ++n) {
            EXPECT_LT((rotation * a.incision[n] + shift - b.incision[n]).norm(), kEquivarianceMm);
            EXPECT_LT((rotation * a.directions[n] - b.directions[n]).norm(), kEquivarianceMm);
            EXPECT_NEAR(a.wall_thickness_mm[n], b.wall_thickness_mm[n], kEquivarianceMm);
        }
        EXPECT_NEAR(a.depth_mm, b.depth_mm, kEquivarianceMm);
        EXPECT_EQ(a.rationale, b.rationale);
    }

    TEST(ApproachTemplates, LinesLieOnTheSkinInSmallSteps)
    {
        for (const Patient& patient : patients()) {
            const BodyProbe probe(patient.labels);
            for (const std::string& name : kTemplates) {
                SCOPED_TRACE(patient.name + " " + name);
                const Approach approach = approach_from_template(patient.labels, request(name));
                ASSERT_GE(approach.incision.size(), 8u);
                for (std::size_t n = 0; n < approach.incision.size(); ++n) {
                    EXPECT_NEAR(approach.directions[n].norm(), 1.0, 1e-12);
                    // Two voxels out there is air, two in there is tissue: no farther off the skin than the voxels
                    // resolve.
                    const double voxels = 2.0 * patient.labels.grid.spacing.maxCoeff();
                    EXPECT_EQ(
                        mesh::label_at(patient.labels, approach.incision[n] - voxels * approach.directions[n]), 0);
                    EXPECT_NE(
                        mesh::label_at(patient.labels, approach.incision[n] + voxels * approach.directions[n]), 0);
                    if (n == 0)
                        continue;
                    const Vec3 step = approach.incision[n] - approach.incision[n - 1];
                    EXPECT_GT(step.norm(), 4.0);
                    EXPECT_LT(step.norm(), 8.0);
                    if (n > 1) { // smooth: the line turns by less than 12 degrees per step
                        const Vec3 before = approach.incision[n - 1] - approach.incision[n - 2];
                        EXPECT_GT(
                            step.normalized().dot(before.normalized()), std::cos(12.0 * std::numbers::pi / 180.0));
                    }
                }
            }
        }
    }

    TEST(ApproachTemplates, BetweenRibsTheSpaceIsDividedBeyondTheSkin)
    {
        for (const std::string& name : kTemplates) {
            ApproachRequest r = request(name);
            EXPECT_EQ(approach_from_template(patients()[0].labels, r).division.extent,
                name == "median"                 ? DivisionExtent::skin
                    : name == "hemisternotomy-j" ? DivisionExtent::sternum_right
                    : name == "hemisternotomy-t" ? DivisionExtent::sternum_across
                                                 : DivisionExtent::full)
                << name;
            r.division = DivisionExtent::skin;
            EXPECT_EQ(approach_from_template(patients()[0].labels, r).division.extent, DivisionExtent::skin) << name;
        }
    }

    TEST(ApproachTemplates, SkinOfTheRoundChestIsAtItsRadius)
    {
        for (const std::string& name : kTemplates)
            for (const Vec3& point : approach_from_template(patients()[0].labels, request(name)).incision)
                EXPECT_NEAR(std::hypot(point.x(), point.y()), test_support::ChestShape {}.radius, kHalfVoxelMm) << name;
    }

    TEST(ApproachTemplates, BladePassesTheWholeWallAndLittleMore)
    {
        for (const Patient& patient : patients()) {
            const mesh::LabelFlags wall = mesh::flagged_labels(patient.labels.table, mesh::is_wall);
            for (const std::string& name : kTemplates) {
                SCOPED_TRACE(patient.name + " " + name);
                const Approach approach = approach_from_template(patient.labels, request(name));
                double thickest = 0.0;
                for (std::size_t n = 0; n < approach.incision.size(); ++n) {
                    thickest = std::max(thickest, approach.wall_thickness_mm[n]);
                    const Vec3 beyond
                        = approach.incision[n] + (approach.wall_thickness_mm[n] + 2.5) * approach.directions[n];
                    EXPECT_FALSE(wall[mesh::label_at(patient.labels, beyond)]) << n;
                }
                EXPECT_GT(approach.depth_mm, thickest);
                EXPECT_LT(approach.depth_mm, thickest + 6.0);
            }
        }
    }

    TEST(ApproachTemplates, NoBladeTouchesBoneThatIsNotSawn)
    {
        for (const Patient& patient : patients())
            for (const std::string& name : kTemplates) {
                const Approach approach = approach_from_template(patient.labels, request(name));
                const bool sternal = name == "median" || name.starts_with("hemisternotomy");
                const double distance = distance_to_bone(patient.labels, approach, sternal ? "sternum" : "");
                EXPECT_GT(distance, 0.5 * patient.labels.grid.spacing.maxCoeff() + 0.8) << patient.name << " " << name;
            }
    }

    TEST(ApproachTemplates, MedianFollowsTheMidlineAndOverrunsTheSternum)
    {
        const Approach approach = approach_from_template(patients()[0].labels, request("median"));
        for (const Vec3& point : approach.incision)
            EXPECT_LT(std::abs(point.x()), kHalfVoxelMm);
        EXPECT_NEAR(approach.incision.front().z(), test_support::kSternumTop + 10.0, 3.0);
        EXPECT_NEAR(approach.incision.back().z(), test_support::kSternumBottom - 10.0, 3.0);
        for (const Vec3& direction : approach.directions)
            EXPECT_LT((direction - Vec3::UnitY()).norm(), 0.03);
        EXPECT_EQ(std::count(approach.uncut_labels.begin(), approach.uncut_labels.end(), "sternum"), 0);
        EXPECT_EQ(std::count(approach.uncut_labels.begin(), approach.uncut_labels.end(), "rib_left_4"), 1);
        EXPECT_EQ(std::count(approach.retracted.begin(), approach.retracted.end(), "lung_right"), 1);
        EXPECT_FALSE(approach.rationale.empty());
    }

    TEST(ApproachTemplates, HemisternotomyEndsAtTheLevelOfItsSpace)
    {
        const test_support::ChestShape shape;
        for (const int space : { 3, 4, 5 }) {
            const Approach approach
                = approach_from_template(patients()[0].labels, request("hemisternotomy-j:" + std::to_string(space)));
            // The ribs of the round chest have no cartilage: their front ends give the level.
            const double level = 0.5
                * (test_support::rib_height_at(shape, space, test_support::kRibToDeg)
                    + test_support::rib_height_at(shape, space + 1, test_support::kRibToDeg));
            EXPECT_NEAR(approach.incision.front().z(), test_support::kSternumTop + 10.0, 3.0);
            EXPECT_NEAR(approach.incision.back().z(), level, 3.0) << space;
            EXPECT_NE(approach.rationale.find("cartilages have no labels"), std::string::npos);
            EXPECT_EQ(approach.template_name, "hemisternotomy-j:" + std::to_string(space));
        }
        EXPECT_THROW(approach_from_template(patients()[0].labels, request("hemisternotomy-j:1")), InputError)
            << "the first space lies at the notch";
        ApproachRequest shorter = request("hemisternotomy-t");
        shorter.length_mm = 60.0;
        EXPECT_THROW(approach_from_template(patients()[0].labels, shorter), InputError);
    }

    TEST(ApproachTemplates, IntercostalRunsAlongTheUpperEdgeOfTheLowerRib)
    {
        const test_support::ChestShape shape;
        for (const bool left : { true, false })
            for (const int space : { 3, 4, 5, 6 }) {
                ApproachRequest r = request("intercostal:" + std::to_string(space));
                r.left = left;
                const Approach approach = approach_from_template(patients()[0].labels, r);
                EXPECT_NEAR(incision_length(approach), 170.0, 2.0);
                for (std::size_t n = 0; n < approach.incision.size(); ++n) {
                    const Vec3 between = approach.incision[n] + approach.hook_depth_mm[n] * approach.directions[n];
                    const double angle = std::atan2(std::abs(between.x()), between.y()) * 180.0 / std::numbers::pi;
                    EXPECT_EQ(between.x() > 0.0, left);
                    EXPECT_NEAR(std::hypot(between.x(), between.y()), shape.rib_radius, 1.0);
                    EXPECT_NEAR(between.z(), test_support::upper_edge_at(shape, space + 1, angle) + kAboveLowerRibMm,
                        0.5 * shape.spacing); // the ribs are voxels
                }
                EXPECT_EQ(approach.retracted.front(), left ? "lung_left" : "lung_right");
            }
    }

    TEST(ApproachTemplates, MidcabIsCentredOverItsTarget)
    {
        const mesh::LabelVolume& labels = patients()[0].labels;
        const Vec3 target(60.0, -35.0, -30.0);
        const auto over_target = [&](const std::string& name) {
            ApproachRequest r = request(name);
            r.target = { .label = {}, .centre = target, .radius_mm = 8.0 };
            return approach_from_template(labels, r);
        };
        const Approach approach = over_target("midcab:5");
        const Vec3 middle = approach.incision[approach.incision.size() / 2];
        EXPECT_NEAR(std::atan2(middle.x(), -middle.y()), std::atan2(target.x(), -target.y()), 0.1); // 6 degrees
        EXPECT_NEAR(incision_length(approach), 70.0, 1.5);
        // Both spaces offered: the nearer one is taken.
        const auto reach = [&](const std::string& name) {
            const Approach a = over_target(name);
            return (a.incision[a.incision.size() / 2] - target).norm();
        };
        EXPECT_LE(reach("midcab"), std::min(reach("midcab:4"), reach("midcab:5")) + 2.0);
    }

    TEST(ApproachTemplates, MiniThoracotomiesOnTheRightLieInFrontAndAtTheSide)
    {
        const mesh::LabelVolume& labels = patients()[0].labels;
        const auto angle_deg = [](const Approach& a) { // from straight back; x points left, y back
            const Vec3 middle = a.incision[a.incision.size() / 2];
            return std::atan2(std::abs(middle.x()), middle.y()) * 180.0 / std::numbers::pi;
        };
        const Approach front = approach_from_template(labels, request("right-anterior")),
                       side = approach_from_template(labels, request("right-lateral"));
        for (const Approach* approach : { &front, &side }) {
            for (const Vec3& point : approach->incision)
                EXPECT_LT(point.x(), 0.0) << approach->name;
            EXPECT_NE(std::ranges::find(approach->retracted, "lung_right"), approach->retracted.end());
            EXPECT_EQ(std::ranges::find(approach->retracted, "lung_left"), approach->retracted.end());
            EXPECT_EQ(approach->division.extent, DivisionExtent::full);
        }
        EXPECT_NEAR(incision_length(front), 60.0, 3.0); // the ribs of this chest end early
        EXPECT_NEAR(incision_length(side), 70.0, 1.5);
        EXPECT_GT(angle_deg(front), angle_deg(side) + 5.0);
        EXPECT_NEAR(angle_deg(side), 112.0, 3.0);
        EXPECT_TRUE(front.template_name == "right-anterior:2" || front.template_name == "right-anterior:3");
        EXPECT_EQ(side.template_name, "right-lateral:4");
        EXPECT_EQ(surgical_name(side), "Right lateral mini-thoracotomy, 4th space");
    }

    TEST(ApproachTemplates, DistalLiesFartherBackThanTheLateralIncision)
    {
        const mesh::LabelVolume& labels = patients()[0].labels;
        const auto middle = [&](const std::string& name) {
            const Approach a = approach_from_template(labels, request(name));
            return a.incision[a.incision.size() / 2];
        };
        EXPECT_GT(middle("distal").y(), middle("intercostal:6").y() + 20.0); // y points back
    }

    TEST(ApproachTemplates, TurnedAndShiftedPatientGetsTheSameIncision)
    {
        const Mat3 rotation = Eigen::AngleAxisd(-1.13, Vec3(0.5, 0.7, -0.2).normalized()).toRotationMatrix();
        const Vec3 shift(-88.8, 512.5, -1203.7);
        for (const Patient& patient : patients()) {
            const mesh::LabelVolume turned = test_support::moved(patient.labels, rotation, shift);
            for (const std::string& name : kTemplates) {
                SCOPED_TRACE(patient.name + " " + name);
                expect_same(approach_from_template(patient.labels, request(name)),
                    approach_from_template(turned, request(name)), rotation, shift);
            }
        }
    }

    TEST(ApproachTemplates, StorageOrderDoesNotMatter)
    {
        for (const int axis : { 0, 1, 2 }) {
            const mesh::LabelVolume backwards = test_support::stored_backwards(patients()[1].labels, axis);
            for (const std::string& name : kTemplates) {
                SCOPED_TRACE(name);
                expect_same(approach_from_template(patients()[1].labels, request(name)),
                    approach_from_template(backwards, request(name)), Mat3::Identity(), Vec3::Zero());
            }
        }
    }

    TEST(ApproachTemplates, RetractedOrgansAndTargetAreInTheTable)
    {
        for (const std::string& name : kTemplates) {
            const mesh::LabelVolume& labels = patients()[1].labels;
            const Approach approach = approach_from_template(labels, request(name));
            EXPECT_FALSE(approach.retracted.empty());
            for (const std::string& organ : approach.retracted)
                EXPECT_NE(mesh::find_label(labels.table, organ), nullptr) << organ;
        }
    }

    TEST(ApproachTemplates, BadRequestsAreRefused)
    {
        const mesh::LabelVolume& labels = patients()[0].labels;
        for (const char* name : { "", "medial", "intercostal", "intercostal:", "intercostal:x", "intercostal:0",
                 "intercostal:12", "intercostal:5x", "median:3" })
            EXPECT_THROW(approach_from_template(labels, request(name, "aneurysm")), InputError) << name;
        EXPECT_THROW(approach_from_template(labels, request("median", "spleen")), InputError);
        EXPECT_THROW(approach_from_template(labels, request("intercostal:9")), InputError); // this chest has eight ribs
        ApproachRequest endless = request("intercostal:5");
        endless.length_mm = 900.0;
        EXPECT_THROW(approach_from_template(labels, endless), InputError);
        ApproachRequest nowhere = request("median");
        nowhere.target = {};
        EXPECT_THROW(approach_from_template(labels, nowhere), InputError); // a sphere of radius 0
        nowhere.target = { .label = "", .centre = Vec3(900, 0, 0), .radius_mm = 10.0 };
        EXPECT_THROW(approach_from_template(labels, nowhere), InputError); // beside the patient
        EXPECT_THROW(approach_from_template(labels, request("median", "sternum")), InputError); // it is cut
    }

    TEST(ApproachTemplates, TooNarrowASpaceIsRefused)
    {
        test_support::ChestShape narrow;
        narrow.rib_height = 22.5; // of a pitch of 24 mm
        EXPECT_THROW(
            approach_from_template(test_support::synthetic_chest(narrow), request("intercostal:4")), InputError);
    }

    TEST(ApproachFromPoints, PointsAreMovedOntoTheSkin)
    {
        const mesh::LabelVolume& labels = patients()[0].labels;
        const double off[] = { 5.0, -8.0, 0.0 };
        std::vector<Vec3> points;
        for (int n = 0; n < 3; ++n) {
            const double angle = 0.35 * n - 0.9;
            points.push_back((test_support::ChestShape {}.radius + off[n]) * Vec3(std::cos(angle), std::sin(angle), 0.0)
                + Vec3(0.0, 0.0, -12.0 * n));
        }
        const PointsApproach result = approach_from_points(labels, points, request("points"));
        for (std::size_t n = 0; n < 3; ++n)
            EXPECT_NEAR(result.moved_mm[n], std::abs(off[n]), 1.0);
        for (std::size_t n = 0; n < result.approach.incision.size(); ++n) {
            const Vec3& point = result.approach.incision[n];
            EXPECT_NEAR(std::hypot(point.x(), point.y()), test_support::ChestShape {}.radius, kHalfVoxelMm);
            EXPECT_GT(result.approach.directions[n].dot(-Vec3(point.x(), point.y(), 0.0).normalized()), 0.98);
        }
        EXPECT_EQ(result.approach.template_name, "points");
    }

    TEST(ApproachFromPoints, ShiftedPointsOnAShiftedPatientAgree)
    {
        const Mat3 rotation = Eigen::AngleAxisd(0.4, Vec3(0.1, 0.9, 0.4).normalized()).toRotationMatrix();
        const Vec3 shift(12.5, -30.1, 77.7);
        std::vector<Vec3> points { { 118.0, -40.0, 10.0 }, { 100.0, -75.0, 0.0 } }, turned;
        for (const Vec3& point : points)
            turned.push_back(rotation * point + shift);
        const mesh::LabelVolume& labels = patients()[0].labels;
        expect_same(approach_from_points(labels, points, request("points")).approach,
            approach_from_points(test_support::moved(labels, rotation, shift), turned, request("points")).approach,
            rotation, shift);
    }

    TEST(ApproachFromPoints, BadPointsAreRefused)
    {
        const mesh::LabelVolume& labels = patients()[0].labels;
        const std::vector<Vec3> good { { 118.0, -40.0, 10.0 }, { 100.0, -75.0, 0.0 } };
        const auto refused_at = [&](const std::vector<Vec3>& points, double depth = 0.0) -> std::string {
            try {
                approach_from_points(labels, points, request("points"), depth);
            } catch (const InputError& error) {
                return error.where();
            }
            return "accepted";
        };
        EXPECT_EQ(refused_at({ good[0] }), "points");
        EXPECT_EQ(refused_at({ good[0], Vec3(std::nan(""), 0.0, 0.0) }), "point 2");
        EXPECT_EQ(refused_at({ good[0], Vec3(300.0, 0.0, 0.0) }), "point 2"); // 180 mm off
        EXPECT_EQ(refused_at({ good[0], good[0] }), "point 2");
        EXPECT_EQ(refused_at(good, -1.0), "depth");
        EXPECT_EQ(refused_at(good, 30.0), "accepted");
    }

    TEST(ApproachFromPoints, ABladeThatCrossesItselfIsRefusedByItsPoints)
    {
        const mesh::LabelVolume labels = datasets::make_block_phantom({}).labels;
        ApproachRequest across = request("points", "target");
        const std::vector<Vec3> corners { { -25, 0, -25 }, { 25, 0, -25 }, { 25, 0, 25 }, { -25, 0, 25 } };
        const auto refusal = [&](std::vector<Vec3> points, const Vec3& last) -> std::string {
            points.push_back(last);
            try {
                approach_from_points(labels, points, across);
            } catch (const InputError& error) {
                return error.where() + ": " + error.what();
            }
            return "accepted";
        };
        const std::string closed = refusal(corners, corners[0]);
        EXPECT_EQ(closed.find("point 5: the blade crosses itself on the way from the point (-25.0, 0.0, 25.0) mm to "
                              "(-25.0, 0.0, -25.0) mm"),
            0u)
            << closed;
        EXPECT_NE(closed.find("an incision does not close; end it some way before its first point"), std::string::npos);
        const std::string crossed = refusal(corners, { 0, 0, -40 });
        EXPECT_EQ(crossed.find("point 5: the blade crosses itself"), 0u) << crossed;
        EXPECT_NE(crossed.find("move these points"), std::string::npos) << crossed;
        EXPECT_EQ(refusal(corners, { -25, 0, -10 }), "accepted");
    }

    TEST(ApproachFromPoints, SolidBodyNeedsADepth)
    {
        mesh::LabelVolume labels = patients()[0].labels;
        for (mesh::LabelInfo& info : labels.table)
            info.role = mesh::Role::wall;
        const std::vector<Vec3> points { { 118.0, -40.0, 10.0 }, { 100.0, -75.0, 0.0 } };
        ApproachRequest sphere = request("points"); // no label is left that is not wall
        sphere.target = { .label = "", .centre = label_centroid(labels, "aneurysm"), .radius_mm = 10.0 };
        EXPECT_THROW(approach_from_points(labels, points, sphere), InputError);
        EXPECT_EQ(approach_from_points(labels, points, sphere, 25.0).approach.depth_mm, 25.0);
    }

} // namespace approach_templates_test
} // namespace retractor::planner

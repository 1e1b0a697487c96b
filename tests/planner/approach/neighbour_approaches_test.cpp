#include "planner/approach/neighbour_approaches.h"

#include "planner/anatomy/body_probe.h"
#include "planner/approach/approach_draft.h"
#include "planner/approach/approach_templates.h"
#include "planner/approach/intercostal_space.h"
#include "planner/approach/retractors.h"
#include "tests/support/block_case.h"
#include "tests/support/synthetic_chest.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace retractor::planner {
namespace neighbour_approaches_test {

    const test_support::ChestShape kShape {};

    Patient& patient()
    {
        static Patient made([] {
            datasets::Phantom phantom {};
            phantom.labels = test_support::synthetic_chest(kShape);
            return test_support::block_case("neighbours", phantom);
        }());
        return made;
    }

    Approach from_template(const std::string& name, bool left = true, double length_mm = 70.0)
    {
        ApproachRequest request;
        request.template_name = name;
        request.target.label = "aneurysm";
        request.left = left;
        request.length_mm = length_mm;
        return opened_by(approach_from_template(*patient().labels(), *patient().anatomy(), request),
            { .hooks = "4", .opening_mm = 30.0 });
    }

    Vec3 middle_of(const Approach& approach)
    {
        return incision_place(approach, 0.5 * incision_length(approach)).of(approach.incision);
    }

    std::vector<std::string> places(const std::vector<NeighbourApproach>& neighbours)
    {
        std::vector<std::string> where;
        for (const NeighbourApproach& neighbour : neighbours)
            where.push_back(neighbour.where);
        return where;
    }

    TEST(NeighbourApproaches, AreOneSpaceHigherAndLowerAndTwentyMillimetresAlong)
    {
        for (const bool left : { true, false }) {
            const Approach approach = from_template("intercostal:4", left);
            const std::vector<NeighbourApproach> neighbours = neighbours_of(patient(), approach);
            ASSERT_EQ(neighbours.size(), 4U);
            EXPECT_EQ(places(neighbours),
                (std::vector<std::string> {
                    "one space higher", "one space lower", "20 mm forwards", "20 mm backwards" }));
            for (const NeighbourApproach& neighbour : neighbours) {
                ASSERT_TRUE(neighbour.approach) << neighbour.where << ": " << neighbour.refused;
                EXPECT_EQ(neighbour.approach->hooks.size(), 4U);
                EXPECT_EQ(neighbour.approach->hooks[0].opening_mm, approach.hooks[0].opening_mm);
                EXPECT_EQ(neighbour.approach->division.extent, approach.division.extent);
                EXPECT_EQ(neighbour.approach->target.label, "aneurysm");
                EXPECT_NEAR(incision_length(*neighbour.approach), 70.0, 3.0);
                EXPECT_NE(neighbour.approach->name, approach.name);
                const auto space = space_under_incision(*patient().anatomy(), *neighbour.approach);
                ASSERT_TRUE(space);
                EXPECT_EQ(space->left, left);
            }
            EXPECT_EQ(neighbours[0].approach->template_name, "intercostal:3");
            EXPECT_EQ(neighbours[0].approach->name, "intercostal_4_space_3");
            EXPECT_EQ(space_under_incision(*patient().anatomy(), *neighbours[1].approach)->number, 5);
            // Ribs lie 24 mm apart.
            EXPECT_NEAR(middle_of(*neighbours[0].approach).z() - middle_of(approach).z(), kShape.rib_pitch, 3.0);
            EXPECT_NEAR((middle_of(*neighbours[2].approach) - middle_of(approach)).norm(), kNeighbourStepMm, 1.5);
            EXPECT_LT(middle_of(*neighbours[2].approach).y(), middle_of(approach).y()) << "the front is at -y";
            EXPECT_GT(middle_of(*neighbours[3].approach).y(), middle_of(approach).y());
        }
    }

    TEST(NeighbourApproaches, OfAPlannedFieldHaveItsRetractorAndNotItsBlades)
    {
        const Approach asked = opened_by(from_template("intercostal:4"), { .retractor = "midcab", .opening_mm = 20.0 });
        Approach planned = asked;
        planned.hooks = blades_of(asked);
        const std::vector<NeighbourApproach> neighbours = neighbours_of(patient(), planned);
        ASSERT_EQ(neighbours.size(), 4U);
        for (const NeighbourApproach& neighbour : neighbours) {
            ASSERT_TRUE(neighbour.approach) << neighbour.where << ": " << neighbour.refused;
            EXPECT_EQ(neighbour.approach->retractor->kind, "midcab");
            EXPECT_TRUE(neighbour.approach->hooks.empty());
            EXPECT_NO_THROW(check_approach(*neighbour.approach));
        }
    }

    TEST(NeighbourApproaches, AreMovedFromWhereTheIncisionLiesAlsoWhereItSlidFromItsWantedPlace)
    {
        Approach approach = from_template("midcab:4"); // the target is nearest beyond the end of the space
        ASSERT_NE(approach.rationale.find("as far as the shoulder blade"), std::string::npos) << approach.rationale;
        const std::vector<NeighbourApproach> neighbours = neighbours_of(patient(), approach);
        ASSERT_EQ(neighbours.size(), 4U);
        int moved = 0;
        for (const std::size_t n : { 2U, 3U })
            if (neighbours[n].approach) {
                ++moved;
                EXPECT_NEAR((middle_of(*neighbours[n].approach) - middle_of(approach)).norm(), kNeighbourStepMm, 1.5);
            }
        EXPECT_EQ(moved, 1) << "away from the end there is room";
    }

    TEST(NeighbourApproaches, OfADrawnIncisionKeepItsAngles)
    {
        const Approach pattern = from_template("intercostal:4");
        std::vector<Vec3> points = incision_handles(pattern);
        for (Vec3& point : points)
            point.z() += 3.0; // not on the line of the cut
        const Approach drawn = with_incision_through(
            patient(),
            [&] {
                Approach approach = pattern;
                approach.template_name = "points";
                return approach;
            }(),
            points);
        const std::vector<NeighbourApproach> neighbours = neighbours_of(patient(), drawn);
        ASSERT_EQ(neighbours.size(), 4U);
        for (const NeighbourApproach& neighbour : neighbours)
            ASSERT_TRUE(neighbour.approach) << neighbour.where << ": " << neighbour.refused;
        EXPECT_NEAR(middle_of(*neighbours[0].approach).z() - middle_of(drawn).z(), kShape.rib_pitch, 3.0);
        EXPECT_NEAR(middle_of(*neighbours[1].approach).z() - middle_of(drawn).z(), -kShape.rib_pitch, 3.0);
        EXPECT_NEAR((middle_of(*neighbours[2].approach) - middle_of(drawn)).norm(), kNeighbourStepMm, 1.5);
        EXPECT_EQ(neighbours[0].approach->template_name, "points");
        EXPECT_EQ(neighbours[0].approach->hooks.size(), 4U);
    }

    TEST(NeighbourApproaches, AnIncisionThatWasMovedIsNotPutBackIntoItsTemplatesPlace)
    {
        const Approach approach = from_template("intercostal:4");
        std::vector<Vec3> points = incision_handles(approach);
        for (Vec3& point : points)
            point.z() += 6.0;
        const Approach by_hand = with_incision_through(patient(), approach, points);
        const std::vector<NeighbourApproach> neighbours = neighbours_of(patient(), by_hand);
        ASSERT_TRUE(neighbours[0].approach) << neighbours[0].refused;
        EXPECT_NEAR(middle_of(*neighbours[0].approach).z() - middle_of(by_hand).z(), kShape.rib_pitch, 3.0);
    }

    TEST(NeighbourApproaches, ThatCannotBeHaveAReason)
    {
        EXPECT_TRUE(neighbours_of(patient(), from_template("median", true, 0.0)).empty());
    }

    TEST(NeighbourApproaches, OfAHemisternotomyTurnInTheSpacesAboveAndBelow)
    {
        Approach j = from_template("hemisternotomy-j:4", true, 0.0);
        const std::vector<NeighbourApproach> found = neighbours_of(patient(), j);
        ASSERT_EQ(found.size(), 2U);
        ASSERT_TRUE(found[0].approach && found[1].approach) << found[0].refused << found[1].refused;
        EXPECT_EQ(found[0].approach->template_name, "hemisternotomy-j:3");
        EXPECT_EQ(found[1].approach->template_name, "hemisternotomy-j:5");
        EXPECT_LT(incision_length(*found[0].approach), incision_length(j));
        EXPECT_GT(incision_length(*found[1].approach), incision_length(j));
        EXPECT_EQ(found[0].approach->division.extent, DivisionExtent::sternum_right);
        j.incision.back() += Vec3(0.0, 0.0, 15.0); // moved by hand: it ends in no space
        EXPECT_TRUE(neighbours_of(patient(), j).empty());
        j.template_name = "hemisternotomy-j:four";
        EXPECT_TRUE(neighbours_of(patient(), j).empty());
        const std::vector<NeighbourApproach> last = neighbours_of(patient(), from_template("intercostal:7"));
        ASSERT_EQ(last.size(), 4U); // the chest has eight ribs
        EXPECT_FALSE(last[1].approach);
        EXPECT_NE(last[1].refused.find("rib_left_9"), std::string::npos) << last[1].refused;
        const std::vector<NeighbourApproach> first = neighbours_of(patient(), from_template("intercostal:1"));
        EXPECT_FALSE(first[0].approach);
        EXPECT_NE(first[0].refused.find("the highest"), std::string::npos) << first[0].refused;

        Approach without_rib = from_template("intercostal:4");
        without_rib.ablations.push_back({ .label = "rib_left_4", .from_mm = -5.0, .to_mm = 5.0 });
        const std::vector<NeighbourApproach> beside = neighbours_of(patient(), without_rib);
        EXPECT_FALSE(beside[0].approach) << "the other space has another rib";
        EXPECT_TRUE(beside[2].approach) << beside[2].refused;
    }

    TEST(NeighbourApproaches, WhereTheSpaceEndsThereIsNoneInThatDirection)
    {
        const Approach approach = from_template("intercostal:4", true, 180.0); // ends near the front end of the space
        const std::vector<NeighbourApproach> neighbours = neighbours_of(patient(), approach);
        ASSERT_EQ(neighbours.size(), 4U);
        EXPECT_FALSE(neighbours[2].approach);
        EXPECT_EQ(neighbours[2].refused, "the space leaves no room that way");
        EXPECT_TRUE(neighbours[3].approach) << neighbours[3].refused;
    }

} // namespace neighbour_approaches_test
} // namespace retractor::planner

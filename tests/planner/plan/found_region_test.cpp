#include "planner/plan/found_region.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace retractor::planner {
namespace found_region_test {

    using Status = RegionDraft::Status;

    constexpr double kWholeMm = 400.0;

    /// A wall in which motion falls as 20 mm exp(-d / decay), and a force that misses what lies beyond the region.
    struct Wall {
        double decay_mm = 30.0;
        double fits_mm = 1e4; ///< larger regions need more memory than there is
        double rim_factor = 1.0; ///< a free rim moves by this factor more than the same tissue in the whole wall
        std::vector<double> asked {};

        double motion_mm(double distance_mm) const { return 20.0 * std::exp(-distance_mm / decay_mm); }

        RegionDraft operator()(double region_mm)
        {
            asked.push_back(region_mm);
            if (region_mm > fits_mm)
                return { .status = Status::memory };
            const double end = std::min(region_mm, kWholeMm);
            return { .moving_mm = std::min(end, decay_mm * std::log(20.0)),
                .farthest_mm = end,
                .rim_motion_mm = region_mm < kWholeMm ? rim_factor * motion_mm(region_mm) : 0.0,
                .force_N = 100.0 * (1.0 - std::exp(-end / decay_mm)) };
        }
    };

    FoundRegion search(Wall& wall)
    {
        return find_region(kWholeMm, [&](double region_mm) { return wall(region_mm); });
    }

    TEST(FoundRegion, HoldsAllTissueThatMoves)
    {
        Wall wall;
        const FoundRegion found = search(wall);
        EXPECT_EQ(found.measures.ended_by, RegionEnd::still);
        EXPECT_EQ(found.measures.drafts, 2);
        EXPECT_LE(wall.motion_mm(found.region_mm), kStillRimMm);
        EXPECT_GT(wall.motion_mm(found.region_mm - 5.0), kStillRimMm); // no larger than needed, in steps of 5 mm
        const double exact = std::exp(-found.region_mm / wall.decay_mm) / (1.0 - std::exp(-kWholeMm / wall.decay_mm));
        ASSERT_TRUE(found.measures.force_change.has_value());
        EXPECT_NEAR(*found.measures.force_change, exact, 1e-4);
    }

    TEST(FoundRegion, GrowsWhileAFreeRimMovesTooFar)
    {
        Wall wall { .rim_factor = 2.0 };
        const FoundRegion found = search(wall);
        EXPECT_EQ(found.measures.ended_by, RegionEnd::still);
        EXPECT_EQ(found.measures.drafts, 3);
        EXPECT_LE(2.0 * wall.motion_mm(found.region_mm), kStillRimMm);
        EXPECT_LT(wall.asked[1], wall.asked[2]);
    }

    TEST(FoundRegion, IsTheFirstRegionWhereLittleMoves)
    {
        Wall wall { .decay_mm = 5.0 };
        EXPECT_EQ(search(wall).region_mm, kFirstRegionMm);
    }

    TEST(FoundRegion, IsTheWholeWallWhereAllOfItMoves)
    {
        Wall wall { .decay_mm = 300.0 };
        const FoundRegion found = search(wall);
        EXPECT_EQ(found.region_mm, kWholeMm);
        EXPECT_EQ(found.measures.ended_by, RegionEnd::whole);
        EXPECT_EQ(found.measures.drafts, 1);
        EXPECT_FALSE(found.measures.force_change.has_value());
    }

    TEST(FoundRegion, EndsWithTheMemoryAndStatesWhatTheWallBeyondChanges)
    {
        Wall wall { .decay_mm = 300.0, .fits_mm = 200.0 };
        const FoundRegion found = search(wall);
        EXPECT_EQ(found.measures.ended_by, RegionEnd::memory);
        EXPECT_NEAR(found.region_mm, kWholeMm / (kRegionGrowth * kRegionGrowth), 1e-9);
        ASSERT_TRUE(found.measures.force_change.has_value());
        EXPECT_GT(*found.measures.force_change, 0.1);
        Wall none { .fits_mm = 0.0 };
        const FoundRegion first = search(none);
        EXPECT_EQ(first.region_mm, kFirstRegionMm);
        EXPECT_EQ(first.measures.ended_by, RegionEnd::memory);
        FoundRegion smallest = first;
        EXPECT_FALSE(shrink_region(smallest));
    }

    TEST(FoundRegion, EndsWithADraftThatGivesNoAnswer)
    {
        const FoundRegion failed = find_region(kWholeMm,
            [](double) { return RegionDraft { .status = Status::failure, .message = "nothing holds the wall" }; });
        EXPECT_EQ(failed.region_mm, kFirstRegionMm);
        EXPECT_EQ(failed.measures.ended_by, RegionEnd::failure);
        EXPECT_EQ(failed.measures.message, "nothing holds the wall");
        EXPECT_FALSE(failed.cancelled);
        EXPECT_TRUE(
            find_region(kWholeMm, [](double) { return RegionDraft { .status = Status::cancelled }; }).cancelled);
    }

    TEST(RegionText, SaysHowFarTheRimMovesAndWhichBonesComeOut)
    {
        FieldMetrics field;
        field.region = { .region_mm = 50.0,
            .ended_by = RegionEnd::given,
            .rim_motion_mm = 33.4,
            .rim_place = "left rib 6, 90 mm from the incision towards the back",
            .force_change = 0.034 };
        EXPECT_EQ(region_text(field),
            "The model holds the wall within 50 mm of the incision (given). Where it ends, tissue moves by up to 33 mm "
            "(left rib 6, 90 mm from the incision towards the back). By drafts, the wall beyond changes the force by "
            "3.4 %.");
        EXPECT_TRUE(is_region_too_small(field));
        EXPECT_TRUE(piercing_text(field).empty());
        field.region.force_change = 7.14;
        EXPECT_NE(region_text(field).find("changes the force more than twofold."), std::string::npos);
        field.region.force_change.reset();
        EXPECT_NE(
            region_text(field).find("No bar contains the force that the wall beyond would add"), std::string::npos);
        field.region.piercing = { { .name = "rib_left_6", .out_mm = 32.6 } };
        EXPECT_NE(piercing_text(field).find("rib 6 on the left by 33 mm"), std::string::npos) << piercing_text(field);
        field.region = { .region_mm = 120.0, .ended_by = RegionEnd::still, .rim_motion_mm = 0.7, .rim_place = "fat" };
        EXPECT_FALSE(is_region_too_small(field));
        EXPECT_EQ(region_text(field).find("No bar contains"), std::string::npos);
        field.region = { .region_mm = 400.0, .ended_by = RegionEnd::whole, .image_end_motion_mm = 2.3 };
        EXPECT_EQ(region_text(field),
            "The model holds the whole wall in the image. Where the image ends, tissue moves by up to 2.3 mm: what "
            "holds it beyond the image is not known.");
    }

} // namespace found_region_test
} // namespace retractor::planner

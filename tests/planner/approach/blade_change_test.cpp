#include "planner/approach/blade_change.h"

#include "datasets/phantoms/phantom.h"
#include "mesh/base/error.h"
#include "planner/approach/approach_draft.h"
#include "planner/approach/blade_sweep.h"
#include "tests/support/block_case.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <numbers>

namespace retractor::planner {
namespace blade_change_test {

    constexpr double kRoundOff = 1e-9;

    Patient& patient()
    {
        static Patient made(
            test_support::block_case("blade", datasets::make_block_phantom(test_support::small_block())));
        return made;
    }

    Approach drawn()
    {
        return approach_from_draft(patient(), patient().planned_case(),
            { .points = { { -22.0, 0.0, 0.0 }, { 24.0, 0.0, 0.0 } },
                .target = "target",
                .opened_by = { .hooks = "2", .opening_mm = 18.0 } });
    }

    Vec3 middle_direction(const Approach& approach)
    {
        return incision_place(approach, 0.5 * incision_length(approach)).of(approach.directions).normalized();
    }

    TEST(WithBlade, TurnsTheWholeBladeAndKeepsTheRest)
    {
        const Approach before = drawn();
        constexpr double kTurnDeg = 20.0;
        const double turn = kTurnDeg * std::numbers::pi / 180.0;
        const Vec3 inward = Eigen::AngleAxisd(turn, Vec3::UnitX()) * middle_direction(before);
        const Approach after = with_blade(patient(), before, 12.0, inward);
        EXPECT_EQ(after.depth_mm, 12.0);
        EXPECT_NEAR((middle_direction(after) - inward).norm(), 0.0, kRoundOff);
        EXPECT_EQ(after.incision, before.incision);
        EXPECT_EQ(after.target.label, before.target.label);
        ASSERT_EQ(after.hooks.size(), before.hooks.size());
        EXPECT_EQ(after.hooks[0].opening_mm, before.hooks[0].opening_mm);
        for (std::size_t n = 0; n < before.directions.size(); ++n)
            EXPECT_NEAR(before.directions[n].dot(after.directions[n]), std::cos(turn), 1e-6) << n;
        for (const double wall : after.wall_thickness_mm)
            EXPECT_LE(wall, 12.0);
        EXPECT_NE(after.rationale.find("Blade set by hand: 12 mm deep."), std::string::npos) << after.rationale;
        const Approach again = with_blade(patient(), after, 15.0, inward);
        EXPECT_EQ(again.rationale.find("12 mm deep"), std::string::npos) << "the last change is told";
    }

    TEST(WithBlade, RefusesWhatNoBladeDoes)
    {
        const Approach approach = drawn();
        const Vec3 inward = middle_direction(approach);
        for (const double depth : { 0.0, 4.9, 251.0, std::nan("") })
            EXPECT_THROW(static_cast<void>(with_blade(patient(), approach, depth, inward)), InputError) << depth;
        EXPECT_THROW(static_cast<void>(with_blade(patient(), approach, 12.0, Vec3::Zero())), InputError);
        EXPECT_THROW(static_cast<void>(with_blade(patient(), approach, 12.0, -inward)), InputError);
        EXPECT_THROW(
            static_cast<void>(with_blade(patient(), approach, 12.0, inward + 2.0 * Vec3::UnitZ())), InputError);
        // The tilt counts from the skin, not from the blade before.
        const auto tilted = [&](double deg) {
            return Vec3(Eigen::AngleAxisd(deg * std::numbers::pi / 180.0, Vec3::UnitX()) * inward);
        };
        const Approach once = with_blade(patient(), approach, 12.0, tilted(40.0));
        EXPECT_THROW(static_cast<void>(with_blade(patient(), once, 12.0, tilted(80.0))), InputError);
    }

    TEST(CheckSweep, NamesThePlaceWhereTheBladeFolds)
    {
        Approach approach = drawn();
        EXPECT_FALSE(fold_of(approach));
        approach.depth_mm = 40.0; // the directions meet 20 mm below
        const double step = (approach.incision[1] - approach.incision[0]).norm();
        approach.directions[1] = (approach.directions[0] - step / 20.0 * Vec3::UnitX()).normalized();
        ASSERT_TRUE(fold_of(approach));
        EXPECT_NEAR((*fold_of(approach) - approach.incision[0]).norm(), 0.0, kRoundOff);
        EXPECT_THROW(check_sweep(approach), InputError);
    }

} // namespace blade_change_test
} // namespace retractor::planner

#include "planner/search/held_open.h"

#include "planner/approach/hook_mesh.h"
#include "planner/approach/retractors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace retractor::planner {
namespace held_open_test {

    TEST(HeldOpen, AnotherRetractorIsOneThatFits)
    {
        SearchRequest request;
        FoundIncision small, broad, sternum;
        small.length_mm = 80.0;
        broad.length_mm = 140.0;
        sternum.length_mm = 200.0;
        small.kind = broad.kind = FoundIncision::Kind::space;
        sternum.kind = FoundIncision::Kind::sternum;
        for (FoundIncision* incision : { &small, &broad, &sternum })
            incision->opening_mm = 40.0;
        EXPECT_EQ(other_retractor(small, request), "finochietto");
        EXPECT_EQ(other_retractor(broad, request), "midcab");
        EXPECT_EQ(other_retractor(sternum, request), "finochietto");
        broad.opening_mm = 100.0; // wider than the small one goes
        EXPECT_EQ(other_retractor(broad, request), "");
        small.length_mm = 45.0; // shorter than its blades
        EXPECT_EQ(other_retractor(small, request), "");
        request.retractor = "sternal"; // who names one gets that one
        EXPECT_EQ(other_retractor(sternum, request), "");
    }

    TEST(HeldOpen, BladesThatTurnNarrowTheHoleBelowTheSkin)
    {
        SearchRequest request;
        FoundIncision incision;
        incision.kind = FoundIncision::Kind::space;
        incision.length_mm = 140.0;
        incision.opening_mm = 40.0;
        constexpr double kWallMm = 35.0;
        const ApertureWidth width = hole_width(incision, kWallMm, request);
        const RetractorKind& rib_spreader = find_retractor(built_in_retractors(), "finochietto");
        EXPECT_NEAR(width.skin_mm, 40.0 - 2.0 * kBladeThicknessMm, 1e-9);
        EXPECT_NEAR(width.inner_mm,
            width.skin_mm - 2.0 * kWallMm * std::tan(rib_spreader.play_deg * std::numbers::pi / 180.0), 1e-9);
        EXPECT_LT(hole_width(incision, 300.0, request).inner_mm, 0.0) << "so deep a wound is closed";
        incision.kind = FoundIncision::Kind::sternum; // its blades hardly turn
        EXPECT_GT(hole_width(incision, kWallMm, request).inner_mm, width.inner_mm);
        request.retractor = "finochietto"; // who names one gets that one
        EXPECT_EQ(hole_width(incision, kWallMm, request).inner_mm, width.inner_mm);
        incision.opening_mm = 2.0; // less than the steel
        EXPECT_GT(hole_width(incision, kWallMm, request).skin_mm, 0.0);
        request.retractor.clear();
        request.hooks = "2"; // hooks do not turn
        incision.opening_mm = 40.0;
        EXPECT_EQ(hole_width(incision, kWallMm, request).inner_mm, 40.0);
    }

} // namespace held_open_test
} // namespace retractor::planner

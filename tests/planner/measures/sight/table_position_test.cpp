#include "planner/measures/sight/table_position.h"

#include <gtest/gtest.h>

#include <vector>

namespace retractor::planner {
namespace table_position_test {

    constexpr double kRoundOff = 1e-9;

    /// LPS: x to the left, y to the back, z to the head.
    AnatomicalFrame frame()
    {
        return { .origin = Vec3::Zero(), .superior = Vec3::UnitZ(), .anterior = -Vec3::UnitY(), .left = Vec3::UnitX() };
    }

    TEST(TablePosition, TheSideThatIsUpIsUpAndOrgansSinkAwayFromIt)
    {
        const TablePosition supine = table_position(frame(), 0.0);
        EXPECT_NEAR((supine.up + Vec3::UnitY()).norm(), 0.0, kRoundOff);
        EXPECT_NEAR(supine.sink.norm(), 0.0, kRoundOff) << "as in the CT";
        const TablePosition on_right = table_position(frame(), 90.0);
        EXPECT_NEAR((on_right.up - Vec3::UnitX()).norm(), 0.0, kRoundOff) << "the left side is up";
        EXPECT_NEAR((on_right.sink - kSinkMmPerGravity * Vec3(-1.0, -1.0, 0.0)).norm(), 0.0, kRoundOff)
            << "to the right, and off the back";
        const TablePosition right_up = table_position(frame(), -30.0);
        EXPECT_LT(right_up.up.x(), 0.0);
        EXPECT_GT(right_up.sink.x(), 0.0) << "to the left";
        EXPECT_NEAR(right_up.up.norm(), 1.0, kRoundOff);
        EXPECT_NEAR(table_position(frame(), 180.0).sink.norm(), 19.0, kRoundOff) << "prone, as measured";
    }

    TEST(TablePosition, TheSideOfTheOpeningIsTurnedUp)
    {
        const auto turns = [](const Vec3& outward) {
            std::vector<double> degrees;
            for (const TablePosition& position : positions_for(outward, frame()))
                degrees.push_back(position.left_side_up_deg);
            return degrees;
        };
        EXPECT_EQ(turns(Vec3(2.0, -1.0, 0.0)), (std::vector<double> { 0.0, 15.0, 30.0, 90.0 }));
        EXPECT_EQ(turns(Vec3(-1.0, -1.0, 0.0)), (std::vector<double> { 0.0, -15.0, -30.0, -90.0 }));
        EXPECT_EQ(turns(Vec3(1e-9, -1.0, 0.2)), (std::vector<double> { 0.0 })) << "an opening in front has no side";
        EXPECT_TRUE(turns(Vec3(0.5, 1.0, 0.0)).empty()) << "an opening on the back";
    }

    TEST(TablePosition, IsSaidInWords)
    {
        EXPECT_EQ(position_words(0.0), "supine");
        EXPECT_EQ(position_words(30.0), "with the left side up by 30 degrees");
        EXPECT_EQ(position_words(-15.0), "with the right side up by 15 degrees");
        EXPECT_EQ(position_words(90.0), "lying on the right side");
        EXPECT_EQ(position_words(-90.0), "lying on the left side");
    }

} // namespace table_position_test
} // namespace retractor::planner

#include "mesh/base/corridor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace retractor {
namespace corridor_test {

    constexpr double kRoundOff = 1e-12; // of distances of some 100 mm, relative to them

    TEST(PolylineDistance, IsTheClosedForm)
    {
        const std::vector<Vec3> line { { 0, 0, 0 }, { 10, 0, 0 }, { 10, 20, 0 } };
        EXPECT_NEAR(polyline_distance(line, { 5, 0, 3 }), 3.0, kRoundOff);
        EXPECT_NEAR(polyline_distance(line, { -3, 0, 4 }), 5.0, kRoundOff);
        EXPECT_NEAR(polyline_distance(line, { 22, 25, 0 }), 13.0, kRoundOff);
        EXPECT_NEAR(polyline_distance(std::vector<Vec3> { { 1, 2, 3 } }, { 1, 2, 5 }), 2.0, kRoundOff);
        EXPECT_EQ(polyline_distance({}, { 1, 2, 3 }), std::numeric_limits<double>::infinity());
    }

    TEST(CorridorDistance, AnswersAsTheSearchDoesInsideTheBoxAndOutside)
    {
        std::mt19937 random(7);
        std::uniform_real_distribution<double> place(-20.0, 120.0);
        std::vector<Vec3> line;
        for (int n = 0; n < 30; ++n)
            line.push_back({ 30 + 40 * std::cos(0.1 * n), 50 + 40 * std::sin(0.1 * n), 2.0 * n });
        const CorridorDistance near(line, Vec3::Zero(), Vec3(100, 90, 70));
        int inside = 0;
        for (int n = 0; n < 20000; ++n) {
            const Vec3 p(place(random), place(random), place(random));
            for (const double radius : { 3.0, 25.0, 50.0 }) {
                const bool within = polyline_distance(line, p) <= radius;
                ASSERT_EQ(near.within(p, radius), within) << p.transpose() << " " << radius;
                inside += within ? 1 : 0;
            }
            ASSERT_EQ(near.distance(p), polyline_distance(line, p)) << p.transpose();
            ASSERT_EQ(near.share(25.0, p, { 1, 2, 3 }, 3), share_within(line, 25.0, p, { 1, 2, 3 }, 3));
        }
        EXPECT_GT(inside, 1000); // both answers occur
        EXPECT_LT(inside, 59000);
        // On the border itself.
        EXPECT_TRUE(
            CorridorDistance({ { 0, 0, 0 }, { 9, 0, 0 } }, Vec3::Zero(), Vec3(9, 9, 9)).within({ 4, 3, 0 }, 3.0));
    }

    TEST(CorridorDistance, WithoutAPointEverythingIsFar)
    {
        const CorridorDistance near({}, Vec3::Zero(), Vec3(10, 10, 10));
        EXPECT_FALSE(near.within({ 1, 1, 1 }, 1e9));
        EXPECT_EQ(near.share(10.0, { 1, 1, 1 }, { 1, 1, 1 }, 3), 0.0);
        EXPECT_EQ(near.distance({ 1, 1, 1 }), std::numeric_limits<double>::infinity());
        const CorridorDistance of_a_point({ { 1, 2, 3 } }, Vec3::Zero(), Vec3(10, 10, 10));
        EXPECT_EQ(of_a_point.distance({ 1, 2, 5 }), 2.0);
    }

} // namespace corridor_test
} // namespace retractor

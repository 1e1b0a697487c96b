#include "planner/approach/smooth_line.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>

namespace retractor::planner {
namespace smooth_line_test {

    constexpr double kRoundOff = 1e-12;

    TEST(SmoothLine, AStraightLineStaysAsItIs)
    {
        std::vector<Vec3> line;
        for (int n = 0; n < 20; ++n)
            line.emplace_back(2.0 * n, -n, 5.0);
        const std::vector<Vec3> smooth = smoothed(line, 4.0);
        ASSERT_EQ(smooth.size(), line.size());
        for (std::size_t n = 0; n < line.size(); ++n)
            EXPECT_NEAR((smooth[n] - line[n]).norm(), 0.0, kRoundOff * 40.0);
        for (const Vec3& tangent : tangents(line))
            EXPECT_NEAR((tangent - Vec3(2, -1, 0).normalized()).norm(), 0.0, kRoundOff);
    }

    TEST(SmoothLine, AZigzagIsFlattened)
    {
        std::vector<Vec3> line;
        for (int n = 0; n < 40; ++n)
            line.emplace_back(n, n % 2 == 0 ? 1.0 : -1.0, 0.0);
        // A Gaussian of two nodes takes exp(-(pi * 2)^2 / 2) = 3e-9 of the shortest wave.
        EXPECT_NEAR(smoothed(line, 2.0)[20].y(), 0.0, 1e-3);
    }

} // namespace smooth_line_test
} // namespace retractor::planner

#include "haptics/surroundings/distance_grid.h"

#include "mesh/base/error.h"
#include "tests/support/test_help.h"

#include <gtest/gtest.h>

#include <cmath>

namespace retractor::haptics {
namespace distance_grid_test {

    constexpr double kStep = 1.0, kFarthest = 12.0;

    /// A square in the plane z, of this half side.
    mesh::NamedSurface square(const std::string& name, double z, double half)
    {
        mesh::NamedSurface surface { .name = name, .surface = {} };
        surface.surface.vertices.resize(4, 3);
        surface.surface.vertices << -half, -half, z, half, -half, z, half, half, z, -half, half, z;
        surface.surface.triangles = { { 0, 1, 2 }, { 0, 2, 3 } };
        return surface;
    }

    /// Distance from a square in the plane z.
    double exact(const Vec3& p, double z, double half)
    {
        const double dx = std::max(std::abs(p.x()) - half, 0.0), dy = std::max(std::abs(p.y()) - half, 0.0);
        return std::hypot(dx, dy, p.z() - z);
    }

    const Eigen::AlignedBox3d kBox { Vec3::Constant(-30.0), Vec3::Constant(30.0) };

    TEST(DistanceGrid, IsTheDistanceFromASquare)
    {
        const DistanceGrid grid({ square("plate", 2.3, 10.0) }, kBox, kStep, kFarthest);
        for (double x = -24.0; x <= 24.0; x += 1.7)
            for (double y = -24.0; y <= 24.0; y += 2.3)
                for (double z = -20.0; z <= 24.0; z += 1.3) {
                    const Vec3 p(x, y, z);
                    const double expected = std::min(exact(p, 2.3, 10.0), kFarthest);
                    ASSERT_NEAR(grid.distance(p), expected, 0.5 * kStep) << p.transpose();
                    // Away from the kink at the surface and from the largest distance the error is of second order.
                    if (expected > 3.0 * kStep && expected < kFarthest - 2.0 * kStep) {
                        ASSERT_NEAR(grid.distance(p), expected, kStep * kStep / (8.0 * expected) * 3.0)
                            << p.transpose();
                    }
                }
        EXPECT_GT(grid.away(Vec3(0.0, 0.0, 6.0)).z(), 0.99);
        EXPECT_LT(grid.away(Vec3(0.0, 0.0, -2.0)).z(), -0.99);
    }

    TEST(DistanceGrid, NamesTheNearestSurface)
    {
        const DistanceGrid grid({ square("low", -8.0, 20.0), square("high", 8.0, 20.0) }, kBox, kStep, kFarthest);
        EXPECT_EQ(grid.names()[static_cast<std::size_t>(grid.nearest(Vec3(3.0, 0.0, -2.0)))], "low");
        EXPECT_EQ(grid.names()[static_cast<std::size_t>(grid.nearest(Vec3(3.0, 0.0, 2.0)))], "high");
        EXPECT_EQ(grid.nearest(Vec3(0.0, 0.0, 28.0)), DistanceGrid::kNone);
        EXPECT_EQ(grid.nearest(Vec3(0.0, 0.0, 280.0)), DistanceGrid::kNone);
        EXPECT_EQ(grid.distance(Vec3(0.0, 0.0, 280.0)), kFarthest);
    }

    TEST(DistanceGrid, RefusesWhatHasNoExtentOrVertex)
    {
        EXPECT_THROW(DistanceGrid({}, kBox, 0.0, kFarthest), InputError);
        EXPECT_THROW(DistanceGrid({}, Eigen::AlignedBox3d(Vec3::Zero(), Vec3::Zero()), kStep, kFarthest), InputError);
        mesh::NamedSurface torn = square("plate", 0.0, 5.0);
        torn.surface.triangles.push_back({ 0, 1, 9 });
        EXPECT_THROW(DistanceGrid({ torn }, kBox, kStep, kFarthest), InputError);
        EXPECT_EQ(DistanceGrid({}, kBox, kStep, kFarthest).distance(Vec3::Zero()), kFarthest) << "nothing is round it";
    }

} // namespace distance_grid_test
} // namespace retractor::haptics

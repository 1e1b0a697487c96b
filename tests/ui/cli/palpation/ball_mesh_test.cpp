#include "ui/cli/framework/ball_mesh.h"

#include "haptics/spheres/surface_locator.h"

#include <gtest/gtest.h>

#include <numbers>

using namespace retractor;
using namespace retractor::ui;
using retractor::ui::cli::ball_mesh;

TEST(BallMesh, isClosedAndNearlyRound)
{
    const TriMesh ball = ui::cli::ball_mesh(Vec3(1.0, 2.0, 3.0), 5.0, 3);
    EXPECT_EQ(ball.triangles.size(), 20U * 64U);
    EXPECT_NO_THROW(haptics::SurfaceLocator { ball });
    const double volume = 4.0 / 3.0 * std::numbers::pi * 125.0;
    EXPECT_NEAR(haptics::enclosed_volume(ball.vertices, ball.triangles), volume, 0.02 * volume); // facets lie inside
}

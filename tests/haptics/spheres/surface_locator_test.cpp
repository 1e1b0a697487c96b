#include "haptics/spheres/surface_locator.h"

#include "tests/support/test_help.h"
#include "tests/support/test_shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

using namespace retractor;
using namespace retractor::haptics;
using retractor::test_support::ball_surface;
using retractor::test_support::box_surface;

TEST(SurfaceLocator, knowsInsideFromOutsideOfABox)
{
    const Vec3 low(-3.0, 1.0, 2.0), high(5.0, 4.0, 9.0);
    const SurfaceLocator box(test_support::box_surface(low, high));
    std::mt19937 random(1);
    std::uniform_real_distribution<double> unit(-0.3, 1.3);
    for (int i = 0; i < 2000; ++i) {
        const Vec3 p = low + Vec3(unit(random), unit(random), unit(random)).cwiseProduct(high - low);
        const bool right = (p.array() > low.array()).all() && (p.array() < high.array()).all();
        EXPECT_EQ(box.inside(p), right) << p.transpose();
    }
    // Under an edge and a vertex of the triangulation, where a plain ray would go wrong.
    EXPECT_TRUE(box.inside(0.5 * (low + high)));
    EXPECT_FALSE(box.inside(Vec3(1.0, 2.5, 1.0)));
}

TEST(SurfaceLocator, nearnessIsTheDistance)
{
    const SurfaceLocator ball(test_support::ball_surface(Vec3(1.0, 2.0, 3.0), 10.0, 40));
    for (const double radius : { 0.0, 4.0, 8.0, 13.0 }) {
        const Vec3 p = Vec3(1.0, 2.0, 3.0) + radius * Vec3(0.6, 0.0, 0.8);
        const double distance = std::abs(10.0 - radius);
        EXPECT_TRUE(ball.is_near(p, distance + 0.05)); // the facets lie up to 0.03 inside the ball
        EXPECT_FALSE(ball.is_near(p, distance - 0.05));
    }
}

TEST(NearestOnTriangle, ofFaceEdgeAndCorner)
{
    const Vec3 a(0.0, 0.0, 0.0), b(4.0, 0.0, 0.0), c(0.0, 4.0, 0.0);
    const auto weights = [&](const Vec3& p) { return nearest_on_triangle(p, a, b, c).weights; };
    EXPECT_TRUE(weights(Vec3(1.0, 1.0, 5.0)).isApprox(Vec3(0.5, 0.25, 0.25)));
    EXPECT_TRUE(weights(Vec3(2.0, -3.0, 1.0)).isApprox(Vec3(0.5, 0.5, 0.0)));
    EXPECT_TRUE(weights(Vec3(5.0, 5.0, 0.0)).isApprox(Vec3(0.0, 0.5, 0.5)));
    EXPECT_TRUE(weights(Vec3(-1.0, -1.0, 0.0)).isApprox(Vec3(1.0, 0.0, 0.0)));
    EXPECT_NEAR(nearest_on_triangle(Vec3(1.0, 1.0, 5.0), a, b, c).distance, 5.0, 1e-12);
}

TEST(EnclosedVolume, ofABox)
{
    const TriMesh box = test_support::box_surface(Vec3(-1.0, 2.0, 3.0), Vec3(2.0, 4.0, 8.0));
    EXPECT_NEAR(enclosed_volume(box.vertices, box.triangles), 30.0, 1e-12);
}

TEST(SurfaceLocator, refusesWhatHasNoInside)
{
    TriMesh open = test_support::box_surface(Vec3::Zero(), Vec3::Ones());
    open.triangles.pop_back();
    EXPECT_NE(test_support::message_of([&] {
        SurfaceLocator { open };
    }).find("the surface is not closed: nothing lies beyond the edge"),
        std::string::npos);
    TriMesh twice = test_support::box_surface(Vec3::Zero(), Vec3::Ones());
    twice.triangles.push_back(twice.triangles.front());
    EXPECT_NE(test_support::message_of([&] { SurfaceLocator { twice }; }).find("two triangles lie on one side"),
        std::string::npos);
    EXPECT_EQ(test_support::message_of([] { SurfaceLocator { TriMesh {} }; }), "the surface has no triangles");
}

#include "haptics/spheres/sphere_filling.h"

#include "haptics/spheres/surface_locator.h"
#include "tests/support/test_help.h"
#include "tests/support/test_shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

using namespace retractor;
using namespace retractor::haptics;
using retractor::test_support::ball_surface;
using retractor::test_support::box_surface;

TEST(SphereFilling, isAFaceCentredLattice)
{
    const SphereFilling filling = fill_with_spheres(test_support::ball_surface(Vec3::Zero(), 30.0, 30), 2.0);
    std::size_t full = 0;
    for (std::size_t i = 0; i < filling.count(); ++i) {
        full += filling.of(i).size() == 12 ? 1 : 0;
        for (const std::int32_t j : filling.of(i))
            EXPECT_NEAR((filling.centres.row(static_cast<Eigen::Index>(i)) - filling.centres.row(j)).norm(), 4.0, 1e-9);
    }
    EXPECT_GT(full, filling.count() / 2);
    // No two overlap: neighbours touch, and all others are farther apart.
    for (Eigen::Index i = 0; i < filling.centres.rows(); i += 17)
        for (Eigen::Index j = 0; j < filling.centres.rows(); ++j)
            if (i != j) {
                EXPECT_GT((filling.centres.row(i) - filling.centres.row(j)).norm(), 4.0 - 1e-9);
            }
}

TEST(SphereFilling, staysInsideTheSurface)
{
    const SphereFilling filling = fill_with_spheres(test_support::ball_surface(Vec3(5.0, 0.0, -3.0), 30.0, 60), 1.5);
    const double farthest
        = (filling.centres.rowwise() - Eigen::RowVector3d(5.0, 0.0, -3.0)).rowwise().norm().maxCoeff();
    EXPECT_LT(farthest + 1.5, 30.0 + 1e-9);
}

TEST(SphereFilling, fillsTheDensityOfItsLattice)
{
    const SphereFilling filling
        = fill_with_spheres(test_support::box_surface(Vec3::Zero(), Vec3(60.0, 60.0, 60.0)), 1.0);
    const double density = static_cast<double>(filling.count()) * 4.0 / 3.0 * std::numbers::pi / (60.0 * 60.0 * 60.0);
    // pi / (3 sqrt 2), less the layer at the rim: centres lie in a box 2 mm smaller.
    EXPECT_NEAR(density, std::numbers::pi / (3.0 * std::numbers::sqrt2) * std::pow(58.0 / 60.0, 3.0), 0.02);
}

TEST(SphereFilling, reachesTheWantedCount)
{
    const TriMesh organ = test_support::ball_surface(Vec3::Zero(), 50.0, 24);
    for (const std::size_t wanted : { 200U, 1880U, 20000U })
        EXPECT_NEAR(static_cast<double>(fill_with_count(organ, wanted).count()), static_cast<double>(wanted),
            0.01 * static_cast<double>(wanted));
}

TEST(SphereFilling, refusesWhatDoesNotFit)
{
    const TriMesh box = test_support::box_surface(Vec3::Zero(), Vec3::Ones());
    EXPECT_EQ(test_support::message_of([&] { fill_with_spheres(box, 0.6); }),
        "no sphere of radius 0.600000 mm fits into the surface");
    EXPECT_EQ(test_support::message_of([&] { fill_with_spheres(box, -1.0); }),
        "the spheres' radius must be positive, got -1.000000");
    EXPECT_NE(test_support::message_of([&] { fill_with_spheres(box, 1e-4); }).find("too small"), std::string::npos);
    EXPECT_EQ(test_support::message_of([&] { fill_with_count(box, 0); }),
        "an organ is filled with 1 to a million spheres, got 0");
    TriMesh inwards = box;
    for (auto& triangle : inwards.triangles)
        std::swap(triangle[0], triangle[1]);
    EXPECT_EQ(test_support::message_of([&] { fill_with_count(inwards, 100); }),
        "the surface encloses no volume, or is oriented inwards");
}

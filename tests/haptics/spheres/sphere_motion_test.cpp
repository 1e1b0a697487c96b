#include "haptics/spheres/sphere_motion.h"

#include "haptics/condensed/sneddon.h"
#include "tests/support/allocation_count.h"
#include "tests/support/haptics/organ_volumes.h"
#include "tests/support/test_help.h"
#include "tests/support/test_shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

using namespace retractor;
using namespace retractor::haptics;
using retractor::test_support::ball_surface;

namespace sphere_motion_test {

constexpr double kOrgan = 40.0, kTip = 8.0, kFrame = 1.0 / 60.0;

SphereOrgan ball_organ(const Vec3& centre = Vec3::Zero(), double radius = 2.5)
{
    const TriMesh surface = test_support::ball_surface(centre, kOrgan, 24);
    return { "ball", surface, fill_with_spheres(surface, radius), 0.02 };
}

struct Press {
    SphereMotion motion;
    std::vector<Fingertip> tips;
    std::vector<SphereContact> contacts;

    explicit Press(const SphereLaw& law = {})
        : motion({ ball_organ() }, law)
        , tips(law.fingers, { Vec3(0.0, 0.0, 100.0), Vec3::Zero(), kTip })
        , contacts(law.fingers)
    {
    }
    void frames(int count)
    {
        for (int i = 0; i < count; ++i)
            motion.advance(kFrame, tips, contacts);
    }
    /// Finger 0 pressed in from the top.
    void press(double depth, int count = 20)
    {
        tips[0].position = Vec3(0.0, 0.0, kOrgan + kTip - depth);
        frames(count);
    }
};

TEST(SphereMotion, untouchedNothingMoves)
{
    Press press;
    press.frames(5);
    EXPECT_EQ(press.motion.positions(), press.motion.rest());
    EXPECT_FALSE(press.contacts[0].touching);
    Points deformed;
    press.motion.deform(deformed);
    EXPECT_EQ(deformed, press.motion.surface().vertices);
}

TEST(SphereMotion, noSphereStaysInsideTheFinger)
{
    Press press;
    press.press(10.0);
    for (Eigen::Index i = 0; i < press.motion.positions().rows(); ++i)
        if (press.motion.layer(static_cast<std::size_t>(i)) == 0) {
            EXPECT_NEAR((press.motion.positions().row(i).transpose() - press.tips[0].position).norm(),
                kTip + press.motion.reach_of(static_cast<std::size_t>(i)), 1e-9);
        }
}

TEST(SphereMotion, depthLimitEndsTheMotion)
{
    for (const int limit : { 1, 3, 6 }) {
        Press press({ .depth_limit = limit });
        press.press(10.0);
        int deepest = 0;
        for (std::size_t i = 0; i < press.motion.sphere_count(); ++i) {
            deepest = std::max(deepest, press.motion.layer(i));
            if (press.motion.layer(i) < 0) {
                EXPECT_EQ(press.motion.positions().row(static_cast<Eigen::Index>(i)),
                    press.motion.rest().row(static_cast<Eigen::Index>(i)));
            }
        }
        EXPECT_EQ(deepest, limit);
    }
}

TEST(SphereMotion, displacementFadesFromLayerToLayer)
{
    Press press({ .depth_limit = 6 });
    press.press(8.0);
    std::map<int, std::pair<double, int>> sums;
    for (std::size_t i = 0; i < press.motion.sphere_count(); ++i) {
        auto& [sum, count] = sums[press.motion.layer(i)];
        const auto row = static_cast<Eigen::Index>(i);
        sum += (press.motion.positions().row(row) - press.motion.rest().row(row)).norm();
        ++count;
    }
    for (int layer = 1; layer <= 6; ++layer)
        EXPECT_LT(sums[layer].first / sums[layer].second, sums[layer - 1].first / sums[layer - 1].second) << layer;
}

TEST(SphereMotion, forceOpposesThePressAndGrowsWithIt)
{
    Press press;
    double last = 0.0;
    for (const double depth : { 3.0, 6.0, 9.0, 12.0 }) {
        press.press(depth);
        const Vec3 force = press.contacts[0].force;
        EXPECT_GT(force.z(), last);
        EXPECT_LT(force.head<2>().norm(), 0.1 * force.z());
        last = force.z();
    }
}

TEST(SphereMotion, forceIsTheSumOfTheDisplacements)
{
    Press press;
    press.press(8.0);
    Vec3 sum = Vec3::Zero();
    std::size_t moved = 0;
    for (std::size_t i = 0; i < press.motion.sphere_count(); ++i)
        if (press.motion.layer(i) >= 0) {
            const auto row = static_cast<Eigen::Index>(i);
            sum += (press.motion.positions().row(row) - press.motion.rest().row(row)).transpose();
            ++moved;
        }
    EXPECT_EQ(press.contacts[0].spheres, moved);
    EXPECT_LT((press.contacts[0].force + 0.02 * sum).norm(), 1e-12);
}

TEST(SphereMotion, releasedTheOrganRecovers)
{
    Press press;
    press.press(10.0);
    press.tips[0].position = Vec3(0.0, 0.0, 100.0);
    press.frames(60 * 3); // twenty recovery times
    EXPECT_EQ(press.motion.positions(), press.motion.rest());
    EXPECT_EQ(test_support::organ_volumes(press.motion)[0].error(), 0.0);
}

TEST(SphereMotion, volumeErrorOfAPressIsSmallAndStated)
{
    Press press;
    press.press(8.0);
    const auto volume = test_support::organ_volumes(press.motion)[0];
    EXPECT_LT(std::abs(volume.error()), 0.05);
    EXPECT_NE(volume.error(), 0.0); // it is measured, not imposed
    EXPECT_EQ(press.motion.sphere_count(), ball_organ().filling.count());
}

TEST(SphereMotion, mirroredFingersFeelMirroredForces)
{
    Press press({ .fingers = 2 });
    press.tips[0].position = Vec3(0.0, 0.0, kOrgan + kTip - 6.0);
    press.tips[1].position = Vec3(0.0, 0.0, -kOrgan - kTip + 6.0);
    press.frames(20);
    EXPECT_NEAR(press.contacts[0].force.z(), -press.contacts[1].force.z(), 1e-9);
}

TEST(SphereMotion, organsPushEachOtherWithoutMoreAdo)
{
    // A slab on another: the lower one is pressed by nobody but the upper one, and both feel one finger.
    const auto slab = [](double low, double high) {
        const TriMesh surface = retractor::test_support::box_surface(Vec3(-40.0, -40.0, low), Vec3(40.0, 40.0, high));
        return SphereOrgan { "slab", surface, fill_with_spheres(surface, 2.5), 0.02 };
    };
    const auto lower_moves = [&](double gap) {
        SphereMotion motion({ slab(0.0, 12.0), slab(-15.0 - gap, -gap) }, {});
        Fingertip tip { Vec3(0.0, 0.0, 12.0 + kTip - 6.0), Vec3::Zero(), kTip };
        SphereContact contact;
        for (int i = 0; i < 30; ++i)
            motion.advance(kFrame, { &tip, 1 }, { &contact, 1 });
        double moved = 0.0;
        for (std::size_t i = 0; i < motion.sphere_count(); ++i)
            if (motion.organ_of(i) == 1)
                moved = std::max(moved, (motion.rest() - motion.positions())(static_cast<Eigen::Index>(i), 2));
        return moved;
    };
    EXPECT_GT(lower_moves(0.0), 0.5);
    EXPECT_EQ(lower_moves(10.0), 0.0);
}

TEST(SphereMotion, pinchMakesAVertexAtTheExactPoint)
{
    Press press;
    const auto vertices = press.motion.surface().vertices.rows();
    const auto triangles = press.motion.surface().triangles.size();
    const Vec3 direction = Vec3(0.3, 0.2, 0.9).normalized();
    press.tips[0].position = (kOrgan + kTip) * direction;
    press.frames(1);
    const VertexId vertex = press.motion.pinch(0, press.tips[0]);
    EXPECT_EQ(press.motion.surface().vertices.rows(), vertices + 1);
    EXPECT_EQ(press.motion.surface().triangles.size(), triangles + 2);
    EXPECT_NEAR((press.motion.surface().vertices.row(vertex).transpose() - kOrgan * direction).norm(), 0.0,
        0.5); // facets lie up to 0.43 inside the ball
    EXPECT_NEAR(enclosed_volume(press.motion.surface().vertices, press.motion.surface().triangles),
        enclosed_volume(ball_organ().surface.vertices, ball_organ().surface.triangles), 1e-6);
    // It goes where the finger goes, exactly.
    Points before, after;
    press.motion.deform(before);
    press.tips[0].position += Vec3(0.0, 0.0, 12.0);
    press.frames(10);
    press.motion.deform(after);
    EXPECT_LT((after.row(vertex) - before.row(vertex) - Eigen::RowVector3d(0.0, 0.0, 12.0)).norm(), 1e-9);
    EXPECT_LT(press.contacts[0].force.z(), 0.0); // pulled back
    press.motion.release(0);
    press.tips[0].position = Vec3(0.0, 0.0, 200.0);
    press.frames(200);
    EXPECT_EQ(press.motion.positions(), press.motion.rest());
}

TEST(SphereMotion, pinchOnAnEdgeKeepsTheSurfaceClosed)
{
    Press press;
    const TriMesh& surface = press.motion.surface();
    const auto corners = surface.triangles[100];
    const Vec3 middle = 0.5 * (surface.vertices.row(corners[0]) + surface.vertices.row(corners[1])).transpose();
    const VertexId vertex = press.motion.pinch(0, { middle, Vec3::Zero(), kTip });
    EXPECT_LT((press.motion.surface().vertices.row(vertex).transpose() - middle).norm(), 1e-9);
    EXPECT_NO_THROW(SurfaceLocator { press.motion.surface() });
    EXPECT_NE(test_support::message_of([&] { press.motion.pinch(0, { middle, Vec3::Zero(), kTip }); }), "");
    press.motion.release(0);
    const Vec3 corner = press.motion.surface().vertices.row(corners[2]).transpose();
    EXPECT_EQ(press.motion.pinch(0, { corner, Vec3::Zero(), kTip }), corners[2]);
}

TEST(SphereMotion, aFastFingerPushesInsteadOfPassingThrough)
{
    Press slow, fast;
    for (int i = 0; i <= 40; ++i) {
        slow.tips[0].position = Vec3(0.0, 0.0, kOrgan + kTip - 0.25 * i);
        slow.frames(1);
    }
    fast.tips[0].position = Vec3(0.0, 0.0, kOrgan + kTip);
    fast.frames(1);
    fast.tips[0].position = Vec3(0.0, 0.0, kOrgan + kTip - 10.0);
    fast.frames(1);
    EXPECT_GT(fast.contacts[0].force.z(), 0.3 * slow.contacts[0].force.z());
}

TEST(SphereMotion, advanceAllocatesNothing)
{
    Press press({ .fingers = 6 });
    press.frames(1);
    const std::size_t before = retractor::test_support::allocation_count();
    for (int i = 0; i < 50; ++i) {
        for (std::size_t f = 0; f < 6; ++f)
            press.tips[f].position = (kOrgan + kTip - 0.2 * i) * Vec3(std::cos(f), std::sin(f), 0.0);
        press.frames(1);
    }
    EXPECT_EQ(retractor::test_support::allocation_count(), before);
}

TEST(SphereMotion, sameMotionGivesTheSameBits)
{
    Press a, b;
    a.press(7.0);
    b.press(7.0);
    EXPECT_EQ(a.motion.positions(), b.motion.positions());
    EXPECT_EQ(a.contacts[0].force, b.contacts[0].force);
}

TEST(SphereForce, sneddonsNumbersAndTheCalibration)
{
    // validation.md's problem 7: R 8, d 5, E 0.020, nu 0.49.
    EXPECT_NEAR(sneddon_force(5.0, 8.0, 0.020, 0.49), 1.0401, 1e-4);
    const SphereLaw law;
    const double stiffness = calibrate_sphere_force(2.5, law, 0.020, 0.49);
    EXPECT_GT(stiffness, 0.0);
    EXPECT_GT(calibrate_sphere_force(5.0, law, 0.020, 0.49), stiffness); // fewer spheres bear the same
    EXPECT_NEAR(calibrate_sphere_force(2.5, law, 0.040, 0.49), 2.0 * stiffness, 1e-12);
}

TEST(SphereMotion, refusesWhatCannotBe)
{
    EXPECT_EQ(test_support::message_of([] { SphereMotion({}, {}); }), "a sphere-filled scene needs an organ");
    EXPECT_EQ(
        test_support::message_of([] { Press({ .depth_limit = 0 }); }), "the depth limit is 1 to 250 layers, got 0");
    EXPECT_EQ(test_support::message_of([] { Press({ .transmission = 1.5 }); }),
        "the transmission lies above 0 and up to 0.8, got 1.500000");
    EXPECT_EQ(
        test_support::message_of([] { Press({ .fingers = 7 }); }), "spheres are touched by 1 to 6 fingers, got 7");
    SphereOrgan limp = ball_organ();
    limp.stiffness = std::nan("");
    EXPECT_EQ(test_support::message_of([&] { SphereMotion({ limp }, {}); }),
        "ball: the organ's stiffness must be positive, got nan");
}

} // namespace sphere_motion_test

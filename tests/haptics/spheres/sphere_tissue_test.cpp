#include "haptics/spheres/sphere_tissue.h"

#include "tests/support/allocation_count.h"
#include "tests/support/test_help.h"
#include "tests/support/test_shapes.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace retractor;
using namespace retractor::haptics;
using retractor::test_support::ball_surface;

namespace sphere_tissue_test {

constexpr double kOrgan = 40.0, kTip = 8.0, kTick = 1e-3;
constexpr int kTicksPerFrame = 16;

struct Touch {
    SphereTissue tissue;
    Fingertip tip { Vec3(0.0, 0.0, kOrgan + kTip + 5.0), Vec3::Zero(), kTip };
    FingerContact contact {};
    Points deformed {};
    int ticks = 0, ticks_per_frame = kTicksPerFrame;
    double largest = 0.0; ///< force, N
    double largest_step = 0.0; ///< of the force from tick to tick, N

    Touch()
        : tissue({ organ() }, {})
    {
    }
    static SphereOrgan organ()
    {
        const TriMesh surface = test_support::ball_surface(Vec3::Zero(), kOrgan, 24);
        return { "ball", surface, fill_with_spheres(surface, 2.5), 0.02 };
    }
    void move_to(double depth, int count)
    {
        const double from = tip.position.z(), to = kOrgan + kTip - depth;
        for (int i = 1; i <= count; ++i) {
            tip.position.z() = from + (to - from) * i / count;
            const Vec3 last = contact.force;
            tissue.tick(++ticks * kTick, kTick, { &tip, 1 }, { &contact, 1 });
            largest = std::max(largest, contact.force.norm());
            largest_step = std::max(largest_step, (contact.force - last).norm());
            if (ticks % ticks_per_frame == 0)
                tissue.follow(deformed);
        }
    }
};

TEST(SphereTissue, servoFeelsWhatTheSpheresSay)
{
    Touch touch;
    touch.move_to(8.0, 500);
    touch.move_to(8.0, 300);
    ASSERT_TRUE(touch.contact.touching);
    SphereMotion motion({ Touch::organ() }, {});
    SphereContact direct;
    for (int i = 0; i < 60; ++i) {
        const Fingertip tip { Vec3(0.0, 0.0, kOrgan + kTip - std::min(8.0, 0.25 * i - 5.0)), Vec3::Zero(), kTip };
        motion.advance(1.0 / 60.0, { &tip, 1 }, { &direct, 1 });
    }
    EXPECT_NEAR(touch.contact.force.z(), direct.force.z(), 0.05 * direct.force.z());
}

TEST(SphereTissue, forceIsSmoothBetweenFrames)
{
    Touch touch;
    touch.move_to(8.0, 500);
    touch.largest_step = 0.0;
    touch.move_to(10.0, 200);
    EXPECT_LT(touch.largest_step, 0.05 * touch.contact.force.norm()); // a frame's change, spread over its ticks
}

TEST(SphereTissue, aFingerSetDownBetweenTwoSlowFramesIsNotHit)
{
    for (const double seen : { 0.05, 0.2, 0.5, 1.0 }) { // mm deep at the frame before
        Touch touch;
        touch.ticks_per_frame = 100; // a display of ten frames a second
        touch.move_to(seen, 200);
        touch.move_to(5.0, 40);
        touch.move_to(5.0, 59);
        const double set_down = touch.largest;
        touch.move_to(5.0, 2001);
        EXPECT_LT(set_down, 1.2 * touch.contact.force.norm()) << seen;
    }
}

TEST(SphereTissue, stiffnessIsOfTheOrganTouchedNotOfTheFirst)
{
    const TriMesh far = test_support::ball_surface(Vec3(200.0, 0.0, 0.0), kOrgan, 24);
    const SphereOrgan coarse { "coarse", far, fill_with_spheres(far, 8.0), 0.02 };
    constexpr double kDepth = 1.0; // less than a sphere's radius, which then sets the secant
    const auto stiffness = [&](std::vector<SphereOrgan> organs) {
        SphereTissue tissue(std::move(organs), {});
        const Fingertip tip { Vec3(0.0, 0.0, kOrgan + kTip - kDepth), Vec3::Zero(), kTip };
        FingerContact contact;
        Points deformed;
        for (int i = 1; i <= 200; ++i) {
            tissue.tick(i * kTick, kTick, { &tip, 1 }, { &contact, 1 });
            if (i % kTicksPerFrame == 0)
                tissue.follow(deformed);
        }
        EXPECT_TRUE(contact.touching);
        return contact.stiffness;
    };
    const double alone = stiffness({ Touch::organ() });
    constexpr double kSame = 1e-6; // the order of sums may differ
    EXPECT_NEAR(stiffness({ coarse, Touch::organ() }), alone, kSame * alone);
    EXPECT_NEAR(stiffness({ Touch::organ(), coarse }), alone, kSame * alone);
}

TEST(SphereTissue, aFingerThatLeavesIsNotPulled)
{
    Touch touch;
    touch.move_to(8.0, 300);
    for (int i = 0; i < 60; ++i) {
        touch.move_to(8.0 - 0.4 * i, 4);
        EXPECT_GE(touch.contact.force.z(), -1e-9);
    }
    touch.move_to(-20.0, 500);
    EXPECT_FALSE(touch.contact.touching);
}

TEST(SphereTissue, nothingIsTouchedBeforeTheFirstTick)
{
    const TriMesh surface = test_support::ball_surface(Vec3(0.0, 0.0, kOrgan), kOrgan, 24); // the origin lies on it
    SphereTissue tissue({ { "ball", surface, fill_with_spheres(surface, 2.5), 0.02 } }, {});
    Points rest, deformed;
    tissue.motion().deform(rest);
    tissue.follow(deformed);
    EXPECT_EQ(deformed, rest);
    // The first pose is where the finger is, not the end of a way from the origin through the organ.
    const Fingertip tip { Vec3(0.0, 0.0, 2.0 * kOrgan + 20.0), Vec3::Zero(), kTip };
    FingerContact contact;
    tissue.tick(kTick, kTick, { &tip, 1 }, { &contact, 1 });
    tissue.follow(deformed);
    EXPECT_EQ(deformed, rest);
    tissue.tick(2 * kTick, kTick, { &tip, 1 }, { &contact, 1 });
    EXPECT_FALSE(contact.touching);
}

TEST(SphereTissue, pinchPullsAndDividesTheSurface)
{
    Touch touch;
    touch.move_to(0.5, 64);
    const auto vertices = touch.tissue.surface().vertices.rows();
    touch.tip.position += Vec3(2.0, 1.0, 0.0);
    touch.tissue.want_pinch(0, true);
    touch.move_to(-8.0, 320);
    EXPECT_EQ(touch.tissue.surface().vertices.rows(), vertices + 1);
    EXPECT_EQ(touch.deformed.rows(), vertices + 1);
    EXPECT_LT(touch.contact.force.z(), 0.0);
    touch.tissue.want_pinch(0, false);
    touch.move_to(-8.0, 500);
    EXPECT_FALSE(touch.contact.touching);
}

TEST(SphereTissue, pinchOfNothingIsForgotten)
{
    Touch touch;
    touch.tissue.want_pinch(0, true);
    touch.move_to(-30.0, 64);
    EXPECT_FALSE(touch.tissue.motion().pinches(0));
}

TEST(SphereTissue, tickAllocatesNothing)
{
    Touch touch;
    touch.move_to(5.0, 100);
    const std::size_t before = retractor::test_support::allocation_count();
    for (int i = 0; i < 1000; ++i)
        touch.tissue.tick(1.0 + i * kTick, kTick, { &touch.tip, 1 }, { &touch.contact, 1 });
    EXPECT_EQ(retractor::test_support::allocation_count(), before);
}

TEST(SphereTissue, refusesANegativeBlend)
{
    EXPECT_EQ(test_support::message_of([] { SphereTissue({ Touch::organ() }, {}, -1.0); }),
        "the blend time must not be negative, got -1.000000");
}

} // namespace sphere_tissue_test

#include "haptics/springs/spring_tissue.h"

#include "tests/support/allocation_count.h"
#include "tests/support/test_help.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace retractor;
using namespace retractor::haptics;

namespace spring_tissue_test {

constexpr double kTick = 1e-3, kRadius = 4.0;

struct Touch {
    SpringTissue tissue;
    Fingertip tip { Vec3(0.0, 0.0, 6.0), Vec3::Zero(), kRadius };
    FingerContact contact {};
    double time = 0.0;

    explicit Touch(const SheetOptions& sheet = {}, const ElementLaw& law = { .drag = 30.0 },
        const SpringTissueOptions& options = {})
        : tissue(make_spring_sheet(sheet), law, options)
    {
    }
    /// Moves the finger evenly to a height in so many ticks.
    void move_to(double z, int ticks)
    {
        const double from = tip.position.z();
        for (int i = 1; i <= ticks; ++i) {
            tip.position.z() = from + (z - from) * i / ticks;
            tissue.tick(time += kTick, kTick, { &tip, 1 }, { &contact, 1 });
        }
    }
    /// What the held edge bears, N.
    Vec3 support() const
    {
        Vec3 sum = Vec3::Zero();
        const SpringMotion& motion = tissue.motion();
        for (VertexId v = 0; v < 625; ++v)
            if (motion.is_held(v))
                sum += motion.element_force(v);
        return sum;
    }
};

TEST(SpringTissue, aFingerThatDoesNotTouchFeelsNothing)
{
    Touch touch;
    touch.move_to(4.5, 50);
    EXPECT_FALSE(touch.contact.touching);
    EXPECT_EQ(touch.contact.force, Vec3(Vec3::Zero()));
    EXPECT_EQ(touch.contact.proxy, touch.tip.position);
}

TEST(SpringTissue, atRestTheFingerBearsWhatTheEdgesPull)
{
    Touch touch;
    touch.move_to(1.0, 300); // 3 mm deep
    touch.move_to(1.0, 3000);
    ASSERT_TRUE(touch.contact.touching);
    EXPECT_GT(touch.contact.force.z(), 0.01);
    // Equilibrium: finger + supports = 0, up to what the sheet's slow last creep and drag take after 3 s.
    EXPECT_LT((touch.contact.force + touch.support()).norm(), 1e-2 * touch.contact.force.norm());
    EXPECT_LT(touch.contact.force.head<2>().norm(), 1e-9); // pressed in the middle of a symmetric sheet
    EXPECT_NEAR(touch.contact.depth, 3.0, 0.05);
    EXPECT_NEAR(touch.contact.normal.z(), 1.0, 1e-9);
}

TEST(SpringTissue, deepenedForceGrowsAndReleasedTissueRecovers)
{
    Touch touch;
    touch.move_to(2.0, 200);
    const double shallow = touch.contact.force.z();
    touch.move_to(0.0, 200);
    EXPECT_GT(touch.contact.force.z(), 2.2 * shallow); // more than the depth: a slack sheet stiffens
    touch.move_to(6.0, 50);
    touch.move_to(6.0, 5000);
    EXPECT_FALSE(touch.contact.touching);
    const Points moved = touch.tissue.motion().positions() - touch.tissue.surface().vertices;
    // Out of its plane a flat sheet's springs pull with the third power of the distance: the last part is slow.
    EXPECT_LT(moved.rowwise().norm().maxCoeff(), 0.4);
}

TEST(SpringTissue, restingFingerFeelsNoVibration)
{
    Touch touch;
    touch.move_to(1.0, 300);
    touch.move_to(1.0, 1000);
    double sum = 0.0, squares = 0.0;
    constexpr int kTicks = 1000;
    for (int i = 0; i < kTicks; ++i) {
        touch.move_to(1.0, 1);
        sum += touch.contact.force.z();
        squares += touch.contact.force.z() * touch.contact.force.z();
    }
    const double variance = squares / kTicks - (sum / kTicks) * (sum / kTicks);
    EXPECT_LT(std::sqrt(std::max(0.0, variance)), 0.01); // N rms; our bound
}

TEST(SpringTissue, aStretchedSheetRecoversSooner)
{
    Touch touch({ .pre_strain = 0.05 });
    touch.move_to(1.0, 200);
    touch.move_to(6.0, 50);
    touch.move_to(6.0, 1000);
    const Points moved = touch.tissue.motion().positions() - touch.tissue.surface().vertices;
    EXPECT_LT(moved.rowwise().norm().maxCoeff(), 0.1);
}

TEST(SpringTissue, aGripPullsAndLetsGo)
{
    Touch touch({}, { .drag = 30.0 });
    touch.move_to(3.8, 100);
    touch.tissue.grip(0, true);
    touch.move_to(6.8, 300);
    EXPECT_EQ(touch.tissue.gripped(0), 9U);
    EXPECT_LT(touch.contact.force.z(), -0.01); // pulled back down
    EXPECT_NEAR(touch.tissue.motion().position(312).z(), 2.8, 0.2);
    touch.tissue.grip(0, false);
    touch.move_to(6.8, 100);
    EXPECT_EQ(touch.tissue.gripped(0), 0U);
    EXPECT_FALSE(touch.contact.touching);
}

TEST(SpringTissue, aFingerThatIsPlacedElsewhereLetsGoAndSweepsNothing)
{
    Touch touch({}, { .drag = 30.0 });
    touch.move_to(3.8, 100);
    touch.tissue.grip(0, true);
    touch.move_to(4.8, 100);
    ASSERT_EQ(touch.tissue.gripped(0), 9U);
    const Points before = touch.tissue.motion().positions();
    touch.tip.position.x() += 150.0;
    touch.tip.placed = true;
    touch.move_to(-4.8, 1);
    EXPECT_EQ(touch.tissue.gripped(0), 0U);
    EXPECT_FALSE(touch.contact.touching);
    constexpr double kOwnLife = 0.1; // mm in a tick: the springs draw back what was held
    EXPECT_LT(Points(touch.tissue.motion().positions() - before).rowwise().norm().maxCoeff(), kOwnLife);
}

TEST(SpringTissue, gravityAgainstTheHandIsFelt)
{
    const auto force = [](double gravity) {
        Touch touch({}, { .drag = 30.0, .gravity = Vec3(0.0, 0.0, gravity) });
        touch.move_to(2.0, 200);
        touch.move_to(2.0, 2000);
        return touch.contact.force.z();
    };
    EXPECT_GT(force(kGravity), force(0.0)); // gravity up, pressing down: fig. 14 of the paper
    EXPECT_LT(force(-kGravity), force(0.0));
}

TEST(SpringTissue, twoFingersShareASheet)
{
    SpringTissue tissue(make_spring_sheet(), { .drag = 30.0 }, { .fingers = 2 });
    std::array<Fingertip, 2> tips { { { Vec3(-5.0, 0.0, 4.0), Vec3::Zero(), 3.0 },
        { Vec3(5.0, 0.0, 4.0), Vec3::Zero(), 3.0 } } };
    std::array<FingerContact, 2> contacts;
    for (int i = 0; i < 1000; ++i) {
        for (Fingertip& tip : tips)
            tip.position.z() = std::max(1.0, 4.0 - 0.01 * i);
        tissue.tick(i * kTick, kTick, tips, contacts);
    }
    EXPECT_NEAR(contacts[0].force.z(), contacts[1].force.z(), 1e-6);
    EXPECT_NEAR(contacts[0].force.x(), -contacts[1].force.x(), 1e-6);
    EXPECT_GT(contacts[0].force.z(), 0.01);
}

TEST(SpringTissue, tickAllocatesNothing)
{
    Touch touch;
    touch.move_to(3.0, 10);
    touch.tissue.grip(0, true);
    const std::size_t before = retractor::test_support::allocation_count();
    for (int i = 0; i < 100; ++i) {
        touch.tip.position.z() -= 0.01;
        touch.tissue.grip(0, i % 10 < 5);
        touch.tissue.tick(i * kTick, kTick * (1.0 + 0.3 * std::sin(i)), { &touch.tip, 1 }, { &touch.contact, 1 });
    }
    EXPECT_EQ(retractor::test_support::allocation_count(), before);
}

TEST(SpringTissue, followGivesTheDeformedSurface)
{
    Touch touch({}, {}, { .ticks_per_frame = 1 });
    touch.move_to(2.0, 300);
    Points deformed;
    touch.tissue.follow(deformed);
    ASSERT_EQ(deformed.rows(), 625);
    EXPECT_NEAR(deformed(312, 2), -2.0, 1e-9); // straight under the finger
}

TEST(SpringTissue, sameMotionGivesTheSameBits)
{
    Touch a, b;
    a.move_to(1.0, 500);
    b.move_to(1.0, 500);
    EXPECT_EQ(a.contact.force, b.contact.force);
    EXPECT_EQ(Points(a.tissue.motion().positions()), Points(b.tissue.motion().positions()));
}

TEST(SpringTissue, answersNanToATickWithoutTime)
{
    Touch touch;
    touch.tissue.tick(0.0, std::nan(""), { &touch.tip, 1 }, { &touch.contact, 1 });
    EXPECT_TRUE(touch.contact.force.hasNaN());
}

TEST(SpringTissue, refusesSpringsTooStiffForTheirMass)
{
    EXPECT_EQ(test_support::message_of([] { SpringTissue(make_spring_sheet({ .stiffness = 1e4 }), {}); }),
        "the springs are too stiff for their mass: their stability bound is 4.08248e-07 s, less than 1/1000 of a tick "
        "of 0.005 s");
    EXPECT_EQ(test_support::message_of([] { SpringTissue(make_spring_sheet(), {}, { .fingers = 0 }); }),
        "a tissue is touched by 1 to 16 fingers, got 0");
}

TEST(SpringTissue, aPulseIsALoadOfPressureTimesArea)
{
    constexpr VertexId kMiddle = 312;
    const Vec3 area(0.0, 0.0, 2.0); // mm^2
    SpringTissueOptions options;
    options.pulse = { PulsePressure::constant(120.0), 80.0 * kMPaPerMmHg, { kMiddle }, { area } };
    Touch pulsed({}, { .drag = 30.0 }, options), loaded;
    loaded.tissue.motion().set_load(kMiddle, 40.0 * kMPaPerMmHg * area);
    pulsed.move_to(5.0, 200);
    loaded.move_to(5.0, 200);
    EXPECT_GT(pulsed.tissue.motion().position(kMiddle).z(), 0.01);
    constexpr double kRoundOff = 1e-12;
    EXPECT_NEAR(pulsed.tissue.motion().position(kMiddle).z(), loaded.tissue.motion().position(kMiddle).z(), kRoundOff);
    options.pulse.areas.clear();
    EXPECT_EQ(test_support::message_of([&] { SpringTissue(make_spring_sheet(), {}, options); }),
        "pulse: there must be one area per particle");
    options.pulse = { PulsePressure::constant(120.0), 0.0, { 625 }, { area } };
    EXPECT_EQ(test_support::message_of([&] { SpringTissue(make_spring_sheet(), {}, options); }),
        "pulse, entry 0: presses on a particle that does not exist, or on an area that is not finite");
}

TEST(SpringTissue, tellsNoStiffnessWhenAskedNotTo)
{
    Touch telling, silent({}, { .drag = 30.0 }, { .tells_stiffness = false });
    telling.move_to(2.0, 300);
    silent.move_to(2.0, 300);
    EXPECT_GT(telling.contact.stiffness, 0.0);
    EXPECT_EQ(silent.contact.stiffness, 0.0);
    EXPECT_EQ(silent.contact.force, telling.contact.force);
}

} // namespace spring_tissue_test

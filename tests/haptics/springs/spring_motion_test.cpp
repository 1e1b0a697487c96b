#include "haptics/springs/spring_motion.h"

#include "tests/support/haptics/ring_load.h"
#include "tests/support/haptics/spring_bodies.h"
#include "tests/support/test_help.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

using namespace retractor;
using namespace retractor::haptics;

namespace spring_motion_test {

constexpr double kStiffness = 0.5, kMass = 1e-7, kLength = 10.0;

/// A chain along x, held at both ends.
SpringBody chain(int movable)
{
    SpringBody body;
    const int particles = movable + 2;
    body.surface.vertices = Points::Zero(particles, 3);
    for (int v = 0; v < particles; ++v)
        body.surface.vertices(v, 0) = v;
    for (int v = 0; v + 1 < particles; ++v)
        body.springs.push_back({ v, v + 1, 1.0, kStiffness });
    body.mass.assign(static_cast<std::size_t>(particles), kMass);
    body.held.assign(static_cast<std::size_t>(particles), 0);
    body.held.front() = body.held.back() = 1;
    return body;
}

/// Kinetic energy and energy of the springs, N mm.
double energy(const SpringMotion& motion)
{
    const SpringBody& body = motion.body();
    double sum = 0.0;
    for (std::size_t v = 0; v < body.mass.size(); ++v)
        sum += 0.5 * body.mass[v] * motion.velocity(static_cast<VertexId>(v)).squaredNorm();
    for (const TissueSpring& spring : body.springs) {
        const double stretch = (motion.position(spring.b) - motion.position(spring.a)).norm() - spring.length;
        sum += 0.5 * spring.stiffness * stretch * stretch;
    }
    return sum;
}

TEST(SpringMotion, voigtElementCreepsAsTheClosedForm)
{
    constexpr double kTime = 0.2, kForce = 0.3, kStep = 1e-4;
    SpringMotion motion(test_support::spring_element(kLength, kStiffness, kMass), { .voigt_time = kTime, .drag = 0.0 });
    motion.set_load(1, Vec3(kForce, 0.0, 0.0));
    ASSERT_LT(kStep, motion.stable_step());
    double worst = 0.0;
    for (int i = 1; i <= 10000; ++i) {
        motion.step(kStep);
        const double t = i * kStep, right = kForce / kStiffness * (1.0 - std::exp(-t / kTime));
        worst = std::max(worst, std::abs(motion.position(1).x() - kLength - right));
    }
    // First order in the step (2.5e-4 of the time constant), and the inertia's own time m / c is 1e-6 s.
    EXPECT_LT(worst, 1e-3 * kForce / kStiffness);
}

TEST(SpringMotion, voigtElementDoesNotRelax)
{
    SpringMotion motion(test_support::spring_element(kLength, kStiffness, kMass, true), { .voigt_time = 0.2 });
    motion.place(1, Vec3(kLength + 1.0, 0.0, 0.0));
    for (int i = 0; i < 100; ++i)
        motion.step(1e-3);
    EXPECT_NEAR(motion.element_force(1).x(), -kStiffness, 1e-12);
}

TEST(SpringMotion, standardLinearSolidRelaxesAsTheClosedForm)
{
    constexpr double kRatio = 0.8, kTime = 0.5, kStep = 1e-3;
    SpringMotion motion(test_support::spring_element(kLength, kStiffness, kMass, true),
        { .voigt_time = 0.0, .arm_ratio = kRatio, .arm_time = kTime });
    motion.place(1, Vec3(kLength + 1.0, 0.0, 0.0));
    motion.step(kStep); // the arm takes the stretch up within this step: its mean age is half a step
    double worst = 0.0;
    for (int i = 1; i <= 2000; ++i) {
        motion.step(kStep);
        const double right = kStiffness * (1.0 + kRatio * std::exp(-(i + 0.5) * kStep / kTime));
        worst = std::max(worst, std::abs(-motion.element_force(1).x() - right));
    }
    EXPECT_LT(worst, 1e-6 * kStiffness); // the step's second order
}

TEST(SpringMotion, standardLinearSolidCreepsAsTheClosedForm)
{
    constexpr double kRatio = 1.0, kTime = 0.1, kForce = 0.3, kStep = 5e-5;
    SpringMotion motion(test_support::spring_element(kLength, kStiffness, kMass),
        { .voigt_time = 1e-3, .arm_ratio = kRatio, .arm_time = kTime });
    motion.set_load(1, Vec3(kForce, 0.0, 0.0));
    double worst = 0.0;
    for (int i = 1; i <= 20000; ++i) {
        motion.step(kStep);
        const double t = i * kStep;
        const double slow = kTime * (1.0 + kRatio);
        const double right = kForce / kStiffness * (1.0 - kRatio / (1.0 + kRatio) * std::exp(-t / slow));
        if (t > 0.02) // after the dashpot beside it has let go
            worst = std::max(worst, std::abs(motion.position(1).x() - kLength - right));
    }
    EXPECT_LT(worst, 5e-3 * kForce / kStiffness); // voigt_time / arm_time, times the share still to creep
}

TEST(SpringMotion, undampedEnergyStaysBoundedAtTheBound)
{
    SpringMotion motion(chain(20), { .voigt_time = 0.0, .drag = 0.0 });
    motion.place(7, Vec3(7.02, 0.0, 0.0));
    const double start = energy(motion);
    double highest = 0.0;
    for (int i = 0; i < 20000; ++i) {
        motion.step(0.99 * motion.stable_step());
        highest = std::max(highest, energy(motion));
    }
    // Symplectic: a neighbouring energy is conserved, which near the bound is up to 1 / (1 - 0.99^2) times apart.
    EXPECT_LT(highest, 60.0 * start);
}

TEST(SpringMotion, boundIsCertainAndSharpForAChain)
{
    constexpr int kMovable = 40;
    const SpringMotion motion(chain(kMovable), {});
    const double highest
        = 2.0 * std::sqrt(kStiffness / kMass) * std::sin(0.5 * kMovable * std::numbers::pi / (kMovable + 1));
    EXPECT_LE(motion.stable_step(), 2.0 / highest);
    EXPECT_GT(motion.stable_step(), 0.99 * 2.0 / highest);
}

TEST(SpringMotion, dashpotsDoNotLowerTheBound)
{
    for (const double time : { 0.0, 1e-3, 0.1, 10.0 }) {
        SpringMotion motion(make_spring_sheet(), { .voigt_time = time, .drag = 0.0 });
        for (VertexId v = 200; v < 400; v += 7) // in and out of plane, not small
            motion.place(v, motion.position(v) + 0.3 * Vec3(std::sin(v), std::cos(3 * v), std::sin(2 * v)));
        const double start = energy(motion);
        double highest = 0.0;
        for (int i = 0; i < 3000; ++i) {
            motion.step(0.999 * motion.stable_step());
            highest = std::max(highest, energy(motion));
        }
        EXPECT_TRUE(std::isfinite(highest));
        EXPECT_LT(highest, 600.0 * start) << time; // as above, 1 / (1 - 0.999^2)
        if (time > 0.0) {
            EXPECT_LT(energy(motion), start) << time;
        }
    }
}

TEST(SpringMotion, momentumIsKeptWithoutSupports)
{
    SpringMotion motion(test_support::free_sheet(), { .drag = 0.0 });
    motion.place(312, Vec3(0.0, 0.0, 2.0));
    for (int i = 0; i < 500; ++i)
        motion.step(1e-4);
    Vec3 momentum = Vec3::Zero();
    double scale = 0.0;
    for (VertexId v = 0; v < 625; ++v) { // of one mass
        momentum += motion.velocity(v);
        scale += motion.velocity(v).norm();
    }
    EXPECT_GT(scale, 1.0);
    EXPECT_LT(momentum.norm(), 1e-10 * scale);
}

TEST(SpringMotion, gravityStretchesAChainAsItsWeight)
{
    SpringBody body = chain(8);
    body.held.back() = 0;
    SpringMotion motion(body, { .voigt_time = 0.01, .drag = 50.0, .gravity = Vec3(kGravity, 0.0, 0.0) });
    for (int i = 0; i < 40000; ++i)
        motion.step(0.9 * motion.stable_step());
    // Spring i carries the nine free particles below it.
    double right = 0.0;
    for (int below = 9; below >= 1; --below) {
        right += 1.0 + below * kMass * kGravity / kStiffness;
        EXPECT_NEAR(motion.position(10 - below).x(), right, 1e-6);
    }
}

TEST(SpringMotion, freeSheetFallsAndACurtainHangs)
{
    const Vec3 down(0.0, -kGravity, 0.0);
    SpringMotion falling(test_support::free_sheet(), { .drag = 0.0, .gravity = down });
    constexpr double kStep = 1e-4;
    for (int i = 0; i < 1000; ++i)
        falling.step(kStep);
    const double time = 0.1;
    for (VertexId v = 0; v < 625; ++v) // symplectic steps fall by half a step more
        EXPECT_NEAR(falling.position(v).y() - falling.body().surface.vertices(v, 1),
            -0.5 * kGravity * time * (time + kStep), 1e-9 * kGravity * time * time);

    SpringMotion curtain(test_support::hanging_sheet(), { .drag = 20.0, .gravity = down });
    for (int i = 0; i < 20000; ++i)
        curtain.step(kStep);
    for (VertexId v = 0; v < 625; ++v)
        EXPECT_LT(curtain.velocity(v).norm(), 0.1);
    EXPECT_EQ(curtain.position(612).y(), 12.0); // the held side
    EXPECT_LT(curtain.position(12).y(), -12.0 - 1e-3); // the hem hangs lower than at rest
}

TEST(SpringMotion, stepsBeyondTheBoundAreRefusedWithTheBoundNamed)
{
    SpringMotion motion(make_spring_sheet(), {});
    const Points before = motion.positions();
    EXPECT_EQ(test_support::message_of([&] { motion.step(1.01 * motion.stable_step()); }),
        "a time step of 0.000150562 s is not positive or beyond the springs' stability bound, 0.000149071 s");
    EXPECT_NE(test_support::message_of([&] { motion.step(0.0); }), "");
    EXPECT_NE(test_support::message_of([&] { motion.step(std::nan("")); }), "");
    EXPECT_EQ(motion.positions(), before);
}

TEST(SpringMotion, elementsByTheSheetsFractionsOfADevicesRange)
{
    const DeviceVoigt voigt = device_voigt({ .max_stiffness = 1.02, .max_damping = 5e-3 });
    EXPECT_NEAR(voigt.stiffness, 0.153, 1e-12);
    EXPECT_NEAR(voigt.stiffness * voigt.voigt_time, 4.5e-3, 1e-12);
}

TEST(SpringMotion, refusesBadLaws)
{
    EXPECT_EQ(test_support::message_of([] { SpringMotion(make_spring_sheet(), { .voigt_time = -1.0 }); }),
        "the elements' voigt_time is out of range: -1.000000");
    EXPECT_EQ(test_support::message_of([] { SpringMotion(make_spring_sheet(), { .arm_time = 0.0 }); }),
        "the elements' arm_time is out of range: 0.000000");
    EXPECT_EQ(test_support::message_of(
                  [] { SpringMotion(make_spring_sheet(), { .gravity = Vec3(0.0, std::nan(""), 0.0) }); }),
        "gravity is not finite");
    SpringMotion motion(make_spring_sheet(), {});
    EXPECT_EQ(test_support::message_of([&] { motion.set_load(625, Vec3::Zero()); }), "particle 625 does not exist");
}

TEST(SpringMotion, ringLoadMakesABroaderAndShallowerDent)
{
    const auto dent = [](bool ring) {
        SpringMotion motion(make_spring_sheet(), { .drag = 30.0 });
        const Vec3 force(0.0, 0.0, -0.2);
        if (ring)
            EXPECT_EQ(test_support::set_ring_load(motion, 312, force), 9U);
        else
            motion.set_load(312, force);
        for (int i = 0; i < 6000; ++i)
            motion.step(1e-4);
        return std::pair { -motion.position(312).z(), -motion.position(313).z() };
    };
    const auto [point, beside_point] = dent(false);
    const auto [ring, beside_ring] = dent(true);
    EXPECT_LT(ring, point);
    EXPECT_GT(beside_ring / ring, beside_point / point); // flatter under the load
}

} // namespace spring_motion_test

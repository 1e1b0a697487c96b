#include "haptics/surroundings/finger_access.h"

#include "haptics/surroundings/hindered_tissue.h"
#include "mesh/base/error.h"
#include "tests/support/allocation_count.h"
#include "tests/support/test_help.h"
#include "tests/support/test_shapes.h"
#include "tests/support/walls.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>

namespace retractor::haptics {
namespace finger_access_test {

    constexpr double kStep = 1.0, kFarthest = 12.0, kTip = 4.0;
    // A plate from z = -kThick to 0 with a slit along y, kHalf to each side of x = 0.
    constexpr double kThick = 20.0, kHalf = 18.0, kLong = 60.0, kFar = 70.0;

    FingerAccess access_through_slit(const Mat3& turn = Mat3::Identity(), const Vec3& shift = Vec3::Zero())
    {
        std::vector<mesh::NamedSurface> walls {
            { "left lip", test_support::box_surface({ -kFar, -kFar, -kThick }, { -kHalf, kFar, 0.0 }) },
            { "right lip", test_support::box_surface({ kHalf, -kFar, -kThick }, { kFar, kFar, 0.0 }) }
        };
        for (mesh::NamedSurface& wall : walls)
            wall.surface.vertices = (wall.surface.vertices * turn.transpose()).rowwise() + shift.transpose();
        const Eigen::AlignedBox3d around { shift - Vec3::Constant(90.0), shift + Vec3::Constant(90.0) };
        return FingerAccess({ .around = std::make_shared<const DistanceGrid>(walls, around, kStep, kFarthest) },
            { .centre = shift,
                .normal = turn * Vec3::UnitZ(),
                .along = turn * Vec3::UnitY(),
                .length_mm = 2.0 * kLong,
                .width_mm = 2.0 * kHalf });
    }

    /// Distance of the corner (x, z) from the axis through the tip and the gate, with the sign of its side.
    double from_axis(const Vec3& tip, double gate, double x, double z)
    {
        const double dx = gate - tip.x(), dz = -tip.z(), length = std::hypot(dx, dz);
        return ((x - tip.x()) * dz - (z - tip.z()) * dx) / length;
    }

    /// Whether a rod of the finger's thickness fits between the four edges of the slit, with the gates that the finger
    /// tries. The tip lies deeper than the taper.
    bool fits_exactly(const Vec3& tip)
    {
        const StraightRod finger;
        const double radius = 0.5 * finger.thickness_mm;
        for (int j = 0; j < 7; ++j) {
            const double gate = 2.0 * kHalf * ((j + 0.5) / 7.0 - 0.5);
            if (std::hypot(gate - tip.x(), tip.z()) > finger.reach_mm)
                continue;
            bool fits = true;
            for (const double z : { 0.0, -kThick })
                fits = fits && from_axis(tip, gate, kHalf, z) >= radius && from_axis(tip, gate, -kHalf, z) <= -radius;
            if (fits)
                return true;
        }
        return false;
    }

    /// The largest x at this depth at which `fits` holds, from the middle outwards.
    template <class Fits> double widest(const Fits& fits)
    {
        double x = 0.0;
        while (x < 60.0 && fits(x))
            x += 0.1;
        return x;
    }

    TEST(FingerAccess, FitsAsFarAsItsThicknessAllows)
    {
        const Mat3 turn = Eigen::AngleAxisd(0.6, Vec3(0.3, -0.8, 0.5).normalized()).toRotationMatrix();
        const Vec3 shift(120.0, -35.0, 1010.0);
        for (const bool turned : { false, true }) {
            const FingerAccess access = turned ? access_through_slit(turn, shift) : access_through_slit();
            for (const double depth : { 40.0, 55.0, 70.0 }) {
                const auto tip = [&](double x) { return Vec3(x, 0.0, -depth); };
                const double exact = widest([&](double x) { return fits_exactly(tip(x)); });
                ASSERT_GT(exact, 5.0);
                const double found = widest(
                    [&](double x) { return access.at(turned ? Vec3(turn * tip(x) + shift) : tip(x), kTip).fits; });
                // The grid is off by half a step at an edge, which a lever of depth to plate enlarges.
                EXPECT_NEAR(found, exact, 0.5 * kStep * (1.0 + depth / kThick)) << depth << " mm deep";
            }
        }
    }

    TEST(FingerAccess, SaysWhatHinders)
    {
        const FingerAccess access = access_through_slit();
        const auto name = [&](const FingerAccess::Answer& answer) {
            return answer.hindrance >= 0 ? access.around().names()[static_cast<std::size_t>(answer.hindrance)]
                                         : std::string();
        };
        EXPECT_TRUE(access.at(Vec3(0.0, 0.0, -60.0), kTip).fits);
        EXPECT_EQ(name(access.at(Vec3(50.0, 0.0, -40.0), kTip)), "right lip");
        EXPECT_EQ(name(access.at(Vec3(-50.0, 0.0, -40.0), kTip)), "left lip");
        EXPECT_EQ(name(access.at(Vec3(-40.0, 0.0, -10.0), kTip)), "left lip") << "inside the tissue";
        EXPECT_EQ(access.at(Vec3(0.0, 0.0, -85.0), kTip).hindrance, FingerAccess::kTooFar);
        EXPECT_TRUE(access.at(Vec3(0.0, 0.0, -850.0), kTip).fits) << "a hand that is put away";
        EXPECT_EQ(access.at(Vec3(95.0, 0.0, -10.0), kTip).hindrance, FingerAccess::kTooFar) << "beside the grid";
        EXPECT_TRUE(access.at(Vec3(40.0, 0.0, 5.0), kTip).fits) << "on the skin";
        EXPECT_FALSE(access.at(Vec3(40.0, 0.0, 2.0), kTip).fits) << "in the skin";
        EXPECT_TRUE(access.at(access.outside(kTip), kTip).fits);
    }

    TEST(FingerAccess, SlidesAlongWhatStopsIt)
    {
        const FingerAccess access = access_through_slit();
        const Vec3 in(0.0, 0.0, -10.0), wanted(40.0, 12.0, -10.0); // into the right lip, and along the slit
        const FingerAccess::Place place = access.towards(in, wanted, kTip, 0);
        EXPECT_TRUE(place.answer.fits);
        EXPECT_NEAR(place.tip.y(), 12.0, 0.5) << "goes along";
        EXPECT_LE(place.tip.x(), kHalf - kTip + 0.5 * kStep);
        EXPECT_GT(place.tip.x(), 3.0) << "up to the lip";
        EXPECT_EQ(place.answer.hindrance, 1);
    }

    TEST(FingerAccess, ChangesNothingWhereThereIsRoom)
    {
        const FingerAccess access = access_through_slit();
        const Vec3 wanted(4.0, -20.0, -45.0);
        const FingerAccess::Place place = access.towards(access.outside(kTip), wanted, kTip, 0);
        EXPECT_EQ(place.tip, wanted);
        EXPECT_TRUE(place.answer.fits);
    }

    /// A ball below the slit: the finger touches its near side, and goes not through it to the far side.
    TEST(FingerAccess, DoesNotPassWhatItTouches)
    {
        constexpr double kRadius = 12.0;
        const Vec3 middle(0.0, 0.0, -50.0);
        const FingerAccess slit = access_through_slit();
        TriMesh ball;
        constexpr int kAround = 24, kUp = 12;
        ball.vertices.resize((kUp + 1) * kAround, 3);
        for (int i = 0; i <= kUp; ++i)
            for (int j = 0; j < kAround; ++j) {
                const double polar = std::numbers::pi * i / kUp, azimuth = 2.0 * std::numbers::pi * j / kAround;
                ball.vertices.row(i * kAround + j) = (middle
                    + kRadius
                        * Vec3(
                            std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar)))
                                                         .transpose();
                const int next = (j + 1) % kAround;
                if (i < kUp) {
                    ball.triangles.push_back({ i * kAround + j, (i + 1) * kAround + j, (i + 1) * kAround + next });
                    ball.triangles.push_back({ i * kAround + j, (i + 1) * kAround + next, i * kAround + next });
                }
            }
        const FingerAccess access(make_surroundings({}, slit.opening(), ball, 16.0), slit.opening());
        const auto at = [&](const Vec3& outward) { return access.at(middle + (kRadius + kTip) * outward, kTip); };
        EXPECT_TRUE(at(Vec3::UnitZ()).fits);
        EXPECT_EQ(at(-Vec3::UnitZ()).hindrance, FingerAccess::kStructure);
        EXPECT_EQ(access.at(middle - (kRadius - kTip) * Vec3::UnitZ(), kTip).hindrance, FingerAccess::kStructure)
            << "nor from inside";
        EXPECT_TRUE(access.at(middle + (kRadius + kTip - 3.0) * Vec3::UnitZ(), kTip).fits) << "it presses";
    }

    TEST(FingerAccess, AHandThatWasPutAwayComesFromOutside)
    {
        const FingerAccess access = access_through_slit();
        const FingerAccess::Place place
            = access.towards(Vec3(0.0, 0.0, -850.0), Vec3(40.0, 0.0, -10.0), kTip, 0); // into the right lip
        EXPECT_TRUE(place.answer.fits);
        EXPECT_GT(place.tip.z(), -10.0);
        EXPECT_LT((place.tip - Vec3(40.0, 0.0, -10.0)).norm(), 60.0) << "near the hand, not behind the patient";
        EXPECT_EQ(place.answer.hindrance, 1);
    }

    TEST(FingerAccess, BeginsOutsideWhereItDoesNotFit)
    {
        const FingerAccess access = access_through_slit();
        const Vec3 in_the_lip(40.0, 0.0, -10.0);
        const FingerAccess::Place place = access.towards(in_the_lip, Vec3(50.0, 0.0, -10.0), kTip, 0);
        EXPECT_TRUE(place.answer.fits);
        EXPECT_NEAR(access.around().distance(place.tip), std::min(kTip, kFarthest), kFarthest);
        EXPECT_GT(place.tip.z(), 0.0) << "on the skin";
    }

    TEST(FingerAccess, AllocatesNothing)
    {
        const FingerAccess access = access_through_slit();
        const std::size_t before = test_support::allocation_count();
        static_cast<void>(access.towards(Vec3(0.0, 0.0, -10.0), Vec3(40.0, 12.0, -50.0), kTip, 0));
        EXPECT_EQ(test_support::allocation_count(), before);
    }

    TEST(FingerAccess, RefusesAnOpeningWithoutExtent)
    {
        const auto around = std::make_shared<const DistanceGrid>(std::vector<mesh::NamedSurface> {},
            Eigen::AlignedBox3d(Vec3::Constant(-1.0), Vec3::Constant(1.0)), kStep, kFarthest);
        EXPECT_THROW(FingerAccess({ .around = around }, { .length_mm = 0.0, .width_mm = 10.0 }), InputError);
    }

    /// Tissue below the slit, felt by a finger that the hand pushes.
    TEST(HinderedTissue, IsTouchedWhereTheFingerFits)
    {
        test_support::Wall tissue { 0.3 }; // the half-space y < 0
        Mat3 turn; // the slit's z is the wall's y
        turn << 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0;
        const Vec3 shift(0.0, 50.0, 0.0);
        const auto access = std::make_shared<const FingerAccess>(access_through_slit(turn, shift));
        HinderedTissue hindered(tissue, access);
        std::vector<Fingertip> fingers(1);
        std::vector<FingerContact> contacts(1);
        const auto touch = [&](const Vec3& at) {
            fingers[0].position = at;
            hindered.tick(0.0, 1e-3, fingers, contacts);
            return contacts[0];
        };
        const FingerContact under = touch(Vec3(0.0, -2.0, 0.0));
        EXPECT_FALSE(under.stopped);
        EXPECT_NEAR(under.force.y(), 0.6, 1e-12) << "as without surroundings";
        EXPECT_GT(under.outward.y(), 0.9);
        const FingerContact aside = touch(Vec3(60.0, -2.0, 0.0));
        EXPECT_TRUE(aside.stopped);
        EXPECT_GE(aside.stopped_by, 0) << "one of the lips between which the finger is jammed";
        EXPECT_LT(aside.stopped_at.x(), 40.0);
        EXPECT_LT(aside.force.x(), -kSurroundingsNPerMm * 20.0 + 1.0) << "the hand is drawn back";
        EXPECT_EQ((aside.force - aside.held_back).y() > 0.0, aside.stopped_at.y() < 0.0) << "beside what tissue does";
        const FingerContact back = touch(Vec3(0.0, -2.0, 0.0));
        EXPECT_FALSE(back.stopped) << "free as soon as the hand is where the finger fits";
        EXPECT_NEAR(back.force.y(), 0.6, 1e-12);
    }

} // namespace finger_access_test
} // namespace retractor::haptics

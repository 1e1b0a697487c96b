#include "ui/scene/camera_motion.h"

#include "tests/support/test_help.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace retractor::ui {
namespace camera_motion_test {

    constexpr double kTolerance = 1e-9; // rounding, of lengths of some 100 mm

    Camera outside()
    {
        return { .eye = { 0, -800, 0 }, .aim = { 0, 0, 0 }, .up = Vec3::UnitZ(), .view_angle_deg = 30 };
    }

    TEST(CameraMotion, BeginsAndEndsAtTheTwoCameras)
    {
        const Camera to { .eye = { 300, -100, 50 }, .aim = { 10, 20, 30 }, .up = Vec3::UnitZ(), .view_angle_deg = 12 };
        for (const auto& [share, camera] : { std::pair { 0.0, outside() }, std::pair { 1.0, to } }) {
            const Camera at = camera_between(outside(), to, share);
            EXPECT_LT((at.eye - camera.eye).norm(), kTolerance);
            EXPECT_LT((at.aim - camera.aim).norm(), kTolerance);
            EXPECT_NEAR(at.view_angle_deg, camera.view_angle_deg, kTolerance);
            const Vec3 sight = (camera.aim - camera.eye).normalized();
            const Vec3 up = (camera.up - camera.up.dot(sight) * sight).normalized(); // what a picture shows of it
            EXPECT_LT((at.up - up).norm(), kTolerance);
        }
    }

    TEST(CameraMotion, HalfWayOfAQuarterTurnTurnsByHalfOfIt)
    {
        Camera to = outside();
        to.eye = { 200, 0, 0 }; // a quarter turn about z, four times as near
        const Camera middle = camera_between(outside(), to, 0.5);
        EXPECT_NEAR(middle.eye.norm(), 400.0, kTolerance); // the geometric mean of 800 and 200
        EXPECT_NEAR(std::atan2(middle.eye.x(), -middle.eye.y()), 0.25 * std::numbers::pi, kTolerance);
        EXPECT_LT((middle.up - Vec3::UnitZ()).norm(), kTolerance);
    }

    TEST(CameraMotion, TurningKeepsTheDistanceAndTheAim)
    {
        const Camera turned = turned_round_aim(outside(), 90.0);
        EXPECT_LT((turned.eye - Vec3(800, 0, 0)).norm(), kTolerance);
        EXPECT_LT((turned.aim - outside().aim).norm(), kTolerance);
    }

    TEST(CameraMotion, AnotherCameraMovesAlikeInItsOwnPicture)
    {
        const Camera left { .eye = { 400, 0, 0 }, .aim = { 0, 0, 0 }, .up = Vec3::UnitZ(), .view_angle_deg = 20 };
        Camera after = turned_round_aim(outside(), 30.0); // and twice as near
        after.eye *= 0.5;
        const Camera moved = moved_alike(left, outside(), after);
        EXPECT_LT((moved.eye - 0.5 * turned_round_aim(left, 30.0).eye).norm(), kTolerance);
        EXPECT_LT((moved.aim - left.aim).norm(), kTolerance);
        EXPECT_NEAR(moved.view_angle_deg, left.view_angle_deg, kTolerance);
        Camera shifted = outside(); // to the right of its picture by a tenth of its distance
        shifted.eye.x() += 80.0;
        shifted.aim.x() += 80.0;
        EXPECT_LT((moved_alike(left, outside(), shifted).aim - Vec3(0, 40, 0)).norm(), kTolerance);
        const Camera still = moved_alike(left, outside(), outside());
        EXPECT_LT((still.eye - left.eye).norm() + (still.aim - left.aim).norm(), kTolerance);
    }

    TEST(CameraMotion, MotionsBeginAndEndAtRest)
    {
        constexpr double kStep = 1e-6;
        EXPECT_NEAR(eased(0.0), 0.0, kTolerance);
        EXPECT_NEAR(eased(1.0), 1.0, kTolerance);
        EXPECT_NEAR(eased(0.5), 0.5, kTolerance);
        EXPECT_LT(eased(kStep) / kStep, 1e-4);
        EXPECT_LT((1.0 - eased(1.0 - kStep)) / kStep, 1e-4);
    }

    TEST(EndoscopeCamera, LooksFromItsTipOffTheShaft)
    {
        const Camera surgeon { .eye = { 0.0, -400.0, 0.0 }, .aim = { 0.0, 100.0, 0.0 }, .up = { 0.0, 0.3, 1.0 } };
        const Camera straight = endoscope_camera(surgeon, 50.0, 0.0);
        EXPECT_NEAR((straight.eye - Vec3(0.0, 50.0, 0.0)).norm(), 0.0, 1e-9);
        EXPECT_NEAR((straight.aim - surgeon.aim).norm(), 0.0, 1e-9);
        EXPECT_NEAR((straight.up - Vec3::UnitZ()).norm(), 0.0, 1e-9);
        EXPECT_EQ(straight.view_angle_deg, kEndoscopeViewDeg);
        const auto sight = [](const Camera& camera) { return Vec3((camera.aim - camera.eye).normalized()); };
        const double c = std::cos(std::numbers::pi / 6.0);
        const Camera up = endoscope_camera(surgeon, 50.0, 30.0);
        EXPECT_NEAR((sight(up) - Vec3(0.0, c, 0.5)).norm(), 0.0, 1e-9) << "30 degrees towards up";
        EXPECT_NEAR(sight(up).dot(up.up), 0.0, 1e-9);
        // Seen along the shaft (y, with z up) the patient's left (x) is on the right.
        EXPECT_NEAR((sight(endoscope_camera(surgeon, 50.0, 30.0, 90.0)) - Vec3(0.5, c, 0.0)).norm(), 0.0, 1e-9);
        EXPECT_NEAR((sight(endoscope_camera(surgeon, 50.0, 30.0, 180.0)) - Vec3(0.0, c, -0.5)).norm(), 0.0, 1e-9);
        EXPECT_NEAR((endoscope_camera(surgeon, 900.0, 0.0).eye - surgeon.eye).norm(), 0.0, 1e-9)
            << "not before the eye";
    }

} // namespace camera_motion_test
} // namespace retractor::ui

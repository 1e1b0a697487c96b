#include "haptics/servo/device_mapping.h"

#include "tests/support/test_help.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <numbers>

namespace retractor::haptics {
namespace device_mapping_test {

    constexpr double kRounding = 1e-12;

    DeviceReading at(const Vec3& position, std::uint32_t buttons = 0)
    {
        return { .position = position, .buttons = buttons };
    }

    MappingOptions turned()
    {
        return { .scene_centre = { 10.0, 20.0, 30.0 },
            .scene_from_device = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitX()).toRotationMatrix(),
            .scale = 2.0 };
    }

    TEST(DeviceMapping, CarriesTheMiddleOfTheWorkspaceToTheCentreAndTurnsTheRest)
    {
        const Workspace workspace { { -10.0, -10.0, 0.0 }, { 10.0, 30.0, 20.0 } };
        DeviceMapping mapping(turned(), workspace);
        mapping.update(at(Vec3(0.0, 10.0, 10.0)));
        EXPECT_NEAR((mapping.to_scene(Vec3(0.0, 10.0, 10.0)) - Vec3(10.0, 20.0, 30.0)).norm(), 0.0, kRounding);
        // A quarter turn about x takes y to z.
        EXPECT_NEAR((mapping.to_scene(Vec3(1.0, 13.0, 10.0)) - Vec3(12.0, 20.0, 36.0)).norm(), 0.0, kRounding);
    }

    TEST(DeviceMapping, KeepsPowerUpToItsTwoScales)
    {
        for (const bool mirrored : { false, true }) {
            MappingOptions options = turned();
            options.mirrored = mirrored;
            options.force_scale = 0.25;
            const DeviceMapping mapping(options, Workspace {});
            const Vec3 velocity(1.0, -2.0, 3.0), force(0.4, 0.5, -0.6);
            const double scene = force.dot(mapping.velocity_to_scene(velocity));
            const double device = mapping.force_to_device(force).dot(velocity);
            EXPECT_NEAR(device, scene * options.force_scale / options.scale, kRounding);
            EXPECT_DOUBLE_EQ(mapping.stiffness_gain(), 0.5);
        }
    }

    TEST(DeviceMapping, MirrorsLeftAndRightHands)
    {
        MappingOptions options;
        const DeviceMapping right(options, Workspace {});
        options.mirrored = true;
        const DeviceMapping left(options, Workspace {});
        const Vec3 p(3.0, 4.0, 5.0);
        EXPECT_NEAR((left.to_scene(p) - Vec3(-3.0, 4.0, 5.0)).norm(), 0.0, kRounding);
        EXPECT_NEAR((left.to_scene(Vec3(-3.0, 4.0, 5.0)) - right.to_scene(p)).norm(), 0.0, kRounding);
        EXPECT_NEAR((left.direction_to_scene(p) - Vec3(-3.0, 4.0, 5.0)).norm(), 0.0, kRounding);
    }

    TEST(DeviceMapping, TheClutchHoldsTheTipAndGoesOnFromThere)
    {
        DeviceMapping mapping(MappingOptions {}, Workspace {});
        mapping.update(at(Vec3(70.0, 0.0, 0.0)));
        const Vec3 before = mapping.to_scene(Vec3(70.0, 0.0, 0.0));
        mapping.update(at(Vec3(70.0, 0.0, 0.0), 2));
        mapping.update(at(Vec3(-70.0, 5.0, 0.0), 2));
        EXPECT_TRUE(mapping.clutched());
        EXPECT_EQ(mapping.to_scene(Vec3(-70.0, 5.0, 0.0)), before);
        EXPECT_EQ(mapping.velocity_to_scene(Vec3(-70.0, 5.0, 0.0)), Vec3::Zero());
        mapping.update(at(Vec3(-70.0, 5.0, 0.0)));
        EXPECT_NEAR((mapping.to_scene(Vec3(-70.0, 5.0, 0.0)) - before).norm(), 0.0, kRounding);
        EXPECT_NEAR((mapping.to_scene(Vec3(60.0, 5.0, 0.0)) - Vec3(200.0, 0.0, 0.0)).norm(), 0.0, kRounding)
            << "three strokes of the device reach the far side of 400 mm";
    }

    TEST(DeviceMapping, ScalesASmallDeviceOverALargeWorkspace)
    {
        EXPECT_NEAR(scale_to_cover(Workspace {}, 400.0), 400.0 / 70.0, kRounding);
        EXPECT_DOUBLE_EQ(scale_to_cover(Workspace { Vec3::Zero(), Vec3::Constant(500.0) }, 400.0), 1.0);
        EXPECT_NE(test_support::message_of([] {
            scale_to_cover({ Vec3::Zero(), Vec3::Zero() }, 400.0);
        }).find("workspace: "),
            std::string::npos);
    }

    TEST(DeviceMapping, AFrameTellsWhereADeviceStands)
    {
        const Workspace workspace { Vec3(-80.0, -60.0, -35.0), Vec3(80.0, 80.0, 35.0) },
            another { Vec3::Zero(), Vec3::Ones() };
        MappingOptions options { .scene_centre = Vec3(10.0, -20.0, 300.0),
            .scene_from_device = Eigen::AngleAxisd(0.7, Vec3(1.0, 2.0, -1.0).normalized()).toRotationMatrix(),
            .scale = 2.5,
            .clutch_buttons = 4 };
        for (const bool mirrored : { false, true }) {
            options.mirrored = mirrored;
            const DeviceMapping mapping(options, workspace);
            const SceneFrame frame = mapping.frame(Vec3::Zero());
            const MappingOptions back = mapping_of(frame, another);
            const DeviceMapping again(back, another);
            for (const Vec3& p : { Vec3(0.0, 0.0, 0.0), Vec3(3.0, -7.0, 11.0) }) {
                EXPECT_LE((frame.linear * p + frame.offset - mapping.to_scene(p)).norm(), 1e3 * kRounding);
                EXPECT_LE((again.to_scene(p) - mapping.to_scene(p)).norm(), 1e3 * kRounding);
            }
            EXPECT_EQ(back.mirrored, mirrored);
            EXPECT_EQ(back.clutch_buttons, 4u);
        }
        SceneFrame skewed;
        skewed.linear(0, 1) = 0.1;
        EXPECT_NE(test_support::message_of([&] { mapping_of(skewed, another); }).find("no rotation times a scale"),
            std::string::npos);
    }

    TEST(DeviceMapping, AFrameTellsWhereTheClutchHasLeftIt)
    {
        const Workspace workspace { Vec3(-80.0, -60.0, -35.0), Vec3(80.0, 80.0, 35.0) };
        const MappingOptions options { .scene_centre = Vec3(10.0, -20.0, 300.0), .scale = 2.5, .clutch_buttons = 4 };
        DeviceMapping mapping(options, workspace);
        const auto update = [](DeviceMapping& moved, const Vec3& position, std::uint32_t buttons) {
            moved.update({ .position = position, .buttons = buttons });
            return moved.to_scene(position);
        };
        const Vec3 a(1.0, 2.0, 3.0), b(-30.0, 20.0, 5.0), c(12.0, 0.0, -8.0);
        update(mapping, a, 4);
        const Vec3 held = update(mapping, b, 4);
        EXPECT_EQ(held, mapping.to_scene(a));
        // One that begins while the clutch is held, and one that begins when it was let go.
        DeviceMapping begun_held(mapping_of(mapping.frame(b), workspace), workspace);
        EXPECT_LE((update(begun_held, b, 4) - held).norm(), 1e3 * kRounding);
        update(mapping, c, 0);
        DeviceMapping begun_after(mapping_of(mapping.frame(c), workspace), workspace);
        for (const Vec3& p : { c, a, b }) {
            const Vec3 there = update(mapping, p, 0);
            EXPECT_LE((update(begun_held, p, 0) - there).norm(), 1e3 * kRounding);
            EXPECT_LE((update(begun_after, p, 0) - there).norm(), 1e3 * kRounding);
            EXPECT_GT((DeviceMapping(options, workspace).to_scene(p) - there).norm(), 1.0);
        }
    }

    TEST(DeviceMapping, RefusesWhatIsNoRotationOrNoScale)
    {
        const auto message = [](const MappingOptions& options) {
            return test_support::message_of([&] { DeviceMapping(options, Workspace {}); });
        };
        EXPECT_EQ(message({ .scene_from_device = Vec3(-1.0, 1.0, 1.0).asDiagonal() }),
            "scene_from_device: the device's orientation in the scene is no rotation");
        EXPECT_EQ(message({ .scale = 0.0 }), "scale: the scale must be positive");
        EXPECT_EQ(message({ .force_scale = NAN }), "force_scale: the force scale must be positive");
        EXPECT_EQ(message({ .scene_centre = Vec3(0.0, NAN, 0.0) }), "scene_centre: the centre is not finite");
    }

} // namespace device_mapping_test
} // namespace retractor::haptics

#pragma once
// Maps a device's frame to the scene's and back: rotation, mirroring (left and right hands), scale, and a clutch for
// scenes larger than the device's workspace. Units mm, N.

#include "haptics/device/device.h"
#include "haptics/servo/tissue_response.h"

namespace retractor::haptics {

struct MappingOptions {
    Vec3 scene_centre = Vec3::Zero(); ///< place of the workspace's middle in the scene, mm
    Mat3 scene_from_device = Mat3::Identity(); ///< a rotation
    bool mirrored = false; ///< reverses x, so that a left hand performs what a right hand shows
    double scale = 1.0; ///< scene mm per device mm
    double force_scale = 1.0; ///< device N per scene N
    /// While any of these buttons is pressed, the device moves and the tip in the scene stands still.
    std::uint32_t clutch_buttons = 2;
};

/// Rotation that turns the device's up (its y axis) to the outward direction of the body.
/// @param outward of any length but zero
Mat3 standing_on(const Vec3& outward);

/// Options that map a device with this workspace by `frame`. @throws InputError as problem_of()
MappingOptions mapping_of(const SceneFrame& frame, const Workspace& workspace);

/// Scale (scene mm per device mm) at which the device's narrowest side covers `extent` mm; 1 when that side is wide
/// enough.
double scale_to_cover(const Workspace& workspace, double extent);

/// The mapping of one device. Servo thread only; allocates nothing.
class DeviceMapping {
public:
    /// @throws InputError when scene_from_device is no rotation, or a scale is not positive and finite
    DeviceMapping(const MappingOptions& options, const Workspace& workspace);

    /// Follows the clutch. Call once per tick, before the other functions.
    void update(const DeviceReading& reading) noexcept;
    [[nodiscard]] Vec3 to_scene(const Vec3& position) const noexcept;
    /// Zero while the clutch is pressed.
    [[nodiscard]] Vec3 velocity_to_scene(const Vec3& velocity) const noexcept;
    /// Rotates and mirrors, but never scales, a direction fixed to the device's tool, such as the offset of a finger on
    /// a hand.
    [[nodiscard]] Vec3 direction_to_scene(const Vec3& direction) const noexcept;
    [[nodiscard]] Vec3 force_to_device(const Vec3& force) const noexcept;
    [[nodiscard]] bool clutched() const noexcept { return clutched_; }
    /// The present frame, including all motion of the clutch. While the clutch is pressed, the frame takes `position`
    /// to the held tip. A mapping that starts with this frame and a pressed clutch continues like this mapping.
    /// @param position position of the device, mm
    [[nodiscard]] SceneFrame frame(const Vec3& position) const noexcept;
    /// Device stiffness (N/mm) when the scene renders 1 N/mm; the same ratio holds for damping.
    [[nodiscard]] double stiffness_gain() const noexcept { return options_.scale * options_.force_scale; }
    [[nodiscard]] const MappingOptions& options() const noexcept { return options_; }

private:
    MappingOptions options_;
    Mat3 turn_; ///< rotation with mirror
    Vec3 device_zero_; ///< device position that corresponds to scene_zero_
    Vec3 scene_zero_;
    Vec3 held_ = Vec3::Zero();
    bool clutched_ = false;
};

} // namespace retractor::haptics

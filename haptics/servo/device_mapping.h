#pragma once
// From a device's frame to the scene's and back: turning, mirroring (left and right hands), scaling, and a clutch for
// work spaces larger than the device's.

#include "haptics/device/device.h"
#include "haptics/servo/tissue_response.h"

#include <string>

namespace retractor::haptics {

struct MappingOptions {
    Vec3 scene_centre = Vec3::Zero(); ///< where the middle of the device's workspace lies in the scene, mm
    Mat3 scene_from_device = Mat3::Identity(); ///< a rotation
    bool mirrored = false; ///< x is turned round: a left hand does what a right hand shows
    double scale = 1.0; ///< scene mm per device mm
    double force_scale = 1.0; ///< device N per scene N
    std::uint32_t clutch_buttons
        = 2; ///< while any of these is down, the device moves and the tip in the scene does not
};

/// Options that map a device of this workspace as the frame says. @throws InputError as problem_of()
MappingOptions mapping_of(const SceneFrame& frame, const Workspace& workspace);

/// Scene mm per device mm that carry the device's narrowest side over `extent` mm; 1 when it already is as wide.
double scale_to_cover(const Workspace& workspace, double extent);

/// One device's way into the scene. Servo thread only; allocates nothing.
class DeviceMapping {
public:
    /// @throws InputError when scene_from_device is no rotation, or a scale is not positive and finite
    DeviceMapping(const MappingOptions& options, const Workspace& workspace);

    /// Call once per tick, before the others: follows the clutch.
    void update(const DeviceReading& reading) noexcept;
    [[nodiscard]] Vec3 to_scene(const Vec3& position) const noexcept;
    /// Zero while the clutch holds the tip.
    [[nodiscard]] Vec3 velocity_to_scene(const Vec3& velocity) const noexcept;
    /// Of a direction fixed to the device's tool, such as a finger's place on a hand: turned and mirrored, never
    /// scaled.
    [[nodiscard]] Vec3 direction_to_scene(const Vec3& direction) const noexcept;
    [[nodiscard]] Vec3 force_to_device(const Vec3& force) const noexcept;
    [[nodiscard]] bool clutched() const noexcept { return clutched_; }
    /// As it is now, whatever the clutch did before. @param position the device's: where the clutch holds the tip it
    /// lies on that, and a mapping that begins with this frame and the clutch held goes on as this one.
    [[nodiscard]] SceneFrame frame(const Vec3& position) const noexcept;
    /// Device stiffness (N/mm) felt when the scene renders 1 N/mm; of damping as well.
    [[nodiscard]] double stiffness_gain() const noexcept { return options_.scale * options_.force_scale; }
    [[nodiscard]] const MappingOptions& options() const noexcept { return options_; }

private:
    MappingOptions options_;
    Mat3 turn_; ///< with the mirror
    Vec3 device_zero_; ///< the device's position that lies on scene_zero_
    Vec3 scene_zero_;
    Vec3 held_ = Vec3::Zero();
    bool clutched_ = false;
};

} // namespace retractor::haptics

#include "haptics/servo/device_mapping.h"

#include "mesh/base/error.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace retractor::haptics {

namespace {

    void check(const MappingOptions& options)
    {
        const Mat3& turn = options.scene_from_device;
        const double error = (turn * turn.transpose() - Mat3::Identity()).cwiseAbs().maxCoeff();
        if (!(error < kRotationTolerance) || !(turn.determinant() > 0.0))
            throw InputError("the device's orientation in the scene is no rotation", "scene_from_device");
        if (!(options.scale > 0.0) || !std::isfinite(options.scale))
            throw InputError("the scale must be positive", "scale");
        if (!(options.force_scale > 0.0) || !std::isfinite(options.force_scale))
            throw InputError("the force scale must be positive", "force_scale");
        if (!options.scene_centre.allFinite())
            throw InputError("the centre is not finite", "scene_centre");
    }

} // namespace

double scale_to_cover(const Workspace& workspace, double extent)
{
    const double narrowest = (workspace.high - workspace.low).minCoeff();
    if (!(narrowest > 0.0) || !(extent > 0.0))
        throw InputError("the workspace is empty", "workspace");
    return std::max(1.0, extent / narrowest);
}

Mat3 standing_on(const Vec3& outward)
{
    return Eigen::Quaterniond::FromTwoVectors(Vec3::UnitY(), outward).toRotationMatrix();
}

MappingOptions mapping_of(const SceneFrame& frame, const Workspace& workspace)
{
    if (const std::string problem = problem_of(frame); !problem.empty())
        throw InputError(problem, "scene_from_device");
    MappingOptions options;
    options.scale = std::cbrt(std::abs(frame.linear.determinant()));
    options.mirrored = frame.linear.determinant() < 0.0;
    options.scene_from_device = frame.linear / options.scale;
    if (options.mirrored)
        options.scene_from_device.col(0) = -options.scene_from_device.col(0);
    options.scene_centre = frame.linear * (0.5 * (workspace.low + workspace.high)) + frame.offset;
    options.clutch_buttons = frame.clutch_buttons;
    return options;
}

DeviceMapping::DeviceMapping(const MappingOptions& options, const Workspace& workspace)
    : options_(options)
    , turn_(options.scene_from_device)
    , device_zero_(0.5 * (workspace.low + workspace.high))
    , scene_zero_(options.scene_centre)
{
    check(options);
    if (options.mirrored)
        turn_.col(0) = -turn_.col(0);
}

void DeviceMapping::update(const DeviceReading& reading) noexcept
{
    const bool clutch = (reading.buttons & options_.clutch_buttons) != 0;
    if (clutch && !clutched_)
        held_ = to_scene(reading.position);
    if (!clutch && clutched_) {
        device_zero_ = reading.position;
        scene_zero_ = held_;
    }
    clutched_ = clutch;
}

Vec3 DeviceMapping::to_scene(const Vec3& position) const noexcept
{
    return clutched_ ? held_ : Vec3(scene_zero_ + options_.scale * (turn_ * (position - device_zero_)));
}

SceneFrame DeviceMapping::frame(const Vec3& position) const noexcept
{
    const Mat3 linear = options_.scale * turn_;
    const Vec3 offset = clutched_ ? Vec3(held_ - linear * position) : Vec3(scene_zero_ - linear * device_zero_);
    return { linear, offset, options_.clutch_buttons };
}

Vec3 DeviceMapping::velocity_to_scene(const Vec3& velocity) const noexcept
{
    return clutched_ ? Vec3(Vec3::Zero()) : Vec3(options_.scale * (turn_ * velocity));
}

Vec3 DeviceMapping::direction_to_scene(const Vec3& direction) const noexcept { return turn_ * direction; }

Vec3 DeviceMapping::force_to_device(const Vec3& force) const noexcept
{
    return options_.force_scale * (turn_.transpose() * force);
}

} // namespace retractor::haptics

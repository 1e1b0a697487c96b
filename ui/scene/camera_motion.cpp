#include "ui/scene/camera_motion.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace retractor::ui {

namespace {

    constexpr double kRadPerDeg = std::numbers::pi / 180.0;

    /// Right, up and back of a camera as columns.
    Eigen::Matrix3d axes_of(const Camera& camera)
    {
        Eigen::Matrix3d axes;
        axes.col(2) = (camera.eye - camera.aim).normalized();
        axes.col(0) = camera.up.cross(axes.col(2)).normalized();
        axes.col(1) = axes.col(2).cross(axes.col(0));
        return axes;
    }

} // namespace

double eased(double share) { return share * share * (3.0 - 2.0 * share); }

Camera camera_between(const Camera& from, const Camera& to, double share)
{
    const Eigen::Quaterniond first(axes_of(from)), last(axes_of(to));
    const Eigen::Matrix3d axes = first.slerp(share, last).toRotationMatrix();
    const double near = (from.eye - from.aim).norm(), far = (to.eye - to.aim).norm();
    Camera camera = to;
    camera.aim = (1.0 - share) * from.aim + share * to.aim;
    camera.eye = camera.aim + std::pow(near, 1.0 - share) * std::pow(far, share) * axes.col(2);
    camera.up = axes.col(1);
    const double first_tan = std::tan(0.5 * from.view_angle_deg * kRadPerDeg),
                 last_tan = std::tan(0.5 * to.view_angle_deg * kRadPerDeg);
    camera.view_angle_deg = 2.0 * std::atan((1.0 - share) * first_tan + share * last_tan) / kRadPerDeg;
    return camera;
}

Camera turned_round_aim(const Camera& camera, double deg)
{
    Camera turned = camera;
    turned.eye
        = camera.aim + Eigen::AngleAxisd(deg * kRadPerDeg, camera.up.normalized()) * Vec3(camera.eye - camera.aim);
    return turned;
}

Camera moved_alike(const Camera& camera, const Camera& before, const Camera& after)
{
    const Eigen::Matrix3d axes = axes_of(camera), before_axes = axes_of(before);
    const Eigen::Matrix3d turned = axes * before_axes.transpose() * axes_of(after);
    const double distance = (camera.eye - camera.aim).norm(), before_distance = (before.eye - before.aim).norm();
    Camera moved = camera;
    moved.aim += axes * before_axes.transpose() * (after.aim - before.aim) * distance / before_distance;
    moved.eye = moved.aim + distance * (after.eye - after.aim).norm() / before_distance * turned.col(2);
    moved.up = turned.col(1);
    moved.view_angle_deg *= after.view_angle_deg / before.view_angle_deg;
    moved.half_height_mm *= after.half_height_mm / before.half_height_mm;
    return moved;
}

Camera endoscope_camera(const Camera& camera, double from_aim_mm, double optics_deg, double turned_deg)
{
    const Eigen::Matrix3d axes = axes_of(camera);
    const Vec3 along = -axes.col(2);
    const Eigen::AngleAxisd turn(turned_deg * kRadPerDeg, along);
    const Vec3 up = turn * Vec3(axes.col(1)), right = along.cross(up);
    const Eigen::AngleAxisd tilt(optics_deg * kRadPerDeg, right); // towards up
    const double before = std::min(from_aim_mm, (camera.aim - camera.eye).norm());
    Camera tip = camera;
    tip.eye = camera.aim - before * along;
    tip.aim = tip.eye + before * (tilt * along);
    tip.up = tilt * up;
    tip.view_angle_deg = kEndoscopeViewDeg;
    tip.parallel = false;
    return tip;
}

} // namespace retractor::ui

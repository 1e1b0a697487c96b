#pragma once
// What a fingertip pad feels where it is pressed in, from the compliance of the stations under it. Units mm, N.

#include "haptics/condensed/touch_surface.h"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace retractor::haptics {

/// ContactNodes near each other, and all that pads on any of them press (they are among those).
struct PadGroup {
    std::vector<std::int32_t> middles, pressed;
};

/// Every station is a middle once.
std::vector<PadGroup> pad_groups(const TouchSurface& surface, double radius);

/// Sum of the forces, per mm, of a pad pressed on the middle of a station: all within its radius give way alike as far
/// as that takes pushing (FingertipShape::pad), each along its own normal. @param compliance of the group's pressed
/// stations along their normals, mm/N.
double pad_stiffness(const TouchSurface& surface, std::int32_t middle, double radius,
    const std::vector<std::int32_t>& pressed, const Eigen::MatrixXd& compliance);

} // namespace retractor::haptics

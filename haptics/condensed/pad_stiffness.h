#pragma once
// The stiffness that a fingertip pad feels, from the compliance of the contact nodes under the pad. Units mm, N.

#include "haptics/condensed/touch_surface.h"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace retractor::haptics {

/// Contact nodes near each other (`middles`), and all contact nodes that pads on them press (`pressed`, which contains
/// `middles`).
struct PadGroup {
    std::vector<std::int32_t> middles, pressed;
};

/// Divides the contact nodes into groups. Every contact node is a middle of exactly one group.
std::vector<PadGroup> pad_groups(const TouchSurface& surface, double radius);

/// Force per mm of a pad pressed on a contact node, N/mm. All contact nodes within the radius move by the same depth as
/// far as this takes pushing (FingertipShape::pad), each along its own normal.
/// @param compliance of the group's pressed contact nodes along their normals, mm/N
double pad_stiffness(const TouchSurface& surface, std::int32_t middle, double radius,
    const std::vector<std::int32_t>& pressed, const Eigen::MatrixXd& compliance);

} // namespace retractor::haptics

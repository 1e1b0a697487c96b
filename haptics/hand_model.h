#pragma once
// A hand to be shown at the proxies: palm, thumb and four fingers from rounded bones, made here, so that no file is
// needed. Units mm. Its own frame: the middle finger points along +y, the palm looks along -z, the thumb of a right
// hand lies towards -x.

#include "mesh/geometry.h"

#include <array>
#include <span>

namespace retractor {

struct HandModel {
    TriMesh surface; ///< closed, oriented outwards
    std::array<Vec3, 5> tips; ///< centres of the fingertips: thumb, fore, middle, ring and little finger
    std::array<double, 5> tip_radius {};
};

/// Half bent, as for a grasp with thumb, forefinger and middle finger. @param length_mm from wrist to the stretched
/// middle fingertip, 100 to 260. @throws InputError otherwise.
HandModel make_hand(bool left, double length_mm = 180.0);

/// Moves the hand as a rigid body so that its first fingertips come as near as they can (least squares) to the given
/// ones: one point moves it only, two turn it too, three fix it. @throws InputError unless there are
/// 1 to 5 points, finite and apart from each other
HandModel placed_hand(const HandModel& hand, std::span<const Vec3> tips);

} // namespace retractor

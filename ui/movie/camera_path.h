#pragma once
// Motions of a camera between two places, and round what it looks at. Units mm, degrees.

#include "ui/scene/scene.h"

namespace retractor::ui {

/// A camera on the way from one to another, at `share` from 0 to 1 of the way. The line of sight and the up vector turn
/// evenly, the distance changes by the same factor in equal steps, and the aim moves straight. Both have perspective.
/// @pre the lines of sight do not point against each other
Camera camera_between(const Camera& from, const Camera& to, double share);

/// The camera turned about its aim, round its up vector.
Camera turned_round_aim(const Camera& camera, double deg);

/// 0 at 0, 1 at 1, and at rest at both ends.
double eased(double share);

} // namespace retractor::ui

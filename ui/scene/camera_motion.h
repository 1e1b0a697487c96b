#pragma once
// Motions of a camera: between two places, round what it looks at, and alike with another camera. Units mm, degrees.

#include "ui/scene/scene.h"

namespace retractor::ui {

/// A camera on the way from one to another, at `share` from 0 to 1 of the way. The line of sight and the up vector turn
/// evenly, the distance changes by the same factor in equal steps, and the aim moves straight. Both have perspective.
/// @pre the lines of sight do not point against each other
Camera camera_between(const Camera& from, const Camera& to, double share);

/// The camera turned about its aim, round its up vector.
Camera turned_round_aim(const Camera& camera, double deg);

/// The camera moved as another one moved: turned and shifted alike in its own picture, its distance changed by the same
/// factor.
Camera moved_alike(const Camera& camera, const Camera& before, const Camera& after);

/// What an endoscope shows whose shaft lies on a camera's line of sight, with its tip before the aim. The optics look
/// off the shaft by an angle, towards the camera's up vector turned about the shaft (seen along the shaft, clockwise).
/// @param from_aim_mm distance of the tip from the aim; the tip does not come before the camera's eye
Camera endoscope_camera(const Camera& camera, double from_aim_mm, double optics_deg, double turned_deg = 0.0);
/// Angle over the picture's height that endoscopes for the chest show, degrees (ours: makers give 70 to 85).
inline constexpr double kEndoscopeViewDeg = 75.0;

/// 0 at 0, 1 at 1, and at rest at both ends.
double eased(double share);

} // namespace retractor::ui

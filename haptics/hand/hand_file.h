#pragma once
// A hand to be shown, from a Wavefront OBJ file: a right hand in mm as hand_model.h lays it (the middle finger along
// +y, the palm looking along -z, the thumb towards -x), the faces of each fingertip in a group or object of its own:
// fingertip-1 (thumb) to fingertip-5 (little finger).

#include "haptics/hand/hand_model.h"

#include <filesystem>

namespace retractor::haptics {

/// @param left the mirror image. @throws IoError when it cannot be read; InputError as read_obj_surface(), when a
/// fingertip is not named, and when it is not of a hand's size.
HandModel read_hand(const std::filesystem::path& path, bool left);

} // namespace retractor::haptics

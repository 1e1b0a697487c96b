#pragma once
// Reads a hand to show from a Wavefront OBJ file. The file contains a right hand in mm, in the frame of hand_model.h
// (middle finger along +y, palm facing -z, thumb towards -x). The faces of each fingertip form a group or object:
// fingertip-1 (thumb) to fingertip-5 (little finger).

#include "haptics/hand/hand_model.h"

#include <filesystem>

namespace retractor::haptics {

/// @param left gives the mirror image
/// @throws IoError when the file cannot be read; InputError as read_obj_surface(), when the name of a fingertip is
/// missing, and when the size is not that of a hand
HandModel read_hand(const std::filesystem::path& path, bool left);

} // namespace retractor::haptics

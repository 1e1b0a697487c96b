#pragma once
// Files of motion recordings. The two formats, binary and CSV, are described in haptics/README.md.

#include "haptics/recording/motion_recording.h"

#include <filesystem>

namespace retractor::haptics {

/// Writes binary, or CSV when the name ends in .csv. Replaces what was there, atomically.
/// @throws IoError naming the path; InputError when counts do not fit each other
void write_motion(const std::filesystem::path& path, const MotionRecording& recording);
/// Either format, told by its first bytes.
/// @throws IoError when it cannot be read; InputError naming the file and the line or byte when it is none of ours, of
/// a later version, cut off, damaged, or has numbers that are not finite, poses beyond pose_check.h, or times that do
/// not increase
MotionRecording read_motion(const std::filesystem::path& path);

} // namespace retractor::haptics

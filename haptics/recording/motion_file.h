#pragma once
// Files of motion recordings in two formats, binary and CSV; docs/method/haptics.md describes both.

#include "haptics/recording/motion_recording.h"

#include <filesystem>

namespace retractor::haptics {

/// Writes CSV when the name ends in .csv, else binary. Replaces an existing file atomically.
/// @throws IoError naming the path; InputError when the counts of the recording do not match
void write_motion(const std::filesystem::path& path, const MotionRecording& recording);
/// Reads either format; the first bytes tell which.
/// @throws IoError when the file cannot be read; InputError naming the file and the line or byte when the file has
/// another format or a later version, is cut off or damaged, or has numbers that are not finite, poses beyond
/// pose_check.h, or times that do not increase
MotionRecording read_motion(const std::filesystem::path& path);

} // namespace retractor::haptics

#pragma once
// The two formats of motion_file.h in memory; docs/method/haptics.md describes both.

#include "haptics/recording/motion_recording.h"

#include <string>
#include <string_view>

namespace retractor::haptics {

std::string motion_to_binary(const MotionRecording& recording);
std::string motion_to_csv(const MotionRecording& recording);
bool is_binary_motion(std::string_view content);
/// @param where file name for messages. @throws InputError as read_motion()
MotionRecording motion_from_binary(std::string_view content, const std::string& where);
MotionRecording motion_from_csv(std::string_view content, const std::string& where);

} // namespace retractor::haptics

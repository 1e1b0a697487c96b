#pragma once
// Small parsers for option values of several commands. All parsers throw InputError with the text in the message.

#include "mesh/base/geometry.h"
#include "planner/case/approach.h"
#include "planner/case/solver_settings.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace retractor::ui::cli {

/// Parses "x,y,z": exactly `count` finite numbers.
std::vector<double> parse_numbers(const std::string& text, std::size_t count, const std::string& where);
Vec3 parse_point(const std::string& text, const std::string& where);
/// Parses a label name, or "x,y,z,r" for a sphere (mm, patient LPS).
planner::TargetSpec parse_target(const std::string& text);
/// Parses "label:from,to[:along_from,along_to]" for a segment (mm across and along the incision), or
/// "ball:x,y,z,radius[:label]". The caller checks whether the label exists and the incision is long enough.
planner::AblationSpec parse_ablation(const std::string& text);
/// Parses "1280x960".
std::pair<int, int> parse_size(const std::string& text);
/// Parses "15%", "15%,2" (share of the force, mm of the opening), or "none": no accuracy is asked.
/// @param otherwise what the text leaves out; ranges are not checked (planner::check_accuracy())
std::optional<planner::AccuracyGoal> parse_accuracy(const std::string& text, const planner::AccuracyGoal& otherwise);
/// Parses one number or two, "60" or "60-180"; one stands for both.
std::pair<double, double> parse_span(const std::string& text, const std::string& where);
/// Parses intercostal spaces, "4" or "3-6", of the option --spaces. The caller checks their range.
std::pair<int, int> parse_spaces(const std::string& text);
/// Splits "a,b,c" at the separator.
std::vector<std::string> split(const std::string& text, char separator);

} // namespace retractor::ui::cli

#pragma once
// Words about the tissue values that a plan was made with: the moduli of ribs and cartilages, and what the ranges of
// the values do to force and opening. Units MPa, mm, N.

#include "planner/anatomy/bone_stiffness.h"
#include "planner/measures/field_metrics.h"

#include <span>
#include <string>
#include <vector>

namespace retractor::planner {

/// The moduli of the labels that a wall contains.
std::vector<BoneStiffness> bones_in_wall(std::span<const BoneStiffness> bones, std::span<const Label> in_wall);

/// Names the bones whose modulus was cut off. Empty without any.
std::string cut_off_text(std::span<const BoneStiffness> bones);

/// One line for people: "ribs 3.4 to 6.1 GPa (7 of 8 by their sections in the CT), costal cartilages 34 MPa (CT)".
/// Empty without bones.
std::string bone_stiffness_text(const FieldMetrics& field);

/// The tissues that decide: those with at least a tenth of the variance, three at most, the largest first.
std::vector<std::string> deciding_parameters(const ParameterInterval& interval);

/// One line for people: "tissue values: force 120 to 310 N, opening 57 to 59 mm; decided by cartilage, intercostal", or
/// the reason why there is no interval. Empty where there is none to be had.
std::string parameter_text(const FieldMetrics& field);

/// The whole answer in one line: "197 N; mesh: +- 9 N; tissue values: 120 to 310 N; decided by cartilage, intercostal".
/// Empty without an interval.
std::string force_with_intervals(const FieldMetrics& field);

} // namespace retractor::planner

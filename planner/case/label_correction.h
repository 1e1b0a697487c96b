#pragma once
// Renames and joins labels in everything that a case says of them, and confirms labels that were estimated.

#include "planner/case/case.h"

#include <string>

namespace retractor::planner {

/// Gives a label another name: in the table, the marks, the supports, the pressures and the approaches.
/// @throws InputError when there is no such label, or when the new name is taken or empty; the case is then unchanged
void rename_label(Case& planned_case, const std::string& name, const std::string& new_name);

/// @throws InputError unless a name is made of letters, digits, "_", "-", "." and "+", and begins with a letter or a
/// digit; a comma, a colon or a space would part it in options
void check_label_name(const std::string& name);

/// Takes a label out of the table, and lets the other one stand wherever it was named. The voxels are joined by
/// datasets::joined().
/// @throws InputError when one of the labels is missing, or both are the same; when one of them is wall and the other
/// is not, or both are wall of different materials; or when an approach that looks at the label holds the other one
/// aside. The case is then unchanged.
void join_label(Case& planned_case, const std::string& name, const std::string& into);

/// Somebody has looked at an estimated label and found it right, or made it right.
/// @throws InputError when there is no such label, or when it is not estimated
void confirm_label(Case& planned_case, const std::string& name);

} // namespace retractor::planner

#pragma once
// Finds numbers of a case that no tissue and no operation has: most of them are slips of units (kPa for MPa, m for mm).
// The ranges are wide on purpose: what is published, widened severalfold, or ours where nothing is published. The
// source of each range stands in plausible_input.cpp; docs/user/case-json.md lists the ranges. Units mm, N, MPa, kPa.

#include "mesh/image/volume.h"
#include "planner/case/approach.h"
#include "planner/case/case.h"

#include <optional>
#include <string>
#include <vector>

namespace retractor::planner {

/// A number out of its plausible range.
struct ImplausibleValue {
    std::string pointer; ///< JSON pointer of the number
    /// "the depth of the cut is 0.04 mm, and 1 to 400 mm is plausible: is it in m (40 mm)?"
    std::string text;
};

/// The implausible numbers of the case's materials and pressures. The approaches are not looked at.
std::vector<ImplausibleValue> find_implausible(const Case& planned_case);

/// The implausible numbers of an approach: incision, depth, hooks and eyes.
/// @param pointer JSON pointer of the approach, put before the keys
std::vector<ImplausibleValue> find_implausible(const Approach& approach, const std::string& pointer = {});

/// @pre check_case() accepts the case
/// @throws InputError naming the first implausible number of the case or of its approaches, unless the case accepts
/// such numbers (Case::accept_implausible)
void check_plausible(const Case& planned_case);

/// The same for an approach that need not belong to the case yet.
void check_plausible(const Case& planned_case, const Approach& approach, const std::string& pointer = {});

/// A sentence on an image whose longest side is shorter than 50 mm or longer than 3 m; nothing for a plausible image.
std::optional<std::string> implausible_extent(const mesh::ImageGrid& grid);

} // namespace retractor::planner

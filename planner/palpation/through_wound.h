#pragma once
// What a finger meets that is put through the opened wound of a plan: the structure that it palpates, and everything
// round it that stops the finger. Units mm; frame patient LPS.

#include "mesh/base/job.h"
#include "mesh/surface/named_surface.h"
#include "planner/case/patient.h"
#include "planner/palpation/palpable.h"
#include "planner/plan/planned_field.h"

#include <string>
#include <vector>

namespace retractor::planner {

struct PalpableThroughWound {
    Palpable palpable;
    std::vector<std::string> structure; ///< labels of which it is made
    /// Everything that stops a finger, by the names that people know: the opened wall, blades, and the organs that stay
    /// where they are, as rigid surfaces. They also block the view, but for the target.
    std::vector<mesh::NamedSurface> around;
};

/// The labels that are palpated with an approach: the label of the target, or in which a spherical target lies; with a
/// vessel also the vessels that touch it, because a finger feels them as one.
/// @throws InputError where a spherical target lies in no organ
std::vector<std::string> palpated_structure(const Approach& approach, Patient& patient);

/// @param field opened, with its remaining wall
/// @param structure labels, usually palpated_structure()
/// @throws as make_palpable() and Patient::organ()
PalpableThroughWound make_palpable_through(
    const PlannedField& field, Patient& patient, const std::vector<std::string>& structure, const Job& job = {});

} // namespace retractor::planner

#pragma once
// Compares the opening, the force and the speed of opening of a field with the retractions in which tissue ruptured.
// Units mm, N.
//
// In 24 thoracotomies held open by a Finochietto rib spreader (7 live pigs, 17 fresh carcasses), tissue ruptured in
// half, always beyond 30 mm and 122.5 N, and in nearly all that were faster than half a turn of the crank in 10 s
// (Chanoit 2019, BioMed Eng OnLine 18:45, doi 10.1186/s12938-019-0664-z).
// These are the smallest values at which a rupture was seen, not limits of what tissue bears.

#include "planner/measures/field_metrics.h"

#include <string>

namespace retractor::planner {

inline constexpr double kRuptureOpeningMm = 30.0, kRuptureForceN = 122.5;
/// What the study says, for those who read no table.
inline constexpr const char* kRuptureSentence
    = "Rib spreaders ruptured tissue in half of 24 pigs (17 of them carcasses), always beyond 30 mm and 122.5 N.";

/// Whether hooks open the wound farther than 30 mm with more than 122.5 N on a side. Never where all hooks bear on the
/// sternum, which is parted by its saw cut: the retractions were those of ribs. The force is that of the plan, or that
/// at the last turn where this is larger.
bool may_rupture(const FieldMetrics& field);

/// "45.0 mm and 203 N: beyond 30 mm and 122.5 N tissue ruptured in half of 24 retractions ..."; empty below.
std::string rupture_text(const FieldMetrics& field);

/// "half a turn of the crank (7 mm) every 5 s: ..."; empty where the crank turns no faster than half a turn in 10 s,
/// and where the sternum is parted.
std::string fast_opening_text(const FieldMetrics& field);

} // namespace retractor::planner

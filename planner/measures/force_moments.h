#pragma once
// Names the moments of the force that holds a wound open: at the last turn of the crank, and minutes later. Units mm,
// N, s.
//
// The notes of the tissue table do not say how fast tissue was stretched. Its moduli are taken to belong to tissue
// that has been stretched for tens of seconds: neither to a sudden stretch nor to one of many minutes. A plan's
// force is therefore taken as the force at the last turn of a slow opening: by OpeningProtocol {}, half a turn of
// the crank every 10 s. The elastic force F_e of relaxation.h follows from it, and from F_e the force of every other
// opening and moment. On the way to the full opening F_e is taken to grow in proportion to the opening. All of this
// is ours.

#include "planner/case/opening_protocol.h"
#include "planner/measures/field_metrics.h"
#include "planner/measures/relaxation.h"

#include <optional>
#include <string>
#include <vector>

namespace retractor::planner {

/// The rises of an elastic force in the steps of the crank: equal rises, the first at 0 s. Their force is largest at
/// the last step. @pre check_opening_protocol() accepts the protocol
std::vector<ForceStep> crank_steps(const OpeningProtocol& protocol, double opening_mm, double elastic_N);

/// Force at the last turn, relative to the elastic force: between the long-term share and 1.
double last_turn_share(const Relaxation& relaxation, const OpeningProtocol& protocol, double opening_mm);

/// The moments of the force on the larger side. Not applicable, with the reason as message, where a hook pulls with a
/// given force, yields or grips softly, or the rack pushes with a given force: there the tissue creeps instead.
/// @param protocol not set: OpeningProtocol {}
/// @returns nothing where no hook pulls
std::optional<ForceMoments> compute_force_moments(
    const FieldMetrics& field, const std::optional<OpeningProtocol>& protocol);

/// "260 N at the last turn, about 49 N after 5 minutes (26 to 73 N between animals)". @pre without a message
std::string force_moments_cell(const ForceMoments& moments);

/// One line for people: the forces, their moments and the opening they belong to, or why there are none. Empty where no
/// hook pulls.
std::string force_moments_text(const FieldMetrics& field);

} // namespace retractor::planner

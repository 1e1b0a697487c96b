#pragma once
// The plans of a case step by step, for the team's case conference: for each approach where it cuts, the layers that
// the blade passes, what is cut, how the wound opens, what the surgeon sees and what she reaches; at the end the
// planned approaches beside each other. The window shows the steps one by one, a movie plays them.

#include "planner/case/case.h"
#include "planner/decision/decisions.h"
#include "planner/measures/field_metrics.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace retractor::planner {

/// What a step shows.
enum class PresentedView {
    patient, ///< there is no approach
    incision, ///< on the skin, before the cut
    blade, ///< slices along and across the incision, with the blade
    cut, ///< the cut as a sheet, through a see-through wall
    opened, ///< the opened patient from outside
    seen, ///< from the surgeon's eye
    reached, ///< the same view: what a finger and two instruments reach of the target
    kept, ///< from where the team kept a view
    comparison, ///< what the surgeon's eye sees through planned approaches, side by side
};

struct PresentationStep {
    PresentedView view = PresentedView::patient;
    std::optional<std::size_t> approach {}; ///< index in the case; nothing: the patient alone, or a comparison
    std::string title {}, text {}; ///< text: a few sentences; of a kept view it may be empty
    std::optional<NamedView> kept {}; ///< of a kept view
    std::vector<std::size_t> compared {}; ///< of a comparison: indices in the case, see compared_approaches()
};

/// What is known of an approach of the case.
struct PresentedApproach {
    const FieldMetrics* field = nullptr; ///< its plan; null: it is not planned
    bool has_slices = false; ///< along and across the incision
    std::vector<std::string> divided_bones {}; ///< labels of bones that the cut divides
};

/// At least one step. @pre one entry of `known` for each approach of the case
std::vector<PresentationStep> presentation_of(
    const Case& planned_case, const std::vector<PresentedApproach>& known, const Decisions& decisions);

} // namespace retractor::planner

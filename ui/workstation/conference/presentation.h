#pragma once
// The plans of a case step by step, for the team's case conference: for each approach where it cuts, what the blade
// passes, how the wound opens and what the surgeon sees; at the end all planned approaches beside each other.

#include "ui/workstation/planning/session_model.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace retractor::ui {

struct PresentationStep {
    std::optional<std::size_t> approach {}; ///< index in the model; nothing: the patient alone, or all approaches
    ViewPreset view = ViewPreset::overview;
    bool opened = false; ///< the opened field, or the patient before the cut
    std::string title {}, text {}; ///< text: one to three sentences
};

/// The steps of the model as it is now: at least one.
std::vector<PresentationStep> presentation_of(const SessionModel& model);

} // namespace retractor::ui

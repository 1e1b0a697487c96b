#pragma once
// The stages of long work in a surgeon's words. The libraries name their stages for those who develop them ("refine
// tetrahedra"); the window says what is done for the surgeon ("building the model of the wall").

#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace retractor::ui {

/// The stages that the libraries name, and their words.
std::span<const std::pair<std::string_view, std::string_view>> stages_and_words();

/// The stage in English words. Of the forecast in brackets that a plan adds, only the time stays.
/// @returns a stage that is not known unchanged
std::string stage_in_words(std::string_view stage);

} // namespace retractor::ui

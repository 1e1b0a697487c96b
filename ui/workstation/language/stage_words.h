#pragma once
// The stages of long work in a surgeon's words. The libraries name their stages for those who develop them ("refine
// tetrahedra"); the window says what is done for the surgeon ("building the model of the wall").

#include <string>
#include <string_view>

namespace retractor::ui {

/// The stage in English words. @returns a stage that is not known unchanged
std::string stage_in_words(std::string_view stage);

} // namespace retractor::ui

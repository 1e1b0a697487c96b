#pragma once
// The tissue models of this program, for the window.

#include "planner/session/palpation_session.h"

namespace retractor::ui {

planner::PalpationBackend palpation_backend();

} // namespace retractor::ui

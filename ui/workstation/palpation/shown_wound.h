#pragma once
// The opened patient round tissue that is palpated through a wound. Plain data.

#include "planner/palpation/palpable.h"
#include "planner/session/palpation_session.h"
#include "ui/scene/scene.h"

#include <vector>

namespace retractor::ui {

struct ShownWound {
    planner::Palpable palpable;
    Scene scene; ///< without the palpated structure; seen by the surgeon's best eye
    std::vector<planner::ThroughOpening> ways; ///< finger first
};

} // namespace retractor::ui

#pragma once
// Dragging hooks through nonlinear tissue near the wound, beside the fully nonlinear answer of the exact path.

#include "tests/benchmarks/opening/open_scene.h"
#include "ui/cli/framework/command.h"

namespace retractor::benchmarks {

/// The scene's whole stroke, its hooks dragged to their full displacement in 40 frames. Keys that begin with
/// nonlinear_, and final_ms: from the last frame to the converged answer of the whole body.
ui::cli::Json measure_nonlinear(const OpenScene& scene, const Job& job);

std::string nonlinear_text(const ui::cli::Json& row);

/// The thorax phantom's wall, cut along its whole median approach, its planned hooks dragged by 30 mm a side in 60
/// frames through what is nonlinear under the hand in the window (drag_options.h), beside the converged answers of the
/// same tissue: of the same zone, and of the whole wall. Keys as above.
ui::cli::Json measure_under_hand(const Job& job);

std::string under_hand_text(const ui::cli::Json& row);

} // namespace retractor::benchmarks

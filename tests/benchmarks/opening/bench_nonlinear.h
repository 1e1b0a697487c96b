#pragma once
// Dragging hooks through nonlinear tissue near the wound, compared with the fully nonlinear solution.

#include "tests/benchmarks/opening/open_scene.h"
#include "ui/cli/framework/command.h"

namespace retractor::benchmarks {

/// Measures the scene's whole stroke, with hooks dragged to their full displacement in 40 frames. The keys begin with
/// nonlinear_. final_ms is the time from the last frame to the converged answer of the whole body.
ui::cli::Json measure_nonlinear(const OpenScene& scene, const Job& job);

std::string nonlinear_text(const ui::cli::Json& row);

/// Measures the thorax phantom's wall, cut along its whole median approach. The planned hooks are dragged by 30 mm a
/// side in 60 frames through the nonlinear region that follows a hand in the window (drag_options.h). The frames are
/// compared with converged answers of the same tissue: with the same region, and with the whole wall nonlinear. Keys
/// as above.
ui::cli::Json measure_under_hand(const Job& job);

std::string under_hand_text(const ui::cli::Json& row);

} // namespace retractor::benchmarks

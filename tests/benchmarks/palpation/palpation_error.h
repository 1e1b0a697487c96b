#pragma once
// How wrong each kind of tissue is, beside what it costs: elements, springs and spheres as one solid block, pressed
// alike by a rigid fingertip, against ten-node elements on a finer mesh. Units mm, N, MPa.

#include "ui/cli/framework/command.h"

namespace retractor::benchmarks {

/// One row per tissue and size: `model`, `element`, `scene` ("block"), `vertices`, `fingers`, `force_us_mean`,
/// `force_us_p999`, `deform_ms_median`, `rel_diff_same_mesh` (springs: from four-node elements), `build_ms`,
/// `rel_error_vs_reference` (where nothing was calibrated), `rel_error_at_calibration` (in the block's middle),
/// `ticks`, `missed`; `calibration` and `note` where there are.
ui::cli::Json palpation_error_rows(std::size_t ticks, const Job& job);

} // namespace retractor::benchmarks

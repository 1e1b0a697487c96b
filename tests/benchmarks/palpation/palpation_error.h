#pragma once
// Error and cost of each kind of tissue: elements, springs and spheres as one solid block under the same rigid
// fingertip, compared with ten-node elements on a finer mesh. Units mm, N, MPa.

#include "ui/cli/framework/command.h"

namespace retractor::benchmarks {

/// One row per tissue and size, with the keys `model`, `element`, `scene` ("block"), `vertices`, `fingers`,
/// `force_us_mean`, `force_us_p999`, `deform_ms_median`, `rel_diff_same_mesh` (springs: difference from four-node
/// elements), `build_ms`, `rel_error_vs_reference` (at a site without calibration), `rel_error_at_calibration` (in
/// the block's middle), `ticks` and `missed`; `calibration` and `note` where present.
ui::cli::Json palpation_error_rows(std::size_t ticks, const Job& job);

} // namespace retractor::benchmarks

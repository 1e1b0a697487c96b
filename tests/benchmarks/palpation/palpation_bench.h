#pragma once
// Common parts of the benchmarks of springs and spheres: the rows of their table, and timing.

#include "haptics/servo/tissue_response.h"
#include "ui/cli/framework/command.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace retractor::benchmarks {

/// One row; a value that was not measured is null in the document.
struct PalpationRow {
    std::string model {}, scene {};
    std::size_t vertices = 0, fingers = 1;
    std::optional<double> force_us_mean {}, force_us_p999 {}, deform_ms_median {}, rel_diff_same_mesh {},
        rel_error_vs_reference {}, fps {}, fps_drawn {};
    std::size_t ticks = 0, missed = 0;
    std::string note {};
};
ui::cli::Json row_document(const PalpationRow& row);
std::string row_table(const std::vector<PalpationRow>& rows);

/// Writes the fingertips of a time into `fingers`.
using FingerScript = std::function<void(double time_s, std::span<haptics::Fingertip> fingers)>;

struct TickCost {
    double mean_us = 0.0, p999_us = 0.0, worst_us = 0.0;
    std::size_t ticks = 0;
    std::size_t missed = 0; ///< ticks that were still running, by the wall clock, when the next one was due
};

/// Runs ticks of a millisecond without pause and measures processor time per tick. Other load on the machine does not
/// affect the mean, but affects `missed`.
TickCost time_ticks(haptics::TissueResponse& tissue, const FingerScript& script, std::size_t ticks);

/// Result of run_live(), which runs ticks on a thread of its own every millisecond of the wall clock for some
/// seconds, and meanwhile calls `frame` on the calling thread without pause.
struct LiveRun {
    std::vector<double> fps; ///< frames in each second
    TickCost ticks;
};
LiveRun run_live(haptics::TissueResponse& tissue, const FingerScript& script, double seconds,
    const std::function<void(const Points& deformed)>& frame, const Job& job);

} // namespace retractor::benchmarks

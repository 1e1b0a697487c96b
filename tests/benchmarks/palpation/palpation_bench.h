#pragma once
// What the benches of springs and spheres share: a row of their table, and the clock they are held to.

#include "haptics/servo/tissue_response.h"
#include "ui/cli/framework/command.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace retractor::benchmarks {

/// One row; what was not measured is null in the document.
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

/// The fingers' places at a time.
using FingerScript = std::function<void(double time_s, std::span<haptics::Fingertip> fingers)>;

struct TickCost {
    double mean_us = 0.0, p999_us = 0.0, worst_us = 0.0;
    std::size_t ticks = 0;
    std::size_t missed = 0; ///< by the wall clock: still under way when the next was due
};

/// So many ticks of a millisecond as fast as they go; processor time per tick, so that what else the machine does is
/// left out of the mean, but not out of `missed`.
TickCost time_ticks(haptics::TissueResponse& tissue, const FingerScript& script, std::size_t ticks);

/// Ticks on a thread of their own every millisecond of the wall clock, while `frame` is called on this one as often as
/// it goes, for so long. @returns frames per second, one value per second.
struct LiveRun {
    std::vector<double> fps; ///< per second
    TickCost ticks;
};
LiveRun run_live(haptics::TissueResponse& tissue, const FingerScript& script, double seconds,
    const std::function<void(const Points& deformed)>& frame, const Job& job);

} // namespace retractor::benchmarks

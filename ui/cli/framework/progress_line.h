#pragma once
// Shows one line of progress with the remaining time on standard error. Nothing is shown when standard error is no
// terminal.

#include "mesh/base/job.h"

#include <mutex>
#include <string>
#include <string_view>

namespace retractor::ui::cli {

class ProgressLine {
public:
    ProgressLine();
    /// Safe to call from several threads. Redraws at most ten times a second.
    void update(std::string_view stage, double fraction);
    /// Clears the line for the next message.
    void clear();

private:
    bool enabled_ = false;
    std::mutex mutex_;
    std::string stage_;
    Stopwatch since_stage_;
    Stopwatch since_draw_;
    bool drawn_ = false;
};

} // namespace retractor::ui::cli

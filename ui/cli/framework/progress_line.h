#pragma once
// One line of progress on standard error, with the time left; silent when that is no terminal.

#include "mesh/base/job.h"

#include <mutex>
#include <string>
#include <string_view>

namespace retractor::ui::cli {

class ProgressLine {
public:
    ProgressLine();
    /// Safe to call from several threads; redraws at most ten times a second.
    void update(std::string_view stage, double fraction);
    /// Wipes the line, so that the next message starts on a clean one.
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

#pragma once
// Shows the progress: on a terminal as one line that is drawn again, with the remaining time; in a log as a line at
// most every half minute, so that a long plan of a batch can be followed and a short command writes nothing.

#include "mesh/base/job.h"

#include <cstdio>
#include <mutex>
#include <string>
#include <string_view>

namespace retractor::ui::cli {

/// Least time between two lines of a log, s.
inline constexpr double kLogLineSeconds = 30.0;

class ProgressLine {
public:
    /// @param out stays open as long as this object lives
    /// @param log_line_s least time between two lines where `out` is no terminal, s
    explicit ProgressLine(std::FILE* out = stderr, double log_line_s = kLogLineSeconds);
    /// Safe to call from several threads. A terminal is redrawn at most ten times a second.
    void update(std::string_view stage, double fraction);
    /// Clears the line on a terminal for the next message.
    void clear();

private:
    std::string remaining(double fraction) const;

    std::FILE* out_;
    bool terminal_ = false;
    double log_line_s_;
    std::mutex mutex_;
    std::string stage_;
    Stopwatch since_start_;
    Stopwatch since_stage_;
    Stopwatch since_line_;
    bool drawn_ = false;
};

} // namespace retractor::ui::cli

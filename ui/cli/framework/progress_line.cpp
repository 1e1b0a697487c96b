#include "ui/cli/framework/progress_line.h"

#include <cstdio>

#include <unistd.h>

namespace retractor::ui::cli {

namespace {
    constexpr double kRedrawSeconds = 0.1;
    /// Below this share of the work the remaining time is only a guess, and not shown.
    constexpr double kSmallestShareToExtrapolate = 0.05;
} // namespace

ProgressLine::ProgressLine()
    : enabled_(::isatty(STDERR_FILENO) != 0)
{
}

void ProgressLine::update(std::string_view stage, double fraction)
{
    if (!enabled_)
        return;
    const std::lock_guard lock(mutex_);
    const bool new_stage = stage != stage_;
    if (new_stage) {
        stage_ = stage;
        since_stage_ = {};
    } else if (since_draw_.seconds() < kRedrawSeconds) {
        return;
    }
    since_draw_ = {};
    drawn_ = true;
    if (fraction > kSmallestShareToExtrapolate && fraction < 1.0)
        std::fprintf(stderr, "\r\033[K%s %3.0f %%, %.0f s left", stage_.c_str(), 100.0 * fraction,
            since_stage_.seconds() * (1.0 - fraction) / fraction);
    else
        std::fprintf(stderr, "\r\033[K%s %3.0f %%", stage_.c_str(), 100.0 * fraction);
    std::fflush(stderr);
}

void ProgressLine::clear()
{
    const std::lock_guard lock(mutex_);
    if (drawn_)
        std::fprintf(stderr, "\r\033[K");
    drawn_ = false;
}

} // namespace retractor::ui::cli

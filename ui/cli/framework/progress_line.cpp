#include "ui/cli/framework/progress_line.h"

#include "mesh/base/text_format.h"

#include <unistd.h>

namespace retractor::ui::cli {

namespace {
    constexpr double kRedrawSeconds = 0.1;
    /// Below this share of the work the remaining time is only a guess, and not shown.
    constexpr double kSmallestShareToExtrapolate = 0.05;
} // namespace

ProgressLine::ProgressLine(std::FILE* out, double log_line_s)
    : out_(out)
    , terminal_(::isatty(::fileno(out)) != 0)
    , log_line_s_(log_line_s)
{
}

std::string ProgressLine::remaining(double fraction) const
{
    // Plans that run side by side report in turn, so that a log, which is read later, would hold wrong guesses.
    return terminal_ && fraction > kSmallestShareToExtrapolate && fraction < 1.0
        ? formatted(", %.0f s left", since_stage_.seconds() * (1.0 - fraction) / fraction)
        : std::string();
}

void ProgressLine::update(std::string_view stage, double fraction)
{
    const std::lock_guard lock(mutex_);
    const bool new_stage = stage != stage_;
    if (new_stage) {
        stage_ = stage;
        since_stage_ = {};
    }
    if (since_line_.seconds() < (terminal_ ? kRedrawSeconds : log_line_s_) && !(terminal_ && new_stage))
        return;
    since_line_ = {};
    const std::string line = formatted("%s %3.0f %%", stage_.c_str(), 100.0 * fraction) + remaining(fraction);
    if (terminal_)
        std::fprintf(out_, "\r\033[K%s", line.c_str());
    else
        std::fprintf(out_, "after %.0f s: %s\n", since_start_.seconds(), line.c_str());
    std::fflush(out_);
    drawn_ = terminal_;
}

void ProgressLine::clear()
{
    const std::lock_guard lock(mutex_);
    if (drawn_)
        std::fprintf(out_, "\r\033[K");
    drawn_ = false;
}

} // namespace retractor::ui::cli

#include "haptics/device/tick_thread.h"

#include "mesh/base/error.h"

#include <cmath>
#include <cstring>
#include <ctime>
#include <system_error>

#include <pthread.h>
#include <sched.h>
#include <sys/prctl.h>

namespace retractor::haptics {

namespace {

    timespec to_timespec(double seconds) noexcept
    {
        const double whole = std::floor(seconds);
        return { static_cast<std::time_t>(whole), static_cast<long>(1e9 * (seconds - whole)) };
    }

} // namespace

TickThread::TickThread(const TickThreadOptions& options)
    : options_(options)
    , timer_(std::make_unique<TickTimer>(options.period_s))
{
    if (!(options.period_s > 0.0) || !std::isfinite(options.period_s))
        throw InputError("the period must be positive", "period_s");
}

TickThread::~TickThread() { stop(); }

void TickThread::loop(Ticked& ticked) noexcept
{
    prctl(PR_SET_TIMERSLACK, 1UL); // ns; the default of 50 us saves power
    const double first = tick_clock_s() + options_.period_s;
    double number = 0.0;
    while (!stopping_.load(std::memory_order_relaxed)) {
        const timespec due = to_timespec(first + number * options_.period_s);
        clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, nullptr);
        const double step = timer_->begin();
        ticked.tick(timer_->time_s(), step);
        number = std::max(number + 1.0, std::ceil((tick_clock_s() - first) / options_.period_s));
    }
}

void TickThread::start(Ticked& ticked)
{
    if (thread_.joinable())
        throw InputError("the tick thread runs already");
    timer_ = std::make_unique<TickTimer>(options_.period_s);
    stopping_ = false;
    realtime_note_.clear();
    try {
        thread_ = std::thread([this, &ticked] { loop(ticked); });
    } catch (const std::system_error& error) {
        throw IoError(std::string("the servo thread cannot be started: ") + error.what());
    }
    pthread_setname_np(thread_.native_handle(), "servo");
    if (options_.priority > 0) {
        const sched_param wanted { .sched_priority = options_.priority };
        if (const int error = pthread_setschedparam(thread_.native_handle(), SCHED_FIFO, &wanted); error != 0)
            realtime_note_ = std::string(std::strerror(error))
                + ": the servo runs without SCHED_FIFO (allow it with 'rtprio' in /etc/security/limits.conf)";
    } else
        realtime_note_ = "SCHED_FIFO was not asked for";
}

void TickThread::stop() noexcept
{
    stopping_ = true;
    if (thread_.joinable())
        thread_.join();
}

} // namespace retractor::haptics

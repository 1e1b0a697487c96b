#include "tests/benchmarks/palpation/palpation_bench.h"

#include "tests/benchmarks/framework/cpu_watch.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <numeric>
#include <thread>

#include <pthread.h>
#include <sched.h>

namespace retractor::benchmarks {

namespace {

    constexpr double kTick = 1e-3; // s

    ui::cli::Json number(const std::optional<double>& value)
    {
        return value ? ui::cli::Json(*value) : ui::cli::Json(nullptr);
    }

    std::string cell(const std::optional<double>& value, const char* format)
    {
        std::array<char, 32> text {};
        if (value)
            std::snprintf(text.data(), text.size(), format, *value);
        else
            std::snprintf(text.data(), text.size(), "-");
        return text.data();
    }

    TickCost summary(std::vector<double>& times, std::size_t missed)
    {
        TickCost result;
        result.ticks = times.size();
        result.missed = missed;
        if (times.empty())
            return result;
        result.mean_us = std::accumulate(times.begin(), times.end(), 0.0) / static_cast<double>(times.size());
        std::sort(times.begin(), times.end());
        result.p999_us = times[static_cast<std::size_t>(0.999 * static_cast<double>(times.size() - 1))];
        result.worst_us = times.back();
        return result;
    }

} // namespace

ui::cli::Json row_document(const PalpationRow& row)
{
    return { { "model", row.model }, { "scene", row.scene }, { "vertices", row.vertices }, { "fingers", row.fingers },
        { "force_us_mean", number(row.force_us_mean) }, { "force_us_p999", number(row.force_us_p999) },
        { "deform_ms_median", number(row.deform_ms_median) }, { "rel_diff_same_mesh", number(row.rel_diff_same_mesh) },
        { "rel_error_vs_reference", number(row.rel_error_vs_reference) }, { "fps", number(row.fps) },
        { "fps_drawn", number(row.fps_drawn) }, { "ticks", row.ticks }, { "missed", row.missed },
        { "note", row.note } };
}

std::string row_table(const std::vector<PalpationRow>& rows)
{
    std::string text
        = "model    scene                          vertices fingers  force us   p99.9  deform ms  error vs FEM"
          "    fps    ticks  missed\n";
    for (const PalpationRow& row : rows) {
        std::array<char, 256> line {};
        std::snprintf(line.data(), line.size(), "%-8s %-30s %8zu %7zu %9s %7s %10s %13s %6s %8zu %7zu  ",
            row.model.c_str(), row.scene.c_str(), row.vertices, row.fingers, cell(row.force_us_mean, "%.1f").c_str(),
            cell(row.force_us_p999, "%.1f").c_str(), cell(row.deform_ms_median, "%.3f").c_str(),
            cell(row.rel_error_vs_reference, "%+.3f").c_str(), cell(row.fps, "%.1f").c_str(), row.ticks, row.missed);
        text += line.data() + row.note + "\n";
    }
    return text;
}

TickCost time_ticks(haptics::TissueResponse& tissue, const FingerScript& script, std::size_t ticks)
{
    std::vector<haptics::Fingertip> fingers(tissue.finger_count());
    std::vector<haptics::FingerContact> contacts(tissue.finger_count());
    std::vector<double> times(ticks);
    std::size_t missed = 0;
    for (std::size_t i = 0; i < ticks; ++i) {
        const double time = static_cast<double>(i + 1) * kTick;
        script(time, fingers);
        const Stopwatch wall;
        const CpuWatch watch;
        tissue.tick(time, kTick, fingers, contacts);
        times[i] = 1e3 * watch.milliseconds();
        if (wall.seconds() > kTick)
            ++missed;
    }
    return summary(times, missed);
}

LiveRun run_live(haptics::TissueResponse& tissue, const FingerScript& script, double seconds,
    const std::function<void(const Points& deformed)>& frame, const Job& job)
{
    using Clock = std::chrono::steady_clock;
    const auto start = Clock::now();
    const auto since = [&] { return std::chrono::duration<double>(Clock::now() - start).count(); };
    std::atomic<bool> stop { false };
    std::vector<double> times;
    times.reserve(static_cast<std::size_t>(seconds / kTick) + 1000);
    std::size_t missed = 0;
    std::thread servo([&] {
        const sched_param priority { .sched_priority = 50 };
        // real-time scheduling where allowed; otherwise the default
        pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority);
        std::vector<haptics::Fingertip> fingers(tissue.finger_count());
        std::vector<haptics::FingerContact> contacts(tissue.finger_count());
        auto due = start;
        double last = since();
        while (!stop.load(std::memory_order_relaxed)) {
            due += std::chrono::milliseconds(1);
            std::this_thread::sleep_until(due);
            const double now = since();
            script(now, fingers);
            const CpuWatch watch;
            tissue.tick(now, now - last, fingers, contacts);
            if (times.size() < times.capacity())
                times.push_back(1e3 * watch.milliseconds());
            last = now;
            // counts ticks that became due before this one ended
            while (due + std::chrono::milliseconds(1) < Clock::now()) {
                due += std::chrono::milliseconds(1);
                ++missed;
            }
        }
    });
    LiveRun run;
    Points deformed;
    double second_began = since();
    int frames = 0;
    while (since() < seconds && !job.cancelled()) {
        tissue.follow(deformed);
        frame(deformed);
        ++frames;
        const double lasted = since() - second_began;
        if (lasted >= 1.0) {
            for (int second = 1; second <= static_cast<int>(lasted); ++second) // a frame may take longer than a second
                run.fps.push_back(frames / lasted);
            job.report("frames drawn", since() / seconds);
            second_began = since();
            frames = 0;
        }
    }
    stop.store(true);
    servo.join();
    run.ticks = summary(times, missed);
    return run;
}

} // namespace retractor::benchmarks

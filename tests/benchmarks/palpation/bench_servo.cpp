#include "tests/benchmarks/palpation/bench_servo.h"

#include "datasets/phantoms/aorta_phantom.h"
#include "haptics/condensed/condensed_tissue.h"
#include "haptics/device/simulated_hand.h"
#include "haptics/device/tick_thread.h"
#include "haptics/servo/device_mapping.h"
#include "haptics/servo/servo.h"
#include "haptics/springs/spring_tissue.h"
#include "mesh/base/atomic_file.h"
#include "tests/benchmarks/framework/process_status.h"
#include "tests/benchmarks/palpation/servo_load.h"
#include "tests/support/haptics/tick_statistics.h"
#include "ui/scene/vtk/render.h"

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <thread>

namespace retractor::benchmarks {

namespace {

    namespace fs = std::filesystem;

    constexpr std::size_t kHands = 2;
    constexpr double kPressEvery = 1.0, kAbove = 8.0, kBelow = -4.0, kApart = 30.0; // s, mm
    constexpr double kEditEvery = 1.0; // s
    constexpr double kSheetSpacing = 4.0; // mm: 96 mm across

    /// Measures the tissue's part of a tick.
    class Timed : public haptics::TissueResponse {
    public:
        explicit Timed(haptics::TissueResponse& inner)
            : inner_(inner)
        {
        }
        std::string_view name() const noexcept override { return inner_.name(); }
        std::size_t finger_count() const noexcept override { return inner_.finger_count(); }
        void tick(double time_s, double step_s, std::span<const haptics::Fingertip> fingers,
            std::span<haptics::FingerContact> contacts) noexcept override
        {
            const double begun = haptics::tick_clock_s();
            inner_.tick(time_s, step_s, fingers, contacts);
            times.add(haptics::tick_clock_s() - begun);
            for (const haptics::FingerContact& contact : contacts)
                touches += contact.touching ? 1 : 0;
        }
        const TriMesh& surface() const noexcept override { return inner_.surface(); }
        void follow(Points& deformed) override { inner_.follow(deformed); }

        test_support::TickHistogram times;
        std::uint64_t touches = 0;

    private:
        haptics::TissueResponse& inner_;
    };

    /// Two hands that each press once a second, alternately, along the y axis of their devices.
    std::vector<std::unique_ptr<haptics::SimulatedHand>> make_hands(double seconds)
    {
        std::vector<std::unique_ptr<haptics::SimulatedHand>> hands;
        for (std::size_t h = 0; h < kHands; ++h) {
            const double shift = 0.5 * kPressEvery * static_cast<double>(h);
            std::vector<haptics::HandKey> keys { { 0.0, Vec3(0.0, kAbove, 0.0) } };
            for (double t = 0.1 + shift; t < seconds; t += kPressEvery) {
                keys.push_back({ t, Vec3(0.0, kAbove, 0.0) });
                keys.push_back({ t + 0.5 * kPressEvery, Vec3(0.0, kBelow, 0.0) });
            }
            haptics::SimulatedHandOptions options { .hand = h == 0 ? haptics::relaxed_grip() : haptics::firm_grip(),
                .path = haptics::HandPath(keys) };
            hands.push_back(std::make_unique<haptics::SimulatedHand>(
                options, haptics::DeviceInfo { .name = h == 0 ? "relaxed" : "firm", .model = "simulated" }));
        }
        return hands;
    }

    /// A tissue, the place of each hand, and a repeatable edit.
    struct Bench {
        std::unique_ptr<haptics::TissueResponse> tissue;
        std::vector<haptics::MappingOptions> mappings;
        std::function<void()> edit;
        double active_power = haptics::PassivityOptions {}.active_power;
    };

    /// The device's y axis points along `outward`; a fingertip just touches at the middle of the device.
    haptics::MappingOptions standing_on(const Vec3& point, const Vec3& outward)
    {
        return { .scene_centre = point + haptics::FingerMount {}.radius * outward,
            .scene_from_device = haptics::standing_on(outward) };
    }

    Bench make_springs()
    {
        Bench bench;
        bench.tissue = std::make_unique<haptics::SpringTissue>(haptics::make_spring_sheet({ .spacing = kSheetSpacing }),
            haptics::ElementLaw {}, haptics::SpringTissueOptions { .fingers = kHands });
        for (const double x : { -0.5 * kApart, 0.5 * kApart })
            bench.mappings.push_back(standing_on(Vec3(x, 0.0, 0.0), Vec3::UnitZ()));
        return bench;
    }

    Bench make_aorta(const Job& job)
    {
        const datasets::PalpationScene scene = datasets::make_aorta_phantom({});
        Bench bench;
        auto tissue = std::make_unique<haptics::CondensedTissue>(
            scene.body, haptics::PulsePressure::aortic(), haptics::CondensedOptions { .fingers = kHands }, job);
        for (const char* site : { "normal", "sclerotic" })
            bench.mappings.push_back(standing_on(scene.site(site).point, scene.site(site).outward));
        bench.edit = [&edited = *tissue, at = scene.site("sclerotic").point, soft = false]() mutable {
            soft = !soft;
            haptics::ElasticTemplate around_it;
            around_it.shape = haptics::ElasticTemplate::Shape::sphere;
            around_it.centre = at;
            around_it.half_size.setConstant(20.0); // mm
            around_it.youngs_modulus = soft ? 1.0 : 3.0;
            edited.edit(around_it);
        };
        bench.active_power = 2.0; // N mm/s: a pulse supplies energy
        bench.tissue = std::move(tissue);
        return bench;
    }

    /// The measurements of a tick source.
    struct MeasuredTimes {
        test_support::TickHistogram periods, jitter, compute;
        std::uint64_t ticks = 0, missed = 0;
    };

    MeasuredTimes times_of(const haptics::TickThread& thread, const test_support::MeasuredTicks& measured)
    {
        return { measured.periods, measured.jitter, measured.compute, thread.times().ticks, thread.times().missed };
    }

    struct ServoRun {
        MeasuredTimes times;
        test_support::TickHistogram tissue;
        std::uint64_t touches = 0, late_faults = 0;
        long edits = 0;
        std::string fault, realtime_note; ///< a fault other than lateness
        double strongest = 0.0;
        std::size_t vertices = 0;
        std::uint64_t damped_ticks = 0;
    };

    ServoRun run_servo(const std::string& model, double seconds, bool edits, const Job& job, const char* stage)
    {
        Bench bench = model == "fem" ? make_aorta(job) : make_springs();
        Timed tissue(*bench.tissue);
        auto hands = make_hands(seconds);
        std::vector<haptics::ServoDevice> devices;
        for (std::size_t h = 0; h < kHands; ++h)
            devices.push_back({ .device = hands[h].get(), .mapping = bench.mappings[h] });
        haptics::ServoOptions options;
        options.passivity.active_power = bench.active_power;
        haptics::Servo servo(std::move(devices), tissue, options);
        haptics::TickThread thread;
        ServoRun run;
        run.vertices = static_cast<std::size_t>(tissue.surface().vertices.rows());
        Points deformed = tissue.surface().vertices;
        const Stopwatch watch;
        test_support::MeasuredTicks measured(servo);
        thread.start(measured);
        run.realtime_note = thread.realtime_note();
        bool rearmed = false;
        double next_edit = kEditEvery;
        while (watch.seconds() < seconds && !job.cancelled() && run.fault.empty()) {
            std::this_thread::sleep_for(std::chrono::milliseconds(33)); // the rate of a view
            tissue.follow(deformed);
            if (edits && bench.edit && watch.seconds() > next_edit) {
                bench.edit();
                ++run.edits;
                next_edit = watch.seconds() + kEditEvery;
            }
            const haptics::ServoState& state = servo.latest();
            for (std::size_t f = 0; f < state.finger_count; ++f)
                run.strongest = std::max(run.strongest, state.forces[f].norm());
            if (state.fault.kind == haptics::FaultKind::none)
                rearmed = false;
            else if (state.fault.kind != haptics::FaultKind::late)
                run.fault = haptics::describe(state.fault);
            else if (!rearmed) {
                ++run.late_faults;
                servo.rearm();
                rearmed = true;
            }
            job.report(stage, watch.seconds() / seconds);
        }
        servo.let_go();
        std::this_thread::sleep_for(std::chrono::milliseconds(150));
        thread.stop();
        run.times = times_of(thread, measured);
        run.tissue = tissue.times;
        run.touches = tissue.touches;
        for (std::size_t h = 0; h < kHands; ++h)
            run.damped_ticks += servo.passivity(h).damped_ticks();
        return run;
    }

    struct Nothing : haptics::Ticked {
        void tick(double, double) noexcept override { }
    };

    /// Measures the jitter of the machine with empty ticks.
    MeasuredTimes run_nothing(double seconds, const Job& job)
    {
        Nothing nothing;
        test_support::MeasuredTicks measured(nothing);
        haptics::TickThread thread;
        thread.start(measured);
        const Stopwatch watch;
        while (watch.seconds() < seconds) {
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
            job.report("empty loop", std::min(1.0, watch.seconds() / seconds));
        }
        thread.stop();
        return times_of(thread, measured);
    }

    void put(ui::cli::Json& row, const std::string& name, const test_support::TickHistogram& h)
    {
        row[name + "_us_mean"] = 1e6 * h.mean_s();
        row[name + "_us_median"] = 1e6 * h.percentile_s(0.5);
        row[name + "_us_p99"] = 1e6 * h.percentile_s(0.99);
        row[name + "_us_p999"] = 1e6 * h.percentile_s(0.999);
        row[name + "_us_max"] = 1e6 * h.max_s();
    }

    ui::cli::Json row_of(const std::string& model, const ServoRun& run, bool load)
    {
        ui::cli::Json row { { "model", model }, { "vertices", run.vertices }, { "fingers", kHands }, { "load", load },
            { "ticks", run.times.ticks }, { "missed", run.times.missed }, { "late_faults", run.late_faults },
            { "touching_ticks", run.touches }, { "strongest_N", run.strongest }, { "damped_ticks", run.damped_ticks },
            { "realtime", run.realtime_note.empty() } };
        put(row, "force", run.tissue);
        put(row, "tick", run.times.compute);
        put(row, "period", run.times.periods);
        put(row, "jitter", run.times.jitter);
        if (!run.fault.empty())
            row["fault"] = run.fault;
        return row;
    }

    ui::cli::Json row_of(const MeasuredTimes& times, bool load)
    {
        ui::cli::Json row { { "model", "empty loop" }, { "fingers", 0 }, { "load", load }, { "ticks", times.ticks },
            { "missed", times.missed } };
        put(row, "tick", times.compute);
        put(row, "period", times.periods);
        put(row, "jitter", times.jitter);
        return row;
    }

    ui::ChartSeries series_of(const std::string& name, const test_support::TickHistogram& histogram)
    {
        ui::ChartSeries series { .name = name, .x = {}, .y = {} };
        for (const test_support::TickHistogram::Bin& bin : histogram.bins()) {
            series.x.push_back(1e6 * 0.5 * (bin.low_s + bin.high_s));
            series.y.push_back(static_cast<double>(bin.count));
        }
        return series;
    }

    ui::ChartPicture chart_of(const ServoRun& run, const std::optional<MeasuredTimes>& empty)
    {
        ui::ChartPicture picture { .x_title = "microseconds", .y_title = "ticks", .panels = {}, .columns = 2 };
        picture.panels.push_back({ .title = "period's distance from 1 ms",
            .series = { series_of("servo, two devices", run.times.jitter) } });
        picture.panels.push_back({ .title = "in the tick",
            .series = { series_of("servo, two devices", run.times.compute), series_of("tissue alone", run.tissue) } });
        if (empty) {
            picture.panels[0].series.push_back(series_of("empty loop", empty->jitter));
            picture.panels[1].series.push_back(series_of("empty loop", empty->compute));
        }
        picture.panel_width = 640;
        return picture;
    }

    std::string text_of(const ui::cli::Json& row)
    {
        std::array<char, 512> line {};
        std::snprintf(line.data(), line.size(),
            "%-10s %9llu ticks, %llu missed; jitter median %.0f us, p99.9 %.0f, max %.0f; in the tick mean %.1f us, "
            "p99.9 "
            "%.1f, max %.0f\n",
            row.at("model").get<std::string>().c_str(), row.at("ticks").get<unsigned long long>(),
            row.at("missed").get<unsigned long long>(), row.at("jitter_us_median").get<double>(),
            row.at("jitter_us_p999").get<double>(), row.at("jitter_us_max").get<double>(),
            row.at("tick_us_mean").get<double>(), row.at("tick_us_p999").get<double>(),
            row.at("tick_us_max").get<double>());
        return line.data();
    }

} // namespace

ui::cli::Outcome bench_servo(const ServoBenchOptions& options, const Job& job)
{
    const bool soaks = options.soak > 0;
    const bool load = options.load && !soaks;
    const double seconds = soaks ? 1e-3 * static_cast<double>(options.soak) : options.seconds;
    std::optional<ServoLoad> work;
    if (load)
        work.emplace(options.model != "fem"); // the aorta is edited by the benchmark itself
    std::optional<MeasuredTimes> empty;
    if (!soaks)
        empty = run_nothing(seconds, job);
    const double before_mb = status_mb("VmRSS");
    const ServoRun run = run_servo(options.model, seconds, load, job, soaks ? "soak" : "servo");
    const double grown_mb = status_mb("VmRSS") - before_mb;
    ui::cli::Outcome outcome;
    ui::cli::Json results = ui::cli::Json::array();
    results.push_back(row_of(options.model, run, load));
    if (empty)
        results.push_back(row_of(*empty, load));
    if (load) {
        work->stop();
        results[0]["cuts_meanwhile"] = work->cuts();
        results[0]["edits_meanwhile"] = work->edits() + run.edits;
    }
    if (soaks)
        results[0]["rss_growth_mb"] = grown_mb;
    outcome.document["results"] = results;
    for (const ui::cli::Json& row : results)
        outcome.text += text_of(row);
    if (!run.realtime_note.empty())
        outcome.text += run.realtime_note + "\n";
    if (load)
        outcome.text += "meanwhile " + std::to_string(work->cuts()) + " cuts were made, opened and taken back, and "
            + std::to_string(work->edits() + run.edits) + " edits of elasticity\n";
    if (!run.fault.empty())
        outcome.text += "the servo let go: " + run.fault + "\n";
    outcome.exit_code = run.fault.empty() && run.touches > 0 ? 0 : 1;
    if (!options.out.empty()) {
        fs::create_directories(options.out);
        write_file_atomically(fs::path(options.out) / "bench_servo.json", outcome.document.dump(2) + "\n");
        ui::OffscreenRenderer renderer(ui::make_offscreen_context());
        ui::write_png(fs::path(options.out) / "servo.png", renderer.render(chart_of(run, empty)));
        outcome.text += (fs::path(options.out) / "servo.png").string() + "\n";
    }
    return outcome;
}

} // namespace retractor::benchmarks

#include "tests/benchmarks/palpation/bench_palpate.h"

#include "datasets/phantoms/aorta_phantom.h"
#include "haptics/condensed/condensed_tissue.h"
#include "haptics/condensed/sneddon.h"
#include "haptics/device/simulated_hand.h"
#include "haptics/device/tick_thread.h"
#include "haptics/servo/device_mapping.h"
#include "haptics/servo/servo.h"
#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "tests/benchmarks/framework/bench_numbers.h"
#include "tests/benchmarks/palpation/palpation_error.h"
#include "tests/support/half_space.h"
#include "tests/support/haptics/pressed_check.h"
#include "tests/support/haptics/tick_statistics.h"
#include "ui/scene/vtk/render.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <numeric>
#include <thread>

namespace retractor::benchmarks {

namespace {

    namespace fs = std::filesystem;

    constexpr double kStep = 1e-3; ///< s
    constexpr double kStrokeDepth = 2.0; ///< mm
    constexpr std::size_t kErrorTicks = 3000; ///< timed ticks of every tissue in the plot of error against time

    double mean(const std::vector<double>& values)
    {
        return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
    }

    struct Variant {
        const char* name;
        haptics::TouchElement element;
        int around, along;
        std::size_t fingers;
        bool servo; ///< also runs at 1 kHz
        double radius = 4.0; ///< radius of a fingertip, mm
    };

    const char* element_name(haptics::TouchElement element)
    {
        switch (element) {
        case haptics::TouchElement::p1:
            return "p1";
        case haptics::TouchElement::locking_free:
            return "locking-free";
        case haptics::TouchElement::p2:
            return "p2";
        }
        return "";
    }

    datasets::PalpationScene arch(int around, int along, int nodes_per_tet = 4)
    {
        datasets::AortaParameters p;
        p.around = around;
        p.along = along;
        p.nodes_per_tet = nodes_per_tet;
        return datasets::make_aorta_phantom(p);
    }

    haptics::Fingertip finger_at(const datasets::TouchSite& site, double depth, double radius = 4.0)
    {
        haptics::Fingertip finger;
        finger.radius = radius;
        finger.position = site.point + (finger.radius - depth) * site.outward;
        return finger;
    }

    /// A fingertip that presses a site from the start, strokes to and fro, and rocks.
    haptics::Fingertip stroking(const datasets::TouchSite& site, double time, double radius)
    {
        constexpr double kStroke = 1.5, kRock = 0.3; // mm
        Vec3 along = site.outward.cross(Vec3::UnitX());
        along = (along.norm() > 0.1 ? along : site.outward.cross(Vec3::UnitY())).normalized();
        const double down = std::min(1.0, time / 0.1);
        haptics::Fingertip finger
            = finger_at(site, kStrokeDepth * down - 6.0 * (1.0 - down) + kRock * std::sin(9.0 * time), radius);
        finger.position += kStroke * std::sin(5.0 * time) * along;
        finger.velocity = 5.0 * kStroke * std::cos(5.0 * time) * along;
        return finger;
    }

    /// Sites under the fingers; the second finger pinches from the other side.
    std::vector<datasets::TouchSite> sites_of(const datasets::PalpationScene& scene, std::size_t fingers)
    {
        std::vector<datasets::TouchSite> sites { scene.site("normal") };
        if (fingers > 1)
            sites.push_back(scene.site("normal-opposite"));
        return sites;
    }

    std::vector<haptics::Fingertip> still(const std::vector<datasets::TouchSite>& sites, double radius = 4.0)
    {
        std::vector<haptics::Fingertip> fingers;
        for (const datasets::TouchSite& site : sites)
            fingers.push_back(finger_at(site, kStrokeDepth, radius));
        return fingers;
    }

    /// Fingertips that come from outside and stay, at the start of a beat and after the beat.
    struct Palpation {
        haptics::CondensedTissue& tissue;
        std::vector<datasets::TouchSite> sites;
        std::vector<haptics::FingerContact> contacts;
        double radius = 4.0, time = 0.0;

        void press()
        {
            constexpr int kSteps = 40;
            for (int i = 0; i <= kSteps; ++i) {
                std::vector<haptics::Fingertip> fingers;
                for (const datasets::TouchSite& site : sites)
                    fingers.push_back(finger_at(site, kStrokeDepth - 6.0 * (kSteps - i) / kSteps, radius));
                tissue.tick(time, kStep, fingers, contacts);
                time += kStep;
            }
        }
        /// Lowest and highest force on the first finger during one beat, N.
        std::pair<double, double> beat()
        {
            const std::vector<haptics::Fingertip> fingers = still(sites, radius);
            double low = std::numeric_limits<double>::infinity(), high = 0.0;
            for (double t = 0.0; t < tissue.pulse().period_s(); t += 4.0 * kStep) {
                tissue.tick(time, kStep, fingers, contacts);
                time += 4.0 * kStep;
                low = std::min(low, contacts[0].force.norm());
                high = std::max(high, contacts[0].force.norm());
            }
            return { low, high };
        }
    };

    struct StrokeTimes {
        std::vector<double> tick_us, empty_us;
        std::size_t most_pressing = 0;
    };

    /// Times consecutive ticks, and a loop without work.
    StrokeTimes time_strokes(haptics::CondensedTissue& tissue, const std::vector<datasets::TouchSite>& sites,
        double radius, int ticks, const Job& job)
    {
        using Clock = std::chrono::steady_clock;
        const auto microseconds
            = [](Clock::duration d) { return std::chrono::duration<double, std::micro>(d).count(); };
        StrokeTimes times;
        times.tick_us.reserve(static_cast<std::size_t>(ticks));
        times.empty_us.reserve(static_cast<std::size_t>(ticks));
        std::vector<haptics::Fingertip> fingers(sites.size());
        std::vector<haptics::FingerContact> contacts(sites.size());
        for (int i = 0; i < ticks && !job.cancelled(); ++i) {
            const double time = i * kStep;
            for (std::size_t f = 0; f < sites.size(); ++f)
                fingers[f] = stroking(sites[f], time + 0.2 * static_cast<double>(f), radius);
            const auto start = Clock::now();
            tissue.tick(time, kStep, fingers, contacts);
            times.tick_us.push_back(microseconds(Clock::now() - start));
            if (i % 1024 == 0)
                times.most_pressing = std::max(times.most_pressing, tissue.last_pressed().forces.size());
        }
        for (int i = 0; i < ticks; ++i) {
            const auto start = Clock::now();
            times.empty_us.push_back(microseconds(Clock::now() - start));
        }
        return times;
    }

    double deform_ms(haptics::CondensedTissue& tissue, Palpation& palpation)
    {
        palpation.press();
        Points deformed;
        std::vector<double> ms;
        constexpr int kFrames = 60;
        for (int i = 0; i < kFrames; ++i) {
            palpation.beat();
            // Fetching columns is measured separately.
            const Stopwatch watch;
            tissue.follow(deformed);
            ms.push_back(watch.seconds() * 1e3);
        }
        return median(ms);
    }

    /// Largest difference between the condensed displacement and a direct solution of the whole body under the same
    /// forces, at contact nodes and at the surface, relative to the largest displacement.
    double difference_on_same_mesh(haptics::CondensedTissue& tissue)
    {
        const test_support::PressedCheck check = test_support::check_pressed(tissue);
        const Eigen::VectorXd& u = check.displacement;
        double worst = check.off_mm;
        Points deformed;
        tissue.follow(deformed);
        for (Eigen::Index v = 0; v < deformed.rows(); ++v) {
            const Vec3 moved = (deformed.row(v) - tissue.surface().vertices.row(v)).transpose();
            worst = std::max(worst,
                (moved - u.segment<3>(3 * tissue.shown_nodes()[static_cast<std::size_t>(v)])).cwiseAbs().maxCoeff());
        }
        return worst / u.cwiseAbs().maxCoeff();
    }

    constexpr double kFrame = 1.0 / 60.0; // period of a display, s

    /// Ticks at 1 kHz with simulated real-time frames. The ticks wait for a frame's work as long as the work takes
    /// here.
    class TicksAndFrames {
    public:
        explicit TicksAndFrames(haptics::CondensedTissue& tissue)
            : fingers(tissue.finger_count())
            , contacts(tissue.finger_count())
            , tissue_(tissue)
        {
            for (haptics::Fingertip& finger : fingers)
                finger.position.setConstant(1e6);
        }
        /// @return whether the contact used the fallback stiffness.
        bool tick()
        {
            const long late = tissue_.late_ticks();
            tissue_.tick(0.0, 0.0, fingers, contacts); // the pulse does not advance
            time_ += kStep;
            behind_ = std::max(0.0, behind_ - kStep);
            if (time_ >= next_frame_ && behind_ == 0.0) {
                const Stopwatch watch;
                tissue_.follow(deformed_);
                behind_ = work_ = watch.seconds();
                next_frame_ = time_ + kFrame;
            }
            return tissue_.late_ticks() > late;
        }
        /// Moves the finger without a frame in between.
        void hop_to(const haptics::Fingertip& finger)
        {
            fingers[0] = finger;
            tissue_.tick(0.0, 0.0, fingers, contacts);
        }
        double last_work_s() const { return work_; } ///< work of the last frame, s
        std::vector<haptics::Fingertip> fingers;
        std::vector<haptics::FingerContact> contacts;

    private:
        haptics::CondensedTissue& tissue_;
        Points deformed_;
        double time_ = 0.0, next_frame_ = 0.5 * kFrame, work_ = 0.0;
        double behind_ = 0.0; ///< time of the simulation thread's work that ticks have not caught up with, s
    };

    struct SetDown {
        double error = 0.0; ///< error of the force at the first tick
        double exact_ms = 0.0; ///< time until the contact uses only its own contact nodes, ms
        double felt_ms = 0.0; ///< time until the force is right to one hundredth, ms
    };

    SetDown set_down(haptics::CondensedTissue& tissue, const haptics::ContactNode& contact_node)
    {
        constexpr int kLimit = 5000, kSettled = 200; // ticks
        const datasets::TouchSite site { "", contact_node.point, contact_node.normal };
        TicksAndFrames run(tissue);
        run.hop_to(finger_at(site, -6.0)); // a fingertip must come from outside to touch
        run.fingers[0] = finger_at(site, kStrokeDepth);
        std::vector<double> forces;
        int last_late = -1;
        double work_ms = 0.0; // work of the frame at whose end the contact nodes are ready
        for (int i = 0; i < kLimit && i < last_late + kSettled; ++i) {
            if (run.tick()) {
                last_late = i;
                work_ms = 1e3 * run.last_work_s();
            }
            forces.push_back(run.contacts[0].force.norm());
        }
        const double exact = forces.back();
        SetDown found { std::abs(forces.front() / exact - 1.0), last_late + 1 + work_ms, 0.0 };
        for (std::size_t i = 0; i < forces.size(); ++i)
            if (std::abs(forces[i] / exact - 1.0) > 0.01)
                found.felt_ms = static_cast<double>(i + 1) + work_ms;
        return found;
    }

    /// Measures fingers that are set down suddenly where no compliance is ready: the fallback force compared with the
    /// final one.
    void measure_set_downs(haptics::CondensedTissue& tissue, ui::cli::Json& row)
    {
        constexpr std::size_t kPlaces = 25;
        const std::vector<haptics::ContactNode>& contact_nodes = tissue.touch_surface().contact_nodes();
        std::vector<double> error, exact, felt;
        for (std::size_t i = 0; i < kPlaces; ++i) {
            const std::size_t s = (2 * i + 1) * contact_nodes.size() / (2 * kPlaces);
            if (tissue.compliance().ready(static_cast<std::int32_t>(s)))
                continue;
            const SetDown found = set_down(tissue, contact_nodes[s]);
            error.push_back(found.error);
            exact.push_back(found.exact_ms);
            felt.push_back(found.felt_ms);
        }
        row["set_downs"] = error.size();
        if (error.empty())
            return;
        const auto worst = [](const std::vector<double>& all) { return *std::max_element(all.begin(), all.end()); };
        row["set_down_error_median"] = median(error);
        row["set_down_error_worst"] = worst(error);
        row["set_down_exact_ms_median"] = median(exact);
        row["set_down_exact_ms_worst"] = worst(exact);
        row["set_down_felt_ms_median"] = median(felt);
        row["set_down_felt_ms_worst"] = worst(felt);
    }

    /// Measures a finger that approaches from 40 mm with frames in real time: how long the contact uses the fallback
    /// stiffness, and the largest error of the force, relative to the force at full depth.
    void measure_approach(
        haptics::CondensedTissue& tissue, const datasets::TouchSite& site, double speed, ui::cli::Json& row)
    {
        constexpr double kFrom = 40.0, kStay = 0.5; // mm, s
        TicksAndFrames run(tissue);
        std::vector<double> depths, forces;
        long late = 0;
        const auto ticks = static_cast<int>((((kFrom + kStrokeDepth) / speed) + kStay) / kStep);
        for (int i = 0; i < ticks; ++i) {
            const double depth = std::min(kStrokeDepth, speed * i * kStep - kFrom);
            run.fingers[0] = finger_at(site, depth);
            run.fingers[0].velocity = depth == kStrokeDepth ? Vec3(Vec3::Zero()) : Vec3(-speed * site.outward);
            late += run.tick() ? 1 : 0;
            forces.push_back(run.contacts[0].force.norm());
            depths.push_back(depth);
        }
        std::vector<haptics::Fingertip> fingers = run.fingers;
        std::vector<haptics::FingerContact> contacts(fingers.size());
        double worst = 0.0;
        for (int i = 0; i < ticks; ++i) { // the same motion again, now that all contact nodes are ready
            fingers[0] = finger_at(site, depths[static_cast<std::size_t>(i)]);
            tissue.tick(0.0, 0.0, fingers, contacts);
            worst = std::max(worst, std::abs(forces[static_cast<std::size_t>(i)] - contacts[0].force.norm()));
        }
        row["late_ticks"] = late;
        row["worst_error"] = worst / contacts[0].force.norm();
        row["speed_mm_s"] = speed;
    }

    /// Measures set-downs and approaches at places that no finger has come near.
    void measure_lateness(haptics::CondensedTissue& tissue, const datasets::PalpationScene& scene, ui::cli::Json& row)
    {
        measure_set_downs(tissue, row);
        row["approaches"] = ui::cli::Json::array();
        for (const auto& [site, speed] : { std::pair { "sclerotic-opposite", 100.0 }, { "normal-opposite", 300.0 } }) {
            row["approaches"].push_back(ui::cli::Json::object());
            measure_approach(tissue, scene.site(site), speed, row["approaches"].back());
        }
    }

    /// Runs the servo at 1 kHz on its own thread with one or two hands, while the stiffness is edited and frames are
    /// made.
    void run_servo(haptics::CondensedTissue& tissue, const std::vector<datasets::TouchSite>& sites, double seconds,
        ui::cli::Json& row, const Job& job)
    {
        const auto path = [](double seconds_down) {
            const auto up = [](double y) { return Vec3(0.0, y, 0.0); };
            return haptics::HandPath({ { 0.0, up(12.0), 0 }, { 0.5, up(4.0 - kStrokeDepth), 0 },
                { seconds_down, up(4.0 - kStrokeDepth), 0 } });
        };
        std::vector<std::unique_ptr<haptics::SimulatedHand>> hands;
        std::vector<haptics::ServoDevice> devices;
        for (const datasets::TouchSite& site : sites) {
            hands.push_back(
                std::make_unique<haptics::SimulatedHand>(haptics::SimulatedHandOptions { .path = path(seconds) }));
            devices.push_back({ hands.back().get(),
                { .scene_centre = site.point, .scene_from_device = haptics::standing_on(site.outward) } });
        }
        haptics::Servo servo(devices, tissue);
        haptics::TickThread thread;
        test_support::MeasuredTicks measured(servo);
        thread.start(measured);
        const Stopwatch watch;
        Points deformed;
        int frames = 0;
        bool edited = false;
        while (watch.seconds() < seconds && !job.cancelled()) {
            const Stopwatch frame;
            if (!edited && watch.seconds() > 0.4 * seconds) {
                haptics::ElasticTemplate sphere;
                sphere.shape = haptics::ElasticTemplate::Shape::sphere;
                sphere.centre = sites[0].point;
                sphere.half_size.x() = 15.0;
                sphere.youngs_modulus = 2.0;
                tissue.edit(sphere);
                edited = true;
            }
            tissue.follow(deformed);
            ++frames;
            std::this_thread::sleep_for(std::chrono::duration<double>(std::max(0.0, kFrame - frame.seconds())));
        }
        row["fps"] = frames / watch.seconds();
        thread.stop();
        row["ticks"] = thread.times().ticks;
        row["missed"] = thread.times().missed;
        row["servo_tick_us_p999"] = measured.compute.percentile_s(0.999) * 1e6;
        row["realtime"] = thread.is_realtime();
        row["edit_swapped_in"] = !tissue.edit_pending();
        if (const haptics::Fault fault = servo.latest().fault; fault.kind != haptics::FaultKind::none)
            row["fault"] = haptics::describe(fault);
    }

    struct Reference {
        double low = 0.0, high = 0.0;
        std::size_t nodes = 0;
    };

    /// The reference: ten-node elements, finer than in any row, with midpoints on the curved wall.
    Reference refined_reference(const Job& job)
    {
        const datasets::PalpationScene scene = arch(32, 64, 10);
        haptics::CondensedOptions options;
        options.fetch_all_below = 0;
        haptics::CondensedTissue tissue(scene.body, haptics::PulsePressure::aortic(), options, job);
        Palpation palpation { tissue, sites_of(scene, 1), std::vector<haptics::FingerContact>(1) };
        tissue.prepare(still(palpation.sites));
        palpation.press();
        const auto [low, high] = palpation.beat();
        return { low, high, scene.body.mesh.vertex_count() };
    }

    ui::cli::Json measure(
        const Variant& variant, const Reference& reference, const PalpateBenchOptions& bench, const Job& job)
    {
        const datasets::PalpationScene scene = arch(variant.around, variant.along);
        haptics::CondensedOptions options;
        options.element = variant.element;
        options.fingers = variant.fingers;
        const Stopwatch watch;
        haptics::CondensedTissue tissue(scene.body, haptics::PulsePressure::aortic(), options, job);
        ui::cli::Json row { { "model", "fem" }, { "element", element_name(variant.element) }, { "scene", "vessel" },
            { "vertices", tissue.surface().vertices.rows() }, { "fingers", variant.fingers },
            { "radius_mm", variant.radius } };
        row["unknowns"] = tissue.compliance().unknowns();
        row["build_ms"] = watch.seconds() * 1e3;
        const std::vector<datasets::TouchSite> sites = sites_of(scene, variant.fingers);
        const Stopwatch fetch;
        tissue.prepare(still(sites, variant.radius));
        row["first_columns_ms"] = fetch.seconds() * 1e3;

        const StrokeTimes times = time_strokes(tissue, sites, variant.radius, bench.ticks, job);
        row["force_us_mean"] = mean(times.tick_us);
        row["force_us_median"] = median(times.tick_us);
        row["force_us_p999"] = percentile(times.tick_us, 0.999);
        row["empty_us_p999"] = percentile(times.empty_us, 0.999);
        row["stations_pressed"] = times.most_pressing;

        Palpation palpation { tissue, sites, std::vector<haptics::FingerContact>(sites.size()), variant.radius };
        row["deform_ms_median"] = deform_ms(tissue, palpation);
        const auto [low, high] = palpation.beat();
        row["force_N"] = high;
        row["pulse_N"] = high - low;
        row["rel_diff_same_mesh"] = difference_on_same_mesh(tissue);
        if (variant.fingers == 1 && variant.radius == 4.0) {
            row["rel_error_vs_reference"] = std::abs(high / reference.high - 1.0);
            row["pulse_rel_error_vs_reference"] = std::abs((high - low) / (reference.high - reference.low) - 1.0);
        }
        if (!tissue.compliance().holds_all())
            measure_lateness(tissue, scene, row);
        row["fps"] = nullptr;
        row["ticks"] = bench.ticks;
        row["missed"] = std::count_if(times.tick_us.begin(), times.tick_us.end(), [](double us) { return us > 1e3; });
        if (variant.servo && bench.seconds > 0.0)
            run_servo(tissue, sites, bench.seconds, row, job);
        return row;
    }

    ui::cli::Json check_row(const char* name, double value, double expected)
    {
        return { { "check", name }, { "value", value }, { "expected", expected },
            { "rel_error", std::abs(value / expected - 1.0) } };
    }

    /// Outward motion of the middle of a long vessel under 40 mmHg, compared with Lame's formula.
    ui::cli::Json tube_check()
    {
        datasets::AortaParameters p;
        p.shape = datasets::AortaParameters::Shape::tube;
        p.length_mm = 600.0;
        p.around = 16;
        p.region.length_mm = 0.0;
        haptics::CondensedOptions options;
        options.fetch_all_below = 0;
        const datasets::PalpationScene scene = datasets::make_aorta_phantom(p);
        haptics::CondensedTissue tissue(scene.body, haptics::PulsePressure::constant(120.0), options);
        std::vector<haptics::Fingertip> finger(1);
        finger[0].position.setConstant(1e6);
        std::vector<haptics::FingerContact> contact(1);
        tissue.tick(0.0, kStep, finger, contact);
        Points deformed;
        tissue.follow(deformed);
        const double r = p.inner_radius_mm, ro = p.outer_radius_mm, nu = p.poissons_ratio;
        const double exact = (1.0 + nu) / p.normal_MPa * 40.0 * haptics::kMPaPerMmHg * r * r / (ro * ro - r * r)
            * ((1.0 - 2.0 * nu) * r + ro * ro / r);
        double sum = 0.0;
        int count = 0;
        for (Eigen::Index v = 0; v < deformed.rows(); ++v) {
            const Vec3 rest = tissue.surface().vertices.row(v).transpose();
            if (std::abs(rest.z() - 0.5 * p.length_mm) > 1.0 || rest.head<2>().norm() > r + 0.1)
                continue;
            sum += deformed.row(v).head<2>().norm() - rest.head<2>().norm();
            ++count;
        }
        return check_row("Lame tube, inner wall, mm", sum / count, exact);
    }

    ui::cli::Json closed_form_checks()
    {
        constexpr double E = 0.020, nu = 0.49, R = 8.0, contact = 5.663;
        ui::cli::Json checks = ui::cli::Json::array();
        checks.push_back(tube_check());
        constexpr double kAway = -1e9;
        const test_support::HalfSpace block(contact, E, nu);
        checks.push_back(check_row("flat punch, N",
            block.press([&](double r) { return r <= contact * (1.0 + 1e-9) ? kStrokeDepth : kAway; }).force,
            test_support::flat_punch_force(contact, kStrokeDepth, E, nu)));
        const double depth = haptics::sneddon_depth(R, contact), exact = haptics::sneddon_force(depth, R, E, nu);
        checks.push_back(check_row("Sneddon's sphere, N",
            block.press([&](double r) { return r < R ? depth - (R - std::sqrt(R * R - r * r)) : kAway; }).force,
            exact));
        return checks;
    }

    std::string line_of(const ui::cli::Json& row)
    {
        const auto part = [&](const char* format, const char* key, double scale = 1.0) -> std::string {
            // a value that was not computed is not written
            if (!row.contains(key) || !row.at(key).is_number())
                return {};
            std::array<char, 100> text {};
            std::snprintf(text.data(), text.size(), format, scale * row.at(key).get<double>());
            return text.data();
        };
        std::string name
            = row.at("model").get<std::string>() + " " + row.value("element", "") + ", " + row.value("scene", "");
        name.resize(std::max<std::size_t>(name.size(), 26), ' ');
        return name + part(" %6.0f vertices", "vertices") + part(" %.0f finger(s)", "fingers")
            + part(" on %.0f stations", "stations_pressed") + part(": force %6.2f us mean", "force_us_mean")
            + part(", %6.2f p99.9", "force_us_p999") + part("; surface %.3f ms", "deform_ms_median")
            + part("; same mesh %.1e", "rel_diff_same_mesh")
            + part("; force off the refined P2 by %5.1f %%", "rel_error_vs_reference", 100.0)
            + part("; build %.0f ms", "build_ms") + part("; set down suddenly: %.1f %%", "set_down_error_median", 100.0)
            + part(" (worst %.0f %%) off,", "set_down_error_worst", 100.0)
            + part(" exact after %.0f ms", "set_down_exact_ms_median")
            + part(" (worst %.0f)", "set_down_exact_ms_worst") + part(", felt so after %.0f", "set_down_felt_ms_median")
            + part(" (worst %.0f)", "set_down_felt_ms_worst") + "\n";
    }

} // namespace

void write_palpation_plot(const fs::path& file, const ui::cli::Json& rows, const Job& job)
{
    ui::ChartPicture picture { .x_title = "",
        .y_title = "error of the force against refined P2",
        .panels = {},
        .columns = 2,
        .panel_width = 860,
        .panel_height = 560 };
    for (const auto& [key, title, axis] :
        { std::array { "force_us_mean", "at every tick", "time per tick, microseconds" },
            std::array { "build_ms", "once", "until the first tick, ms" } }) {
        ui::ChartPanel panel;
        panel.title = title;
        panel.x_title = axis;
        std::map<std::string, std::size_t> series_of;
        for (const ui::cli::Json& row : rows) {
            if (!row.contains(key) || !row.contains("rel_error_vs_reference")
                || !row.at("rel_error_vs_reference").is_number())
                continue;
            const auto word = [&](const char* which, const char* before) {
                return row.contains(which) ? before + row.at(which).get<std::string>() : std::string();
            };
            const std::string name = word("model", "") + word("element", " ") + word("scene", ", ");
            const auto [at, added] = series_of.try_emplace(name, panel.series.size());
            if (added)
                panel.series.push_back({ name, {}, {} });
            panel.series[at->second].x.push_back(row.at(key).get<double>());
            panel.series[at->second].y.push_back(std::abs(row.at("rel_error_vs_reference").get<double>()));
        }
        for (ui::ChartSeries& series : panel.series) // remove lines with fewer than two points
            if (series.x.size() == 1) {
                series.x.push_back(series.x.front());
                series.y.push_back(series.y.front());
            }
        picture.panels.push_back(panel);
    }
    ui::OffscreenRenderer renderer(ui::make_offscreen_context(), job);
    ui::write_png(file, renderer.render(picture));
}

ui::cli::Outcome bench_palpate(const PalpateBenchOptions& options, const Job& job)
{
    std::vector<Variant> variants { { "source", haptics::TouchElement::p1, 20, 40, 1, true },
        { "source", haptics::TouchElement::p1, 20, 40, 2, true },
        { "source, 12", haptics::TouchElement::p1, 20, 40, 1, false, 9.0 },
        { "source, 12", haptics::TouchElement::p1, 20, 40, 2, false, 9.0 },
        { "locking-free", haptics::TouchElement::locking_free, 20, 40, 1, false },
        { "quadratic", haptics::TouchElement::p2, 20, 40, 1, true },
        { "quadratic", haptics::TouchElement::p2, 20, 40, 2, false },
        { "5,000", haptics::TouchElement::p1, 34, 73, 1, false } };
    if (options.largest)
        variants.push_back({ "20,000", haptics::TouchElement::p1, 68, 146, 1, false });
    ui::cli::Outcome outcome;
    job.report("bench palpate: reference", 0.0);
    const Reference reference = refined_reference(job);
    ui::cli::Json rows = ui::cli::Json::array();
    for (std::size_t i = 0; i < variants.size() && !job.cancelled(); ++i) {
        job.report("bench palpate", static_cast<double>(i) / static_cast<double>(variants.size()));
        rows.push_back(measure(variants[i], reference, options, job));
        outcome.text += line_of(rows.back());
    }
    if (!job.cancelled())
        for (ui::cli::Json& row : palpation_error_rows(kErrorTicks, job)) {
            outcome.text += line_of(row);
            rows.push_back(std::move(row));
        }
    outcome.document["results"] = rows;
    outcome.document["reference"] = { { "element", "p2" }, { "nodes", reference.nodes }, { "force_N", reference.high },
        { "pulse_N", reference.high - reference.low } };
    if (!job.cancelled()) {
        outcome.document["checks"] = closed_form_checks();
        for (const ui::cli::Json& check : outcome.document["checks"]) {
            std::array<char, 160> line {};
            std::snprintf(line.data(), line.size(), "%-28s %.5f, closed form %.5f: %.2f %% off\n",
                check.at("check").get<std::string>().c_str(), check.at("value").get<double>(),
                check.at("expected").get<double>(), 100.0 * check.at("rel_error").get<double>());
            outcome.text += line.data();
        }
    } else {
        outcome.text += "cancelled\n";
        outcome.exit_code = 1;
    }
    if (!options.out.empty() && !rows.empty()) {
        fs::create_directories(options.out);
        const fs::path plot = fs::path(options.out) / "palpation_error_against_time.png";
        write_palpation_plot(plot, rows, job);
        outcome.document["plot"] = plot.string();
        write_file_atomically(fs::path(options.out) / "bench_palpate.json", outcome.document.dump(2) + "\n");
    }
    return outcome;
}

} // namespace retractor::benchmarks

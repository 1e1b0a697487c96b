// Fingers that press condensed finite elements, springs and spheres through the servo, with devices that fail.

#include "datasets/phantoms/aorta_phantom.h"
#include "haptics/condensed/condensed_tissue.h"
#include "haptics/device/simulated_hand.h"
#include "haptics/device/udp_bridge.h"
#include "haptics/servo/device_mapping.h"
#include "haptics/servo/servo.h"
#include "haptics/spheres/sphere_tissue.h"
#include "haptics/springs/spring_tissue.h"
#include "tests/support/haptics/pressed_check.h"
#include "tests/verification/cli/touch_cases.h"
#include "ui/cli/framework/ball_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace retractor::verification {

namespace {

    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    constexpr double kStep = 1e-3; // s
    constexpr double kTip = 4.0; // mm: a fingertip's radius
    constexpr double kFelt = 0.05; // N: a smaller force does not count as a press
    // mm above and below the surface: the places to which the hand is steered
    constexpr double kClear = 3.0, kDeep = 6.0;

    // Schedule in ticks: the hand presses, lifts off and presses again. The pause is long because the watch on energy
    // softens tissue that was pressed without a force, and the tissue hardens again while the hand is free.
    constexpr std::uint64_t kFault = 600, kSound = 800, kArmed = 900, kLift = 1000, kAgain = 2700, kEnd = 3300;
    constexpr std::uint64_t kMeasured = 50; // number of ticks measured at the end of each press
    constexpr std::uint64_t kWays = 4; // ticks that a force takes from the servo to a remote hand, with a margin
    constexpr std::uint64_t kFades = 101 + kWays; // the ramp of 0.1 s and the tick in which the ramp begins

    haptics::SimulatedHandOptions pressing_hand(const haptics::HandParameters& grip = haptics::relaxed_grip())
    {
        const auto at = [](std::uint64_t tick, double y) {
            return haptics::HandKey { .time_s = kStep * static_cast<double>(tick), .position = Vec3(0.0, y, 0.0) };
        };
        haptics::SimulatedHandOptions options;
        options.hand = grip;
        options.path = haptics::HandPath({ at(0, kClear), at(200, -kDeep), at(kLift, -kDeep), at(kLift + 200, kClear),
            at(kAgain, kClear), at(kAgain + 200, -kDeep) });
        return options;
    }

    /// A hand whose pose is corrupted on its way to the servo.
    class FaultyDevice : public haptics::Device {
    public:
        explicit FaultyDevice(const haptics::HandParameters& grip = haptics::relaxed_grip())
            : hand(pressing_hand(grip))
        {
        }
        [[nodiscard]] const haptics::DeviceInfo& info() const noexcept override { return hand.info(); }
        haptics::DeviceReading read(double time_s, double step_s) noexcept override
        {
            haptics::DeviceReading reading = hand.read(time_s, step_s);
            if (spoil)
                spoil(reading);
            return reading;
        }
        Vec3 write(const Vec3& force) noexcept override { return written = hand.write(force); }

        haptics::SimulatedHand hand;
        std::function<void(haptics::DeviceReading&)> spoil; ///< empty: the pose stays correct
        Vec3 written = Vec3::Zero();
    };

    /// A tissue, and a place on its surface.
    struct Touched {
        std::string model;
        std::unique_ptr<haptics::TissueResponse> tissue;
        Vec3 point = Vec3::Zero(), outward = Vec3::UnitY();
        /// finite elements only: the problem with the stiffness of the tissue
        std::optional<fem::ElasticProblem> problem {};
    };

    /// A short vessel at one pressure.
    Touched vessel(double youngs_modulus)
    {
        datasets::AortaParameters parameters {
            .shape = datasets::AortaParameters::Shape::tube, .length_mm = 40.0, .along = 12
        };
        parameters.region.length_mm = 0.0;
        parameters.normal_MPa = youngs_modulus;
        const datasets::PalpationScene scene = datasets::make_aorta_phantom(parameters);
        Touched touched { "servo, condensed elements", nullptr, scene.site("centre").point,
            scene.site("centre").outward };
        const fem::Material wall { "wall", youngs_modulus, parameters.poissons_ratio, 1e-9, "verification" };
        touched.problem = fem::ElasticProblem { scene.body.mesh, std::vector<fem::Material>(3, wall), {}, {} };
        for (VertexId v = 0; v < static_cast<VertexId>(scene.body.roles.size()); ++v)
            if (scene.body.roles[static_cast<std::size_t>(v)] == datasets::VertexRole::fixed)
                touched.problem->supports.fixed.push_back(v);
        touched.tissue
            = std::make_unique<haptics::CondensedTissue>(scene.body, haptics::PulsePressure::constant(scene.rest_mmHg),
                haptics::CondensedOptions {
                    .element = haptics::TouchElement::p1, .rest_pressure = scene.rest_mmHg * haptics::kMPaPerMmHg });
        return touched;
    }
    Touched soft_vessel() { return vessel(1.0); }

    Touched sheet()
    {
        return { "servo, springs",
            std::make_unique<haptics::SpringTissue>(
                haptics::make_spring_sheet({ .columns = 13, .rows = 13, .spacing = 2.0 }),
                haptics::ElementLaw { .drag = 30.0 }),
            Vec3::Zero(), Vec3::UnitZ() };
    }

    Touched ball()
    {
        constexpr double kRadius = 40.0;
        // N/mm per sphere: stiffer spheres, moved 60 times a second, set the hand swinging
        constexpr double kSoft = 0.004;
        const TriMesh surface = ui::cli::ball_mesh(Vec3::Zero(), kRadius, 4);
        return { "servo, spheres",
            std::make_unique<haptics::SphereTissue>(std::vector { haptics::SphereOrgan { "ball", surface,
                                                        haptics::fill_with_spheres(surface, 2.5), kSoft } },
                haptics::SphereLaw {}),
            Vec3(0.0, 0.0, kRadius), Vec3::UnitZ() };
    }

    /// Condition numbers, for finite elements only: springs take explicit steps, and spheres have no equations.
    void set_condition_of(StabilityRow& row, const Touched& touched)
    {
        if (touched.problem)
            set_condition(row, *touched.problem, fem::Elasticity::linear);
        else
            row.unconditioned
                = touched.tissue->name() == "springs" ? Unconditioned::explicit_steps : Unconditioned::no_matrix;
    }

    /// Returns the answers of another tissue, except in one tick.
    class UnsureTissue : public haptics::TissueResponse {
    public:
        UnsureTissue(haptics::TissueResponse& tissue, std::uint64_t bad_tick)
            : tissue_(tissue)
            , bad_tick_(bad_tick)
        {
        }
        [[nodiscard]] std::string_view name() const noexcept override { return tissue_.name(); }
        [[nodiscard]] std::size_t finger_count() const noexcept override { return tissue_.finger_count(); }
        void tick(double time_s, double step_s, std::span<const haptics::Fingertip> fingers,
            std::span<haptics::FingerContact> contacts) noexcept override
        {
            tissue_.tick(time_s, step_s, fingers, contacts);
            if (ticks_++ == bad_tick_)
                contacts[0].force.setConstant(kNan);
        }
        [[nodiscard]] const TriMesh& surface() const noexcept override { return tissue_.surface(); }
        void follow(Points& deformed) override { tissue_.follow(deformed); }

    private:
        haptics::TissueResponse& tissue_;
        std::uint64_t bad_tick_, ticks_ = 0;
    };

    /// The servo, with checks of its guarantees in every tick.
    class Press {
    public:
        Press(haptics::TissueResponse& tissue, haptics::Device& device, const Touched& touched)
            : tissue_(tissue)
            , servo_({ { .device = &device, .mapping = mapping_onto(touched) } }, tissue, quick_servo())
            , limit_(device.info().limits.max_force)
        {
        }

        /// @throws PromiseNotKept when a force or the tissue's surface is not finite, or when a force exceeds the
        /// device's limit.
        void tick(double step_s = kStep)
        {
            time_ += std::isfinite(step_s) ? step_s : kStep;
            if (before)
                before(time_);
            servo_.tick(time_, step_s);
            constexpr std::uint64_t kFrame = 16; // ticks
            if (++ticks_ % kFrame == 0) {
                tissue_.follow(deformed_);
                if (!deformed_.allFinite())
                    throw PromiseNotKept("the tissue's surface is not finite" + when());
            }
            const haptics::ServoState& state = servo_.latest();
            if (!state.forces[0].allFinite() || !state.fingers[0].position.allFinite())
                throw PromiseNotKept("a force or place is not finite" + when());
        }
        /// @throws as tick(), and when the force that reaches the device is not finite or exceeds the limit.
        void check_force(const Vec3& written) const
        {
            constexpr double kRoundOff = 1e-9;
            if (!(written.norm() <= limit_ + kRoundOff)) // true for NaN
                throw PromiseNotKept("a force of " + std::to_string(written.norm()) + " N went out" + when());
        }
        [[nodiscard]] std::string when() const { return " (tick " + std::to_string(ticks_) + ")"; }
        [[nodiscard]] std::uint64_t ticks() const { return ticks_; }
        [[nodiscard]] double time() const { return time_; }
        haptics::Servo& servo() { return servo_; }

        std::function<void(double time_s)> before; ///< additional work in a tick

    private:
        static haptics::MappingOptions mapping_onto(const Touched& touched)
        {
            return { .scene_centre = touched.point + kTip * touched.outward,
                .scene_from_device = haptics::standing_on(touched.outward) };
        }
        static haptics::ServoOptions quick_servo()
        {
            haptics::ServoOptions options;
            options.faults.ramp_up_s = 0.05;
            return options;
        }

        haptics::TissueResponse& tissue_;
        haptics::Servo servo_;
        double limit_, time_ = 0.0;
        std::uint64_t ticks_ = 0;
        Points deformed_;
    };

    /// A fault that begins at tick kFault.
    struct Trouble {
        const char* name;
        haptics::FaultKind kind; ///< fault that the servo must latch; none: the servo must continue
        std::uint64_t lasts; ///< ticks
        std::function<void(haptics::DeviceReading&)> spoil {};
        double step_s = kStep; ///< length of the first tick of the fault, s
        bool unsure_tissue = false;
    };

    std::function<void(haptics::DeviceReading&)> says(haptics::DeviceTrouble trouble)
    {
        return [trouble](haptics::DeviceReading& reading) { reading.trouble = trouble; };
    }
    std::function<void(haptics::DeviceReading&)> aside(double mm)
    {
        return [mm](haptics::DeviceReading& reading) { reading.position.x() += mm; };
    }

    std::vector<Trouble> troubles()
    {
        constexpr std::uint64_t kLong = kSound - kFault;
        return {
            { "device reports a place of NaN", haptics::FaultKind::bad_position, kLong,
                [](haptics::DeviceReading& r) { r.position.y() = kNan; } },
            { "device jumps by 100 mm in one tick", haptics::FaultKind::jump, kLong, aside(100.0) },
            { "device jumps by 99 mm, and back", haptics::FaultKind::none, 5, aside(99.0) },
            { "device stops answering", haptics::FaultKind::silent, kLong, says(haptics::DeviceTrouble::silent) },
            { "device is unplugged", haptics::FaultKind::lost, kLong, says(haptics::DeviceTrouble::lost) },
            { "device reports a velocity of NaN", haptics::FaultKind::bad_position, 1,
                [](haptics::DeviceReading& r) { r.velocity.x() = kNan; } },
            { "device reports 10 km/s", haptics::FaultKind::bad_position, 1,
                [](haptics::DeviceReading& r) { r.velocity.x() = 1e7; } },
            { "device reports no rotation", haptics::FaultKind::bad_position, 1,
                [](haptics::DeviceReading& r) { r.orientation.setZero(); } },
            { "device has warm motors", haptics::FaultKind::over_limit, kLong,
                says(haptics::DeviceTrouble::over_limit) },
            { "a tick 50 ms late", haptics::FaultKind::late, 1, {}, 0.05 },
            { "a tick at no time", haptics::FaultKind::late, 1, {}, kNan },
            { "tissue answers NaN", haptics::FaultKind::bad_force, 1, {}, kStep, true },
        };
    }
    // number of faults tried with each tissue; the other faults never reach the tissue
    constexpr std::size_t kForEachTissue = 5;

    /// Distance between the place of the fingertip and the elements under the forces of the last press, solved anew
    /// without condensation, relative to the largest depth. Springs and spheres solve no equations.
    double contact_residual(haptics::TissueResponse& tissue)
    {
        auto* condensed = dynamic_cast<haptics::CondensedTissue*>(&tissue);
        if (condensed == nullptr)
            return 0.0;
        const test_support::PressedCheck check = test_support::check_pressed(*condensed);
        return check.deepest_mm > 0.0 ? check.off_mm / check.deepest_mm : kNan;
    }

    /// What a hand feels that presses, lifts off and presses again.
    struct TwoPresses {
        double before = 0.0, after = 0.0; ///< force at the end of each press, N
        haptics::Fault fault; ///< fault between the presses
    };

    /// @param prepare called before each tick; returns the length of the tick.
    /// @param felt the force that pushes the hand
    /// @throws PromiseNotKept when the force grows or returns between a fault and kArmed.
    TwoPresses press_twice(
        Press& press, const std::function<double(std::uint64_t)>& prepare, const std::function<Vec3()>& felt)
    {
        TwoPresses presses;
        std::uint64_t latched_at = 0;
        while (press.ticks() < kEnd) {
            const std::uint64_t tick = press.ticks();
            if (tick == kArmed)
                press.servo().rearm();
            press.tick(prepare(tick));
            press.check_force(felt());
            const double force = felt().norm();
            if (tick < kFault && tick + kMeasured >= kFault)
                presses.before += force / kMeasured;
            if (tick + kMeasured >= kEnd)
                presses.after += force / kMeasured;
            if (tick >= kArmed)
                continue;
            if (latched_at == 0 && press.servo().latest().fault.kind != haptics::FaultKind::none) {
                latched_at = tick;
                presses.fault = press.servo().latest().fault;
            }
            constexpr double kDamping = 0.1; // N: force that the watch on energy may add while the force fades
            if (latched_at != 0 && force > presses.before + kDamping)
                throw PromiseNotKept("the force grew after the servo let go" + press.when());
            if (latched_at != 0 && tick >= latched_at + kFades && force != 0.0)
                throw PromiseNotKept("the force came back before the servo was armed" + press.when());
        }
        return presses;
    }

    /// After the servo is armed again and the finger was lifted, the force must be the same as without a fault.
    void judge(
        StabilityRow& row, const TwoPresses& presses, haptics::FaultKind expected, haptics::TissueResponse& tissue)
    {
        row.residual = contact_residual(tissue);
        row.quantity = "force of the next press against that before, relative";
        row.error = std::abs(presses.after / presses.before - 1.0);
        row.bound = 0.05; // a step of the encoder, 0.055 mm, relative to a depth of millimetres
        if (!(presses.before > kFelt))
            throw PromiseNotKept("the finger felt only " + std::to_string(presses.before) + " N");
        if (presses.fault.kind != expected)
            throw PromiseNotKept("the servo let go for \"" + haptics::describe(presses.fault) + "\"");
        if (!(row.error <= row.bound))
            throw PromiseNotKept("the next press felt " + std::to_string(presses.after) + " N, the one before "
                + std::to_string(presses.before) + " N");
        if (expected != haptics::FaultKind::none)
            refuse(row, "let go: " + haptics::describe(presses.fault));
    }

    void press_through(StabilityRow& row, const Touched& touched, const Trouble& trouble)
    {
        set_condition_of(row, touched);
        FaultyDevice hand;
        UnsureTissue unsure(*touched.tissue, trouble.unsure_tissue ? kFault : kEnd);
        Press press(unsure, hand, touched);
        const auto prepare = [&](std::uint64_t tick) {
            hand.spoil = tick >= kFault && tick < kFault + trouble.lasts ? trouble.spoil : nullptr;
            return tick == kFault ? trouble.step_s : kStep;
        };
        judge(row, press_twice(press, prepare, [&] { return hand.written; }), trouble.kind, *touched.tissue);
    }

    StabilityRow touch_row(const char* name, haptics::FaultKind expected, const Touched& touched,
        const std::function<void(StabilityRow&, const Touched&)>& press)
    {
        StabilityRow row = attempt(name, touched.model, [&](StabilityRow& r) { press(r, touched); });
        if (expected != haptics::FaultKind::none)
            row.allowed = { StabilityOutcome::refused };
        return row;
    }

    /// A device on another computer.
    struct Bridge {
        const char* name;
        haptics::FaultKind kind;
        bool lossy = false; ///< a fifth of the poses of the second press are lost
        bool device_hangs = false, servo_hangs = false; ///< from kFault to kSound
    };
    constexpr std::array<Bridge, 3> kBridges {
        { { "a fifth of a far device's poses lost", haptics::FaultKind::none, true },
            { "a far device's computer hangs", haptics::FaultKind::silent, false, true },
            { "the servo's computer hangs", haptics::FaultKind::late, false, false, true } }
    };

    void press_from_afar(StabilityRow& row, const Touched& touched, const Bridge& bridge)
    {
        set_condition_of(row, touched);
        haptics::SimulatedHand hand(pressing_hand());
        haptics::UdpDevice near;
        haptics::UdpRelay relay(hand, { .servo_port = near.port() });
        Press press(*touched.tissue, near, touched);
        // Simulated ticks run faster than a busy system delivers messages. A late delivery would appear as a silence
        // that is not part of the case.
        const auto arrived = [&](const auto& end) {
            constexpr double kPatience = 30.0; // s
            if (!end.wait(kPatience))
                throw PromiseNotKept("this computer did not deliver a datagram to itself" + press.when());
        };
        bool force_is_due = false;
        press.before = [&](double time_s) {
            const std::uint64_t tick = press.ticks();
            if (force_is_due)
                arrived(relay);
            force_is_due = true; // from the end of this tick on
            const bool lost = bridge.lossy && tick >= kLift && tick % 5 == 0;
            const bool hangs = bridge.device_hangs && tick >= kFault && tick < kSound;
            if (!lost && !hangs) {
                relay.tick(time_s, kStep);
                arrived(near);
            }
        };
        // While no force arrives, the device's side must fade the force by itself.
        const auto hang = [&] {
            constexpr std::uint64_t kPause = kSound - kFault;
            arrived(relay);
            force_is_due = false;
            for (std::uint64_t i = 1; i <= kPause; ++i)
                relay.tick(press.time() + kStep * static_cast<double>(i), kStep);
            if (hand.motor_force().norm() != 0.0)
                throw PromiseNotKept("the far device did not let go on its own");
            return kStep * static_cast<double>(kPause);
        };
        const auto prepare = [&](std::uint64_t tick) { return bridge.servo_hangs && tick == kFault ? hang() : kStep; };
        // When the servo's computer hangs, the device's own watch must act.
        const auto felt = [&]() -> Vec3 {
            const bool hung = bridge.device_hangs && press.ticks() > kFault && press.ticks() <= kSound + kWays;
            return hung ? Vec3::Zero() : hand.motor_force();
        };
        judge(row, press_twice(press, prepare, felt), bridge.kind, *touched.tissue);
    }

    /// A finger at rest on bone: no vibration, and the force is the force of the hand's springs.
    void rest_on_bone(StabilityRow& row, const Touched& touched, const haptics::HandParameters& grip)
    {
        set_condition_of(row, touched);
        FaultyDevice hand(grip);
        Press press(*touched.tissue, hand, touched);
        double sum = 0.0, squares = 0.0, tip = 0.0;
        constexpr std::uint64_t kWatched = 400;
        while (press.ticks() < kLift) {
            press.tick();
            press.check_force(hand.written);
            if (press.ticks() <= kLift - kWatched)
                continue;
            const double force = hand.hand.motor_force().y();
            sum += force / kWatched;
            squares += force * force / kWatched;
            tip += hand.hand.true_position().y() / kWatched;
        }
        if (const haptics::Fault& fault = press.servo().latest().fault; fault.kind != haptics::FaultKind::none)
            throw PromiseNotKept("the servo let go for \"" + haptics::describe(fault) + "\"");
        const double spring = 1.0 / (1.0 / grip.grip_stiffness.y() + 1.0 / grip.arm_stiffness.y());
        if (!(sum > kFelt))
            throw PromiseNotKept("the hand felt only " + std::to_string(sum) + " N");
        row.residual = std::abs(sum - spring * (tip + kDeep)) / sum;
        constexpr double kNotBorne = 2e-3; // relative to the force: a hand that holds loosely still settles
        if (!(row.residual <= kNotBorne))
            throw PromiseNotKept("the hand's springs bear all but " + std::to_string(row.residual) + " of the force");
        row.quantity = "vibration of the force at rest, rms, N";
        row.error = std::sqrt(std::max(0.0, squares - sum * sum));
        row.bound = 0.01; // below the threshold of feeling
        std::array<char, 96> text {};
        (void)std::snprintf(
            text.data(), text.size(), "force %.3f N; the hand's springs bear all but the residual", sum);
        row.reason = text.data();
    }

} // namespace

StabilityCase device_fault_case()
{
    return { "devices that fail", "the servo lets go, says why, stays away, and feels the same once it is armed again",
        [](const Job& job) {
            std::vector<StabilityRow> rows;
            const std::vector<Trouble> all = troubles();
            for (std::size_t t = 0; t < all.size(); ++t)
                for (Touched (*make)() : { soft_vessel, sheet, ball })
                    if (!job.cancelled() && (t < kForEachTissue || make == soft_vessel))
                        rows.push_back(touch_row(all[t].name, all[t].kind, make(),
                            [&](StabilityRow& row, const Touched& touched) { press_through(row, touched, all[t]); }));
            for (const Bridge& bridge : kBridges)
                if (!job.cancelled())
                    rows.push_back(touch_row(bridge.name, bridge.kind, soft_vessel(),
                        [&](StabilityRow& row, const Touched& touched) { press_from_afar(row, touched, bridge); }));
            return rows;
        } };
}

StabilityCase bone_touch_case()
{
    return { "fingers on bone", "10,000 MPa under a hand that holds loosely and one that holds firmly: quiet at rest",
        [](const Job&) {
            std::vector<StabilityRow> rows;
            constexpr double kBone = 1e4; // MPa
            for (const auto& [name, grip] : { std::pair { "a loose hand on bone", haptics::relaxed_grip() },
                     std::pair { "a firm hand on bone", haptics::firm_grip() } })
                rows.push_back(touch_row(name, haptics::FaultKind::none, vessel(kBone),
                    [&, &g = grip](StabilityRow& row, const Touched& touched) { rest_on_bone(row, touched, g); }));
            return rows;
        } };
}

} // namespace retractor::verification

#include "planner/session/palpation_session.h"

#include "haptics/condensed/condensed_tissue.h"
#include "haptics/device/hand_path.h"
#include "haptics/device/simulated_hand.h"
#include "haptics/recording/replay.h"
#include "haptics/servo/device_mapping.h"
#include "haptics/spheres/sphere_tissue.h"
#include "haptics/springs/spring_tissue.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <set>
#include <thread>
#include <utility>

namespace retractor::planner {

static_assert(kMostFingers <= haptics::SphereMotion::kMostFingers && kMostFingers <= haptics::kMaxFingers);

namespace {

    constexpr double kPeriod = 1e-3; // s
    constexpr std::size_t kRecordedTicks = 300'000; ///< five minutes; 41 MB for each finger
    constexpr double kMeasureEvery = 0.5; // s
    /// s; limit of a late tick when no device pushes, so that a short pause of the machine is no fault
    constexpr double kLateWithoutForce = 0.5; // s
    constexpr double kLeastPress = 0.25; ///< mm; a shallower press is no measure for a calibration
    constexpr double kAbove = 12.0; ///< mm between the tissue and a hand that does not press
    constexpr double kReachShare = 0.6; ///< share of the body's diagonal that a device's workspace covers

    bool is_mouse(const std::string& name) { return name == "mouse"; }
    bool is_simulated(const std::string& name) { return name == "simulated" || name == "simulated:firm"; }

    std::string device_of(const PalpationSetup& setup, std::size_t finger)
    {
        return finger < setup.devices.size() ? setup.devices[finger] : "mouse";
    }

    double diagonal_of(const datasets::PalpationScene& scene)
    {
        const Points& p = scene.body.mesh.vertices;
        return (p.colwise().maxCoeff() - p.colwise().minCoeff()).norm();
    }

    /// A device whose time starts when the servo takes it: recordings and hand paths play from their start.
    class FromNow : public haptics::Device {
    public:
        explicit FromNow(haptics::Device& device)
            : device_(device)
        {
        }
        [[nodiscard]] const haptics::DeviceInfo& info() const noexcept override { return device_.info(); }
        haptics::DeviceReading read(double time_s, double step_s) noexcept override
        {
            if (began_ < 0.0)
                began_ = time_s;
            return device_.read(time_s - began_, step_s);
        }
        Vec3 write(const Vec3& force) noexcept override { return device_.write(force); }

    private:
        haptics::Device& device_;
        double began_ = -1.0;
    };

    /// The site where a finger's device works: the first finger at the first site, the second finger opposite.
    datasets::TouchSite site_of(const datasets::PalpationScene& scene, std::size_t finger)
    {
        if (scene.sites.empty())
            throw InputError("has no site where a device could work: take the mouse", scene.name);
        if (finger == 1)
            for (const datasets::TouchSite& site : scene.sites)
                if (site.name == scene.sites.front().name + "-opposite")
                    return site;
        std::vector<const datasets::TouchSite*> plain;
        for (const datasets::TouchSite& site : scene.sites)
            if (!site.name.ends_with("-opposite"))
                plain.push_back(&site);
        return plain.empty() ? scene.sites[finger % scene.sites.size()] : *plain[finger % plain.size()];
    }

    /// Down, two seconds of rest, up, and again; y points out of the tissue.
    haptics::HandPath pressing_path(double radius, double press_mm)
    {
        constexpr double kDown = 1.0, kHold = 2.0, kUp = 0.5, kRest = 0.5;
        constexpr int kTimes = 1000;
        const Vec3 above(0.0, radius + kAbove, 0.0), pressed(0.0, radius - press_mm, 0.0);
        std::vector<haptics::HandKey> keys { { 0.0, above, 0 } };
        for (int i = 0; i < kTimes; ++i) {
            const double t = keys.back().time_s;
            keys.push_back({ t + kDown, pressed, 0 });
            keys.push_back({ t + kDown + kHold, pressed, 0 });
            keys.push_back({ t + kDown + kHold + kUp, above, 0 });
            keys.push_back({ t + kDown + kHold + kUp + kRest, above, 0 });
        }
        return haptics::HandPath(std::move(keys));
    }

} // namespace

std::size_t fingers_of(const std::string& model) { return model == "spheres" ? kMostFingers : 2; }

double fingertip_radius(const datasets::PalpationScene& scene, const haptics::FingerAccess* access)
{
    constexpr double kLargeBody = 200.0; // mm; a larger body is an organ and not a vessel
    const double radius = diagonal_of(scene) < kLargeBody ? 4.0 : 8.0;
    return access != nullptr ? std::min(radius, 0.5 * access->finger().thickness_mm) : radius;
}

haptics::DeviceInfo mouse_info(std::size_t finger)
{
    constexpr double kNoLimit = 1e6;
    haptics::DeviceInfo info { .name = "mouse, finger " + std::to_string(finger + 1) };
    info.limits = { .max_force = kNoLimit,
        .continuous_force = kNoLimit,
        .max_stiffness = kNoLimit,
        .max_damping = 0.0,
        .resolution = 0.0 };
    return info;
}

void WatchedTicks::tick(double time_s, double step_s) noexcept
{
    const double began = haptics::tick_clock_s();
    last_ = offset_ + time_s;
    servo_->tick(last_, step_s);
    const double lasted = haptics::tick_clock_s() - began;
    ticks_.fetch_add(1, std::memory_order_relaxed);
    if (const double periods = std::round(step_s / kPeriod); periods > 1.0)
        missed_.fetch_add(static_cast<std::uint64_t>(periods) - 1, std::memory_order_relaxed);
    busy_.store(busy_.load(std::memory_order_relaxed) + lasted, std::memory_order_relaxed);
    if (lasted > worst_.load(std::memory_order_relaxed))
        worst_.store(lasted, std::memory_order_relaxed);
}

void WatchedTicks::start_again() noexcept { offset_ = last_ + kPeriod; }

/// The devices, their rig, and the source that ticks them.
struct PalpationSession::Hands {
    std::unique_ptr<haptics::DeviceRig> rig; ///< null: no device of these kinds
    std::vector<std::unique_ptr<haptics::SimulatedHand>> simulated;
    std::vector<std::unique_ptr<FromNow>> from_now;
    std::vector<haptics::ServoDevice> devices; ///< one per finger
    haptics::TickThread thread;
    bool pushes = false; ///< whether a device can push a person

    haptics::Device* begin_now(haptics::Device& device)
    {
        from_now.push_back(std::make_unique<FromNow>(device));
        return from_now.back().get();
    }
    haptics::TickSource& source() { return rig != nullptr ? rig->source() : thread; }
};

PalpationSession::PalpationSession(datasets::PalpationScene scene, PalpationSetup setup, PalpationBackend backend,
    std::vector<haptics::PointerDevice*> pointers, const Job& job)
    : scene_(std::move(scene))
    , setup_(std::move(setup))
    , backend_(std::move(backend))
    , pointers_(std::move(pointers))
{
    make_tissue(setup_, job);
    start(open_hands(setup_, tissue_->finger_count()));
}

PalpationSession::~PalpationSession() { stop(); }

void PalpationSession::make_tissue(const PalpationSetup& setup, const Job& job)
{
    double radius = fingertip_radius(scene_); // of the thinnest that may touch it
    for (const ThroughOpening& way : backend_.ways)
        radius = std::min(radius, fingertip_radius(scene_, way.access.get()));
    const TissueChoice wish { .model = setup.model,
        .fingers = fingers_of(setup.model),
        .radius_mm = radius,
        .depth_mm = std::max(setup.press_mm, kLeastPress) };
    if (wish.fingers > pointers_.size())
        throw InputError("there are too few pointers for so many fingers", setup.model);
    ChosenTissue made = backend_.make(scene_, wish, job);
    if (job.cancelled())
        throw InputError("cancelled", scene_.name);
    stop();
    servo_.reset(); // the servo refers to the old tissue
    hindered_.reset(); // refers to the old tissue
    tissue_ = std::move(made.response);
    go_through(setup.through);
    notes_ = std::move(made.notes);
    heart_rate_ = scene_.heart_rate_per_min;
    surface_.reset();
    spheres_.reset();
    strip_.clear();
    health_ = {};
}

std::unique_ptr<PalpationSession::Hands> PalpationSession::open_hands(
    const PalpationSetup& setup, std::size_t fingers) const
{
    auto hands = std::make_unique<Hands>();
    std::vector<std::string> names;
    std::vector<std::size_t> fingers_of_names;
    for (std::size_t f = 0; f < fingers; ++f)
        if (const std::string name = device_of(setup, f); !is_mouse(name) && !is_simulated(name)) {
            names.push_back(name);
            fingers_of_names.push_back(f);
        }
    if (!names.empty())
        hands->rig = std::make_unique<haptics::DeviceRig>(names, haptics::HdOptions {}, fingers_of_names);
    std::size_t rigged = 0;
    const double radius = fingertip_radius(scene_, access_.get());
    for (std::size_t f = 0; f < fingers; ++f) {
        const std::string name = device_of(setup, f);
        if (is_mouse(name)) {
            // The frame of a pointer is the scene's.
            hands->devices.push_back({ pointers_[f], { .clutch_buttons = 0 } });
            continue;
        }
        if (is_simulated(name)) {
            const datasets::TouchSite site = site_of(scene_, f);
            hands->simulated.push_back(std::make_unique<haptics::SimulatedHand>(haptics::SimulatedHandOptions {
                .hand = name == "simulated" ? haptics::relaxed_grip() : haptics::firm_grip(),
                .path = pressing_path(radius, setup.press_mm) }));
            hands->devices.push_back({ hands->begin_now(*hands->simulated.back()),
                { .scene_centre = site.point, .scene_from_device = haptics::standing_on(site.outward) } });
            continue;
        }
        haptics::Device* device = hands->rig->devices()[rigged++];
        std::optional<haptics::SceneFrame> recorded;
        if (const auto* replay = dynamic_cast<const haptics::ReplayDevice*>(device))
            recorded = replay->frame();
        hands->pushes = hands->pushes || haptics::is_live_device(name);
        if (!haptics::is_live_device(name))
            device = hands->begin_now(*device);
        if (recorded) { // a replay continues in its recorded frame
            hands->devices.push_back({ device, haptics::mapping_of(*recorded, device->info().workspace) });
            continue;
        }
        Vec3 centre;
        double covered = kReachShare * diagonal_of(scene_);
        if (access_ != nullptr) { // from the opening to the first site
            const haptics::Opening& opening = access_->opening();
            centre = scene_.sites.empty() ? opening.centre : Vec3(0.5 * (opening.centre + scene_.sites.front().point));
            covered = std::max(opening.length_mm, 2.0 * (opening.centre - centre).norm()) + 2.0 * kAbove;
        } else {
            const datasets::TouchSite site = site_of(scene_, f);
            centre = site.point + (radius + kAbove) * site.outward;
        }
        hands->devices.push_back({ device,
            { .scene_centre = centre,
                .scene_from_device = setup.towards_viewer,
                .scale = haptics::scale_to_cover(device->info().workspace, covered) } });
    }
    return hands;
}

void PalpationSession::start(std::unique_ptr<Hands> hands)
{
    haptics::ServoOptions options;
    for (std::size_t f = 0; f < hands->devices.size(); ++f)
        options.fingers.push_back({ .device = f, .radius = fingertip_radius(scene_, access_.get()) });
    options.force_gain = setup_.force_gain;
    if (!hands->pushes)
        options.faults.late_s = kLateWithoutForce;
    haptics::TissueResponse* touched = tissue_.get();
    if (hindered_ != nullptr)
        touched = hindered_.get();
    servo_ = std::make_unique<haptics::Servo>(hands->devices, *touched, options);
    hands_ = std::move(hands);
    ticks_.watch(servo_.get());
    ticks_.start_again();
    measured_at_ = 0.0;
    hands_->source().start(ticks_);
}

void PalpationSession::stop()
{
    if (hands_ == nullptr)
        return;
    if (hands_->pushes && servo_ != nullptr) {
        servo_->let_go();
        std::this_thread::sleep_for(std::chrono::duration<double>(1.5 * haptics::FaultOptions {}.ramp_down_s));
    }
    hands_->source().stop();
    parked_.clear();
}

void PalpationSession::change(const PalpationSetup& setup, const Job& job)
{
    refuse_while_recording();
    if (!(setup.force_gain > 0.0) || !std::isfinite(setup.force_gain))
        throw InputError("the force gain must be positive and finite", "force gain");
    if (setup.model != setup_.model)
        make_tissue(setup, job); // on failure the former tissue still runs
    stop();
    servo_.reset();
    hands_.reset(); // closes devices before the same device is opened again
    if (setup.through != setup_.through)
        go_through(setup.through);
    setup_ = setup;
    start_or_give_to_mouse([&] { return open_hands(setup_, tissue_->finger_count()); });
}

void PalpationSession::start_or_give_to_mouse(const std::function<std::unique_ptr<Hands>()>& hands)
{
    try {
        start(hands());
    } catch (...) {
        servo_.reset();
        hands_.reset();
        setup_.devices.clear();
        start(open_hands(setup_, tissue_->finger_count()));
        throw;
    }
}

void PalpationSession::refuse_while_recording() const
{
    if (recorder_ != nullptr)
        throw InputError("a recording is under way: stop it first", scene_.name);
}

void PalpationSession::reset(const Job& job)
{
    refuse_while_recording();
    make_tissue(setup_, job);
    start_or_give_to_mouse([&] { return std::move(hands_); });
}

TissueAbilities PalpationSession::abilities() const
{
    TissueAbilities can;
    const bool fem = dynamic_cast<const haptics::CondensedTissue*>(tissue_.get()) != nullptr;
    can.edits = fem;
    can.pulse = fem && has_inner_wall(scene_.body);
    if (const auto* springs = dynamic_cast<const haptics::SpringTissue*>(tissue_.get())) {
        can.grips = true;
        can.pulse = springs->has_pulse();
    }
    if (const auto* spheres = dynamic_cast<const haptics::SphereTissue*>(tissue_.get())) {
        can.grips = can.spheres = true;
        for (std::size_t i = 0; i < spheres->motion().organ_count(); ++i)
            can.organs.push_back(spheres->motion().organ(i).name);
    }
    return can;
}

std::size_t PalpationSession::edit(const haptics::ElasticTemplate& edit)
{
    auto* const condensed = dynamic_cast<haptics::CondensedTissue*>(tissue_.get());
    if (condensed == nullptr)
        throw InputError("only finite elements have an elasticity to edit", std::string(tissue_->name()));
    return condensed->edit(edit);
}

std::vector<haptics::ElasticTemplate> PalpationSession::edits() const
{
    const auto* const condensed = dynamic_cast<const haptics::CondensedTissue*>(tissue_.get());
    return condensed != nullptr ? condensed->edits() : std::vector<haptics::ElasticTemplate>();
}

void PalpationSession::set_heart_rate(double per_min)
{
    if (!abilities().pulse)
        throw InputError("this tissue has no pulse", scene_.name);
    if (auto* const condensed = dynamic_cast<haptics::CondensedTissue*>(tissue_.get()))
        condensed->set_heart_rate(per_min);
    else if (auto* const springs = dynamic_cast<haptics::SpringTissue*>(tissue_.get()))
        springs->set_heart_rate(per_min);
    heart_rate_ = per_min;
}

void PalpationSession::grip(std::size_t finger, bool held)
{
    if (finger >= tissue_->finger_count())
        return;
    if (auto* const spheres = dynamic_cast<haptics::SphereTissue*>(tissue_.get()))
        spheres->want_pinch(finger, held);
    else if (auto* const springs = dynamic_cast<haptics::SpringTissue*>(tissue_.get()))
        springs->grip(finger, held);
}

void PalpationSession::start_recording()
{
    if (recorder_ != nullptr)
        return;
    recorder_ = std::make_unique<haptics::MotionRecorder>(servo_->recorded_devices(), 1.0 / kPeriod, kRecordedTicks);
    recording_since_ = servo_->latest().time_s;
    servo_->record_to(recorder_.get());
}

haptics::MotionRecording PalpationSession::stop_recording(std::size_t& lost)
{
    servo_->record_to(nullptr);
    // The running tick may still write to the recorder.
    const std::uint64_t ticks = ticks_.ticks();
    for (int i = 0; i < 1000 && ticks_.ticks() < ticks + 2; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::unique_ptr<haptics::MotionRecorder> recorder = std::move(recorder_);
    lost = recorder->lost_ticks();
    haptics::MotionRecording recording = recorder->recording();
    if (ticks_.ticks() < ticks + 2)
        parked_.push_back(std::move(recorder)); // a tick may still hold the recorder
    return recording;
}

double PalpationSession::pressure_mmHg()
{
    if (auto* const condensed = dynamic_cast<haptics::CondensedTissue*>(tissue_.get());
        condensed != nullptr && has_inner_wall(scene_.body))
        return (condensed->last_pressure() + condensed->options().rest_pressure) / haptics::kMPaPerMmHg;
    if (const auto* springs = dynamic_cast<const haptics::SpringTissue*>(tissue_.get()))
        return springs->last_pressure() / haptics::kMPaPerMmHg;
    return 0.0;
}

void PalpationSession::add_strip(const haptics::ServoState& state)
{
    if (state.ticks == 0 || (!strip_.empty() && strip_.back().time_s >= state.time_s))
        return;
    StripSample sample { state.time_s, pressure_mmHg(), {} };
    for (std::size_t f = 0; f < state.finger_count; ++f)
        sample.force[f] = state.contacts[f].force.allFinite() ? force_of_tissue(state.contacts[f]) : 0.0;
    strip_.push_back(sample);
    const double oldest = state.time_s - PalpationFrame::kStripSeconds;
    strip_.erase(strip_.begin(),
        std::find_if(strip_.begin(), strip_.end(), [&](const StripSample& s) { return s.time_s >= oldest; }));
}

void PalpationSession::measure_servo()
{
    const double now = haptics::tick_clock_s();
    health_.ticks = ticks_.ticks();
    health_.missed = ticks_.missed();
    health_.note = hands_->rig == nullptr ? hands_->thread.realtime_note() : std::string();
    if (hands_->rig != nullptr)
        for (const haptics::HdProblem& problem : hands_->rig->take_problems())
            health_.device_problem = haptics::describe(problem);
    if (measured_at_ == 0.0 || now - measured_at_ >= kMeasureEvery) {
        const double busy = ticks_.busy_s();
        const auto fresh = static_cast<double>(health_.ticks - ticks_before_);
        if (measured_at_ > 0.0 && fresh > 0.0) {
            health_.rate_hz = fresh / (now - measured_at_);
            health_.mean_us = 1e6 * (busy - busy_before_) / fresh;
            health_.worst_us = 1e6 * ticks_.take_worst_s();
        } else
            health_.rate_hz = 0.0;
        measured_at_ = now;
        busy_before_ = busy;
        ticks_before_ = health_.ticks;
    }
}

/// @pre the servo is stopped
void PalpationSession::go_through(const std::string& name)
{
    hindered_.reset();
    access_.reset();
    reached_.reset();
    reached_share_ = 1.0;
    if (backend_.ways.empty())
        return;
    const auto way = std::ranges::find(backend_.ways, name, &ThroughOpening::name);
    access_ = (way != backend_.ways.end() ? *way : backend_.ways.front()).access;
    hindered_ = std::make_unique<haptics::HinderedTissue>(*tissue_, access_);
}

/// Finds which triangles a finger reaches, with the pad of its tip on their middle.
void PalpationSession::find_reached()
{
    const haptics::FingerAccess& access = *access_;
    const TriMesh& surface = *surface_;
    auto reached = std::make_shared<std::vector<std::uint8_t>>(surface.triangles.size(), 0);
    double area = 0.0, area_reached = 0.0;
    std::size_t gate = 0;
    const double radius = fingertip_radius(scene_, &access);
    std::set<std::array<float, 3>> inner; // places of the inner wall, which no finger from outside touches
    const auto place = [](const auto& row) {
        return std::array<float, 3> { static_cast<float>(row.x()), static_cast<float>(row.y()),
            static_cast<float>(row.z()) };
    };
    for (std::size_t v = 0; v < scene_.body.roles.size(); ++v)
        if (scene_.body.roles[v] == datasets::VertexRole::inner_wall)
            inner.insert(place(scene_.body.mesh.vertices.row(static_cast<Eigen::Index>(v))));
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
        const auto& [a, b, c] = surface.triangles[t];
        const Vec3 p = surface.vertices.row(a), q = surface.vertices.row(b), r = surface.vertices.row(c);
        if (inner.contains(place(p)) || inner.contains(place(q)) || inner.contains(place(r)))
            continue;
        const Vec3 normal = (q - p).cross(r - p);
        const double twice = normal.norm();
        area += twice;
        if (!(twice > 0.0))
            continue;
        const haptics::FingerAccess::Answer answer
            = access.at((p + q + r) / 3.0 + radius / twice * normal, radius, gate);
        gate = answer.gate; // of a neighbour, usually
        (*reached)[t] = answer.fits ? 1 : 0;
        area_reached += answer.fits ? twice : 0.0;
    }
    reached_ = std::move(reached);
    reached_share_ = area > 0.0 ? area_reached / area : 0.0;
}

void PalpationSession::frame(PalpationFrame& frame)
{
    tissue_->follow(frame.shown);
    const TriMesh& surface = tissue_->surface();
    if (surface_ == nullptr || surface_->triangles.size() != surface.triangles.size()) {
        surface_ = std::make_shared<TriMesh>(surface);
        reached_.reset();
    }
    if (access_ != nullptr && reached_ == nullptr)
        find_reached();
    frame.surface = surface_;
    frame.reached = reached_;
    frame.reached_share = reached_share_;
    frame.stiffness_pending = false;
    if (const auto* condensed = dynamic_cast<const haptics::CondensedTissue*>(tissue_.get()))
        frame.stiffness_pending = condensed->edit_pending();
    if (const auto* tissue = dynamic_cast<const haptics::SphereTissue*>(tissue_.get())) {
        const haptics::SphereMotion& motion = tissue->motion();
        if (spheres_ == nullptr) {
            auto set = std::make_shared<SphereSet>();
            for (std::size_t i = 0; i < motion.sphere_count(); ++i) {
                set->radius.push_back(motion.radius_of(i));
                set->organ.push_back(motion.organ_of(i));
            }
            spheres_ = std::move(set);
        }
        frame.sphere_centres = motion.positions();
        frame.sphere_layers.resize(motion.sphere_count());
        for (std::size_t i = 0; i < motion.sphere_count(); ++i)
            frame.sphere_layers[i] = motion.layer(i);
    }
    frame.spheres = spheres_;
    frame.servo = servo_->latest();
    add_strip(frame.servo);
    frame.strip = strip_;
    measure_servo();
    frame.health = health_;
    frame.recorded_s = recorder_ != nullptr ? frame.servo.time_s - recording_since_ : -1.0;
}

} // namespace retractor::planner

#pragma once
// A palpation without a window: tissue, the devices that touch it, the servo between them, and what is to be shown of
// it. The servo runs on its own source (1 kHz); everything else here belongs to one thread, the simulation's, which
// calls frame() at the display's pace. Pointer devices belong to whoever made them and are moved by the window's
// thread. Units mm, s, N, MPa; the frame is the scene's.

#include "datasets/phantoms/elastic_model.h"
#include "haptics/condensed/elastic_template.h"
#include "haptics/device/device_rig.h"
#include "haptics/device/pointer_device.h"
#include "haptics/device/tick_thread.h"
#include "haptics/recording/motion_recording.h"
#include "haptics/servo/servo.h"
#include "mesh/base/job.h"

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace retractor::planner {

struct TissueWish {
    std::string model = "fem";
    std::size_t fingers = 2;
    double radius_mm = 4.0; ///< of a fingertip
    double depth_mm = 1.5; ///< how deep it is meant to press: springs are measured against elements there
};

struct MadeTissue {
    std::unique_ptr<haptics::TissueResponse> response;
    std::vector<std::string> notes; ///< what is to be said of it
};

/// Where tissue comes from.
struct PalpationBackend {
    std::vector<std::string> models;
    /// @throws InputError on a model that cannot serve the scene, saying why.
    std::function<MadeTissue(const datasets::PalpationScene&, const TissueWish&, const Job&)> make;
};

/// Fingers that a model is given, at most kMostFingers.
constexpr std::size_t kMostFingers = 6;
std::size_t fingers_of(const std::string& model);
/// For the size of a body.
double fingertip_radius(const datasets::PalpationScene& scene);

/// Of a pointer that feels nothing: the force that is shown is the tissue's, whatever a device could render.
haptics::DeviceInfo mouse_info(std::size_t finger);

struct PalpationSetup {
    std::string model = "fem";
    /// Per finger: mouse, simulated, simulated:firm, or a name of DeviceRig's; those that are missing are the mouse's.
    std::vector<std::string> devices {};
    double force_gain = 1.0; ///< of all forces on hands: shown when it is not 1
    double press_mm = 1.5; ///< how far simulated hands press; springs are calibrated for it when they are made
    Mat3 towards_viewer = Mat3::Identity(); ///< columns: right, up and out of the picture, for devices on a table
};

struct ServoHealth {
    double rate_hz = 0.0; ///< of late
    std::uint64_t ticks = 0, missed = 0; ///< since the palpation began; missed: whole periods without a tick
    double mean_us = 0.0, worst_us = 0.0; ///< in a tick, of late
    std::string note; ///< why there is no SCHED_FIFO; empty: there is
    std::string device_problem; ///< the last one that a Touch reported on this tissue; empty: none
};

/// One moment of the strip chart.
struct StripSample {
    double time_s = 0.0, pressure_mmHg = 0.0;
    std::array<double, haptics::kMaxFingers> force {}; ///< of the tissue on each finger, N
};

/// The spheres inside: what does not move of them.
struct SphereSet {
    std::vector<double> radius;
    std::vector<std::size_t> organ;
};

/// Everything a window draws, as of one moment.
struct PalpationFrame {
    std::shared_ptr<const TriMesh> surface; ///< at rest; another one after a pinch has divided a polygon
    Points shown; ///< as many rows as surface->vertices
    std::shared_ptr<const SphereSet> spheres; ///< null: there are none
    Points sphere_centres;
    std::vector<int> sphere_layers; ///< how many spheres lie between it and a finger; -1: not moved
    haptics::ServoState servo;
    ServoHealth health;
    std::vector<StripSample> strip; ///< the last kStripSeconds, oldest first
    bool stiffness_pending = false; ///< an edit is not felt yet
    double recorded_s = -1.0; ///< of a recording under way; negative: there is none

    static constexpr double kStripSeconds = 10.0;
};

/// What a tissue can do beside answering.
struct TissueAbilities {
    bool edits = false, pulse = false, grips = false, spheres = false;
    std::vector<std::string> organs; ///< names, by label from 1, where they can be hidden one by one
};

/// Runs the servo, counts its ticks as they come, and lets time go on where another source starts anew.
class WatchedTicks : public haptics::Ticked {
public:
    void watch(haptics::Servo* servo) noexcept { servo_ = servo; } ///< @pre no tick runs
    void tick(double time_s, double step_s) noexcept override;
    void start_again() noexcept; ///< @pre no tick runs: the next time counts from the last

    [[nodiscard]] std::uint64_t ticks() const noexcept { return ticks_.load(std::memory_order_relaxed); }
    [[nodiscard]] std::uint64_t missed() const noexcept { return missed_.load(std::memory_order_relaxed); }
    [[nodiscard]] double busy_s() const noexcept { return busy_.load(std::memory_order_relaxed); }
    /// The longest tick since the last call, s.
    double take_worst_s() noexcept { return worst_.exchange(0.0, std::memory_order_relaxed); }

private:
    haptics::Servo* servo_ = nullptr;
    double offset_ = 0.0, last_ = 0.0;
    std::atomic<std::uint64_t> ticks_ { 0 }, missed_ { 0 };
    std::atomic<double> busy_ { 0.0 }, worst_ { 0.0 };
};

class PalpationSession {
public:
    /// Makes the tissue, opens the devices and starts the servo. @param pointers one for each finger that a model may
    /// have; they live longer. @throws as the backend and DeviceRig do.
    PalpationSession(datasets::PalpationScene scene, PalpationSetup setup, PalpationBackend backend,
        std::vector<haptics::PointerDevice*> pointers, const Job& job);
    /// Lets go first.
    ~PalpationSession();
    PalpationSession(const PalpationSession&) = delete;
    PalpationSession& operator=(const PalpationSession&) = delete;

    [[nodiscard]] const PalpationSetup& setup() const { return setup_; }
    [[nodiscard]] const datasets::PalpationScene& scene() const { return scene_; }
    [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }
    [[nodiscard]] TissueAbilities abilities() const;
    [[nodiscard]] std::size_t finger_count() const { return tissue_->finger_count(); }
    [[nodiscard]] double heart_rate() const { return heart_rate_; } ///< per minute

    /// Makes anew what differs: the tissue for another model, the servo for other devices and gains. When there is no
    /// such tissue everything is as before; when a device cannot be opened the mouse has all fingers.
    /// @throws as the constructor; InputError on a gain that is not positive and while a recording is under way.
    void change(const PalpationSetup& setup, const Job& job);
    /// The scene as it was read: elasticity, heart rate, no grips, armed. When the devices do not start again the mouse
    /// has all fingers. @throws as the backend; InputError while a recording is under way.
    void reset(const Job& job);
    /// Felt some frames later. @return elements changed. @throws InputError as apply(), and where the tissue has no
    /// elasticity to edit.
    std::size_t edit(const haptics::ElasticTemplate& edit);
    /// In force, in order; those that a frame() refused are gone.
    [[nodiscard]] std::vector<haptics::ElasticTemplate> edits() const;
    /// @throws InputError outside 20 to 300 per minute, and where there is no pulse.
    void set_heart_rate(double per_min);
    void grip(std::size_t finger, bool held); ///< nothing where the tissue knows no grip
    void rearm() { servo_->rearm(); }

    [[nodiscard]] bool recording() const { return recorder_ != nullptr; }
    void start_recording(); ///< goes on when one is under way
    /// @pre recording(). @return what was recorded; ticks that found no room any more are said in `lost`.
    haptics::MotionRecording stop_recording(std::size_t& lost);

    /// Brings the tissue to the newest tick and writes down what is to be shown. @throws as follow() does.
    void frame(PalpationFrame& frame);

private:
    struct Hands;
    std::unique_ptr<Hands> open_hands(const PalpationSetup& setup, std::size_t fingers) const;
    void make_tissue(const PalpationSetup& setup, const Job& job);
    void start(std::unique_ptr<Hands> hands);
    void start_or_give_to_mouse(const std::function<std::unique_ptr<Hands>()>& hands);
    void stop();
    void refuse_while_recording() const;
    [[nodiscard]] double pressure_mmHg();
    void add_strip(const haptics::ServoState& state);
    void measure_servo();

    datasets::PalpationScene scene_;
    PalpationSetup setup_;
    PalpationBackend backend_;
    std::vector<haptics::PointerDevice*> pointers_;

    std::unique_ptr<haptics::TissueResponse> tissue_;
    std::vector<std::string> notes_;
    double heart_rate_ = 0.0;
    std::unique_ptr<Hands> hands_;
    WatchedTicks ticks_;
    std::unique_ptr<haptics::Servo> servo_;
    std::unique_ptr<haptics::MotionRecorder> recorder_;
    std::vector<std::unique_ptr<haptics::MotionRecorder>> parked_; ///< done with, until no tick runs
    double recording_since_ = 0.0;

    std::shared_ptr<const TriMesh> surface_;
    std::shared_ptr<const SphereSet> spheres_;
    std::vector<StripSample> strip_;
    ServoHealth health_;
    double measured_at_ = 0.0, busy_before_ = 0.0;
    std::uint64_t ticks_before_ = 0;
};

} // namespace retractor::planner

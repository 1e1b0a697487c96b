#pragma once
// A palpation without a window: tissue, the devices that touch it, the servo between them, and the data to show. The
// servo runs on its own source (1 kHz). Everything else belongs to one thread, the simulation thread, which calls
// frame() at the display's rate. Pointer devices belong to their creator and are moved by the window's thread. Units
// mm, s, N, MPa; frame: the scene's.

#include "datasets/phantoms/elastic_model.h"
#include "haptics/condensed/elastic_template.h"
#include "haptics/device/device_rig.h"
#include "haptics/device/pointer_device.h"
#include "haptics/device/tick_thread.h"
#include "haptics/recording/motion_recording.h"
#include "haptics/servo/servo.h"
#include "haptics/surroundings/hindered_tissue.h"
#include "mesh/base/job.h"
#include "planner/session/tissue_choice.h"

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace retractor::planner {

/// What is put through an opening to touch tissue, and where it fits.
struct ThroughOpening {
    std::string name; ///< "finger", "instrument"
    std::shared_ptr<const haptics::FingerAccess> access;
};

/// The source of tissue.
struct PalpationBackend {
    std::vector<std::string> models = tissue_models();
    /// @throws InputError naming the reason when a model cannot serve the scene
    std::function<ChosenTissue(const datasets::PalpationScene&, const TissueChoice&, const Job&)> make = make_tissue;
    std::vector<ThroughOpening> ways {}; ///< empty: nothing is round the tissue
};

/// Number of fingers of a model, at most kMostFingers.
constexpr std::size_t kMostFingers = 6;
std::size_t fingers_of(const std::string& model);
/// Radius of a fingertip that suits the size of the body, mm; of a finger or instrument in an opening at most half of
/// its thickness. @param access null: nothing is round the tissue
double fingertip_radius(const datasets::PalpationScene& scene, const haptics::FingerAccess* access = nullptr);

/// Properties of a pointer. A pointer feels nothing, so the shown force is the tissue's, without the limits of a
/// device.
haptics::DeviceInfo mouse_info(std::size_t finger);

struct PalpationSetup {
    std::string model = "fem";
    /// Device of each finger: mouse, simulated, simulated:firm, or a name of DeviceRig. Missing entries are the mouse.
    std::vector<std::string> devices {};
    std::string through = "finger"; ///< name among PalpationBackend::ways; another name: the first of them
    double force_gain = 1.0; ///< factor on all forces on hands; shown when it is not 1
    double press_mm = 1.5; ///< depth of a press by simulated hands; new spring tissue is calibrated at this depth
    Mat3 towards_viewer = Mat3::Identity(); ///< columns: right, up and out of the picture, for devices on a table
};

struct ServoHealth {
    double rate_hz = 0.0; ///< recent tick rate
    /// Since the start of the palpation; `missed` counts whole periods without a tick.
    std::uint64_t ticks = 0, missed = 0;
    double mean_us = 0.0, worst_us = 0.0; ///< recent time in a tick
    std::string note; ///< why the servo thread has no SCHED_FIFO; empty: it has
    std::string device_problem; ///< last problem that a Touch reported with this tissue; empty: none
};

/// One moment of the strip chart.
struct StripSample {
    double time_s = 0.0, pressure_mmHg = 0.0;
    std::array<double, haptics::kMaxFingers> force {}; ///< force of the tissue on each finger, N
};

/// The force of the tissue on a finger, N, without what surroundings hold back.
inline double force_of_tissue(const haptics::FingerContact& contact)
{
    return (contact.force - contact.held_back).norm();
}

/// The constant data of the spheres inside.
struct SphereSet {
    std::vector<double> radius;
    std::vector<std::size_t> organ;
};

/// Everything that a window draws at one moment.
struct PalpationFrame {
    std::shared_ptr<const TriMesh> surface; ///< at rest; replaced after a pinch has divided a polygon
    Points shown; ///< deformed positions, as many rows as surface->vertices, mm
    std::shared_ptr<const SphereSet> spheres; ///< null: no spheres
    Points sphere_centres;
    std::vector<int> sphere_layers; ///< per sphere: number of spheres between it and a finger; -1: not moved
    haptics::ServoState servo;
    ServoHealth health;
    std::vector<StripSample> strip; ///< last kStripSeconds, oldest first
    bool stiffness_pending = false; ///< an edit has not taken effect yet
    double recorded_s = -1.0; ///< length of the running recording; negative: none
    /// Through an opening: 1 per triangle of `surface` that a finger reaches, else 0. Null: nothing is round the
    /// tissue.
    std::shared_ptr<const std::vector<std::uint8_t>> reached {};
    double reached_share = 1.0; ///< of the area of `surface`, without the inside of a vessel's wall

    static constexpr double kStripSeconds = 10.0;
};

/// The abilities of a tissue beside contact.
struct TissueAbilities {
    bool edits = false, pulse = false, grips = false, spheres = false;
    std::vector<std::string> organs; ///< names by label from 1, when organs can be hidden one by one
};

/// Runs the servo and counts its ticks. Time continues when another source starts.
class WatchedTicks : public haptics::Ticked {
public:
    void watch(haptics::Servo* servo) noexcept { servo_ = servo; } ///< @pre no tick runs
    void tick(double time_s, double step_s) noexcept override;
    void start_again() noexcept; ///< continues from the last time when a new source starts. @pre no tick runs

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
    /// Makes the tissue, opens the devices and starts the servo.
    /// @param pointers one for each possible finger of a model; they must outlive the session
    /// @throws as the backend and DeviceRig
    PalpationSession(datasets::PalpationScene scene, PalpationSetup setup, PalpationBackend backend,
        std::vector<haptics::PointerDevice*> pointers, const Job& job);
    /// First ramps the force down.
    ~PalpationSession();
    PalpationSession(const PalpationSession&) = delete;
    PalpationSession& operator=(const PalpationSession&) = delete;

    [[nodiscard]] const PalpationSetup& setup() const { return setup_; }
    [[nodiscard]] const datasets::PalpationScene& scene() const { return scene_; }
    [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }
    [[nodiscard]] TissueAbilities abilities() const;
    [[nodiscard]] std::size_t finger_count() const { return tissue_->finger_count(); }
    [[nodiscard]] double heart_rate() const { return heart_rate_; } ///< 1/min

    /// Rebuilds the parts that differ: the tissue for another model, the servo for other devices and gains. When the
    /// tissue cannot be made, nothing changes. When a device cannot be opened, the mouse takes all fingers.
    /// @throws as the constructor; InputError on a gain that is not positive, and during a recording
    void change(const PalpationSetup& setup, const Job& job);
    /// Restores the scene as it was read: elasticity, heart rate, no grips, armed. When the devices do not start again,
    /// the mouse takes all fingers.
    /// @throws as the backend; InputError during a recording
    void reset(const Job& job);
    /// Edits the tissue. The edit is felt some frames later.
    /// @return the number of changed elements
    /// @throws InputError as apply(), and when the tissue has no elasticity to edit
    std::size_t edit(const haptics::ElasticTemplate& edit);
    /// Active edits in order, without edits that a frame() refused.
    [[nodiscard]] std::vector<haptics::ElasticTemplate> edits() const;
    /// @throws InputError outside 20 to 300 per minute, and when there is no pulse
    void set_heart_rate(double per_min);
    void grip(std::size_t finger, bool held); ///< does nothing when the tissue has no grips
    void rearm() { servo_->rearm(); }

    [[nodiscard]] bool recording() const { return recorder_ != nullptr; }
    void start_recording(); ///< does nothing during a recording
    /// @pre recording()
    /// @param lost receives the number of ticks for which there was no more room
    /// @return the recording
    haptics::MotionRecording stop_recording(std::size_t& lost);

    /// Brings the tissue up to the newest tick and writes the data to show. @throws as TissueResponse::follow()
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
    void find_reached();
    void go_through(const std::string& name);

    datasets::PalpationScene scene_;
    PalpationSetup setup_;
    PalpationBackend backend_;
    std::vector<haptics::PointerDevice*> pointers_;

    std::unique_ptr<haptics::TissueResponse> tissue_;
    std::shared_ptr<const haptics::FingerAccess> access_; ///< null: nothing is round the tissue
    std::unique_ptr<haptics::HinderedTissue> hindered_; ///< the tissue through an opening; null: nothing is round it
    std::vector<std::string> notes_;
    double heart_rate_ = 0.0;
    std::unique_ptr<Hands> hands_;
    WatchedTicks ticks_;
    std::unique_ptr<haptics::Servo> servo_;
    std::unique_ptr<haptics::MotionRecorder> recorder_;
    std::vector<std::unique_ptr<haptics::MotionRecorder>> parked_; ///< no longer used, but kept until no tick runs
    double recording_since_ = 0.0;

    std::shared_ptr<const TriMesh> surface_;
    std::shared_ptr<const std::vector<std::uint8_t>> reached_;
    double reached_share_ = 1.0;
    std::shared_ptr<const SphereSet> spheres_;
    std::vector<StripSample> strip_;
    ServoHealth health_;
    double measured_at_ = 0.0, busy_before_ = 0.0;
    std::uint64_t ticks_before_ = 0;
};

} // namespace retractor::planner

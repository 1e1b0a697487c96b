#pragma once
// Runs one press after the other with devices, servo and tissue, and records the results. Simulated and recorded hands
// tick without pauses, with the same result on every machine. A device that runs in real time ticks the whole loop.

#include "haptics/device/hand_path.h"
#include "haptics/recording/motion_recording.h"
#include "haptics/servo/servo_fault.h"
#include "haptics/servo/tissue_response.h"
#include "planner/session/tissue_choice.h"
#include "ui/cli/palpation/palpate_devices.h"

#include <vector>

namespace retractor::ui::cli {

/// The motion and the forces of one finger over time. All vectors have the same length.
struct FingerLog {
    std::string site;
    std::vector<double> time, pressure_mmHg, depth, stiffness, hand_force;
    std::vector<Vec3> position, force; ///< force of the tissue on the finger, with gain
};

/// One press: its fingers, and the surface at the deepest point.
struct PressLog {
    std::string name;
    std::vector<FingerLog> fingers;
    Points deformed;
    std::vector<haptics::Fingertip> deepest; ///< fingers at the deepest point
    long ticks = 0, late_ticks = 0;
    int faults = 0; ///< number of passing faults: late ticks, silence
    std::string fault; ///< fault that ended the press; empty: none
    std::vector<std::string> device_problems; ///< messages of the Touch devices
    haptics::MotionRecording motion; ///< recorded motion of the devices
};

/// A press at several sites at the same time.
struct Press {
    std::string name;
    std::vector<datasets::TouchSite> sites; ///< one per finger
};

/// The place where a recorded motion is played.
enum class ReplayAt {
    scene_or_site, ///< a motion of a mouse, recorded in the scene's frame, at its own place; others at the pressed site
    recorded, ///< at the place of the recording
    site, ///< with the middle of the device's workspace on the pressed site
};

/// The motion of a hand.
struct PressPlan {
    double depth_mm = 2.0, radius_mm = 4.0;
    double seconds = 4.0; ///< time that the finger is down in each press
    int times = 1;
    ReplayAt replay_at = ReplayAt::scene_or_site;
};

constexpr double kPalpateStep = 1e-3; ///< s

/// The path up and down along y, with the site at the origin.
haptics::HandPath press_path(const PressPlan& plan);
/// Interval (s) in which the fingertip is to be down: press `time` of the plan.
std::pair<double, double> held_between(const PressPlan& plan, int time);

/// The device of each finger.
/// @param names one per finger, or one for all
/// @throws InputError on another number of names, or when one device that a person holds would serve all fingers
std::vector<std::string> one_per_finger(const std::vector<std::string>& names, const Press& press);

/// @param device_names one per finger, or one for all
/// @param pressure the pulse, or nullptr
/// @param force_gain gain of the servo
/// @throws InputError on another number of devices, or when the place of a recording is requested and the recording
/// does not have it; SolverError when the servo stops a press with simulated hands
PressLog run_press(const Press& press, haptics::TissueResponse& tissue, const std::vector<std::string>& device_names,
    const PressPlan& plan, const haptics::PulsePressure* pressure, double force_gain, const Job& job);

} // namespace retractor::ui::cli

#pragma once
// One press after the other: devices, servo and tissue brought together, tick by tick, and what came of it. With
// simulated or recorded hands alone the ticks follow each other as fast as they go and are the same on every machine;
// a device that lives in real time ticks everything.

#include "haptics/device/hand_path.h"
#include "haptics/recording/motion_recording.h"
#include "haptics/servo/servo_fault.h"
#include "haptics/servo/tissue_response.h"
#include "planner/session/tissue_choice.h"
#include "ui/cli/palpation/palpate_devices.h"

#include <vector>

namespace retractor::ui::cli {

/// What one finger does and feels over time; all of one length.
struct FingerLog {
    std::string site;
    std::vector<double> time, pressure_mmHg, depth, stiffness, hand_force;
    std::vector<Vec3> position, force; ///< of the tissue on the finger, gain included
};

/// One press: its fingers, and the surface when they were deepest.
struct PressLog {
    std::string name;
    std::vector<FingerLog> fingers;
    Points deformed;
    std::vector<haptics::Fingertip> deepest; ///< fingers, then
    long ticks = 0, late_ticks = 0;
    int faults = 0; ///< that passed: late ticks, silence
    std::string fault; ///< that ended it; empty: none
    std::vector<std::string> device_problems; ///< as Touches reported them
    haptics::MotionRecording motion; ///< of its devices
};

/// Sites that are pressed at the same time.
struct Press {
    std::string name;
    std::vector<datasets::TouchSite> sites; ///< one per finger
};

/// Where a recorded motion is played.
enum class ReplayAt {
    scene_or_site, ///< a mouse's, which was recorded in the scene's own frame, there; others at the site pressed
    recorded, ///< where it was recorded
    site, ///< the middle of the device's workspace on the site pressed
};

/// How a hand goes.
struct PressPlan {
    double depth_mm = 2.0, radius_mm = 4.0;
    double seconds = 4.0; ///< down, each time
    int times = 1;
    ReplayAt replay_at = ReplayAt::scene_or_site;
};

constexpr double kPalpateStep = 1e-3; ///< s

/// Up and down along y, the site at the origin.
haptics::HandPath press_path(const PressPlan& plan);
/// From when to when the fingertip is to be down, s: press `time` of the plan.
std::pair<double, double> held_between(const PressPlan& plan, int time);

/// The device of each finger. @param names one per finger, or one for all
/// @throws InputError on another number, or when all fingers were to be one device that somebody holds.
std::vector<std::string> one_per_finger(const std::vector<std::string>& names, const Press& press);

/// @param device_names one per finger, or one for all; @param pressure the pulse, or nullptr
/// @param force_gain of the servo
/// @throws InputError on another number of devices, and on a recording that does not tell where it was made when that
/// is asked for; SolverError when a press with simulated hands is let go.
PressLog run_press(const Press& press, haptics::TissueResponse& tissue, const std::vector<std::string>& device_names,
    const PressPlan& plan, const haptics::PulsePressure* pressure, double force_gain, const Job& job);

} // namespace retractor::ui::cli

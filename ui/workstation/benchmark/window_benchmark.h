#pragma once
// How the window keeps up with a hand: events are sent to a window on the screen as a mouse sends them, whether or not
// the window has answered, and the pictures that reach the screen are counted.

#include <string>
#include <vector>

namespace retractor::ui {

class MainWindow;

/// One motion of the hand, and the rest after it. Times in ms.
struct MotionFigures {
    std::string picture {}; ///< what is shown: "closed, surgeon", "opened, overview"
    std::string motion {}; ///< "drag" or "wheel"
    int events = 0; ///< of the motion
    double seconds = 0.0; ///< from the first event of the motion to its last
    int pictures = 0; ///< put on the screen within `seconds`, each drawn after the one before
    double pictures_per_s = 0.0;
    /// From the sending of an event of the motion to its handling.
    double delay_median_ms = 0.0, delay_p99_ms = 0.0, delay_largest_ms = 0.0;
    /// The same while the hand rests and sends events without effect: a long drawing of the picture at rest shows here.
    double rest_delay_largest_ms = 0.0;
    double full_ms = 0.0; ///< from the end of the motion until the picture is shown in full quality
};

/// Waits for the case and its closed picture, and measures surgeon's eye, overview and slices (where there is a CT);
/// with `plan`, plans the selected approach and measures the opened field too, alone and in the conference. In each
/// picture it drags with the left button, 60 events a second, which turns a picture in space and moves the point in
/// which slices meet; then it turns the wheel to and fro, 10 notches a second, which zooms or steps through slices.
/// Runs the event loop.
/// @param seconds of each motion
/// @throws InputError when there is nothing to measure, or a motion changes nothing
std::vector<MotionFigures> measure_window(MainWindow& window, bool plan, double seconds = 3.0);

/// The figures and the size of the view in pixels as JSON.
std::string to_json(const std::vector<MotionFigures>& figures, MainWindow& window);

} // namespace retractor::ui

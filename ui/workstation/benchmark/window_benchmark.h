#pragma once
// How the window keeps up with a hand: events are sent to a window on the screen as a mouse sends them, whether or not
// the window has answered, and the pictures that reach the screen are counted.

#include <string>
#include <vector>

namespace retractor::ui {

class MainWindow;

/// One motion of the hand, and the rest after it. Times in ms.
struct MotionFigures {
    std::string picture {}; ///< what is shown: "closed, surgeon", "opened, slices"
    std::string motion {}; ///< "drag" or "wheel"
    int events = 0; ///< of the motion
    double seconds = 0.0; ///< from the first event of the motion to its last
    int pictures = 0; ///< put on the screen within `seconds`, each drawn after the one before
    double pictures_per_s = 0.0;
    /// From an event's sending to its handling. Events without effect are sent on while the hand rests, so that a long
    /// drawing of the picture at rest shows too.
    double delay_median_ms = 0.0, delay_p99_ms = 0.0, delay_largest_ms = 0.0;
    double full_ms = 0.0; ///< from the end of the motion until the picture is shown in full quality
};

/// Drags with the left button for three seconds at 60 events a second, which turns a picture in space and moves the
/// point in which slices meet; then turns the wheel for three seconds at 10 notches a second, to and fro, which zooms
/// or steps through slices. Runs the event loop.
/// @pre the window is shown, idle, and its picture is drawn
std::vector<MotionFigures> measure_motions(MainWindow& window, const std::string& picture);

/// Waits for the case and its closed picture, and measures it in each view; with `plan`, plans the selected approach
/// and measures the opened field too. Runs the event loop.
/// @throws InputError when there is no picture to measure
std::vector<MotionFigures> measure_window(MainWindow& window, bool plan);

/// The figures and the window's size as JSON.
std::string to_json(const std::vector<MotionFigures>& figures, const MainWindow& window);

} // namespace retractor::ui

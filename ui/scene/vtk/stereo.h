#pragma once
// Pictures for two eyes.

#include <cstdint>

class vtkCamera;
class vtkRenderWindow;

namespace retractor::ui {

/// How one picture holds those of two eyes.
enum class Stereo : std::uint8_t {
    off, ///< one eye
    red_cyan, ///< for glasses of these colours, the red one before the left eye
    /// The left eye's picture in the left half, both at half their width: 3D monitors and television sets stretch them.
    side_by_side,
    lines, ///< every other line of the screen for the other eye, for monitors with polarised glasses
};

/// Distance of the two eyes over that of the camera from its aim. Eyes farther apart strain the viewer, and through an
/// endoscope they would stand in its sheath.
inline constexpr double kEyesApartShare = 1.0 / 20.0;

/// Sets this for all further pictures of the window. What lies at the camera's aim lies in the plane of the screen.
void set_stereo(vtkRenderWindow& window, Stereo stereo);

/// The eyes of the camera, by kEyesApartShare. A parallel camera has one eye.
void set_eyes_apart(vtkCamera& camera);

} // namespace retractor::ui

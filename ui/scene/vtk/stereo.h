#pragma once
// Pictures for two eyes: the left eye's and the right eye's in one, for glasses that part them.

class vtkCamera;
class vtkRenderWindow;

namespace retractor::ui {

enum class Stereo {
    off,
    red_cyan, ///< for glasses with a red glass before the left eye, on any screen
    row_by_row, ///< each eye every other row, for passive 3D screens with polarised rows
};

/// Distance of the two eyes, mm: the mean of adults, as in the measures of sight.
inline constexpr double kEyesApartMm = 64.0;

/// All further pictures of the window are drawn so. What lies at the camera's aim lies in the plane of the screen.
void set_stereo(vtkRenderWindow& window, Stereo stereo);

/// The eyes of the camera where it is now. Call again when it has moved. A parallel camera has one eye.
void set_eyes_apart(vtkCamera& camera);

} // namespace retractor::ui

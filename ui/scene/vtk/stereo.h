#pragma once
// Pictures for two eyes: the left eye's in red and the right eye's in cyan, for glasses with such colours, of which the
// red one stands before the left eye.

class vtkCamera;
class vtkRenderWindow;

namespace retractor::ui {

/// Distance of the two eyes over that of the camera from its aim. Eyes farther apart strain the viewer, and through an
/// endoscope they would stand in its sheath.
inline constexpr double kEyesApartShare = 1.0 / 20.0;

/// All further pictures of the window are for two eyes, or for one. What lies at the camera's aim lies in the plane of
/// the screen.
void set_stereo(vtkRenderWindow& window, bool on);

/// The eyes of the camera, by kEyesApartShare. A parallel camera has one eye.
void set_eyes_apart(vtkCamera& camera);

} // namespace retractor::ui

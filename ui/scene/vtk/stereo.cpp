#include "ui/scene/vtk/stereo.h"

#include <vtkCamera.h>
#include <vtkRenderWindow.h>

#include <cmath>
#include <numbers>

namespace retractor::ui {

void set_stereo(vtkRenderWindow& window, bool on)
{
    window.SetStereoTypeToAnaglyph();
    window.SetStereoRender(on ? 1 : 0);
}

void set_eyes_apart(vtkCamera& camera)
{
    const bool one_eye = camera.GetParallelProjection() != 0;
    camera.SetEyeAngle(one_eye ? 0.0 : 2.0 * std::atan(0.5 * kEyesApartShare) * 180.0 / std::numbers::pi);
}

} // namespace retractor::ui

#include "ui/scene/vtk/stereo.h"

#include <vtkCamera.h>
#include <vtkRenderWindow.h>

#include <cmath>
#include <numbers>

namespace retractor::ui {

void set_stereo(vtkRenderWindow& window, Stereo stereo)
{
    if (stereo == Stereo::red_cyan)
        window.SetStereoTypeToAnaglyph();
    else if (stereo == Stereo::row_by_row)
        window.SetStereoTypeToInterlaced();
    window.SetStereoRender(stereo == Stereo::off ? 0 : 1);
}

void set_eyes_apart(vtkCamera& camera)
{
    const double distance_mm = camera.GetDistance();
    const bool one_eye = camera.GetParallelProjection() != 0 || !(distance_mm > 0.0);
    camera.SetEyeAngle(one_eye ? 0.0 : 2.0 * std::atan(0.5 * kEyesApartMm / distance_mm) * 180.0 / std::numbers::pi);
}

} // namespace retractor::ui

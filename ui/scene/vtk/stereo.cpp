#include "ui/scene/vtk/stereo.h"

#include <vtkCamera.h>
#include <vtkRenderWindow.h>

#include <cmath>
#include <numbers>

namespace retractor::ui {

void set_stereo(vtkRenderWindow& window, Stereo stereo)
{
    switch (stereo) {
    case Stereo::side_by_side:
        window.SetStereoTypeToSplitViewportHorizontal();
        break;
    case Stereo::lines:
        window.SetStereoTypeToInterlaced();
        break;
    case Stereo::red_cyan:
    case Stereo::off:
        window.SetStereoTypeToAnaglyph();
        break;
    }
    window.SetStereoRender(stereo == Stereo::off ? 0 : 1);
}

void set_eyes_apart(vtkCamera& camera)
{
    const bool one_eye = camera.GetParallelProjection() != 0;
    camera.SetEyeAngle(one_eye ? 0.0 : 2.0 * std::atan(0.5 * kEyesApartShare) * 180.0 / std::numbers::pi);
}

} // namespace retractor::ui

#include "ui/workstation/view/turn_style.h"

#include <vtkCamera.h>
#include <vtkObjectFactory.h>
#include <vtkRenderer.h>

namespace retractor::ui {

vtkStandardNewMacro(TurnStyle);

bool TurnStyle::on_slice() const
{
    return CurrentRenderer != nullptr && CurrentRenderer->GetActiveCamera()->GetParallelProjection() != 0;
}

void TurnStyle::Rotate()
{
    if (on_slice())
        Pan();
    else
        vtkInteractorStyleTrackballCamera::Rotate();
}

void TurnStyle::Spin()
{
    if (on_slice())
        Pan();
    else
        vtkInteractorStyleTrackballCamera::Spin();
}

} // namespace retractor::ui

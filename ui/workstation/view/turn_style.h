#pragma once
// The mouse turns and zooms the camera in space, and shifts and zooms slices. Keys belong to the window, so VTK's own
// keys are off (3 would switch stereo on, and e would leave the program).

#include <vtkInteractorStyleTrackballCamera.h>

namespace retractor::ui {

class TurnStyle : public vtkInteractorStyleTrackballCamera {
public:
    static TurnStyle* New();
    void OnChar() override { }
    void Rotate() override;
    void Spin() override;

private:
    bool on_slice() const;
};

} // namespace retractor::ui

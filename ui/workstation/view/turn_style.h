#pragma once
// How the mouse moves the camera: turn and zoom in space, only shift and zoom on slices. No letters: keys belong to the
// window (VTK's own would switch stereo on at 3 and leave the program at e).

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

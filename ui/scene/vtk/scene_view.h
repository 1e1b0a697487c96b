#pragma once
// A scene in a VTK window: the same for pictures without a window and for the workstation's.

#include "ui/scene/scene.h"
#include "ui/scene/vtk/volume_actor.h"

#include <memory>

class vtkRenderer;
class vtkRenderWindow;

namespace retractor::ui {

/// One rectangle of a window. Needs the window's size to be set, and its context to exist when shown.
class SceneView {
public:
    /// @param viewport only its rectangle counts. Window and cache must outlive the view.
    SceneView(vtkRenderWindow& window, const Viewport& viewport, VolumeCache& volumes);
    ~SceneView();
    SceneView(SceneView&&) noexcept;
    SceneView& operator=(SceneView&&) noexcept;

    /// Replaces what is shown, camera included. Call again when the window's size has changed.
    /// @throws InputError as check_scene does.
    void show(const Scene& scene);
    void set_camera(const Camera& camera);
    Camera camera() const;
    vtkRenderer& renderer();

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace retractor::ui

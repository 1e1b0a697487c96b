#pragma once
// Shows a scene in a VTK window, for pictures without a window and for the workstation.

#include "ui/scene/scene.h"
#include "ui/scene/vtk/volume_actor.h"

#include <memory>

class vtkRenderer;
class vtkRenderWindow;

namespace retractor::ui {

/// full: translucent surfaces are sorted by depth, and edges are smoothed. fast: neither; of a translucent surface only
/// the faces towards the eye are drawn.
enum class DrawingQuality { full, fast };

/// One rectangle of a window. The window must have a size, and its context must exist when a scene is shown.
class SceneView {
public:
    /// @param viewport only its rectangle is used
    /// @pre window and cache outlive the view
    SceneView(vtkRenderWindow& window, const Viewport& viewport, VolumeCache& volumes,
        DrawingQuality quality = DrawingQuality::full);
    ~SceneView();
    SceneView(SceneView&&) noexcept;

    /// Replaces the scene and the camera. Call again after a change of the window's size.
    /// @throws InputError as check_scene() does
    void show(const Scene& scene);
    void set_camera(const Camera& camera);
    /// Moves the plane, or draws all again.
    void set_cut_away(const std::optional<CutAway>& cut_away);
    Camera camera() const;
    vtkRenderer& renderer();

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace retractor::ui

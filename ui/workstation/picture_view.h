#pragma once
// The picture in the window: the same plain scenes that are drawn off-screen, to be turned by hand. While the camera
// moves, volumes are sampled coarsely; at rest the picture is drawn in full quality.

#include "ui/scene/scene.h"
#include "ui/scene/vtk_errors.h"

#include <QVTKOpenGLNativeWidget.h>

#include <QTimer>

#include <memory>
#include <string>
#include <vector>

class QLabel;

namespace retractor {

class PictureView : public QVTKOpenGLNativeWidget {
public:
    explicit PictureView(QWidget* parent = nullptr);
    ~PictureView() override;

    /// One scene fills the view; several share it in a grid of two columns. Cameras are those of the scenes, except
    /// that slices are fitted into their rectangles. None: the view is empty.
    /// @throws InputError as check_scene does; the view then shows what it showed.
    void show_scenes(std::vector<Scene> scenes);
    const std::vector<Scene>& scenes() const { return scenes_; }

    /// A line over the picture, e.g. what is being waited for; empty: none.
    void show_note(const QString& note);

    /// Draws now, in full quality, and returns what is seen.
    QImage picture();

    /// What the drawing library complained about since the view was made; empty: nothing.
    std::string drawing_errors() const { return errors_.errors(); }

    /// Whether volumes are sampled coarsely now.
    bool coarse() const { return coarse_; }
    /// The camera of the first scene as it stands now, turned by hand or not. @pre a scene is shown and drawn.
    Camera camera() const;

protected:
    void initializeGL() override;
    void resizeEvent(QResizeEvent* event) override;

private:
    /// @param keep_cameras of scenes in space; slices are fitted anew.
    void build(bool keep_cameras);
    void camera_moves();
    void camera_rests();
    void place_note();

    VtkErrorTrap errors_;
    std::vector<Scene> scenes_;
    struct Drawn;
    std::unique_ptr<Drawn> drawn_;
    QTimer rest_timer_, resize_timer_;
    QLabel* note_ = nullptr;
    bool coarse_ = false;
    bool ready_ = false; ///< there is an OpenGL context
};

/// Where scenes of a grid go: one fills everything; more fill rows of two from the top left. Slices are fitted.
std::vector<Viewport> arrange_scenes(const std::vector<Scene>& scenes, double width_px, double height_px);

} // namespace retractor

#pragma once
// The picture in the window: the same plain scenes as off-screen, with a camera that the mouse turns. Volumes are
// sampled coarsely while the camera moves, and in full quality at rest.

#include "planner/session/wall_picture.h"
#include "ui/scene/scene.h"
#include "ui/scene/vtk/vtk_errors.h"

#include <QVTKOpenGLNativeWidget.h>

#include <QTimer>

#include <memory>
#include <string>
#include <vector>

class QLabel;
class QMouseEvent;

namespace retractor::ui {

class LiveProps;

/// A use of the mouse in place of turning the camera.
class PictureTool {
public:
    virtual ~PictureTool() = default;
    virtual void press(const QPointF& at) = 0;
    /// @param held whether the left button is down
    virtual void move(const QPointF& at, bool held) = 0;
    virtual void release(const QPointF& at) = 0;
    /// @param notches away from the user
    /// @return whether the tool used the wheel; otherwise the camera gets it
    virtual bool wheel(double notches);
};

class PictureView : public QVTKOpenGLNativeWidget {
public:
    explicit PictureView(QWidget* parent = nullptr);
    ~PictureView() override;

    /// Shows the scenes. One scene fills the view; several share it in a grid of two columns. Scenes keep their own
    /// cameras, but slices are fitted into their rectangles. No scene: the view is empty.
    /// @throws InputError as check_scene() does; the view then keeps its scenes
    void show_scenes(std::vector<Scene> scenes);
    const std::vector<Scene>& scenes() const { return scenes_; }

    /// Props drawn with the first scene. Their owner changes them between pictures and then calls draw_soon(). Null:
    /// none. Remove the props before they end.
    void set_live(const LiveProps* live);
    bool has_live() const { return live_ != nullptr; }
    /// Draws after about one frame; calls until then share this drawing.
    void draw_soon();
    /// Duration of the last drawing by draw_soon() (ms); 0 before the first.
    double draw_ms() const { return draw_ms_; }

    /// Gives the left button to the tool. The right button, or shift, then turns the camera. Null: all buttons turn the
    /// camera. Remove the tool before it ends.
    void set_tool(PictureTool* tool);
    /// The ray from the eye through a point of the widget into the first scene. @pre one scene is shown and drawn
    planner::Ray ray_at(const QPointF& at) const;

    /// Shows a line over the picture, e.g. the work that is awaited; empty: none.
    void show_note(const QString& note);

    /// Draws now, in full quality, and returns the picture.
    QImage picture();

    /// Errors of the drawing library since the view was made; empty: none.
    std::string drawing_errors() const { return errors_.errors(); }

    /// Whether volumes are sampled coarsely now.
    bool coarse() const { return coarse_; }
    bool is_drawn() const; ///< there is a scene, and a window for it
    /// Whether there is an OpenGL context and the pictures have the view's present size.
    bool ready() const { return ready_ && !resize_timer_.isActive(); }
    /// The present camera of the first scene. @pre a scene is shown and drawn
    Camera camera() const;

protected:
    bool event(QEvent* event) override;
    void initializeGL() override;
    void resizeEvent(QResizeEvent* event) override;

private:
    /// @param keep_cameras keep the cameras of scenes in space; slices are fitted anew
    void build(bool keep_cameras);
    void camera_moves();
    void camera_rests();
    void place_note();
    bool handle_mouse(QMouseEvent& event);
    void add_live();
    void draw_now();

    VtkErrorTrap errors_;
    std::vector<Scene> scenes_;
    struct Drawn;
    std::unique_ptr<Drawn> drawn_;
    QTimer rest_timer_, resize_timer_, draw_timer_;
    QLabel* note_ = nullptr;
    const LiveProps* live_ = nullptr;
    PictureTool* tool_ = nullptr;
    bool turning_ = false; ///< the camera is being turned while there is a tool
    double draw_ms_ = 0.0;
    bool coarse_ = false;
    bool ready_ = false; ///< there is an OpenGL context
};

/// Arranges scenes in a grid: one scene fills everything; more fill rows of two from the top left. Slices are fitted.
std::vector<Viewport> arrange_scenes(const std::vector<Scene>& scenes, double width_px, double height_px);

} // namespace retractor::ui

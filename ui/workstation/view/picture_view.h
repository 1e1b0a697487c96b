#pragma once
// The picture in the window: the same plain scenes that are drawn off-screen, to be turned by hand. While the camera
// moves, volumes are sampled coarsely; at rest the picture is drawn in full quality.

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

/// What the mouse does instead of turning the camera.
class PictureTool {
public:
    virtual ~PictureTool() = default;
    virtual void press(const QPointF& at) = 0;
    /// @param held the left button is down.
    virtual void move(const QPointF& at, bool held) = 0;
    virtual void release(const QPointF& at) = 0;
    /// @param notches away from the user. @return whether it is the tool's; else the camera has it.
    virtual bool wheel(double notches);
};

class PictureView : public QVTKOpenGLNativeWidget {
public:
    explicit PictureView(QWidget* parent = nullptr);
    ~PictureView() override;

    /// One scene fills the view; several share it in a grid of two columns. Cameras are those of the scenes, except
    /// that slices are fitted into their rectangles. None: the view is empty.
    /// @throws InputError as check_scene does; the view then shows what it showed.
    void show_scenes(std::vector<Scene> scenes);
    const std::vector<Scene>& scenes() const { return scenes_; }

    /// Drawn with the first scene, and changed between pictures by its owner, who then calls draw_soon(). Null: none.
    /// Must be taken away before it ends.
    void set_live(const LiveProps* live);
    bool has_live() const { return live_ != nullptr; }
    /// Draws within a frame or so, once for all calls until then.
    void draw_soon();
    /// How long the last picture drawn that way took (ms); 0 before.
    double draw_ms() const { return draw_ms_; }

    /// The left button goes to the tool; the camera is then turned with the right one, or with shift. Null: the camera
    /// has the mouse to itself. The tool must be taken away before it ends.
    void set_tool(PictureTool* tool);
    /// From the eye through a point of the widget, into the first scene. @pre one scene is shown and drawn.
    planner::Ray ray_at(const QPointF& at) const;

    /// A line over the picture, e.g. what is being waited for; empty: none.
    void show_note(const QString& note);

    /// Draws now, in full quality, and returns what is seen.
    QImage picture();

    /// What the drawing library complained about since the view was made; empty: nothing.
    std::string drawing_errors() const { return errors_.errors(); }

    /// Whether volumes are sampled coarsely now.
    bool coarse() const { return coarse_; }
    bool is_drawn() const; ///< there is a scene, and a window to draw it in
    /// Whether there is an OpenGL context and pictures are made for the view's size as it is now.
    bool ready() const { return ready_ && !resize_timer_.isActive(); }
    /// The camera of the first scene as it stands now, turned by hand or not. @pre a scene is shown and drawn.
    Camera camera() const;

protected:
    bool event(QEvent* event) override;
    void initializeGL() override;
    void resizeEvent(QResizeEvent* event) override;

private:
    /// @param keep_cameras of scenes in space; slices are fitted anew.
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

/// Where scenes of a grid go: one fills everything; more fill rows of two from the top left. Slices are fitted.
std::vector<Viewport> arrange_scenes(const std::vector<Scene>& scenes, double width_px, double height_px);

} // namespace retractor::ui

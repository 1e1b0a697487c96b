#pragma once
// The picture in the window: the same plain scenes as off-screen, with a camera that the mouse turns. The window draws
// coarse copies of the scenes, one picture a frame. When the picture rests, another thread draws it in full quality,
// and the window shows that picture until something moves again.

#include "planner/session/wall_picture.h"
#include "ui/scene/scene.h"
#include "mesh/base/vtk_errors.h"
#include "ui/workstation/view/background_picture.h"
#include "ui/workstation/view/moving_resolution.h"

#include <QVTKOpenGLNativeWidget.h>

#include <QCursor>
#include <QTimer>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

class QLabel;
class QMouseEvent;
class QWheelEvent;

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
    /// @return whether the tool used the wheel; otherwise the camera gets it, as always with Ctrl
    virtual bool wheel(const QPointF& at, double notches);
};

/// A place on a slice that the left button drags.
struct SliceHandle {
    std::size_t scene = 0; ///< among those shown
    Vec3 place = Vec3::Zero();
};

/// Calls a function for each press of the left button.
class ClickTool : public PictureTool {
public:
    explicit ClickTool(std::function<void(const QPointF&)> on_click)
        : on_click_(std::move(on_click))
    {
    }
    void press(const QPointF& at) override { on_click_(at); }
    void move(const QPointF&, bool) override { }
    void release(const QPointF&) override { }

private:
    std::function<void(const QPointF&)> on_click_;
};

class PictureView : public QVTKOpenGLNativeWidget {
public:
    explicit PictureView(QWidget* parent = nullptr);
    ~PictureView() override;

    /// Shows the scenes. One scene fills the view; several share it in a grid of two columns. Scenes keep their own
    /// cameras, but slices are fitted into their rectangles. No scene: the view is empty.
    /// @throws InputError as check_scene() does; the view then keeps its scenes
    void show_scenes(std::vector<Scene> scenes);
    /// The triangles of the pictures that follow a motion, of all scenes together. With the default software drawing on
    /// two cores shows about 20 such pictures a second; most of the time then goes into pixels.
    static constexpr std::size_t kCoarseTriangles = 30000;
    /// @pre called before show_scenes()
    void set_coarse_triangles(std::size_t triangles) { coarse_triangles_ = triangles; }
    const std::vector<Scene>& scenes() const { return *scenes_; }
    /// How several scenes share the view; scenes in space keep their cameras.
    void set_layout(SceneLayout layout);
    SceneLayout layout_of_scenes() const { return layout_; }

    /// Shows scenes in space to two eyes; not beside slices, whose greys would suffer. In side by side the mouse means
    /// the same in both halves. Pictures that are saved are for one eye.
    void set_stereo(Stereo stereo);

    /// Whether all scenes in space move alike when the mouse moves one of them.
    void set_linked(bool linked);
    /// The present cameras of the scenes. @pre scenes are shown and drawn
    std::vector<Camera> cameras() const;

    /// Looks at the first scene from another place. @pre a scene is shown and drawn
    void set_camera(const Camera& camera);

    /// Shows another scene in place of one of those shown, from the same place.
    /// @throws InputError as check_scene() does; the view then keeps its scenes
    void replace_scene(std::size_t index, Scene scene);

    /// Moves the plane that cuts a scene away. @pre the scene has a plane
    void move_cut_away(std::size_t index, const CutAway& cut_away);

    /// The handle of the scenes that are shown now; nothing: there is none. It has the left button near its place,
    /// unless a tool has it.
    void set_handle(std::optional<SliceHandle> handle);
    /// The point of the widget at which the handle is shown; nothing: there is none.
    std::optional<QPointF> handle_at() const;
    /// Called while the handle is dragged, with the place of its slice under the mouse, and at the end.
    std::function<void(const Vec3& place, bool last)> on_handle;

    /// Called where the left button is pressed and let go at one place of a scene in space, with the scene's place
    /// among those shown and the ray from the eye. Not while a tool has the mouse.
    std::function<void(std::size_t, const planner::Ray&)> on_space_click;
    /// Called where shift and the wheel ask to move the plane that cuts a scene away, in notches away from the user.
    std::function<void(double)> on_cut_step;

    /// Called where the mouse asks for slices through another point (mm, LPS): the wheel steps through the planes of
    /// the slice under it, the left button names a place on a slice. Empty: the mouse moves the cameras of slices.
    std::function<void(const Vec3&)> on_slice_point;

    /// Called with the place of the scene, among those shown, that was clicked twice. Not while a tool has the mouse.
    std::function<void(std::size_t)> on_double_click;

    /// Props drawn with the first scene. Their owner changes them between pictures and then calls draw_soon(). Null:
    /// none. Remove the props before they end.
    void set_live(const LiveProps* live);
    bool has_live() const { return live_ != nullptr; }
    /// Draws after about one frame; calls until then share this drawing.
    void draw_soon();
    /// Number of the window's own pictures drawn so far.
    int pictures() const { return pictures_; }
    /// Duration of the last drawing by draw_soon() (ms); 0 before the first.
    double draw_ms() const { return draw_ms_; }

    /// Gives the left button to the tool. The right button, or shift, then turns the camera. Null: all buttons turn the
    /// camera. Remove the tool before it ends.
    void set_tool(PictureTool* tool);
    /// The ray from the eye through a point of the widget into the first scene. @pre one scene is shown and drawn
    planner::Ray ray_at(const QPointF& at) const;
    /// The place in the patient under a point of the widget that shows a slice; nothing elsewhere.
    std::optional<Vec3> slice_place_at(const QPointF& at) const;
    /// The plane of the patient that a point of the widget shows; nothing elsewhere.
    std::optional<SlicePlane> slice_plane_at(const QPointF& at) const;
    /// The point of the widget at which the first scene shows a place; nothing behind the eye. @pre as ray_at()
    std::optional<QPointF> shown_at(const Vec3& place) const;

    /// Shows a line over the picture, e.g. the work that is awaited; empty: none.
    void show_note(const QString& note);

    /// Draws in full quality and returns the picture. Waits for it.
    QImage picture();

    /// Called with each full picture that is shown.
    std::function<void(const QImage&)> on_full_picture;

    /// Called when the background could not draw the picture; drawing_errors() says why. The window then draws whole
    /// scenes itself until other scenes are shown.
    std::function<void()> on_drawing_error;
    /// Errors of the drawing library since the view was made; empty: none.
    std::string drawing_errors() const;

    /// Whether the coarse picture is shown now, because something moves or the full picture is not drawn yet. Props
    /// drawn with the first scene are always shown in the window's own, coarse picture.
    bool coarse() const { return coarse_; }
    bool is_drawn() const; ///< there is a scene, and a window for it
    std::string renderer(); ///< name of OpenGL's renderer; "none" without a context
    /// Whether there is an OpenGL context and the pictures have the view's present size.
    bool ready() const { return ready_ && !resize_timer_.isActive(); }
    /// The present camera of the first scene. @pre a scene is shown and drawn
    Camera camera() const;

protected:
    bool event(QEvent* event) override;
    bool take_event(QEvent* event); ///< with the mouse in the picture of one eye
    void initializeGL() override;
    void paintGL() override;
    void resizeEvent(QResizeEvent* event) override;

private:
    /// @param keep_cameras keep the cameras of scenes in space; slices are fitted anew
    void build(bool keep_cameras);
    /// The picture changes: shows the coarse picture and draws it soon.
    void change();
    /// Asks for the full picture where there can be one.
    void rest();
    /// Whether the background can draw the full picture.
    bool can_rest() const;
    bool draws_whole_scenes() const;
    PictureRequest request(Stereo stereo) const;
    /// What is drawn now: no slices, and nothing that is saved, is for two eyes.
    Stereo drawn_stereo() const;
    void show_full(const PictureAnswer& answer);
    void place_note();
    bool handle_mouse(QMouseEvent& event);
    std::vector<Viewport> arranged() const; ///< the scenes as the view shows them
    /// The scene whose linked slice lies under a place of the widget.
    std::optional<std::size_t> slice_at(const QPointF& at) const;
    std::optional<std::size_t> scene_at(const QPointF& at) const;
    /// Asks for slices through a point with the next picture.
    void want_point(const Vec3& point);
    bool step_slice(const QWheelEvent& event);
    bool point_on_slice(const QMouseEvent& event);
    void click_in_space(const QMouseEvent& event);
    bool drag_handle(const QMouseEvent& event);
    void set_over_handle(bool over); ///< the mouse is near the handle: the cursor says so
    /// The point of the widget at which a scene shows a place; nothing behind the eye.
    std::optional<QPointF> shown_in(std::size_t index, const Vec3& place) const;
    bool step_cut(const QWheelEvent& event);
    /// The ray from the eye through a place of the widget into a scene in space.
    planner::Ray ray_into(std::size_t index, const QPointF& at) const;
    void add_live();
    /// Moves the other cameras as the one that has moved since the last picture.
    void move_linked();
    void draw_now();
    /// Measures, once, how long a drawing takes on this machine. @return whether the resolution has changed by it
    bool measure_drawing();
    /// Pixels drawn for each of the widget's, along each side.
    double pixel_ratio() const;
    /// Draws with that many pixels from now on.
    void set_pixel_ratio(double ratio);

    VtkErrorTrap errors_;
    std::shared_ptr<const std::vector<Scene>> scenes_ = std::make_shared<const std::vector<Scene>>();
    std::size_t coarse_share(std::size_t scenes) const;
    std::size_t coarse_triangles_ = kCoarseTriangles;
    std::vector<Scene> coarse_scenes_;
    struct Drawn;
    std::unique_ptr<Drawn> drawn_;
    QTimer rest_timer_, resize_timer_, draw_timer_;
    std::optional<Vec3> wanted_point_; ///< of the slices, not asked for yet
    QLabel* note_ = nullptr;
    QLabel* full_ = nullptr; ///< the full picture, over the coarse picture
    std::string full_error_; ///< why no full picture can be drawn; the window then draws whole scenes itself
    const LiveProps* live_ = nullptr;
    PictureTool* tool_ = nullptr;
    std::optional<Vec3> before_press_; ///< where the slices met before the left button went down last
    std::optional<std::size_t> pointing_; ///< the slice on which the left button went down
    std::optional<SliceHandle> handle_;
    bool dragging_ = false, dragged_ = false; ///< the handle is held, and has been moved
    bool over_handle_ = false;
    QCursor cursor_before_; ///< the mouse came to the handle
    QPointF pressed_at_; ///< where the handle was taken
    std::optional<QPointF> pressed_in_space_; ///< where the left button went down on a scene in space
    bool turning_ = false; ///< the camera is being turned while there is a tool
    double draw_ms_ = 0.0;
    MovingResolution moving_;
    bool measured_ = false; ///< how long a drawing takes here
    int pictures_ = 0;
    bool coarse_ = false;
    bool linked_ = false;
    Stereo stereo_ = Stereo::off; ///< wanted
    int half_ = 0; ///< of a picture side by side: the one in which a button is pressed
    SceneLayout layout_ = SceneLayout::grid;
    std::vector<Camera> drawn_cameras_; ///< of the last picture
    bool ready_ = false; ///< there is an OpenGL context
    bool painting_ = false; ///< Qt paints the widget
    int number_ = 0; ///< of the picture; a full picture with an older number is dropped
    bool saving_ = false; ///< the window itself draws whole scenes
    BackgroundPicture background_; ///< declared last: its thread calls the view until it has ended
};

} // namespace retractor::ui

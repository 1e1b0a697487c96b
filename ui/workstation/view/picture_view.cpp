#include "ui/workstation/view/picture_view.h"

#include "mesh/base/assert.h"
#include "mesh/base/job.h"
#include "ui/scene/vtk/live_surface.h"
#include "ui/scene/vtk/scene_view.h"
#include "ui/workstation/view/turn_style.h"

#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>

#include <QLabel>
#include <QMouseEvent>
#include <QWheelEvent>

#include <cmath>
#include <numbers>
#include <utility>

namespace retractor::ui {

namespace {

    /// A shorter pause in turning starts no full-quality picture, which takes up to a second.
    constexpr int kRestMs = 300;
    constexpr int kResizeMs = 150;
    /// Changes within this time are drawn in one picture.
    constexpr int kFrameMs = 12;
    constexpr double kNotch = 120.0; ///< Qt's angle of one notch of a mouse wheel

    void call(void* function) { (*static_cast<std::function<void()>*>(function))(); }

    vtkSmartPointer<vtkCallbackCommand> command(std::function<void()> function)
    {
        auto made = vtkSmartPointer<vtkCallbackCommand>::New();
        made->SetClientData(new std::function<void()>(std::move(function)));
        made->SetClientDataDeleteCallback([](void* data) { delete static_cast<std::function<void()>*>(data); });
        made->SetCallback([](vtkObject*, unsigned long, void* data, void*) { call(data); });
        return made;
    }

} // namespace

bool PictureTool::wheel(double) { return false; }

struct PictureView::Drawn {
    vtkSmartPointer<vtkGenericOpenGLRenderWindow> window = vtkSmartPointer<vtkGenericOpenGLRenderWindow>::New();
    /// Visible where no scene is.
    vtkSmartPointer<vtkRenderer> backdrop = vtkSmartPointer<vtkRenderer>::New();
    VolumeCache volumes;
    std::vector<SceneView> views;
};

PictureView::PictureView(QWidget* parent)
    : QVTKOpenGLNativeWidget(parent)
    , drawn_(std::make_unique<Drawn>())
{
    drawn_->window->SetMultiSamples(0);
    const Scene empty;
    drawn_->backdrop->SetBackground(empty.background_high.r, empty.background_high.g, empty.background_high.b);
    drawn_->backdrop->SetInteractive(0);
    drawn_->window->AddRenderer(drawn_->backdrop);
    setRenderWindow(drawn_->window);
    setMinimumSize(320, 240);
    setAccessibleName("Picture");

    const auto style = vtkSmartPointer<TurnStyle>::New();
    style->AddObserver(vtkCommand::StartInteractionEvent, command([this] { camera_moves(); }));
    style->AddObserver(vtkCommand::EndInteractionEvent, command([this] { rest_timer_.start(); }));
    interactor()->SetInteractorStyle(style);

    rest_timer_.setSingleShot(true);
    rest_timer_.setInterval(kRestMs);
    connect(&rest_timer_, &QTimer::timeout, this, [this] { camera_rests(); });
    resize_timer_.setSingleShot(true);
    resize_timer_.setInterval(kResizeMs);
    connect(&resize_timer_, &QTimer::timeout, this, [this] { build(true); });

    draw_timer_.setSingleShot(true);
    draw_timer_.setInterval(kFrameMs);
    connect(&draw_timer_, &QTimer::timeout, this, [this] { draw_now(); });

    note_ = new QLabel(this);
    note_->setTextFormat(Qt::PlainText);
    note_->setStyleSheet("background: rgba(20, 24, 28, 210); color: #e4e8eb; padding: 10px 18px; border-radius: 5px;");
    note_->hide();
}

PictureView::~PictureView()
{
    makeCurrent();
    drawn_->views.clear();
    drawn_->backdrop->ReleaseGraphicsResources(drawn_->window);
}

void PictureView::show_scenes(std::vector<Scene> scenes)
{
    for (const Scene& scene : scenes)
        check_scene(scene);
    scenes_ = std::move(scenes);
    build(false);
}

void PictureView::build(bool keep_cameras)
{
    if (!ready_)
        return;
    makeCurrent();
    std::vector<Camera> cameras;
    for (const SceneView& view : drawn_->views)
        cameras.push_back(view.camera());
    drawn_->views.clear();
    const double ratio = devicePixelRatioF();
    for (Viewport& viewport : arrange_scenes(scenes_, ratio * width(), ratio * height())) {
        drawn_->views.emplace_back(*drawn_->window, viewport, drawn_->volumes);
        const std::size_t index = drawn_->views.size() - 1;
        if (keep_cameras && index < cameras.size() && viewport.scene.slices.empty())
            viewport.scene.camera = cameras[index];
        drawn_->views.back().show(viewport.scene);
    }
    add_live();
    drawn_->volumes.sweep();
    drawn_->window->Render();
    update();
}

void PictureView::add_live()
{
    if (live_ == nullptr || drawn_->views.empty())
        return;
    vtkRenderer& renderer = drawn_->views.front().renderer();
    for (vtkProp* prop : live_->props())
        if (renderer.HasViewProp(prop) == 0)
            renderer.AddViewProp(prop);
    renderer.ResetCameraClippingRange();
}

void PictureView::set_live(const LiveProps* live)
{
    if (live_ != nullptr && !drawn_->views.empty()) {
        makeCurrent();
        for (vtkProp* prop : live_->props()) {
            drawn_->views.front().renderer().RemoveViewProp(prop);
            prop->ReleaseGraphicsResources(drawn_->window);
        }
    }
    live_ = live;
    draw_soon();
}

void PictureView::draw_soon()
{
    if (ready_ && !draw_timer_.isActive())
        draw_timer_.start();
}

void PictureView::draw_now()
{
    const Stopwatch watch;
    makeCurrent();
    add_live();
    drawn_->window->Render();
    update();
    draw_ms_ = 1e3 * watch.seconds();
}

void PictureView::set_tool(PictureTool* tool)
{
    tool_ = tool;
    setCursor(tool != nullptr ? Qt::CrossCursor : Qt::ArrowCursor);
}

planner::Ray PictureView::ray_at(const QPointF& at) const
{
    RETRACTOR_ASSERT(is_drawn());
    const Camera camera = this->camera();
    const Vec3 sight = (camera.aim - camera.eye).normalized();
    const Vec3 right = sight.cross(camera.up).normalized(), up = right.cross(sight);
    const double half = 0.5 * height();
    // Relative to half the picture's height.
    const double x = (at.x() - 0.5 * width()) / half, y = (half - at.y()) / half;
    const double slope = std::tan(0.5 * camera.view_angle_deg * std::numbers::pi / 180.0);
    return { camera.eye, (sight + slope * (x * right + y * up)).normalized() };
}

bool PictureView::event(QEvent* event)
{
    switch (event->type()) {
    case QEvent::MouseButtonPress:
    case QEvent::MouseButtonDblClick:
    case QEvent::MouseMove:
    case QEvent::MouseButtonRelease:
        if (tool_ != nullptr && handle_mouse(*static_cast<QMouseEvent*>(event)))
            return true;
        break;
    case QEvent::Wheel:
        if (tool_ != nullptr && tool_->wheel(static_cast<QWheelEvent*>(event)->angleDelta().y() / kNotch)) {
            event->accept();
            return true;
        }
        break;
    default:
        break;
    }
    return QVTKOpenGLNativeWidget::event(event);
}

bool PictureView::handle_mouse(QMouseEvent& event)
{
    const auto as_left_button = [&](QEvent::Type type, Qt::MouseButton button, Qt::MouseButtons buttons) {
        QMouseEvent left(type, event.localPos(), event.windowPos(), event.screenPos(), button, buttons, Qt::NoModifier);
        QVTKOpenGLNativeWidget::event(&left);
    };
    const bool left = event.button() == Qt::LeftButton;
    if (event.type() == QEvent::MouseMove) {
        if (turning_)
            as_left_button(QEvent::MouseMove, Qt::NoButton, Qt::LeftButton);
        else
            tool_->move(event.localPos(), (event.buttons() & Qt::LeftButton) != 0);
    } else if (event.type() == QEvent::MouseButtonRelease) {
        if (std::exchange(turning_, false))
            as_left_button(QEvent::MouseButtonRelease, Qt::LeftButton, Qt::NoButton);
        else if (left)
            tool_->release(event.localPos());
        else
            return false;
    } else if (event.button() == Qt::RightButton || (left && (event.modifiers() & Qt::ShiftModifier) != 0)) {
        turning_ = true;
        as_left_button(QEvent::MouseButtonPress, Qt::LeftButton, Qt::LeftButton);
    } else if (left) {
        tool_->press(event.localPos());
    } else {
        return false; // the middle button still shifts the picture
    }
    event.accept();
    return true;
}

void PictureView::initializeGL()
{
    QVTKOpenGLNativeWidget::initializeGL();
    ready_ = true;
    resize_timer_.start(0);
}

void PictureView::resizeEvent(QResizeEvent* event)
{
    QVTKOpenGLNativeWidget::resizeEvent(event);
    place_note();
    // Words and scale bars depend on the size. They are made again when the size has settled.
    resize_timer_.start(kResizeMs);
}

void PictureView::camera_moves()
{
    rest_timer_.stop();
    coarse_ = true;
    drawn_->volumes.set_interactive(true);
}

void PictureView::camera_rests()
{
    coarse_ = false;
    drawn_->volumes.set_interactive(false);
    drawn_->window->Render();
    update();
}

QImage PictureView::picture()
{
    if (resize_timer_.isActive()) {
        resize_timer_.stop();
        build(true);
    }
    rest_timer_.stop();
    camera_rests();
    return grabFramebuffer();
}

bool PictureView::is_drawn() const { return !drawn_->views.empty(); }

Camera PictureView::camera() const { return drawn_->views.at(0).camera(); }

void PictureView::show_note(const QString& note)
{
    note_->setText(note);
    note_->setVisible(!note.isEmpty());
    place_note();
}

void PictureView::place_note()
{
    note_->adjustSize();
    note_->move((width() - note_->width()) / 2, (height() - note_->height()) / 2);
}

std::vector<Viewport> arrange_scenes(const std::vector<Scene>& scenes, double width_px, double height_px)
{
    std::vector<Viewport> viewports;
    const std::size_t columns = scenes.size() > 1 ? 2 : 1;
    const std::size_t rows = (scenes.size() + columns - 1) / columns;
    for (std::size_t i = 0; i < scenes.size(); ++i) {
        const auto column = static_cast<double>(i % columns), row = static_cast<double>(i / columns);
        Viewport viewport;
        viewport.left = column / static_cast<double>(columns);
        viewport.right = (column + 1.0) / static_cast<double>(columns);
        viewport.top = 1.0 - row / static_cast<double>(rows);
        viewport.bottom = 1.0 - (row + 1.0) / static_cast<double>(rows);
        viewport.scene = scenes[i];
        const double aspect
            = (viewport.right - viewport.left) * width_px / ((viewport.top - viewport.bottom) * height_px);
        if (viewport.scene.slices.size() == 1)
            viewport.scene.camera = camera_for_slice(viewport.scene.slices.front(), aspect);
        viewports.push_back(std::move(viewport));
    }
    return viewports;
}

} // namespace retractor::ui

#include "ui/workstation/view/picture_view.h"

#include "mesh/base/assert.h"
#include "mesh/base/job.h"
#include "ui/scene/arrange_scenes.h"
#include "ui/scene/camera_motion.h"
#include "ui/scene/linked_slices.h"
#include "ui/scene/moving_scene.h"
#include "ui/scene/vtk/live_surface.h"
#include "ui/scene/vtk/scene_view.h"
#include "ui/scene/vtk/stereo.h"
#include "ui/workstation/language/language.h"
#include "ui/workstation/view/turn_style.h"

#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>

#include <QImage>
#include <QLabel>
#include <QLineF>
#include <QMouseEvent>
#include <QOpenGLContext>
#include <QOpenGLFunctions>
#include <QPixmap>
#include <QWheelEvent>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <utility>

namespace retractor::ui {

namespace {

    /// A shorter pause in turning starts no full picture, which takes up to some seconds of a processor.
    constexpr int kRestMs = 200;
    constexpr int kResizeMs = 150;
    constexpr double kStillPx = 4.0; ///< a hand that clicks moves a little
    /// Changes within this time are drawn in one picture.
    constexpr int kFrameMs = 12;
    constexpr double kNotch = 120.0; ///< Qt's angle of one notch of a mouse wheel
    /// Samples slices about once for two pixels of a view of this height.
    void sample_at_pixels(Scene& scene, double height_px)
    {
        constexpr double kPixelsPerSample = 1.5; // along each side
        for (SliceItem& slice : scene.slices)
            slice.pixel_mm = std::max(slice.pixel_mm, kPixelsPerSample * 2.0 * scene.camera.half_height_mm / height_px);
    }

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

bool PictureTool::wheel(const QPointF&, double) { return false; }

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
    , background_([this](PictureAnswer answer) {
        QMetaObject::invokeMethod(
            this, [this, answer = std::move(answer)] { show_full(answer); }, Qt::QueuedConnection);
    })
{
    drawn_->window->SetMultiSamples(0);
    const Scene empty;
    drawn_->backdrop->SetBackground(empty.background_high.r, empty.background_high.g, empty.background_high.b);
    drawn_->backdrop->SetInteractive(0);
    drawn_->window->AddRenderer(drawn_->backdrop);
    setRenderWindow(drawn_->window);
    setMinimumSize(320, 240);
    setAccessibleName("Picture");

    interactor()->SetInteractorStyle(vtkSmartPointer<TurnStyle>::New());
    // VTK would draw at once for every event, and events would queue up behind slow pictures. While Qt paints the
    // widget, VTK asks for a drawing in the same way, and needs it then.
    interactor()->EnableRenderOff();
    interactor()->AddObserver(vtkCommand::RenderEvent, command([this] {
        if (painting_)
            drawn_->window->Render();
        else
            change();
    }));
    drawn_->window->AddObserver(vtkCommand::EndEvent, command([this] { ++pictures_; }));

    rest_timer_.setSingleShot(true);
    rest_timer_.setInterval(kRestMs);
    connect(&rest_timer_, &QTimer::timeout, this, [this] { rest(); });
    resize_timer_.setSingleShot(true);
    resize_timer_.setInterval(kResizeMs);
    connect(&resize_timer_, &QTimer::timeout, this, [this] { build(true); });

    draw_timer_.setSingleShot(true);
    draw_timer_.setInterval(kFrameMs);
    connect(&draw_timer_, &QTimer::timeout, this, [this] { draw_now(); });

    full_ = new QLabel(this);
    full_->setAttribute(Qt::WA_TransparentForMouseEvents);
    full_->hide();
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

/// The triangles of each of several scenes. A picture of slices is drawn again, scene in space included, for every step
/// of a slice.
std::size_t PictureView::coarse_share(std::size_t scenes) const
{
    return scenes > 1 ? coarse_triangles_ / 2 : coarse_triangles_;
}

void PictureView::show_scenes(std::vector<Scene> scenes)
{
    for (Scene& scene : scenes) {
        check_scene(scene);
        translate_texts(scene);
    }
    coarse_scenes_.clear();
    for (const Scene& scene : scenes)
        coarse_scenes_.push_back(moving_scene(scene, coarse_share(scenes.size())));
    scenes_ = std::make_shared<const std::vector<Scene>>(std::move(scenes));
    full_error_.clear(); // other scenes may be drawn in the background again
    pointing_.reset();
    wanted_point_.reset();
    set_handle(std::nullopt);
    build(false);
}

std::vector<Viewport> PictureView::arranged() const { return arrange_scenes(*scenes_, width(), height(), layout_); }

void PictureView::set_layout(SceneLayout layout)
{
    if (layout == layout_)
        return;
    layout_ = layout;
    build(true);
}

void PictureView::replace_scene(std::size_t index, Scene scene)
{
    check_scene(scene);
    translate_texts(scene);
    if (is_drawn()) {
        makeCurrent();
        scene.camera = drawn_->views.at(index).camera();
    }
    auto scenes = std::make_shared<std::vector<Scene>>(*scenes_);
    scenes->at(index) = scene;
    coarse_scenes_.at(index) = moving_scene(std::move(scene), coarse_share(scenes->size()));
    scenes_ = std::move(scenes);
    if (is_drawn()) {
        Scene shown = draws_whole_scenes() ? scenes_->at(index) : coarse_scenes_.at(index);
        const Viewport place = arranged().at(index);
        if (!draws_whole_scenes())
            sample_at_pixels(shown, (place.top - place.bottom) * pixel_ratio() * height());
        drawn_->views.at(index).show(shown);
    }
    change();
}

bool PictureView::draws_whole_scenes() const { return saving_ || !full_error_.empty(); }

void PictureView::build(bool keep_cameras)
{
    if (!ready_)
        return;
    makeCurrent();
    const std::vector<Camera> before = cameras();
    drawn_->views.clear();
    const double ratio = pixel_ratio();
    set_pixel_ratio(ratio);
    const bool whole = draws_whole_scenes();
    ui::set_stereo(*drawn_->window, drawn_stereo());
    drawn_->volumes.set_interactive(!whole);
    for (Viewport& viewport :
        arrange_scenes(whole ? *scenes_ : coarse_scenes_, ratio * width(), ratio * height(), layout_)) {
        drawn_->views.emplace_back(
            *drawn_->window, viewport, drawn_->volumes, whole ? DrawingQuality::full : DrawingQuality::fast);
        const std::size_t index = drawn_->views.size() - 1;
        if (keep_cameras && index < before.size() && viewport.scene.slices.empty())
            viewport.scene.camera = before[index];
        if (!whole)
            sample_at_pixels(viewport.scene, (viewport.top - viewport.bottom) * ratio * height());
        drawn_->views.back().show(viewport.scene);
    }
    drawn_cameras_ = cameras();
    add_live();
    drawn_->volumes.sweep();
    change();
    rest_timer_.start(0);
}

void PictureView::change()
{
    ++number_;
    coarse_ = true;
    full_->hide();
    draw_soon();
    rest_timer_.start(kRestMs);
}

bool PictureView::can_rest() const { return live_ == nullptr && full_error_.empty(); }

PictureRequest PictureView::request(Stereo stereo) const
{
    PictureRequest request {
        .scenes = scenes_, .layout = layout_, .cameras = cameras(), .stereo = stereo, .number = number_
    };
    request.width = static_cast<int>(std::lround(devicePixelRatioF() * width()));
    request.height = static_cast<int>(std::lround(devicePixelRatioF() * height()));
    return request;
}

double PictureView::pixel_ratio() const
{
    // What stays on the screen, because no full picture follows it, is as fine as the screen.
    return devicePixelRatioF() * (can_rest() && !saving_ ? moving_.scale() : 1.0);
}

void PictureView::set_pixel_ratio(double ratio)
{
    // The letters are sized in pixels of the picture. VTK's widget would enlarge them by the ratio once more.
    constexpr int kLetterDpi = 72; // VTK's own, at which a font's size is its height in pixels
    setUnscaledDPI(static_cast<int>(std::lround(kLetterDpi / ratio)));
    drawn_->window->SetDPI(kLetterDpi);
    const double before = effectiveDevicePixelRatio();
    if (ratio == before)
        return;
    setCustomDevicePixelRatio(ratio == devicePixelRatioF() ? 0.0 : ratio); // 0: as Qt has it, on each screen
    const int across = static_cast<int>(std::lround(ratio * width())),
              down = static_cast<int>(std::lround(ratio * height()));
    drawn_->window->SetSize(across, down);
    interactor()->SetSize(across, down); // counts the mouse's rows from below
    // A drag goes on from where the mouse is, in the new pixels.
    int at[2] = { 0, 0 };
    interactor()->GetEventPosition(at);
    interactor()->SetEventPosition(
        static_cast<int>(std::lround(at[0] * ratio / before)), static_cast<int>(std::lround(at[1] * ratio / before)));
}

bool PictureView::measure_drawing()
{
    // An empty scene says nothing.
    if (measured_ || std::all_of(scenes_->begin(), scenes_->end(), [](const Scene& scene) {
            return scene.surfaces.empty() && scene.volumes.empty();
        }))
        return false;
    measured_ = true;
    makeCurrent();
    double quickest_ms = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 2; ++i) {
        const Stopwatch watch;
        drawn_->window->Render();
        quickest_ms = std::min(quickest_ms, 1e3 * watch.seconds());
    }
    return moving_.begin(quickest_ms);
}

void PictureView::rest()
{
    if (can_rest() && is_drawn() && (measure_drawing() || moving_.rested())) {
        build(true);
        return; // it rests again at once
    }
    if (can_rest() && is_drawn())
        background_.request(request(drawn_stereo()));
    else
        coarse_ = false;
}

void PictureView::show_full(const PictureAnswer& answer)
{
    if (answer.number != number_ || live_ != nullptr)
        return;
    if (answer.image.isNull()) {
        full_error_ = answer.error;
        build(true);
        if (on_drawing_error)
            on_drawing_error();
        return;
    }
    coarse_ = false;
    QPixmap pixmap = QPixmap::fromImage(answer.image);
    pixmap.setDevicePixelRatio(devicePixelRatioF());
    full_->setPixmap(pixmap);
    full_->setGeometry(rect());
    full_->show();
    if (on_full_picture && drawn_stereo() == Stereo::off)
        on_full_picture(answer.image);
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
    if (pixel_ratio() != effectiveDevicePixelRatio())
        build(true);
    else
        change();
}

void PictureView::draw_soon()
{
    if (ready_ && !draw_timer_.isActive())
        draw_timer_.start();
}

void PictureView::set_stereo(Stereo stereo)
{
    stereo_ = stereo;
    build(true);
}

Stereo PictureView::drawn_stereo() const
{
    const bool in_space
        = std::all_of(scenes_->begin(), scenes_->end(), [](const Scene& scene) { return scene.slices.empty(); });
    return saving_ || !in_space ? Stereo::off : stereo_;
}

void PictureView::set_linked(bool linked)
{
    linked_ = linked;
    drawn_cameras_ = cameras();
}

void PictureView::set_camera(const Camera& camera)
{
    RETRACTOR_ASSERT(is_drawn());
    makeCurrent();
    drawn_->views.front().set_camera(camera);
    change();
}

std::vector<Camera> PictureView::cameras() const
{
    std::vector<Camera> cameras;
    for (const SceneView& view : drawn_->views)
        cameras.push_back(view.camera());
    return cameras;
}

void PictureView::move_linked()
{
    if (!linked_)
        return;
    const auto same = [](const Camera& a, const Camera& b) {
        return a.eye == b.eye && a.aim == b.aim && a.up == b.up && a.view_angle_deg == b.view_angle_deg
            && a.half_height_mm == b.half_height_mm;
    };
    const std::vector<Camera> now = cameras();
    if (now.size() == drawn_cameras_.size()) {
        const auto moved = std::mismatch(now.begin(), now.end(), drawn_cameras_.begin(), same);
        if (moved.first != now.end())
            for (std::size_t i = 0; i < now.size(); ++i)
                if (now[i].parallel == moved.first->parallel && &now[i] != &*moved.first)
                    drawn_->views[i].set_camera(moved_alike(now[i], *moved.second, *moved.first));
    }
    drawn_cameras_ = cameras();
}

void PictureView::draw_now()
{
    const Stopwatch watch;
    if (const auto point = std::exchange(wanted_point_, std::nullopt); point && on_slice_point)
        on_slice_point(*point);
    draw_timer_.stop(); // this picture shows all changes
    makeCurrent();
    move_linked();
    add_live();
    const Stopwatch drawing;
    drawn_->window->Render();
    const double render_ms = 1e3 * drawing.seconds(); // slices that are cut anew take time too, at any resolution
    update();
    draw_ms_ = 1e3 * watch.seconds();
    if (can_rest() && !saving_ && is_drawn() && moving_.drawn(render_ms)) {
        build(true);
        rest_timer_.start(kRestMs); // the motion goes on
    }
}

void PictureView::set_tool(PictureTool* tool)
{
    tool_ = tool;
    pointing_.reset();
    dragging_ = false;
    set_over_handle(false);
    setCursor(tool != nullptr ? Qt::CrossCursor : Qt::ArrowCursor);
}

planner::Ray PictureView::ray_at(const QPointF& at) const
{
    RETRACTOR_ASSERT(is_drawn());
    return ray_into(0, at);
}

std::optional<Vec3> PictureView::slice_place_at(const QPointF& at) const
{
    if (!is_drawn())
        return std::nullopt;
    const double across = at.x() / width(), up = 1.0 - at.y() / height();
    const std::vector<Viewport> viewports = arranged();
    for (std::size_t i = 0; i < viewports.size() && i < drawn_->views.size(); ++i) {
        const Viewport& v = viewports[i];
        if (v.scene.slices.size() != 1 || across < v.left || across >= v.right || up < v.bottom || up >= v.top)
            continue;
        const double wide = v.right - v.left, high = v.top - v.bottom;
        return place_on_slice(v.scene.slices.front(), drawn_->views[i].camera(), (across - v.left) / wide,
            (up - v.bottom) / high, wide * width() / (high * height()));
    }
    return std::nullopt;
}

std::optional<QPointF> PictureView::shown_in(std::size_t index, const Vec3& place) const
{
    RETRACTOR_ASSERT(is_drawn());
    const Viewport in = arranged().at(index);
    const Camera camera = drawn_->views.at(index).camera();
    const Vec3 sight = (camera.aim - camera.eye).normalized();
    const Vec3 right = sight.cross(camera.up).normalized(), up = right.cross(sight);
    const double depth = (place - camera.eye).dot(sight);
    if (!camera.parallel && !(depth > 0.0))
        return std::nullopt;
    const double half = 0.5 * (in.top - in.bottom) * height();
    const double half_mm = camera.parallel ? camera.half_height_mm
                                           : depth * std::tan(0.5 * camera.view_angle_deg * std::numbers::pi / 180.0);
    const QPointF middle(0.5 * (in.left + in.right) * width(), (1.0 - 0.5 * (in.bottom + in.top)) * height());
    return middle + half / half_mm * QPointF((place - camera.eye).dot(right), -(place - camera.eye).dot(up));
}

std::optional<QPointF> PictureView::shown_at(const Vec3& place) const { return shown_in(0, place); }

void PictureView::set_handle(std::optional<SliceHandle> handle)
{
    handle_ = handle;
    dragging_ = dragging_ && handle_;
    if (!handle_)
        set_over_handle(false);
}

std::optional<QPointF> PictureView::handle_at() const
{
    return handle_ && is_drawn() && handle_->scene < drawn_->views.size() ? shown_in(handle_->scene, handle_->place)
                                                                          : std::nullopt;
}

void PictureView::set_over_handle(bool over)
{
    if (over == over_handle_)
        return;
    over_handle_ = over;
    if (over) {
        cursor_before_ = cursor();
        setCursor(Qt::SizeAllCursor);
    } else {
        setCursor(cursor_before_);
    }
}

bool PictureView::drag_handle(const QMouseEvent& event)
{
    constexpr double kNearPx = 14.0;
    const auto at = handle_at();
    if (!at)
        return false;
    const bool near = QLineF(*at, event.localPos()).length() <= kNearPx;
    if (event.type() == QEvent::MouseButtonPress && event.button() == Qt::LeftButton
        && event.modifiers() == Qt::NoModifier) {
        dragging_ = near;
        dragged_ = false;
        pressed_at_ = event.localPos();
    }
    if ((event.buttons() & Qt::LeftButton) == 0 && event.type() == QEvent::MouseMove) {
        dragging_ = false; // the button went up elsewhere
        set_over_handle(near);
    }
    if (!dragging_)
        return false;
    const bool last = event.type() == QEvent::MouseButtonRelease && event.button() == Qt::LeftButton;
    dragged_ = dragged_ || QLineF(pressed_at_, event.localPos()).length() > kStillPx;
    if (last)
        dragging_ = false;
    const auto place = scene_at(event.localPos()) == handle_->scene ? slice_place_at(event.localPos()) : std::nullopt;
    if (dragged_ && (place || last) && on_handle)
        on_handle(place.value_or(handle_->place), last);
    return true;
}

bool PictureView::event(QEvent* event)
{
    const bool of_mouse = event->type() == QEvent::MouseButtonPress || event->type() == QEvent::MouseMove
        || event->type() == QEvent::MouseButtonRelease || event->type() == QEvent::MouseButtonDblClick;
    if (!of_mouse || drawn_stereo() != Stereo::side_by_side)
        return take_event(event);
    // Each half shows the whole picture at half its width. A drag stays in the half in which it began.
    const auto& mouse = *static_cast<QMouseEvent*>(event);
    const double half_width = 0.5 * width();
    if (event->type() != QEvent::MouseButtonRelease && (mouse.buttons() & ~mouse.button()) == Qt::NoButton)
        half_ = mouse.localPos().x() < half_width ? 0 : 1;
    const QPointF place(2.0 * (mouse.localPos().x() - half_ * half_width), mouse.localPos().y());
    QMouseEvent in_one_eye(
        mouse.type(), place, mouse.windowPos(), mouse.screenPos(), mouse.button(), mouse.buttons(), mouse.modifiers());
    const bool taken = take_event(&in_one_eye);
    event->setAccepted(in_one_eye.isAccepted());
    return taken;
}

bool PictureView::take_event(QEvent* event)
{
    switch (event->type()) {
    case QEvent::MouseButtonDblClick:
        if (const auto& click = *static_cast<QMouseEvent*>(event); tool_ == nullptr && on_double_click
            && click.button() == Qt::LeftButton && click.modifiers() == Qt::NoModifier)
            if (const auto index = scene_at(click.localPos())) {
                pointing_.reset();
                wanted_point_.reset();
                if (before_press_ && on_slice_point) // the first click has moved the slices
                    on_slice_point(*std::exchange(before_press_, std::nullopt));
                on_double_click(*index);
                return true;
            }
        [[fallthrough]];
    case QEvent::MouseButtonPress:
    case QEvent::MouseMove:
    case QEvent::MouseButtonRelease:
        if (tool_ != nullptr && handle_mouse(*static_cast<QMouseEvent*>(event)))
            return true;
        if (tool_ == nullptr
            && (drag_handle(*static_cast<QMouseEvent*>(event)) || point_on_slice(*static_cast<QMouseEvent*>(event))))
            return true;
        if (tool_ == nullptr)
            click_in_space(*static_cast<QMouseEvent*>(event));
        break;
    case QEvent::Wheel:
        if (const auto& wheel = *static_cast<QWheelEvent*>(event); tool_ != nullptr
            && (wheel.modifiers() & Qt::ControlModifier) == 0
            && tool_->wheel(wheel.position(), wheel.angleDelta().y() / kNotch)) {
            event->accept();
            return true;
        }
        if (step_slice(*static_cast<QWheelEvent*>(event)) || step_cut(*static_cast<QWheelEvent*>(event)))
            return true;
        if (const double ratio = effectiveDevicePixelRatio(); ratio != 1.0) {
            // VTK 9.1 scales the place of a press and of a move to the picture's pixels, but not that of the wheel.
            const auto& wheel = *static_cast<QWheelEvent*>(event);
            QWheelEvent scaled(ratio * wheel.position(), wheel.globalPosition(), wheel.pixelDelta(), wheel.angleDelta(),
                wheel.buttons(), wheel.modifiers(), wheel.phase(), wheel.inverted());
            return QVTKOpenGLNativeWidget::event(&scaled);
        }
        break;
    default:
        break;
    }
    return QVTKOpenGLNativeWidget::event(event);
}

std::optional<std::size_t> PictureView::slice_at(const QPointF& at) const
{
    if (!on_slice_point || !is_drawn())
        return std::nullopt;
    const double across = at.x() / width(), up = 1.0 - at.y() / height();
    const std::vector<Viewport> viewports = arranged();
    for (std::size_t i = 0; i < viewports.size(); ++i) {
        const Viewport& v = viewports[i];
        if (is_linked_slice(v.scene) && across >= v.left && across < v.right && up >= v.bottom && up < v.top)
            return i;
    }
    return std::nullopt;
}

std::optional<std::size_t> PictureView::scene_at(const QPointF& at) const
{
    if (!is_drawn())
        return std::nullopt;
    const double across = at.x() / width(), up = 1.0 - at.y() / height();
    const std::vector<Viewport> viewports = arranged();
    for (std::size_t i = 0; i < viewports.size(); ++i) {
        const Viewport& v = viewports[i];
        if (across >= v.left && across < v.right && up >= v.bottom && up < v.top)
            return i;
    }
    return std::nullopt;
}

std::string PictureView::renderer()
{
    if (context() == nullptr)
        return "none";
    makeCurrent();
    const auto* name = context()->functions()->glGetString(GL_RENDERER);
    std::string text = name == nullptr ? "none" : reinterpret_cast<const char*>(name);
    doneCurrent();
    return text;
}

std::optional<SlicePlane> PictureView::slice_plane_at(const QPointF& at) const
{
    const auto index = slice_at(at);
    return index ? std::optional((*scenes_)[*index].slices.front().plane) : std::nullopt;
}

void PictureView::want_point(const Vec3& point)
{
    wanted_point_ = point;
    draw_soon();
}

bool PictureView::step_slice(const QWheelEvent& event)
{
    const auto index = slice_at(event.position());
    if (!index || (event.modifiers() & Qt::ControlModifier) != 0)
        return false;
    SliceItem slice = (*scenes_)[*index].slices.front();
    slice.point = wanted_point_.value_or(slice.point);
    want_point(stepped(slice, event.angleDelta().y() / kNotch));
    return true;
}

bool PictureView::point_on_slice(const QMouseEvent& event)
{
    if (event.type() == QEvent::MouseButtonRelease && event.button() == Qt::LeftButton)
        return std::exchange(pointing_, std::nullopt).has_value();
    const bool pressed = event.type() == QEvent::MouseButtonPress || event.type() == QEvent::MouseButtonDblClick;
    if (pressed && event.button() == Qt::LeftButton && event.modifiers() == Qt::NoModifier) {
        pointing_ = slice_at(event.localPos());
        before_press_ = pointing_ ? std::optional((*scenes_)[*pointing_].slices.front().point) : std::nullopt;
    }
    if ((event.buttons() & Qt::LeftButton) == 0)
        pointing_.reset(); // the button went up elsewhere
    if (!pointing_ || !is_drawn() || *pointing_ >= scenes_->size() || !is_linked_slice((*scenes_)[*pointing_]))
        return false;
    const Viewport v = arranged()[*pointing_];
    const double wide = v.right - v.left, high = v.top - v.bottom;
    SliceItem slice = (*scenes_)[*pointing_].slices.front();
    slice.point = wanted_point_.value_or(slice.point);
    want_point(
        place_on_slice(slice, drawn_->views.at(*pointing_).camera(), (event.localPos().x() / width() - v.left) / wide,
            (1.0 - event.localPos().y() / height() - v.bottom) / high, wide * width() / (high * height())));
    return true;
}

planner::Ray PictureView::ray_into(std::size_t index, const QPointF& at) const
{
    const Viewport place = arranged().at(index);
    const Camera camera = drawn_->views.at(index).camera();
    const Vec3 sight = (camera.aim - camera.eye).normalized();
    const Vec3 right = sight.cross(camera.up).normalized(), up = right.cross(sight);
    const double half = 0.5 * (place.top - place.bottom) * height();
    // From the middle of the scene's rectangle, relative to half its height.
    const double x = (at.x() - 0.5 * (place.left + place.right) * width()) / half,
                 y = ((1.0 - 0.5 * (place.bottom + place.top)) * height() - at.y()) / half;
    const double slope = std::tan(0.5 * camera.view_angle_deg * std::numbers::pi / 180.0);
    return { camera.eye, (sight + slope * (x * right + y * up)).normalized() };
}

void PictureView::click_in_space(const QMouseEvent& event)
{
    if (event.type() == QEvent::MouseButtonPress) {
        pressed_in_space_.reset();
        const auto index = scene_at(event.localPos());
        if (index && event.button() == Qt::LeftButton && event.modifiers() == Qt::NoModifier
            && !drawn_->views.at(*index).camera().parallel)
            pressed_in_space_ = event.localPos();
        const auto slice = std::find_if(scenes_->begin(), scenes_->end(), is_linked_slice);
        if (pressed_in_space_ && slice != scenes_->end())
            before_press_ = slice->slices.front().point;
    } else if (event.type() == QEvent::MouseMove) {
        if (pressed_in_space_ && (event.localPos() - *pressed_in_space_).manhattanLength() > kStillPx)
            pressed_in_space_.reset();
    } else if (event.type() == QEvent::MouseButtonRelease && event.button() == Qt::LeftButton) {
        if (const auto at = std::exchange(pressed_in_space_, std::nullopt); at && on_space_click)
            if (const auto index = scene_at(*at))
                on_space_click(*index, ray_into(*index, *at));
    }
}

bool PictureView::step_cut(const QWheelEvent& event)
{
    const auto index = scene_at(event.position());
    if (!index || !on_cut_step || (event.modifiers() & Qt::ShiftModifier) == 0 || !(*scenes_)[*index].cut_away)
        return false;
    on_cut_step(event.angleDelta().y() / kNotch);
    return true;
}

void PictureView::move_cut_away(std::size_t index, const CutAway& cut_away)
{
    RETRACTOR_ASSERT(scenes_->at(index).cut_away);
    auto scenes = std::make_shared<std::vector<Scene>>(*scenes_);
    (*scenes)[index].cut_away = coarse_scenes_.at(index).cut_away = cut_away;
    scenes_ = std::move(scenes);
    if (is_drawn()) {
        makeCurrent();
        drawn_->views.at(index).set_cut_away(cut_away);
    }
    change();
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

void PictureView::paintGL()
{
    painting_ = true;
    QVTKOpenGLNativeWidget::paintGL();
    painting_ = false;
}

void PictureView::resizeEvent(QResizeEvent* event)
{
    QVTKOpenGLNativeWidget::resizeEvent(event);
    place_note();
    if (ready_)
        change(); // a full picture of the old size does not fit
    // Words and scale bars depend on the size. They are made again when the size has settled.
    resize_timer_.start(kResizeMs);
}

QImage PictureView::picture()
{
    if (resize_timer_.isActive()) {
        resize_timer_.stop();
        build(true);
    }
    if (can_rest() && is_drawn()) {
        const PictureAnswer answer = background_.draw(request(Stereo::off));
        if (drawn_stereo() == Stereo::off)
            show_full(answer);
        if (!answer.image.isNull())
            return answer.image;
    }
    // What is drawn with the scene cannot be drawn in the background.
    saving_ = true;
    build(true);
    draw_now();
    QImage image = grabFramebuffer();
    saving_ = false;
    build(true);
    return image;
}

std::string PictureView::drawing_errors() const
{
    const std::string errors = errors_.errors();
    return errors.empty() || full_error_.empty() ? errors + full_error_ : errors + "; " + full_error_;
}

bool PictureView::is_drawn() const { return !drawn_->views.empty(); }

Camera PictureView::camera() const { return drawn_->views.at(0).camera(); }

void PictureView::show_note(const QString& note)
{
    note_->setText(translated(note));
    note_->setVisible(!note.isEmpty());
    place_note();
}

void PictureView::place_note()
{
    note_->adjustSize();
    note_->move((width() - note_->width()) / 2, (height() - note_->height()) / 2);
}

} // namespace retractor::ui

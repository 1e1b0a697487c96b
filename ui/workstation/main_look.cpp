// How the main window lets one look into the patient: through the wall, past a cut, and what lies under the mouse.

#include "mesh/base/text_format.h"
#include "planner/measures/bones/bone_limits.h"
#include "ui/plan_scene/plan_scene.h"
#include "ui/scene/camera_motion.h"
#include "ui/scene/pick.h"
#include "ui/workstation/language/language.h"
#include "ui/workstation/main_window.h"
#include "ui/workstation/view/picture_view.h"

#include <QActionGroup>
#include <QMenu>

#include <cmath>
#include <memory>
#include <tuple>
#include <utility>
#include <vector>

namespace retractor::ui {

namespace {

    constexpr int kMarkMs = 400; ///< the mark follows when the hand has rested: it takes longer to draw than slices
    constexpr double kCutStepMm = 5.0;
    constexpr double kObliqueDeg = 30.0, kTipMm = 50.0, kQuarterDeg = 90.0; ///< of endoscopes

} // namespace

void MainWindow::make_look_actions(QMenu& menu)
{
    QMenu* const wall = menu.addMenu("Body wall");
    wall_looks_ = new QActionGroup(this);
    for (const auto& [text, look, tip] : { std::tuple { "Solid", WallLook::solid, "Skin, muscle and ribs as they are" },
             std::tuple { "See-through", WallLook::see_through, "Bones, heart and vessels shine through the skin" },
             std::tuple { "Hidden", WallLook::hidden, "Bones, heart and vessels alone" } }) {
        QAction* const action = add_action(*wall, text, {}, tip, [this, look = look] { set_wall_look(look); });
        action->setCheckable(true);
        wall_looks_->addAction(action);
    }
    wall->addSeparator();
    add_action(*wall, "Next", Qt::Key_W, "Solid, see-through, hidden", [this] { next_wall_look(); });
    QMenu* const cut = menu.addMenu("Cut away");
    cut_sides_ = new QActionGroup(this);
    const auto add = [&](const QString& text, std::optional<CutSide> side) {
        QAction* const action = add_action(*cut, text, {},
            side ? "Cut this part away, up to where the slices meet; Shift and the wheel move the cut"
                 : "Show the whole patient",
            [this, side] { set_cut_side(side); });
        action->setCheckable(true);
        action->setData(side ? static_cast<int>(*side) : -1);
        cut_sides_->addAction(action);
    };
    add("Nothing", std::nullopt);
    add("The front", CutSide::front);
    add("The back", CutSide::back);
    add("The patient's left", CutSide::left);
    add("The patient's right", CutSide::right);
    add("Towards the head", CutSide::head);
    add("Towards the feet", CutSide::feet);
    cut->addSeparator();
    add_action(
        *cut, "Next", Qt::Key_V, "Nothing, the front, the back, one side after the other", [this] { next_cut_side(); });
    QMenu* const stereo = menu.addMenu("Stereo");
    auto* const eyes = new QActionGroup(this);
    for (const auto& [text, kind, tip] : { std::tuple { "Off", Stereo::off, "Show scenes in space to one eye" },
             std::tuple { "Red and cyan", Stereo::red_cyan, "For coloured glasses, the red one before the left eye" },
             std::tuple { "Side by side", Stereo::side_by_side,
                 "For a 3D monitor that takes both pictures beside each other; use the full screen" },
             std::tuple { "Lines", Stereo::lines,
                 "For a 3D monitor whose lines belong to the left and the right eye in turn" } }) {
        QAction* const action = add_action(*stereo, text, {}, tip, [this, kind = kind] { view_->set_stereo(kind); });
        action->setCheckable(true);
        action->setChecked(kind == Stereo::off);
        eyes->addAction(action);
    }
    straight_optics_ = add_action(menu, "Endoscope, straight", Qt::Key_6,
        "Look into the opened wound through an endoscope, 50 mm before the target",
        [this] { look_through_endoscope(0.0); });
    oblique_optics_ = add_action(menu, "Endoscope, 30°", Qt::Key_7,
        "The same with optics that look 30° off the shaft; again: turned by 90° about the shaft",
        [this] { look_through_endoscope(kObliqueDeg); });
    large_ = add_action(menu, "One large picture", QKeySequence("Shift+L"),
        "With slices, the picture in space fills two thirds of the view", [this] {
            shown_ = {};
            show_picture();
        });
    large_->setCheckable(true);
    mark_timer_.setSingleShot(true);
    mark_timer_.setInterval(kMarkMs);
    connect(&mark_timer_, &QTimer::timeout, this, [this] { show_space_again(); });
}

/// Has the organs drawn that are wanted and not there yet, in the background.
void MainWindow::make_anatomy()
{
    if (!backend_.anatomy || !model_->take_anatomy_wish())
        return;
    ++closed_running_;
    closed_executor_.post([this, generation = generation_, make = backend_.anatomy](const Job& job) {
        auto made = std::make_shared<std::vector<SurfaceItem>>();
        std::optional<Failure> failure;
        try {
            *made = make(job);
        } catch (...) {
            failure = with_controls(current_failure());
        }
        post_back(generation, [this, made, failure] {
            --closed_running_;
            model_->set_anatomy(std::move(*made));
            show_space_again();
            if (failure)
                show_error(*failure);
            show_all();
        });
    });
}

void MainWindow::set_wall_look(WallLook look)
{
    model_->set_wall_look(look);
    make_anatomy();
    show_space_again();
    show_actions();
}

void MainWindow::set_opened(bool opened)
{
    model_->set_show_opened(opened);
    show_all();
}

void MainWindow::next_wall_look()
{
    if (!model_)
        return;
    const bool solid = model_->wall_look() == WallLook::solid, hidden = model_->wall_look() == WallLook::hidden;
    set_wall_look(solid ? WallLook::see_through : hidden ? WallLook::solid : WallLook::hidden);
    show_message(solid ? "The body's wall is see-through."
            : hidden   ? "The body's wall is solid."
                       : "The body's wall is hidden.");
}

void MainWindow::set_cut_side(std::optional<CutSide> side)
{
    model_->set_cut_side(side);
    make_anatomy();
    show_space_again();
    show_actions();
    if (side)
        show_message("Shift and the wheel move the cut.");
}

void MainWindow::next_cut_side()
{
    if (!model_ || !model_->can_cut_away())
        return;
    const int next = model_->cut_side() ? static_cast<int>(*model_->cut_side()) + 1 : 0;
    set_cut_side(next <= static_cast<int>(CutSide::feet) ? std::optional(static_cast<CutSide>(next)) : std::nullopt);
}

void MainWindow::look_through_endoscope(double optics_deg)
{
    const bool again = optics_deg_ == optics_deg && optics_deg > 0.0;
    const double turned = again ? std::fmod(optics_turned_deg_ + kQuarterDeg, 4.0 * kQuarterDeg) : 0.0;
    model_->set_show_opened(true);
    set_view(ViewPreset::surgeon);
    if (!view_->is_drawn() || shown_.view != ViewPreset::surgeon || !shown_.opened)
        return;
    const ApproachState& state = model_->shown_state();
    view_->set_camera(endoscope_camera(state.field->surgeon.camera, kTipMm, optics_deg, turned));
    optics_deg_ = optics_deg;
    optics_turned_deg_ = turned;
    show_message(optics_deg > 0.0
            ? QString(
                "Endoscope, 30° off its shaft, 50 mm before the target; 7 turns it, 0 goes back to the surgeon's eye.")
            : QString("Endoscope, straight, 50 mm before the target; 0 goes back to the surgeon's eye."));
}

void MainWindow::show_space_again()
{
    if (model_ && shown_ == model_->shown_source() && shown_.pictures != nullptr)
        show_again([](const Scene& scene) { return scene.slices.empty(); });
}

void MainWindow::show_place()
{
    if (slices_shown())
        show_slices();
    if (shown_ != model_->shown_source())
        return;
    if (const auto cut = model_->cut_away())
        for (std::size_t i = 0; i < view_->scenes().size(); ++i)
            if (view_->scenes()[i].cut_away)
                view_->move_cut_away(i, *cut);
    if (is_drawn_on(model_->shown_view()))
        mark_timer_.start();
}

void MainWindow::step_cut(double notches)
{
    const auto cut = model_ ? model_->cut_away() : std::nullopt;
    const auto box
        = scene_bounds(model_ && model_->shown_state().closed ? model_->shown_state().closed->patient : Scene());
    if (!cut || !box)
        return;
    const Vec3 wanted = cut->point + notches * kCutStepMm * cut->kept;
    model_->set_slice_point(wanted.cwiseMax(box->low).cwiseMin(box->high));
    show_place();
}

namespace {

    /// The cut on a slice across the incision: from the skin to the end of the blade.
    LineItem* blade_of(Scene& scene)
    {
        for (LineItem& line : scene.lines)
            if (line.name == kCutName && line.points.size() == 2)
                return &line;
        return nullptr;
    }

} // namespace

std::optional<SliceHandle> MainWindow::blade_handle() const
{
    if (!model_ || model_->shown_view() != ViewPreset::incision || only_looks() || in_conference()
        || knife_->scene() != nullptr)
        return std::nullopt;
    std::vector<Scene> scenes = view_->scenes();
    for (std::size_t n = 0; n < scenes.size(); ++n)
        if (const LineItem* const blade = blade_of(scenes[n]))
            return SliceHandle { .scene = n, .place = blade->points.back() };
    return std::nullopt;
}

void MainWindow::drag_blade(const Vec3& place, bool last)
{
    const auto handle = blade_handle();
    if (!handle)
        return;
    Scene scene = view_->scenes().at(handle->scene);
    LineItem& blade = *blade_of(scene);
    const Vec3 into = place - blade.points.front();
    if (last)
        return editor_->change_blade(into.norm(), into);
    blade.points.back() = place;
    for (TextItem& word : scene.words) {
        word.position = place;
        word.text = formatted("%.0f mm deep", into.norm());
    }
    view_->replace_scene(handle->scene, std::move(scene));
    view_->set_handle(blade_handle());
}

/// Selects an approach by its place among the compared pictures, which stay.
void MainWindow::select_compared(std::size_t place)
{
    const std::vector<std::size_t> compared = model_->compared();
    if (place >= compared.size() || in_conference() || model_->selected() == compared[place])
        return;
    model_->select(compared[place]);
    show_all();
}

/// Says what was clicked in space, and marks it where it lies as in the CT.
void MainWindow::name_place(std::size_t scene, const planner::Ray& ray)
{
    if (!model_ || knife_->scene() != nullptr || shown_ != model_->shown_source())
        return;
    if (model_->shown_view() == ViewPreset::compare) // what is chosen with Shift+C
        select_compared(model_->alone().value_or(scene));
    const auto picked = pick(view_->scenes().at(scene), ray.origin, ray.direction);
    if (!picked)
        return show_message({});
    const QString name = QString::fromStdString(planner::capital(translated(model_->name_of(*picked)).toStdString()));
    if (!model_->lies_as_in_ct(*picked))
        return show_message(name);
    model_->set_slice_point(picked->place);
    show_place();
    show_actions();
    show_message(site_->isEnabled() ? name + ". T makes this place the target; 3 shows its slices." : name);
}

} // namespace retractor::ui

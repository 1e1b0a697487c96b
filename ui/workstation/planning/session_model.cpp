#include "ui/workstation/planning/session_model.h"

#include "mesh/base/assert.h"
#include "mesh/base/text_format.h"
#include "planner/anatomy/rib_name.h"
#include "planner/approach/approach_draft.h"
#include "planner/measures/comparison.h"
#include "ui/plan_scene/plan_scene.h"
#include "ui/plan_scene/planned_cut.h"
#include "ui/scene/label_colors.h"
#include "ui/scene/linked_slices.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace retractor::ui {

namespace {

    /// A field of a request (see Error::fields()) and the control for it.
    struct FieldControl {
        std::string_view field, control;
    };

    constexpr std::array kFieldControls {
        FieldControl { "model", "Tissue: Model" },
        FieldControl { "structure", "File: Palpate a structure…" },
    };

    /// The controls for the fields, " (see Tissue: Model)"; empty when no control sets any of them.
    std::string control_hint(const std::vector<std::string>& fields)
    {
        std::string controls;
        for (const std::string& field : fields)
            for (const FieldControl& entry : kFieldControls)
                if (entry.field == field)
                    controls += (controls.empty() ? "" : ", ") + std::string(entry.control);
        return controls.empty() ? std::string() : " (see " + controls + ")";
    }

    /// Point and unit blade direction at half the length of the incision.
    std::pair<Vec3, Vec3> incision_middle(const planner::Approach& approach)
    {
        const double half = planner::incision_length(approach) / 2.0;
        double walked = 0.0;
        for (std::size_t i = 0; i + 1 < approach.incision.size(); ++i) {
            const double step = (approach.incision[i + 1] - approach.incision[i]).norm();
            if (walked + step >= half && step > 0.0) {
                const double t = (half - walked) / step;
                return { (1.0 - t) * approach.incision[i] + t * approach.incision[i + 1],
                    ((1.0 - t) * approach.directions[i] + t * approach.directions[i + 1]).normalized() };
            }
            walked += step;
        }
        return { approach.incision.back(), approach.directions.back().normalized() };
    }

    /// Slices that show other labels, each in its own colour.
    std::vector<Scene> with_labels(std::vector<Scene> scenes, const std::shared_ptr<const mesh::LabelVolume>& labels)
    {
        constexpr double kStrongFill = 0.35;
        for (Scene& scene : scenes)
            for (SliceItem& slice : scene.slices) {
                slice.labels = labels;
                slice.outline_of_label = label_colors(labels->table);
                slice.fill = kStrongFill;
            }
        return scenes;
    }

    std::map<Label, std::string> names_of(const mesh::LabelTable& table)
    {
        std::map<Label, std::string> names;
        for (const mesh::LabelInfo& info : table)
            names[info.id] = readable(info.name);
        return names;
    }

} // namespace

std::optional<ViewPreset> view_from_string(std::string_view text)
{
    if (text == "surgeon")
        return ViewPreset::surgeon;
    if (text == "overview")
        return ViewPreset::overview;
    if (text == "slices")
        return ViewPreset::slices;
    if (text == "compare")
        return ViewPreset::compare;
    return text == "incision" ? std::optional(ViewPreset::incision) : std::nullopt;
}

Failure with_controls(Failure failure)
{
    failure.what += control_hint(failure.fields);
    return failure;
}

Failure case_failure(const std::filesystem::path& file, const Error& error)
{
    const std::string name = file.string();
    if (error.where().find(name) != std::string::npos)
        return { error.what(), error.where() };
    return { error.what(), error.where().empty() ? name : name + ": " + error.where() };
}

SessionModel::SessionModel(planner::Case planned_case)
    : case_(std::move(planned_case))
{
    states_[kPatientAlone] = {};
    for (std::size_t n = 0; n < case_.approaches.size(); ++n)
        ids_.push_back(new_id());
    if (!ids_.empty())
        selected_ = 0;
}

std::size_t SessionModel::new_id()
{
    const std::size_t id = states_.rbegin()->first + 1;
    states_[id] = {};
    return id;
}

void SessionModel::select(std::size_t index)
{
    RETRACTOR_ASSERT(index < ids_.size());
    selected_ = index;
}

void SessionModel::select(std::string_view name)
{
    const planner::Approach& found = planner::find_approach(case_, name);
    select(static_cast<std::size_t>(&found - case_.approaches.data()));
}

SessionModel::Edition SessionModel::edition(std::string what) const
{
    return { .approaches = case_.approaches, .ids = ids_, .selected = selected_, .what = std::move(what) };
}

void SessionModel::begin_edit(std::string what)
{
    undo_.push_back(edition(std::move(what)));
    redo_.clear();
}

void SessionModel::add_approach(planner::Approach approach)
{
    planner::Case edited = case_;
    const std::string what = "add " + planner::spoken_name(approach);
    planner::add_approach(edited, std::move(approach));
    begin_edit(what);
    case_ = std::move(edited);
    ids_.push_back(new_id());
    selected_ = ids_.size() - 1;
}

void SessionModel::add_approaches(std::vector<planner::Approach> approaches, std::string what)
{
    planner::Case edited = case_;
    const std::size_t count = approaches.size();
    for (planner::Approach& approach : approaches)
        planner::add_approach(edited, std::move(approach));
    begin_edit(std::move(what));
    case_ = std::move(edited);
    for (std::size_t n = 0; n < count; ++n)
        ids_.push_back(new_id());
}

void SessionModel::replace_approach(std::size_t index, planner::Approach approach, std::string what)
{
    planner::Case edited = case_;
    edited.approaches.erase(edited.approaches.begin() + static_cast<std::ptrdiff_t>(index));
    planner::add_approach(edited, std::move(approach));
    std::rotate(edited.approaches.begin() + static_cast<std::ptrdiff_t>(index), edited.approaches.end() - 1,
        edited.approaches.end());
    begin_edit(std::move(what));
    case_ = std::move(edited);
    ids_.at(index) = new_id();
    selected_ = index;
    withdraw_absent();
}

void SessionModel::rename_approach(std::size_t index, const std::string& title)
{
    planner::Case edited = case_;
    planner::set_title(edited, approach(index).name, title);
    const std::string before = planner::spoken_name(approach(index)),
                      after = planner::spoken_name(edited.approaches.at(index));
    begin_edit("rename " + before);
    case_ = std::move(edited);
    for (const std::string& name : { before, after }) // the edit can be taken back
        state_of(index).former_names.push_back(name);
}

void SessionModel::remove_approach(std::size_t index)
{
    begin_edit("remove " + planner::spoken_name(approach(index)));
    case_.approaches.erase(case_.approaches.begin() + static_cast<std::ptrdiff_t>(index));
    ids_.erase(ids_.begin() + static_cast<std::ptrdiff_t>(index));
    selected_ = ids_.empty() ? std::nullopt : std::optional(std::min(index, ids_.size() - 1));
    withdraw_absent();
}

std::optional<std::string> SessionModel::edit_to_undo() const
{
    return undo_.empty() ? std::nullopt : std::optional(undo_.back().what);
}

std::optional<std::string> SessionModel::edit_to_redo() const
{
    return redo_.empty() ? std::nullopt : std::optional(redo_.back().what);
}

void SessionModel::take(std::vector<Edition>& from, std::vector<Edition>& to)
{
    RETRACTOR_ASSERT(!from.empty());
    Edition taken = std::move(from.back());
    from.pop_back();
    to.push_back(edition(std::move(taken.what)));
    case_.approaches = std::move(taken.approaches);
    ids_ = std::move(taken.ids);
    selected_ = taken.selected;
    withdraw_absent();
}

void SessionModel::undo_edit() { take(undo_, redo_); }
void SessionModel::redo_edit() { take(redo_, undo_); }

void SessionModel::withdraw_absent()
{
    const auto absent = [&](std::size_t id) { return std::find(ids_.begin(), ids_.end(), id) == ids_.end(); };
    for (const std::size_t id : waiting_)
        if (absent(id))
            states_.at(id).status = FieldStatus::closed;
    std::erase_if(waiting_, absent);
    if (planning_ && absent(*planning_))
        states_.at(*planning_).status = FieldStatus::cancelling;
    if (view_ == ViewPreset::compare && !view_available(view_))
        view_ = shown_view(); // or the comparison would come back by itself
}

std::vector<std::size_t> SessionModel::planned() const
{
    std::vector<std::size_t> indices;
    for (std::size_t i = 0; i < ids_.size(); ++i)
        if (state(i).field != nullptr && !state(i).as_draft)
            indices.push_back(i);
    return indices;
}

std::vector<std::size_t> SessionModel::compared() const
{
    return planner::compared_approaches(case_, planned(), decisions_);
}

std::size_t SessionModel::place_of(std::size_t index) const
{
    const std::vector<std::size_t> all = planned();
    return static_cast<std::size_t>(std::ranges::find(all, index) - all.begin());
}

std::optional<std::vector<std::string>> SessionModel::compared_with(std::size_t index, bool is_compared) const
{
    std::vector<std::size_t> indices = compared();
    std::erase(indices, index);
    if (is_compared)
        indices.push_back(index);
    if (indices.size() < planner::kLeastCompared || indices.size() > planner::kMostCompared)
        return std::nullopt;
    std::vector<std::string> names;
    for (const std::size_t one : indices)
        names.push_back(approach(one).name);
    for (std::size_t one = 0; one < approach_count(); ++one) // comes back with its plan
        if ((state(one).field == nullptr || state(one).as_draft)
            && std::ranges::count(decisions_.compared, approach(one).name) > 0)
            names.push_back(approach(one).name);
    return names;
}

bool SessionModel::view_available(ViewPreset view) const
{
    if (view == ViewPreset::compare)
        return planned().size() >= planner::kLeastCompared;
    if (view == ViewPreset::surgeon)
        return selected_.has_value();
    const auto& closed = shown_state().closed;
    if (view == ViewPreset::overview)
        return true;
    if (view == ViewPreset::incision)
        return selected_ && (closed != nullptr ? !closed->incision_slices.empty() : case_.ct.has_value());
    return closed != nullptr ? !closed->slices.empty() : case_.ct.has_value();
}

bool SessionModel::can_plan(std::size_t index, bool as_draft) const
{
    const ApproachState& now = state(index);
    return now.status == FieldStatus::closed || now.status == FieldStatus::failed
        || (now.status == FieldStatus::planned && now.as_draft && !as_draft);
}

void SessionModel::request_plan(std::size_t index, bool as_draft)
{
    if (!can_plan(index, as_draft))
        return;
    ApproachState& state = state_of(index);
    state.status = FieldStatus::waiting;
    state.as_draft = as_draft;
    state.field.reset();
    state.failure.reset();
    waiting_.push_back(ids_[index]);
}

void SessionModel::cancel()
{
    for (const std::size_t id : waiting_)
        states_.at(id).status = FieldStatus::closed;
    waiting_.clear();
    if (planning_)
        states_.at(*planning_).status = FieldStatus::cancelling;
}

std::optional<std::size_t> SessionModel::planning() const
{
    const auto found = planning_ ? std::find(ids_.begin(), ids_.end(), *planning_) : ids_.end();
    return found == ids_.end() ? std::nullopt : std::optional(static_cast<std::size_t>(found - ids_.begin()));
}

bool SessionModel::planning_unwanted() const
{
    return planning_ && states_.at(*planning_).status == FieldStatus::cancelling;
}

std::optional<std::size_t> SessionModel::begin_plan()
{
    if (planning_ || waiting_.empty())
        return std::nullopt;
    planning_ = waiting_.front();
    waiting_.pop_front();
    states_.at(*planning_).status = FieldStatus::planning;
    return planning();
}

void SessionModel::plan_done(FieldPictures field)
{
    RETRACTOR_ASSERT(planning_);
    ApproachState& state = states_.at(*std::exchange(planning_, std::nullopt));
    state.field = std::make_shared<const FieldPictures>(std::move(field));
    state.status = FieldStatus::planned;
}

void SessionModel::plan_cancelled()
{
    RETRACTOR_ASSERT(planning_);
    states_.at(*std::exchange(planning_, std::nullopt)).status = FieldStatus::closed;
}

void SessionModel::plan_failed(Failure failure)
{
    RETRACTOR_ASSERT(planning_);
    ApproachState& state = states_.at(*std::exchange(planning_, std::nullopt));
    state.failure = std::move(failure);
    state.status = FieldStatus::failed;
}

std::optional<ClosedWork> SessionModel::begin_closed()
{
    if (making_closed_)
        return std::nullopt;
    std::optional<std::size_t> wanted; // index
    for (std::size_t i = 0; i < ids_.size() && !wanted; ++i)
        if (const std::size_t index = (*selected_ + i) % ids_.size(); !state(index).closed_tried)
            wanted = index;
    if (!wanted && (selected_ || states_.at(kPatientAlone).closed_tried))
        return std::nullopt;
    making_closed_ = wanted ? ids_[*wanted] : kPatientAlone;
    states_.at(*making_closed_).closed_tried = true;
    ClosedWork work;
    if (wanted)
        work.approach = approach(*wanted);
    return work;
}

void SessionModel::closed_done(ClosedPictures pictures)
{
    RETRACTOR_ASSERT(making_closed_);
    states_.at(*std::exchange(making_closed_, std::nullopt)).closed
        = std::make_shared<const ClosedPictures>(std::move(pictures));
}

void SessionModel::closed_failed(Failure failure)
{
    RETRACTOR_ASSERT(making_closed_);
    states_.at(*std::exchange(making_closed_, std::nullopt)).failure = std::move(failure);
}

std::optional<std::size_t> SessionModel::begin_saved()
{
    if (reading_saved_)
        return std::nullopt;
    for (std::size_t i = 0; i < ids_.size(); ++i) {
        const std::size_t index = (*selected_ + i) % ids_.size();
        ApproachState& wanted = state_of(index);
        if (wanted.saved_tried || wanted.closed == nullptr || wanted.status != FieldStatus::closed)
            continue;
        wanted.saved_tried = true;
        reading_saved_ = ids_[index];
        return index;
    }
    return std::nullopt;
}

void SessionModel::saved_done(std::optional<FieldPictures> field)
{
    RETRACTOR_ASSERT(reading_saved_);
    const std::size_t id = *std::exchange(reading_saved_, std::nullopt);
    ApproachState& state = states_.at(id);
    // A plan that was asked for meanwhile says the same, and waits no longer.
    if (!field || (state.status != FieldStatus::closed && state.status != FieldStatus::waiting))
        return;
    std::erase(waiting_, id);
    state.as_draft = false;
    state.field = std::make_shared<const FieldPictures>(std::move(*field));
    state.status = FieldStatus::planned;
}

void SessionModel::set_grey_window(std::size_t index)
{
    RETRACTOR_ASSERT(index < kGreyWindows.size());
    grey_window_ = index;
}

std::optional<Vec3> SessionModel::slice_place() const
{
    const ApproachState& state = shown_state();
    if (state.closed == nullptr || state.closed->slices.empty())
        return std::nullopt;
    return state.slice_point.value_or(state.closed->slices.front().slices.front().point);
}

Vec3 SessionModel::marked_place() const
{
    const ApproachState& state = shown_state();
    if (const auto place = state.slice_point ? state.slice_point : slice_place())
        return *place;
    const auto box = state.closed != nullptr ? scene_bounds(state.closed->patient) : std::nullopt;
    return box ? Vec3(0.5 * (box->low + box->high)) : Vec3(Vec3::Zero());
}

void SessionModel::set_slice_point(const Vec3& point) { states_.at(shown_id()).slice_point = point; }

ShownSource SessionModel::shown_source() const
{
    const ApproachState& state = shown_state();
    const bool opened = state.field != nullptr && (show_opened_ || state.closed == nullptr);
    if (shown_view() == ViewPreset::compare) {
        ShownSource source { .pictures = nullptr, .opened = true, .view = view_, .approach = std::nullopt };
        for (const std::size_t index : compared()) {
            source.compared.push_back(this->state(index).field);
            source.name += planner::spoken_name(approach(index)) + "\n";
        }
        source.pictures = source.compared.front();
        source.alone = alone_;
        source.map = map_;
        return source;
    }
    ShownSource source { .pictures = nullptr, .opened = opened, .view = view_, .approach = std::nullopt };
    if (selected_) {
        source.approach = shown_id();
        source.name = planner::spoken_name(approach(*selected_));
    }
    if (opened) {
        source.pictures = state.field;
        source.map = map_;
    } else {
        source.pictures = state.closed;
    }
    if (shows_slices(view_))
        source.slices = state.closed;
    source.alone = alone_;
    return source;
}

std::vector<Scene> SessionModel::unmeasured_scenes() const
{
    const ShownSource source = shown_source();
    if (source.pictures == nullptr)
        return {};
    if (shown_view() == ViewPreset::compare)
        return compared_scenes();
    const ApproachState& state = shown_state();
    const Scene overview = source.opened ? mapped(*state.field, state.field->overview) : state.closed->patient;
    std::vector<Scene> scenes;
    if (view_ == ViewPreset::slices && state.closed != nullptr && !state.closed->slices.empty()) {
        scenes = corrected_ != nullptr
            ? slices_at(with_labels(state.closed->slices, corrected_), *slice_place(), names_of(corrected_->table))
            : slices_at(state.closed->slices, *slice_place(), state.closed->label_names);
    } else if (shown_view() == ViewPreset::incision && state.closed != nullptr) {
        scenes = state.closed->incision_slices;
    }
    for (Scene& scene : scenes)
        for (SliceItem& slice : scene.slices)
            dress(slice);
    const bool surgeon = shown_view() == ViewPreset::surgeon || shown_view() == ViewPreset::incision;
    if (!surgeon || !scenes.empty())
        scenes.push_back(overview);
    if (!surgeon)
        return scenes;
    scenes.push_back(source.opened ? mapped(*state.field, state.field->surgeon) : overview);
    if (!source.opened)
        scenes.back().camera = surgeon_camera(approach(*selected_), overview.camera.up);
    return scenes;
}

void SessionModel::dress(SliceItem& slice) const
{
    slice.window_hu = kGreyWindows[grey_window_].window_hu;
    slice.level_hu = kGreyWindows[grey_window_].level_hu;
    if (label_look_ == LabelLook::outlined)
        slice.fill = 0.0;
    if (label_look_ == LabelLook::hidden)
        slice.outline_of_label.clear();
}

std::optional<CutAway> SessionModel::cut_away() const
{
    if (!cut_side_ || !can_cut_away())
        return std::nullopt;
    constexpr double kFacePixelMm = 1.0; // fast enough to follow the hand
    CutAway cut { .point = marked_place() };
    SlicePlane plane = SlicePlane::coronal;
    switch (*cut_side_) {
    case CutSide::front:
    case CutSide::back:
        cut.kept = *cut_side_ == CutSide::front ? Vec3::UnitY() : Vec3(-Vec3::UnitY());
        break;
    case CutSide::left:
    case CutSide::right:
        plane = SlicePlane::sagittal;
        cut.kept = *cut_side_ == CutSide::right ? Vec3::UnitX() : Vec3(-Vec3::UnitX());
        break;
    case CutSide::head:
    case CutSide::feet:
        plane = SlicePlane::axial;
        cut.kept = *cut_side_ == CutSide::feet ? Vec3::UnitZ() : Vec3(-Vec3::UnitZ());
        break;
    }
    const auto& closed = shown_state().closed;
    if (opened_shown() || closed == nullptr)
        return cut;
    for (const Scene& scene : closed->slices)
        if (scene.slices.front().plane == plane && scene.slices.front().labels != nullptr) {
            cut.face = scene.slices.front();
            cut.face->point = cut.point;
            cut.face->pixel_mm = kFacePixelMm;
            dress(*cut.face);
        }
    return cut;
}

bool SessionModel::take_anatomy_wish()
{
    return (wall_look_ != WallLook::solid || cut_side_) && !std::exchange(anatomy_wished_, true);
}

void SessionModel::set_anatomy(std::vector<SurfaceItem> surfaces)
{
    anatomy_ = std::make_shared<const std::vector<SurfaceItem>>(std::move(surfaces));
}

std::string SessionModel::name_of(const Picked& picked) const
{
    std::string name = picked.name == kBodyName ? "skin" : picked.name;
    const auto& closed = shown_state().closed;
    if (picked.label && closed != nullptr)
        if (const auto found = closed->label_names.find(*picked.label); found != closed->label_names.end())
            name = found->second;
    const std::size_t marks = std::min(name.find(" ("), name.size()); // "(estimated)"
    if (const auto rib = planner::rib_name(std::string_view(name).substr(0, marks)))
        return planner::rib_in_words(*rib) + name.substr(marks);
    return readable(name);
}

bool SessionModel::lies_as_in_ct(const Picked& picked) const
{
    if (shown_view() == ViewPreset::compare)
        return false;
    if (!opened_shown())
        return true;
    const auto& closed = shown_state().closed;
    return !picked.label && closed != nullptr
        && std::any_of(closed->label_names.begin(), closed->label_names.end(),
            [&](const auto& name) { return name.second == picked.name; });
}

Scene SessionModel::looked_into(Scene scene) const
{
    constexpr double kMarkMm = 10.0;
    const auto is_wall = [](const SurfaceItem& item) {
        return item.name == kBodyName || item.name == kWallName || item.name == kBeyondName;
    };
    if (wall_look_ == WallLook::hidden)
        std::erase_if(scene.surfaces, is_wall);
    if (wall_look_ == WallLook::see_through)
        for (SurfaceItem& item : scene.surfaces)
            if (is_wall(item))
                item.opacity = kSeeThroughOpacity;
    scene.cut_away = cut_away();
    const bool inside = wall_look_ != WallLook::solid || scene.cut_away;
    if (inside && anatomy_ != nullptr && !opened_shown())
        for (const SurfaceItem& organ : *anatomy_)
            if (std::none_of(scene.surfaces.begin(), scene.surfaces.end(),
                    [&](const SurfaceItem& item) { return item.name == organ.name; }))
                scene.surfaces.push_back(organ);
    if (const auto& closed = shown_state().closed;
        cut_shown_ && wall_look_ != WallLook::solid && !opened_shown() && closed != nullptr && closed->cut)
        scene.surfaces.push_back(*closed->cut);
    if (const auto& place = shown_state().slice_point; place && is_drawn_on(shown_view())) // slices show it themselves
        for (const LineItem& line : mark_at(*place, kMarkMm))
            scene.lines.push_back(line);
    return scene;
}

bool SessionModel::map_available(FieldMapKind map) const
{
    const ApproachState& state = shown_state();
    return state.field != nullptr && state.field->maps.contains(map);
}

Scene SessionModel::mapped(const FieldPictures& field, const Scene& scene) const
{
    const auto map = map_ ? field.maps.find(*map_) : field.maps.end();
    if (map == field.maps.end() || (map->second.from_side_deg != 0.0 && &scene != &field.overview))
        return scene;
    return with_map(scene, map->second);
}

std::vector<Scene> SessionModel::compared_scenes() const
{
    std::vector<Scene> scenes;
    for (const std::size_t index : compared()) {
        const std::string letter = planner::compared_letter(place_of(index));
        const FieldPictures& field = *state(index).field;
        scenes.push_back(mapped(field, field.surgeon));
        scenes.back().title = letter + "  " + planner::spoken_name(approach(index));
    }
    return scenes;
}

void SessionModel::put_present_name(Scene& scene) const
{
    if (!selected_)
        return;
    for (const std::string& former : shown_state().former_names)
        if (scene.title.starts_with(former + ":")) {
            scene.title.replace(0, former.size(), planner::spoken_name(approach(*selected_)));
            return;
        }
}

std::vector<Scene> SessionModel::shown_scenes() const
{
    std::vector<Scene> scenes = unmeasured_scenes();
    for (Scene& scene : scenes) {
        put_present_name(scene);
        if (scene.slices.empty())
            scene = looked_into(std::move(scene));
    }
    draw_measurements(scenes, measurements_);
    if (alone_ && *alone_ < scenes.size()) {
        std::swap(scenes.front(), scenes[*alone_]);
        scenes.resize(1);
    }
    return scenes;
}

std::string SessionModel::measure(const Vec3& place)
{
    constexpr std::size_t kOfAnAngle = 3;
    const bool ended = std::exchange(measurement_ended_, false);
    if (measurements_.empty() || ended || measurements_.back().area || measurements_.back().places.size() == kOfAnAngle)
        measurements_.emplace_back();
    measurements_.back().places.push_back(place);
    return measurement_text(measurements_.back());
}

std::string SessionModel::measure_area(const Vec3& corner)
{
    const bool ended = std::exchange(measurement_ended_, false);
    if (measurements_.empty() || ended || !measurements_.back().area)
        measurements_.push_back({ .area = true });
    measurements_.back().places.push_back(corner);
    return measurement_text(measurements_.back());
}

void SessionModel::end_measurement()
{
    measurement_ended_ = true;
    if (!measurements_.empty() && measurement_text(measurements_.back()).empty())
        measurements_.pop_back();
}

bool SessionModel::unmeasure()
{
    if (measurements_.empty())
        return false;
    measurements_.back().places.pop_back();
    if (measurements_.back().places.empty())
        measurements_.pop_back();
    return true;
}

Camera surgeon_camera(const planner::Approach& approach, const Vec3& up)
{
    // The incision fills about half of the picture's height, so that the body round it shows its place.
    constexpr double kHeightPerLength = 2.0;
    constexpr double kSmallestHeightMm = 120.0;
    const auto [middle, into] = incision_middle(approach);
    Camera camera;
    camera.eye = middle - approach.view.eye_distance_mm * into;
    camera.aim = middle;
    const double height = std::max(kSmallestHeightMm, kHeightPerLength * planner::incision_length(approach));
    camera.view_angle_deg = 2.0 * std::atan(height / 2.0 / approach.view.eye_distance_mm) * 180.0 / std::numbers::pi;
    camera.up = (up - up.dot(into) * into);
    // In a view along `up` the vector has no use, and the head serves instead.
    if (camera.up.norm() < 0.05 * up.norm())
        camera.up = into.unitOrthogonal();
    camera.up.normalize();
    return camera;
}

} // namespace retractor::ui

#include "ui/workstation/planning/approach_editor.h"

#include "mesh/base/text_format.h"
#include "planner/approach/approach_draft.h"
#include "planner/approach/retractors.h"
#include "planner/case/target_site.h"
#include "planner/plan/saved/saved_plan.h"
#include "ui/workstation/planning/approach_dialog.h"
#include "ui/workstation/planning/metric_rows.h"
#include "ui/workstation/planning/site_dialog.h"

#include <QWidget>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>

namespace retractor::ui {

namespace {

    /// Length over the given points, mm.
    double length_of(const std::vector<Vec3>& points)
    {
        double length = 0.0;
        for (std::size_t n = 1; n < points.size(); ++n)
            length += (points[n] - points[n - 1]).norm();
        return length;
    }

    /// Whether a changed approach has the plan of the one that it comes from: at most its title is another.
    bool gives_the_same_plan(const planner::Case& planned_case, const planner::Approach& changed)
    {
        planner::Case after = planned_case;
        after.approaches = { changed };
        return planner::plan_inputs(after, changed.name) == planner::plan_inputs(planned_case, changed.name);
    }

} // namespace

ApproachEditor::ApproachEditor(PictureView& view, QWidget& window)
    : view_(view)
    , window_(window)
    , tool_(view)
{
    tool_.on_change = [this] {
        on_state(); // undo is possible now, or no longer
        say_what_to_do();
    };
    tool_.on_finish = [this] { finish(); };
    tool_.on_refusal = [this](const QString& text) { on_message(text); };
}

void ApproachEditor::set_case(SessionModel* model, PlanningBackend backend)
{
    tool_.end();
    if (dialog_)
        dialog_->close(); // it offers what the other case has
    ++generation_;
    ++drawings_;
    working_ = 0;
    model_ = model;
    backend_ = std::move(backend);
}

bool ApproachEditor::draw_possible() const
{
    return model_ != nullptr && model_->shown_state().closed != nullptr && model_->shown_state().closed->skin_under;
}

void ApproachEditor::changed(const QString& message)
{
    on_edit();
    on_message(message);
}

template <class Result>
void ApproachEditor::work(
    std::function<Result()> make, std::function<void(Result)> take, std::function<void(const Failure&)> refuse)
{
    ++working_;
    on_state();
    executor_.post([this, generation = generation_, make = std::move(make), take = std::move(take),
                       refuse = std::move(refuse)](const Job&) {
        std::function<void()> deliver;
        try {
            deliver = [take, result = make()] { take(result); };
        } catch (...) {
            deliver = [refuse, failure = current_failure()] { refuse(failure); };
        }
        QMetaObject::invokeMethod(
            this,
            [this, generation, deliver = std::move(deliver)] {
                if (generation != generation_)
                    return;
                --working_;
                deliver();
                on_state();
            },
            Qt::QueuedConnection);
    });
}

void ApproachEditor::ask(ApproachDialog* dialog, std::function<Make(const planner::ApproachDraft&)> make,
    std::function<void(planner::Approach)> take)
{
    dialog->setAttribute(Qt::WA_DeleteOnClose);
    dialog_ = dialog;
    const std::shared_ptr<bool> open = std::make_shared<bool>(true); // the approach of a closed dialog is not wanted
    connect(dialog, &QDialog::finished, this, [open] { *open = false; });
    dialog->on_accept = [this, dialog, open, make = std::move(make), take = std::move(take)] {
        dialog->set_busy(true);
        const auto refuse = [dialog, open](const Failure& failure) {
            if (!*open)
                return;
            dialog->set_busy(false);
            dialog->show_failure(QString::fromStdString(to_string(failure)));
        };
        work<planner::Approach>(
            make(dialog->draft()),
            [dialog, open, take, refuse](planner::Approach approach) {
                if (!*open)
                    return;
                try {
                    take(std::move(approach));
                    dialog->close();
                } catch (...) {
                    refuse(current_failure());
                }
            },
            refuse);
    };
    dialog->open();
}

void ApproachEditor::add_from_template()
{
    if (model_ == nullptr)
        return;
    auto* dialog = new ApproachDialog(ApproachDialog::Asks::kind, possible_targets(model_->planned_case()), &window_);
    ask(
        dialog,
        [this](const planner::ApproachDraft& draft) -> Make {
            return [make = backend_.make_approach, present = model_->planned_case(), draft] {
                return make(present, draft);
            };
        },
        [this](planner::Approach approach) {
            const QString name = QString::fromStdString(planner::spoken_name(approach));
            model_->add_approach(std::move(approach));
            changed("Added: " + name);
        });
}

void ApproachEditor::begin(std::vector<Vec3> points, const QString& message)
{
    opened_before_ = model_->show_opened();
    ++drawings_;
    model_->set_show_opened(false); // the skin is drawn on before it is cut
    if (!is_drawn_on(model_->view()) || !model_->view_available(model_->view()))
        model_->set_view(ViewPreset::overview);
    model_->set_cut_shown(false);
    made_see_through_ = model_->wall_look() == WallLook::solid;
    if (made_see_through_) // who cuts between ribs must see them
        on_wall_look(WallLook::see_through);
    on_state(); // shows the closed patient
    tool_.begin(std::move(points), model_->shown_state().closed->skin_under);
    on_state();
    on_message(message);
}

void ApproachEditor::draw()
{
    if (abandon() || !draw_possible())
        return;
    moving_ = false;
    begin({}, "Click the points of the incision on the skin, or drag along it. Enter ends, Esc discards.");
}

void ApproachEditor::move_points()
{
    if (abandon() || !draw_possible() || !model_->selected())
        return;
    moving_ = true;
    moved_id_ = model_->id(*model_->selected());
    begin(planner::incision_handles(model_->approach(*model_->selected())),
        "Drag the points of the incision. Enter ends, Esc leaves the incision as it was.");
    moved_from_ = tool_.points();
}

void ApproachEditor::say_what_to_do()
{
    const std::vector<Vec3>& points = tool_.points();
    if (points.size() < 2)
        return on_message("Click further points of the incision.");
    on_message(QString::fromStdString(formatted("%zu points, %.0f mm. Enter ends, Esc discards, Ctrl+Z takes the last "
                                                "change back.",
        points.size(), length_of(points))));
}

/// Gives the mouse back, and shows the opened field again where it was shown before.
void ApproachEditor::end_drawing()
{
    ++drawings_;
    tool_.end();
    model_->set_show_opened(opened_before_);
    model_->set_cut_shown(true);
    if (std::exchange(made_see_through_, false) && model_->wall_look() == WallLook::see_through)
        on_wall_look(WallLook::solid);
}

void ApproachEditor::finish_moving()
{
    const auto index = model_->selected();
    if (!index || model_->id(*index) != moved_id_) {
        abandon();
        return;
    }
    if (tool_.points() == moved_from_) { // the plan stays
        abandon();
        return on_message("The incision is where it was.");
    }
    tool_.freeze(true); // what is dragged now would be lost
    const auto refuse = [this, drawing = drawings_](const Failure& failure) {
        if (drawing == drawings_)
            tool_.freeze(false);
        on_failure(failure);
    };
    work<planner::Approach>([move = backend_.move_incision, approach = model_->approach(*index),
                                points = tool_.points()] { return move(approach, points); },
        [this, refuse, drawing = drawings_, at = *index](planner::Approach approach) {
            if (drawing != drawings_)
                return; // it was discarded meanwhile
            const std::string name = planner::spoken_name(approach);
            try {
                model_->replace_approach(at, std::move(approach), "move the incision of " + name);
            } catch (...) {
                return refuse(current_failure());
            }
            end_drawing();
            changed("Moved the incision of " + QString::fromStdString(name));
        },
        refuse);
}

void ApproachEditor::finish()
{
    if (!tool_.active() || tool_.frozen())
        return;
    if (tool_.points().size() < 2)
        return on_message("An incision needs at least two points.");
    if (moving_)
        return finish_moving();
    auto* dialog = new ApproachDialog(ApproachDialog::Asks::drawn, possible_targets(model_->planned_case()), &window_);
    ask(
        dialog,
        [this, points = tool_.points()](planner::ApproachDraft draft) -> Make {
            draft.points = points;
            return [make = backend_.make_approach, present = model_->planned_case(), draft] {
                return make(present, draft);
            };
        },
        [this](planner::Approach approach) {
            const QString name = QString::fromStdString(planner::spoken_name(approach));
            model_->add_approach(std::move(approach));
            end_drawing();
            changed("Added: " + name);
        });
}

bool ApproachEditor::abandon()
{
    if (!tool_.active())
        return false;
    end_drawing();
    on_state();
    on_message({});
    return true;
}

void ApproachEditor::change_opening()
{
    if (model_ == nullptr || !model_->selected())
        return;
    const std::size_t id = model_->id(*model_->selected());
    const planner::Approach approach = model_->approach(*model_->selected());
    std::vector<ApproachDialog::Target> targets = possible_targets(model_->planned_case());
    const std::string target
        = approach.target.is_site() ? planner::target_name(approach.target) : approach.target.label;
    if (std::ranges::none_of(targets, [&](const auto& other) { return other.first == target; }))
        targets.insert(targets.begin(),
            { target,
                approach.target.is_sphere()     ? "a ball, as it is"
                    : approach.target.is_site() ? readable(target) + ", as it is"
                                                : readable(target) });
    auto* dialog = new ApproachDialog(ApproachDialog::Asks::opening, targets, &window_);
    const std::string spoken = planner::spoken_name(approach);
    planner::Approach untitled = approach;
    untitled.title.clear();
    const std::string usual = planner::spoken_name(untitled);
    dialog->show_draft({ .name = spoken == usual && usual != approach.name ? std::string() : spoken,
        .target = target,
        .opened_by = { .opening_mm = planner::asked_opening_mm(approach) } });
    dialog->set_usual_name(QString::fromStdString(usual));
    dialog->set_present_instrument(
        QString::fromStdString(approach.retractor ? planner::instrument_name(approach.retractor->kind)
                                                  : hooks_in_words(approach.hooks.size())));
    ask(
        dialog,
        [approach, target, dialog, usual](const planner::ApproachDraft& draft) -> Make {
            return [approach, target, draft, usual, keeps = dialog->keeps_opening()] {
                planner::Approach changed = approach;
                changed.title = draft.name == usual ? std::string() : draft.name;
                if (draft.target != target)
                    changed = planner::with_target(std::move(changed), { .label = draft.target });
                if (!keeps)
                    return planner::opened_by(std::move(changed), draft.opened_by);
                const double present = planner::asked_opening_mm(changed), asked = draft.opened_by.opening_mm;
                if (present > 0.0 && asked > 0.0 && asked != present)
                    changed = planner::with_opening(std::move(changed), asked);
                return changed;
            };
        },
        [this, id](planner::Approach changed_approach) {
            const auto selected = model_->selected();
            if (!selected || model_->id(*selected) != id)
                return;
            const QString name = QString::fromStdString(planner::spoken_name(changed_approach));
            planner::Case titled = model_->planned_case();
            planner::set_title(titled, changed_approach.name, changed_approach.title); // or it is refused
            if (gives_the_same_plan(model_->planned_case(), changed_approach)) {
                if (changed_approach.title == model_->approach(*selected).title)
                    return on_message("Nothing was changed.");
                model_->rename_approach(*selected, changed_approach.title);
                return changed("Renamed: " + name);
            }
            model_->replace_approach(*selected, std::move(changed_approach), "change " + name.toStdString());
            changed("Changed " + name);
        });
}

void ApproachEditor::change_blade(double depth_mm, const Vec3& inward)
{
    if (model_ == nullptr || !model_->selected())
        return;
    const std::size_t id = model_->id(*model_->selected());
    work<planner::Approach>([change = backend_.change_blade, approach = model_->approach(*model_->selected()), depth_mm,
                                inward] { return change(approach, depth_mm, inward); },
        [this, id](planner::Approach with_blade) {
            const auto selected = model_->selected();
            if (!selected || model_->id(*selected) != id)
                return;
            const std::string name = planner::spoken_name(with_blade);
            const double depth = with_blade.depth_mm;
            try {
                model_->replace_approach(*selected, std::move(with_blade), "set the blade of " + name);
            } catch (...) {
                return on_failure(current_failure());
            }
            changed(QString::fromStdString(formatted("The blade goes %.0f mm deep", depth)));
        },
        [this](const Failure& failure) { on_failure(failure); });
}

void ApproachEditor::choose_site()
{
    if (model_ == nullptr || !model_->selected() || !model_->slice_place())
        return;
    const std::size_t id = model_->id(*model_->selected());
    const auto labels = model_->shown_state().closed->slices.front().slices.front().labels;
    if (labels == nullptr)
        return on_message("The slices have no labels: nothing is known of this place.");
    planner::TargetSpec site;
    try {
        site = planner::site_at(*labels, *model_->slice_place());
    } catch (...) {
        return on_failure(current_failure());
    }
    const mesh::LabelInfo* const here
        = mesh::find_label(labels->table, mesh::label_at(*labels, *model_->slice_place()));
    auto* dialog = new SiteDialog(site, here != nullptr && here->name == site.label, &window_);
    dialog->setAttribute(Qt::WA_DeleteOnClose);
    connect(dialog, &QDialog::accepted, this, [this, dialog, labels, id] {
        const auto selected = model_ != nullptr ? model_->selected() : std::nullopt;
        if (!selected || model_->id(*selected) != id)
            return;
        planner::Approach approach = planner::with_target(model_->approach(*selected), dialog->target());
        const std::string name = planner::target_name(approach.target);
        try {
            if (approach.target.is_site())
                planner::check_site(*labels, approach.target);
            model_->replace_approach(*selected, std::move(approach), "choose the target");
            changed("The target is the " + QString::fromStdString(readable(name)));
        } catch (...) {
            on_failure(current_failure());
        }
    });
    dialog->open();
}

void ApproachEditor::duplicate()
{
    if (model_ == nullptr || !model_->selected())
        return;
    planner::Approach copy = model_->approach(*model_->selected());
    copy.name = planner::free_approach_name(model_->planned_case(), copy.name);
    copy.title.clear(); // it is the other's
    const QString name = QString::fromStdString(planner::spoken_name(copy));
    try {
        model_->add_approach(std::move(copy));
        changed("Added: " + name);
    } catch (...) {
        on_failure(current_failure());
    }
}

void ApproachEditor::add_with_retractor(const std::string& kind, double opening_mm, const Vec3& at)
{
    if (model_ == nullptr || !model_->selected())
        return;
    const planner::Approach& from = model_->approach(*model_->selected());
    try {
        planner::RetractorSpec cranked = from.retractor && from.retractor->kind == kind
            ? *from.retractor
            : planner::make_retractor(from, planner::find_retractor(planner::built_in_retractors(), kind), {});
        cranked.force_N.reset();
        cranked.opening_mm = std::round(opening_mm); // nobody sets tenths of a millimetre
        planner::Approach added = planner::with_retractor_at(from, std::move(cranked), at);
        added.name = planner::free_approach_name(model_->planned_case(), added.name);
        const QString message = QString::fromStdString(formatted(
            "Added: %s, opened by %.0f mm", planner::spoken_name(added).c_str(), added.retractor->opening_mm));
        model_->add_approach(std::move(added));
        changed(message);
    } catch (...) {
        on_failure(current_failure());
    }
}

void ApproachEditor::add_neighbours()
{
    if (model_ == nullptr || !model_->selected())
        return;
    const planner::Approach approach = model_->approach(*model_->selected());
    work<std::vector<planner::NeighbourApproach>>([find = backend_.neighbours, approach] { return find(approach); },
        [this, name = planner::spoken_name(approach)](const std::vector<planner::NeighbourApproach>& neighbours) {
            std::vector<planner::Approach> added;
            std::vector<std::string> places, there;
            std::map<std::string, std::vector<std::string>> missing; ///< places by reason
            for (const planner::NeighbourApproach& neighbour : neighbours) {
                if (!neighbour.approach) {
                    missing[neighbour.refused].push_back(neighbour.where);
                } else if (planner::free_approach_name(model_->planned_case(), neighbour.approach->name)
                    != neighbour.approach->name) {
                    there.push_back(neighbour.where);
                } else {
                    added.push_back(*neighbour.approach);
                    places.push_back(neighbour.where);
                }
            }
            std::string without;
            if (!there.empty())
                without += " There already: " + joined(there) + ".";
            for (const auto& [why, where] : missing)
                without += " Not " + joined(where) + ": " + why + ".";
            if (added.empty())
                return on_message(QString::fromStdString("There is nothing to add beside " + name + "." + without));
            try {
                model_->add_approaches(std::move(added), "add what lies beside " + name);
                changed(QString::fromStdString("Added " + joined(places) + ". Shift+P plans, 5 compares." + without));
            } catch (...) {
                on_failure(current_failure());
            }
        },
        [this](const Failure& failure) { on_failure(failure); });
}

void ApproachEditor::remove()
{
    if (model_ == nullptr || !model_->selected())
        return;
    const QString name = QString::fromStdString(planner::spoken_name(model_->approach(*model_->selected())));
    model_->remove_approach(*model_->selected());
    changed("Removed " + name + ". Ctrl+Z brings it back.");
}

} // namespace retractor::ui

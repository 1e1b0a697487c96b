#include "planner/case/label_session.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/case/label_correction.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace retractor::planner {

namespace {

    /// What corrections change, and what they refer to; images stay out.
    Case names_of(const Case& planned_case)
    {
        Case names;
        names.label_table = planned_case.label_table;
        names.estimated_labels = planned_case.estimated_labels;
        names.supports = planned_case.supports;
        names.pressures = planned_case.pressures;
        names.approaches = planned_case.approaches;
        return names;
    }

    void add_to_table(mesh::LabelTable& table, const mesh::LabelInfo& info)
    {
        check_label_name(info.name);
        if (mesh::find_label(table, info.name) != nullptr)
            throw InputError("there is a label \"" + info.name + "\" already");
        table.push_back(info);
    }

} // namespace

LabelSession::LabelSession(const Case& planned_case, const std::shared_ptr<const mesh::LabelVolume>& labels)
    : labels_(std::make_shared<mesh::LabelVolume>(*labels))
    , counts_(mesh::kLabelCount, 0)
    , names_(names_of(planned_case))
{
    for (const Label label : labels_->voxels)
        ++counts_[label];
}

double LabelSession::volume_ml(Label label) const
{
    constexpr double kMm3PerMl = 1000.0;
    return static_cast<double>(counts_[label]) * labels_->grid.voxel_volume() / kMm3PerMl;
}

bool LabelSession::is_estimated(const std::string& name) const { return planner::is_estimated(names_, name); }

mesh::LabelVolume& LabelSession::writable()
{
    if (labels_.use_count() == 1)
        return *labels_;
    // A picture holds the present state: go on in the spare one, or in a copy.
    if (spare_ != nullptr && spare_.use_count() == 1) {
        for (const std::size_t voxel : behind_)
            spare_->voxels[voxel] = labels_->voxels[voxel];
        spare_->table = labels_->table;
    } else
        spare_ = std::make_shared<mesh::LabelVolume>(*labels_);
    std::swap(labels_, spare_);
    behind_.clear();
    return *labels_;
}

void LabelSession::note_changes(const Step& step, bool made)
{
    for (const datasets::LabelEdit& edit : step.edits) {
        behind_.insert(behind_.end(), edit.voxels.begin(), edit.voxels.end());
        for (std::size_t n = 0; n < edit.voxels.size(); ++n) {
            --counts_[made ? edit.before[n] : edit.after[n]];
            ++counts_[made ? edit.after[n] : edit.before[n]];
        }
    }
    if (behind_.size() > labels_->voxels.size()) { // a copy is cheaper
        spare_.reset();
        behind_.clear();
    }
}

void LabelSession::take(Step step)
{
    undone_.clear();
    done_.push_back(std::move(step));
}

bool LabelSession::edit(const MakeEdit& make, Part part)
{
    if (done_.empty() || !undone_.empty()) // the step to go on with was taken back
        part = Part::first;
    if (part == Part::instead) {
        move(done_.back(), false);
        try {
            datasets::LabelEdit made = make(*labels_);
            const bool changes = !made.empty();
            done_.pop_back();
            if (!changes)
                return false;
            Step step { .what = made.what };
            step.edits.push_back(std::move(made));
            move(step, true);
            done_.push_back(std::move(step));
            return true;
        } catch (...) {
            if (!done_.empty())
                move(done_.back(), true);
            throw;
        }
    }
    datasets::LabelEdit made = make(*labels_);
    if (made.empty())
        return false;
    Step step { .what = made.what };
    step.edits.push_back(std::move(made));
    move(step, true);
    if (part == Part::more)
        done_.back().edits.push_back(std::move(step.edits.front()));
    else
        take(std::move(step));
    return true;
}

std::size_t LabelSession::unlabelled_by_last() const
{
    std::size_t count = 0;
    if (!done_.empty())
        for (const datasets::LabelEdit& edit : done_.back().edits)
            count += static_cast<std::size_t>(std::ranges::count(edit.after, Label { 0 }));
    return count;
}

void LabelSession::correct(
    std::string what, NameCorrection names, std::function<void(Case&)> correct, std::optional<datasets::LabelEdit> edit)
{
    Step step {
        .what = std::move(what), .edits = {}, .correct = std::move(correct), .names = std::move(names), .before = names_
    };
    Case after = names_;
    step.correct(after);
    step.after = after;
    if (edit && !edit->empty())
        step.edits.push_back(std::move(*edit));
    move(step, true);
    take(std::move(step));
}

void LabelSession::join(const std::string& name, const std::string& into)
{
    Case tried = names_;
    join_label(tried, name, into); // refuses before voxels are looked for
    correct(
        "join " + readable(name) + " with " + readable(into),
        { .kind = NameCorrection::Kind::join, .name = name, .other = into },
        [name, into](Case& planned_case) { join_label(planned_case, name, into); },
        datasets::joined(*labels_, mesh::label_named(table(), name).id, mesh::label_named(table(), into).id));
}

void LabelSession::rename(const std::string& name, const std::string& new_name)
{
    correct("rename " + readable(name), { .kind = NameCorrection::Kind::rename, .name = name, .other = new_name },
        [name, new_name](Case& planned_case) { rename_label(planned_case, name, new_name); });
}

void LabelSession::confirm(const std::string& name)
{
    correct("confirm " + readable(name), { .kind = NameCorrection::Kind::confirm, .name = name },
        [name](Case& planned_case) { confirm_label(planned_case, name); });
}

void LabelSession::add_label(const std::string& name, const std::string& material, mesh::Role role)
{
    Label id = 0;
    for (const mesh::LabelInfo& info : table())
        id = std::max(id, info.id);
    if (id == std::numeric_limits<Label>::max())
        throw InputError("no label id is left");
    const mesh::LabelInfo info { static_cast<Label>(id + 1), name, material, role };
    correct("add " + readable(name),
        { .kind = NameCorrection::Kind::add, .name = name, .other = {}, .material = material, .role = role },
        [info](Case& planned_case) { add_to_table(planned_case.label_table, info); });
}

std::optional<std::string> LabelSession::to_undo() const
{
    return done_.empty() ? std::nullopt : std::optional(done_.back().what);
}

std::optional<std::string> LabelSession::to_redo() const
{
    return undone_.empty() ? std::nullopt : std::optional(undone_.back().what);
}

void LabelSession::move(Step& step, bool make_again)
{
    mesh::LabelVolume& labels = writable();
    if (make_again)
        for (const datasets::LabelEdit& edit : step.edits)
            datasets::make_edit(labels, edit);
    else
        for (auto edit = step.edits.rbegin(); edit != step.edits.rend(); ++edit)
            datasets::take_back(labels, *edit);
    note_changes(step, make_again);
    if (step.correct) {
        names_ = make_again ? step.after : step.before;
        labels.table = names_.label_table;
    }
}

void LabelSession::undo()
{
    RETRACTOR_ASSERT(!done_.empty());
    move(done_.back(), false);
    undone_.push_back(std::move(done_.back()));
    done_.pop_back();
}

void LabelSession::redo()
{
    RETRACTOR_ASSERT(!undone_.empty());
    move(undone_.back(), true);
    done_.push_back(std::move(undone_.back()));
    undone_.pop_back();
}

std::vector<LabelStep> LabelSession::steps() const
{
    std::vector<LabelStep> steps;
    for (const Step& step : done_) {
        steps.push_back({ .what = step.what, .names = step.names });
        if (!step.names) // a join finds its voxels again
            steps.back().edits = step.edits;
    }
    return steps;
}

void LabelSession::make_steps(const std::vector<LabelStep>& steps)
{
    for (const LabelStep& step : steps) {
        if (step.names) {
            switch (step.names->kind) {
            case NameCorrection::Kind::join:
                join(step.names->name, step.names->other);
                break;
            case NameCorrection::Kind::rename:
                rename(step.names->name, step.names->other);
                break;
            case NameCorrection::Kind::confirm:
                confirm(step.names->name);
                break;
            case NameCorrection::Kind::add:
                add_label(step.names->name, step.names->material, step.names->role);
                break;
            }
            continue;
        }
        Part part = Part::first;
        for (const datasets::LabelEdit& made : step.edits) {
            edit(
                [&](const mesh::LabelVolume& labels) {
                    bool fits = made.before.size() == made.voxels.size() && made.after.size() == made.voxels.size();
                    for (std::size_t n = 0; fits && n < made.voxels.size(); ++n)
                        fits = made.voxels[n] < labels.voxels.size() && labels.voxels[made.voxels[n]] == made.before[n];
                    if (!fits)
                        throw InputError("the correction \"" + made.what + "\" was made on other labels");
                    return made;
                },
                part);
            part = Part::more;
        }
    }
}

Case LabelSession::corrected(Case planned_case) const
{
    for (const Step& step : done_)
        if (step.correct)
            step.correct(planned_case);
    planned_case.label_table = table();
    return planned_case;
}

} // namespace retractor::planner

#pragma once
// Labels of a case under correction, with undo: edits of voxels, and changes of names and marks. The case on disk stays
// until its owner writes labels() and corrected() (write_corrected_labels()); another session begins then. Used from
// one thread; what labels() has handed out stays unchanged. Units mm; frame patient LPS.

#include "datasets/labels/label_edit.h"
#include "mesh/image/volume.h"
#include "planner/case/case.h"

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace retractor::planner {

/// A change of names and marks, as a session makes it.
struct NameCorrection {
    enum class Kind { join, rename, confirm, add };
    Kind kind = Kind::confirm;
    std::string name {};
    std::string other {}; ///< the label that is joined with, or the new name
    std::string material {}; ///< of a label that is added
    mesh::Role role = mesh::Role::voxel; ///< of a label that is added
};

/// A step that was made.
struct LabelStep {
    std::string what; ///< in words
    std::vector<datasets::LabelEdit> edits {}; ///< of voxels, where `names` is not set
    std::optional<NameCorrection> names {};
};

class LabelSession {
public:
    /// @param labels as Patient::labels() reads them
    LabelSession(const Case& planned_case, const std::shared_ptr<const mesh::LabelVolume>& labels);

    /// With the present voxels and names.
    std::shared_ptr<const mesh::LabelVolume> labels() const { return labels_; }
    const mesh::LabelTable& table() const { return labels_->table; }
    bool is_estimated(const std::string& name) const;
    /// Volume of a label now, ml.
    double volume_ml(Label label) const;

    using MakeEdit = std::function<datasets::LabelEdit(const mesh::LabelVolume&)>;
    /// How an edit stands to the last step, as the parts of a stroke do.
    enum class Part {
        first, ///< a step of its own
        more, ///< belongs to the last step
        instead, ///< takes the place of the last step
    };
    /// Makes an edit. @returns whether the labels are others than before the step
    /// @throws what `make` throws; nothing changes then
    bool edit(const MakeEdit& make, Part part = Part::first);
    /// Number of voxels that the last step left without a label.
    std::size_t unlabelled_by_last() const;
    /// As join_label(), rename_label() and confirm_label() of the case, with the voxels.
    /// @throws InputError as they do; nothing changes then
    void join(const std::string& name, const std::string& into);
    void rename(const std::string& name, const std::string& new_name);
    void confirm(const std::string& name);
    /// Adds a label without voxels, to be painted. @throws InputError when the name is empty or taken, or when there is
    /// no id left
    void add_label(const std::string& name, const std::string& material, mesh::Role role);

    /// The step that undo() or redo() would take back or make again, in words; nothing: there is none.
    std::optional<std::string> to_undo() const;
    std::optional<std::string> to_redo() const;
    void undo();
    void redo();
    /// Whether the labels differ from those of the case.
    bool changed() const { return !done_.empty(); }

    /// The steps that are made now, the oldest first.
    std::vector<LabelStep> steps() const;
    /// Makes steps of an earlier session on the same labels.
    /// @throws InputError when a step does not fit these labels; the steps before it are made
    void make_steps(const std::vector<LabelStep>& steps);

    /// The corrections of names and marks for another state of the same case, whose approaches may have changed.
    /// write_corrected_labels() refuses what contradicts the approaches.
    /// @throws InputError when a label of a correction is missing in that state
    Case corrected(Case planned_case) const;

private:
    struct Step {
        std::string what;
        std::vector<datasets::LabelEdit> edits {};
        std::function<void(Case&)> correct {}; ///< names and marks; empty: the step changes voxels only
        std::optional<NameCorrection> names {}; ///< where `correct` is set: what it does
        Case before {}, after {}; ///< where `correct` is set: names and marks alone
    };
    mesh::LabelVolume& writable();
    /// @param made whether the step was made, or taken back
    void note_changes(const Step& step, bool made);
    void take(Step step);
    /// @param make_again whether a step is made again, or else taken back
    void move(Step& step, bool make_again);
    /// A step of names and marks, with the edit of voxels that goes with it.
    void correct(std::string what, NameCorrection names, std::function<void(Case&)> correct,
        std::optional<datasets::LabelEdit> edit = {});

    std::shared_ptr<mesh::LabelVolume> labels_;
    /// An older state, so that a picture that holds labels_ costs no copy of all voxels; null: there is none.
    std::shared_ptr<mesh::LabelVolume> spare_;
    std::vector<std::size_t> behind_; ///< voxels in which spare_ may differ from labels_
    std::vector<std::size_t> counts_; ///< of voxels, by label
    Case names_; ///< the case, with the corrections made so far
    std::vector<Step> done_, undone_;
};

} // namespace retractor::planner

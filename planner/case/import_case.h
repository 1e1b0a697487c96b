#pragma once
// From images as hospitals and other programs deliver them to a case folder. Two steps, so that a caller can show what
// was found before anything is written, and so that a cancelled import leaves nothing. Units mm and Hounsfield units;
// frame patient LPS.

#include "datasets/dicom/dicom.h"
#include "datasets/labels/label_repair.h"
#include "datasets/segmentation/autosegment.h"
#include "mesh/base/job.h"
#include "planner/case/case.h"

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace retractor::planner {

struct ImportRequest {
    std::filesystem::path ct; ///< DICOM folder or file, or an image; empty: a case of labels alone
    /// Images of labels or folders of masks. Of several, the later ones correct the earlier ones, on the CT's grid.
    std::vector<std::filesystem::path> labels;
    std::string preset; ///< see LabelImportOptions
    std::string series; ///< see DicomReadOptions
    bool rectify_tilt = true;
    bool repair_labels = false; ///< see repair_labels()
    bool autosegment = false; ///< labels, when there are any, are then the parts that are right already
    double autosegment_spacing_mm = datasets::AutosegmentOptions {}.spacing_mm;
    bool with_identity = false; ///< keep the patient's name and id in the case file
};

/// What was read, found and decided; nothing of it is on disk yet. But for `patient`, nothing here names the patient.
struct ImportedCase {
    bool cancelled = false; ///< everything else is then unspecified
    std::shared_ptr<const mesh::Volume> ct; ///< null when the request had none
    std::shared_ptr<const mesh::LabelVolume>
        labels; ///< on their own grid; only labels that have voxels are in the table
    std::vector<datasets::DicomSeries> series; ///< those of the folder, when the CT is a DICOM folder
    std::vector<std::string> notes; ///< what was decided, one line each
    std::vector<std::string> warnings; ///< what the user must look at
    std::vector<datasets::FoundStructure> structures; ///< of an automatic segmentation
    std::vector<datasets::LabelFragments> fragments; ///< labels in pieces or with holes, after any repair
    std::vector<datasets::LabelFragments> repaired; ///< what a repair changed
    std::optional<datasets::PatientIdentity> patient; ///< only when asked for
};

/// Reads, segments, checks. Progress goes to the job; a cancelled job gives `cancelled`.
/// @throws InputError, IoError: those of import_volume(), import_labels(), autosegment(); a request that names neither
/// labels nor a segmentation, or options that do not go together; labels that do not overlap the CT.
[[nodiscard]] ImportedCase read_import(const ImportRequest& request, const Job& job = {});

/// A case file may have any name that ends in .json, but for those of label tables. @throws InputError.
void check_case_file_name(const std::filesystem::path& case_file);

/// Writes ct.nrrd and labels.nrrd (voxels and geometry, no patient data) and then `case_file`, beside them. An image
/// that is there already is never overwritten: one with the same content is used again, else the next free name is
/// taken (labels-2.nrrd); so a case that is replaced stays whole until the new case file takes its place in one step.
/// @throws InputError, as check_case_file_name() too; IoError.
Case write_import(const ImportedCase& imported, const std::filesystem::path& case_file);

/// What to say when the images lie in the case folder and still name the patient there; nothing when they do not.
std::optional<std::string> identity_warning(const std::filesystem::path& ct, const std::filesystem::path& case_file);

/// One label as found, for tables.
struct LabelSize {
    mesh::LabelInfo info;
    std::size_t voxels = 0;
    double volume_ml = 0.0;
};
/// In the order of the table.
std::vector<LabelSize> label_sizes(const mesh::LabelVolume& labels);

} // namespace retractor::planner

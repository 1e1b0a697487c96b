#pragma once
// Makes a case folder from images of hospitals and other programs. The import has two steps: a caller can show the
// findings before anything is written, and a cancelled import leaves nothing on disk. Units mm and Hounsfield units;
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
    std::filesystem::path ct; ///< DICOM folder or file, or an image; empty: a case without CT
    /// Images of labels or folders of masks. A later entry corrects the earlier ones, on the CT's grid.
    std::vector<std::filesystem::path> labels;
    std::string preset; ///< see LabelImportOptions
    std::string series; ///< see DicomReadOptions
    bool rectify_tilt = true;
    bool repair_labels = false; ///< see repair_labels()
    bool autosegment = false; ///< segment the CT; given labels count as the correct parts of the segmentation
    double autosegment_spacing_mm = datasets::AutosegmentOptions {}.spacing_mm;
    bool with_identity = false; ///< keep the patient's name and id in the case file
    /// Warns of labels that the CT contradicts instead of refusing them.
    bool accept_labels = false;
    /// Warns about an image of an implausible extent instead of refusing it. The case then accepts implausible numbers
    /// (Case::accept_implausible).
    bool accept_implausible = false;
};

/// The result of reading an import, before anything is written. Only `patient` names the patient.
struct ImportedCase {
    bool cancelled = false; ///< all other members are then unspecified
    std::shared_ptr<const mesh::Volume> ct; ///< null when the request names no CT
    /// Labels on their own grid; the table holds only labels that have voxels.
    std::shared_ptr<const mesh::LabelVolume> labels;
    std::vector<datasets::DicomSeries> series; ///< series of the folder, when the CT is a DICOM folder
    std::vector<std::string> notes; ///< decisions of the import, one line each
    std::vector<std::string> warnings; ///< findings that the user must check, one line each
    std::vector<datasets::FoundStructure> structures; ///< structures that the automatic segmentation found
    std::vector<datasets::LabelFragments> fragments; ///< labels in several pieces or with holes, after any repair
    std::vector<datasets::LabelFragments> repaired; ///< changes by a repair
    std::optional<datasets::PatientIdentity> patient; ///< filled only on request
    bool accept_implausible = false; ///< as requested
    /// Vessels and nerves that the labels do not show, where they usually are.
    std::vector<AssumedVessel> assumed_vessels {};
};

/// Reads, segments and checks. The job shows the progress; a cancelled job gives `cancelled`.
/// @throws InputError, IoError as import_volume(), import_labels() and autosegment() do; InputError when the request
/// has neither labels nor a segmentation, when options contradict each other, when an image has an implausible extent
/// (implausible_extent()), or when the labels do not overlap the CT, or most of them do not show what the CT shows
[[nodiscard]] ImportedCase read_import(const ImportRequest& request, const Job& job = {});

/// @throws InputError unless the name ends in .json and is not reserved for label tables
void check_case_file_name(const std::filesystem::path& case_file);

/// Writes ct.nrrd and labels.nrrd (voxels and geometry, no patient data), and then `case_file` beside them.
/// An existing image is never overwritten. An image with the same content is used again; otherwise the next free name
/// is taken (labels-2.nrrd). An existing case stays complete until the new case file replaces it in one step.
/// @throws InputError as check_case_file_name() does too; IoError
Case write_import(const ImportedCase& imported, const std::filesystem::path& case_file);

/// Writes corrected labels beside the labels of a case, whose file stays, and then the case, which names the new file.
/// The case takes over the table of the labels; its other content stays as it is.
/// @returns the case as written
/// @throws InputError when the corrected case is not valid (check_case()): a label that an approach names is missing;
/// IoError. The case on disk is then as before.
Case write_corrected_labels(Case planned_case, const mesh::LabelVolume& labels);

/// A warning when the images lie in the case folder and still name the patient there; otherwise nothing.
std::optional<std::string> identity_warning(const std::filesystem::path& ct, const std::filesystem::path& case_file);

/// One label of an import with its size, for tables.
struct LabelSize {
    mesh::LabelInfo info;
    std::size_t voxels = 0;
    double volume_ml = 0.0;
};
/// The sizes in the order of the label table.
std::vector<LabelSize> label_sizes(const mesh::LabelVolume& labels);

} // namespace retractor::planner

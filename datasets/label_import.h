#pragma once
// Label maps from elsewhere, made into a LabelVolume with names, materials and roles. Frame: patient LPS.

#include "mesh/base/job.h"
#include "mesh/volume.h"

#include <filesystem>
#include <string>
#include <vector>

namespace retractor {

struct LabelImportOptions {
    /// See label_preset_names(). Empty: the JSON table beside the image, else the names in the file (.seg.nrrd, or
    /// TotalSegmentator's own extension of NIfTI), else an error that says what is missing.
    std::string preset;
};

struct ImportedLabels {
    LabelVolume labels; ///< on the file's own grid
    std::vector<std::string> notes; ///< what was decided, one line each
};

/// One image of labels (every format of read_volume(), .seg.nrrd of 3D Slicer, layered too), or a folder of one mask
/// per organ, named by its file ("heart.nii.gz"; the masks may lie on different grids in one world: the finest is kept;
/// where masks overlap the smaller structure wins and a note says how many voxels).
/// @throws InputError as read_label_volume() does, and for ids without a name; IoError.
ImportedLabels import_labels(
    const std::filesystem::path& path, const LabelImportOptions& options = {}, const Job& job = {});

} // namespace retractor

#pragma once
// Label maps from elsewhere, made into a LabelVolume with names, materials and roles. Frame: patient LPS.

#include "mesh/base/job.h"
#include "mesh/image/volume.h"

#include <filesystem>
#include <string>
#include <vector>

namespace retractor::datasets {

struct LabelImportOptions {
    /// See label_preset_names(). Empty: the JSON table beside the image, else the names in the file (.seg.nrrd, or
    /// TotalSegmentator's own extension of NIfTI), else an error that says what is missing.
    std::string preset;
};

struct ImportedLabels {
    mesh::LabelVolume labels; ///< on the file's own grid
    std::vector<std::string> notes; ///< what was decided, one line each
};

/// One image of labels (every format of read_volume(), .seg.nrrd of 3D Slicer, layered too), or a folder of one mask
/// per organ, named by its file ("heart.nii.gz").
///
/// One image: ids are named by the preset, else by the table beside it, else by the names in the file itself. Names
/// from a preset or from the file keep only the structures that have voxels; a preset that contradicts the names in the
/// file is refused. Preset "cip": the low byte (region) is kept, the high byte (type) is told and dropped.
///
/// A folder: masks may lie on different grids of one world. The finest of the grids is kept (of equals the largest) and
/// extended by whole voxels where labelled voxels lie outside it; the others are resampled to it by world position,
/// nearest voxel. Where masks overlap the smaller structure wins and a note says how many voxels the larger one lost.
/// Masks of one structure are joined; an image in the folder with several ids needs names of its own. Ids count from 1
/// in the order of the file names; empty masks are noted and left out; a preset plays no part.
///
/// Cancelled, it returns no voxels. Records the part "labels".
/// @throws InputError as read_label_volume() does, and: ids without a name (told with their voxel counts), no labelled
/// voxel at all, a folder without images, masks whose grids lie in separate places; IoError.
ImportedLabels import_labels(
    const std::filesystem::path& path, const LabelImportOptions& options = {}, const Job& job = {});

} // namespace retractor::datasets

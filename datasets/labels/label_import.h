#pragma once
// Converts label maps of other programs to a LabelVolume with names, materials and roles. Frame: patient LPS.

#include "mesh/base/job.h"
#include "mesh/image/volume.h"

#include <filesystem>
#include <string>
#include <vector>

namespace retractor::datasets {

/// How to name the labels.
struct LabelImportOptions {
    /// A preset of label_preset_names(). Empty takes the names from the JSON table beside the image, or else from the
    /// file itself (.seg.nrrd, or TotalSegmentator's extension of NIfTI). Without names the import throws an error that
    /// says what is missing.
    std::string preset;
};

/// The labels, and the decisions made while importing them.
struct ImportedLabels {
    mesh::LabelVolume labels; ///< on the grid of the file, or on the common grid of the masks
    std::vector<std::string> notes; ///< decisions, one line each
};

/// Imports one image of labels (every format of read_volume(); .seg.nrrd of 3D Slicer, also with layers; DICOM SEG and
/// RTSTRUCT), or a folder with one mask per organ, named by its file ("heart.nii.gz").
///
/// One image: the preset names the ids, or else the table beside the image, or else the names in the file. A table from
/// a preset or from the file keeps only structures that have voxels. A preset that contradicts the names in the file is
/// refused. Preset "cip" keeps the low byte (region) and drops the high byte (type) with a note.
///
/// A folder: the masks may have different grids in one world frame. The result takes the finest of the grids, and the
/// largest of equally fine grids. Whole voxels extend this grid where labelled voxels lie outside. The other masks are
/// resampled by world position, nearest voxel. Where masks overlap, the smaller structure wins, and a note gives the
/// number of voxels that the larger structure lost. Masks of one structure are joined. An image with several ids needs
/// names of its own. Ids count from 1 in the order of the file names. Empty masks are left out with a note. The preset
/// has no effect.
///
/// A cancelled import returns no voxels. Records the part "labels".
/// @throws InputError as read_label_volume() does, and for ids without a name (with their voxel counts), no labelled
/// voxel, a folder without images, and masks whose grids lie apart; IoError when a file cannot be read.
ImportedLabels import_labels(
    const std::filesystem::path& path, const LabelImportOptions& options = {}, const Job& job = {});

} // namespace retractor::datasets

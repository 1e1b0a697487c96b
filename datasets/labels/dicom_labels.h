#pragma once
// Reads labels that DICOM objects hold: segmentations (DICOM SEG) and contours of radiotherapy (RTSTRUCT). Standard:
// DICOM PS3.3, A.51 Segmentation IOD and A.19 RT Structure Set IOD. The objects are parsed by DCMTK.

#include "datasets/labels/seg_nrrd.h"
#include "mesh/base/job.h"

#include <filesystem>

namespace retractor::datasets {

/// True for a DICOM file of a segmentation or of a structure set. False for every other or unreadable file.
bool is_dicom_labels(const std::filesystem::path& file);

/// Reads the segments of a DICOM SEG on the grid of its frames, or the closed contours of an RTSTRUCT on a grid of 1 mm
/// in the planes of the contours. Segments that overlap lie in different layers. A fractional segment counts where it
/// fills at least half of a voxel. Contours inside a contour of the same structure are holes. Structures without voxels
/// are left out with a note.
/// @throws InputError when the object is damaged or is another one, when frames or contours do not lie in parallel,
/// evenly spaced planes, when they differ in size or direction, or when no structure has a voxel
SegmentedImage read_dicom_labels(const std::filesystem::path& file, const Job& job = {});

} // namespace retractor::datasets

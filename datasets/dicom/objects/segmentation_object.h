#pragma once
// Labels as a DICOM Segmentation (PS3.3 A.51), for other programs and the archive of a hospital.

#include "datasets/dicom/objects/dicom_study.h"
#include "mesh/image/volume.h"

#include <filesystem>
#include <string>
#include <vector>

namespace retractor::datasets {

/// Writes every label of the table that has voxels as one binary segment. Only the slices in which a label appears are
/// stored. Names of segments are those of the table; their codes are of SNOMED CT, "tissue" where no better one is
/// known.
/// @param labels spacing and direction as an image: rows and columns are i and j
/// @param estimated names of labels that were not seen in the image; their segments say so
/// @throws InputError when no label has a voxel; IoError when the object cannot be written
void write_segmentation(const std::filesystem::path& file, const mesh::LabelVolume& labels,
    const std::vector<std::string>& estimated, const DicomStudy& study, const ResultSeries& series);

} // namespace retractor::datasets

#pragma once
// Reads and writes CT and label images. Every image in memory has the frame patient LPS, in mm; the readers convert
// NIfTI and NRRD files in RAS. The suffix selects the format: .nii, .nii.gz, .nrrd, .nhdr, .mha, .mhd, .vti. A folder
// is a DICOM series.

#include "mesh/base/job.h"
#include "mesh/image/volume.h"

#include <filesystem>
#include <string>
#include <vector>

namespace retractor::datasets {

/// An image of another program, and the decisions made while reading the file.
struct ImportedVolume {
    mesh::Volume volume;
    /// One decision each, for the user: chosen series, padding, straightened gantry; without a patient's name or id.
    std::vector<std::string> notes;
};
/// How to read DICOM; other formats have no options.
struct ImportOptions {
    std::string series; ///< see DicomReadOptions
    bool rectify_tilt = true; ///< see DicomReadOptions
};
/// Reads a CT that another program wrote: every format of read_volume(), and DICOM with a choice of the series, also as
/// one file. Values below -1024 HU become -1024, and a note gives their number. Doubtful values, spacings and headers
/// give a note each. @throws as read_volume() and read_dicom() do.
ImportedVolume import_volume(const std::filesystem::path& path, const ImportOptions& options = {}, const Job& job = {});

/// Reads a CT in Hounsfield units. Records the part "voxels".
/// @throws InputError for an unknown suffix, an image that is not 3-D with one number per voxel, bad geometry, fewer
/// pixels than the header declares, and values that are no 16-bit Hounsfield numbers; IoError when the file does not
/// exist or cannot be opened.
mesh::Volume read_volume(const std::filesystem::path& path, const Job& job = {});

/// Reads labels with an empty table, so the ids have no names yet. Decisions are appended to `notes`, if given. Records
/// the part "labels".
/// @throws as read_volume() does; InputError also for values that are no whole numbers from 0 to 65535.
mesh::LabelVolume read_label_voxels(
    const std::filesystem::path& path, std::vector<std::string>* notes = nullptr, const Job& job = {});

/// Reads labels and the table in the JSON file beside the image (label_table_path()). Records the part "labels".
/// @throws as read_label_voxels() does; InputError also for a missing or wrong table (file and JSON pointer in
/// where()), and for voxel values that the table does not name.
mesh::LabelVolume read_label_volume(const std::filesystem::path& path, const Job& job = {});

/// Writes a CT; the suffix selects the format. NRRD (gzip, space left-posterior-superior) stores the geometry exactly,
/// NIfTI in single precision. The file appears complete or not at all.
/// @throws InputError for a bad grid or suffix; IoError when writing fails.
void write_volume(const std::filesystem::path& path, const mesh::Volume& volume);

/// Writes labels as write_volume() writes a CT, and the table beside the image.
/// @throws as write_volume() does; InputError also for voxel values that the table does not name.
void write_label_volume(const std::filesystem::path& path, const mesh::LabelVolume& labels);

/// The path `<stem>.labels.json` beside the image. The format is in datasets/io/label_table.h.
std::filesystem::path label_table_path(const std::filesystem::path& image);

/// Returns the labels on another grid. Each voxel takes the label that is nearest to its centre in the world, or 0
/// outside the labels' grid.
/// @throws InputError when no voxel centre of `grid` lies inside the labels' grid. Two different frames are then
/// likely.
mesh::LabelVolume resample_labels_to(const mesh::LabelVolume& labels, const mesh::ImageGrid& grid);

} // namespace retractor::datasets

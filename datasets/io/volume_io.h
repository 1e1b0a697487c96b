#pragma once
// CT and label images on disk. Every file ends up in patient LPS mm: NIfTI and NRRD files in RAS are converted
// where they are read. Formats by suffix: .nii, .nii.gz, .nrrd, .nhdr, .mha, .mhd, .vti; a folder is a DICOM series.

#include "mesh/base/job.h"
#include "mesh/image/volume.h"

#include <filesystem>
#include <string>
#include <vector>

namespace retractor::datasets {

/// An image from elsewhere, and what was decided while reading it, one line each, for the user: the series that was
/// chosen, padding, a gantry that was straightened. No line holds a patient's name or id.
struct ImportedVolume {
    mesh::Volume volume;
    std::vector<std::string> notes;
};
struct ImportOptions {
    std::string series; ///< see DicomReadOptions
    bool rectify_tilt = true;
};
/// A CT from another program's files: everything read_volume() takes, and DICOM with choice of series (one file too).
/// Values below -1024 HU become -1024 and are counted in a note; values, spacing or headers that leave a doubt have a
/// note each. @throws as read_volume() and read_dicom() do.
ImportedVolume import_volume(const std::filesystem::path& path, const ImportOptions& options = {}, const Job& job = {});

/// Records the part "voxels".
/// @throws InputError for an unknown suffix, an image that is not 3-D with one number per voxel, bad geometry,
/// fewer pixels than the header promises, values that are no 16-bit Hounsfield numbers; IoError when there is no
/// such file or it cannot be opened.
mesh::Volume read_volume(const std::filesystem::path& path, const Job& job = {});

/// The labels alone, with an empty table: their ids have no names yet. `notes`, if given, gets a line for what was
/// decided. Records the part "labels". @throws as read_volume() does, and for values that are no whole numbers from 0
/// to 65535.
mesh::LabelVolume read_label_voxels(
    const std::filesystem::path& path, std::vector<std::string>* notes = nullptr, const Job& job = {});

/// The image and its table from the JSON beside it (`label_table_path`). Records the part "labels".
/// @throws InputError as above, for a table that is missing or wrong (file and JSON pointer in where()), and for
/// voxel values that the table does not name.
mesh::LabelVolume read_label_volume(const std::filesystem::path& path, const Job& job = {});

/// The format follows the suffix; NRRD (gzip, space left-posterior-superior) keeps the geometry exactly, NIfTI in
/// single precision. The file appears whole or not at all.
void write_volume(const std::filesystem::path& path, const mesh::Volume& volume);

/// The image as above and the table beside it.
void write_label_volume(const std::filesystem::path& path, const mesh::LabelVolume& labels);

/// `<stem>.labels.json` beside the image: {"frame": "LPS", "labels": [{"id", "name", "material", "role"}]}.
std::filesystem::path label_table_path(const std::filesystem::path& image);

/// The labels seen on another grid: each voxel takes the label nearest to its centre in the world, 0 outside.
/// @throws InputError when not one voxel centre lies inside the labels' grid (two different frames, most likely).
mesh::LabelVolume resample_labels_to(const mesh::LabelVolume& labels, const mesh::ImageGrid& grid);

} // namespace retractor::datasets

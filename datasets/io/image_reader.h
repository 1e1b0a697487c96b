#pragma once
// Images of every format that is one file: header, then voxels, decoded and made into what the project stores on the
// way, so that only one copy of them is ever in memory.

#include "datasets/io/image_header.h"
#include "mesh/base/job.h"

namespace retractor::datasets {

/// True where the suffix is one of .nii, .nii.gz, .nrrd, .nhdr, .mha, .mhd, .vti.
bool is_image_name(const std::filesystem::path& path);
/// The file's name without its suffix, ".nii.gz" being one.
std::string image_stem(const std::filesystem::path& path);

/// Hounsfield units, rounded. When the job is cancelled the voxels stay incomplete.
/// @throws InputError naming the file, and for a value that cannot be the voxel's index; IoError.
ImageHeader read_hounsfield_image(
    const std::filesystem::path& path, std::vector<std::int16_t>& voxels, const Job& job = {});

/// Labels, whole numbers from 0 to 65535. `components` numbers per voxel, which must be 1 unless `layered`.
ImageHeader read_label_image(
    const std::filesystem::path& path, std::vector<Label>& voxels, bool layered, const Job& job = {});

} // namespace retractor::datasets

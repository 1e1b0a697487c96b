#pragma once
// Reads images of every format that stores a header and then voxels. The voxels are decoded and converted in one pass,
// so that only one copy of them is in memory.

#include "datasets/io/image_header.h"
#include "mesh/base/job.h"

namespace retractor::datasets {

/// True for the suffixes .nii, .nii.gz, .nrrd, .nhdr, .mha, .mhd, .vti.
bool is_image_name(const std::filesystem::path& path);
/// The file's name without its suffix; ".nii.gz" is one suffix.
std::string image_stem(const std::filesystem::path& path);

/// Reads a CT and fills `voxels` with Hounsfield units, rounded. After a cancellation the voxels are incomplete.
/// @throws InputError naming the file, and naming the voxel's index for a value that is not possible; IoError when the
/// file cannot be read.
ImageHeader read_hounsfield_image(
    const std::filesystem::path& path, std::vector<std::int16_t>& voxels, const Job& job = {});

/// Reads labels, whole numbers from 0 to 65535. `voxels` gets `components` numbers per voxel; more than one number per
/// voxel requires `layered`. @throws as read_hounsfield_image() does.
ImageHeader read_label_image(
    const std::filesystem::path& path, std::vector<Label>& voxels, bool layered, const Job& job = {});

} // namespace retractor::datasets

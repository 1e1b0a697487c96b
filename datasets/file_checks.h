#pragma once
// What the image library lets pass in silence: files with fewer pixels than their header promises, damaged
// compression, headers whose numbers cannot be.

#include <filesystem>

namespace retractor {

/// .nii, .nii.gz: magic, element size, spacing and slope finite, all pixels there, checksum right.
/// @throws InputError naming the file and what is wrong; IoError when it cannot be opened.
void check_nifti_file(const std::filesystem::path& path);

/// .mha: pixels in the file itself are all there, also when compressed. Files whose pixels are elsewhere pass.
void check_metaimage_file(const std::filesystem::path& path);

} // namespace retractor

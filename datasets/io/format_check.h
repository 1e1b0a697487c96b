#pragma once
// Which image formats this machine reads, tried out on small images of our own.

#include <filesystem>
#include <string>
#include <vector>

namespace retractor::datasets {

struct FormatCheck {
    std::string format; ///< "DICOM JPEG lossless", "NRRD" ...
    bool works = false; ///< every voxel came back
    std::string problem; ///< of a format that does not work
};

/// Reads a series of 8 x 8 slices in each lossless transfer syntax of hospitals, and writes and reads each volume
/// format.
/// @param folder where it may write; it is left as it was.
std::vector<FormatCheck> check_formats(const std::filesystem::path& folder);

/// Names and versions of the libraries that read images.
std::string image_library_versions();

} // namespace retractor::datasets

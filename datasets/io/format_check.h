#pragma once
// Tests which image formats this machine reads, on small images that the test makes itself.

#include <filesystem>
#include <string>
#include <vector>

namespace retractor::datasets {

/// The result of the test for one format.
struct FormatCheck {
    std::string format; ///< "DICOM JPEG lossless", "NRRD" ...
    bool works = false; ///< every voxel was read with its value
    std::string problem; ///< message of the failure; empty when the format works
};

/// Reads a series of 8 x 8 slices in each lossless transfer syntax that hospitals use, then writes and reads each
/// volume format.
/// @param folder a writable folder; the test removes its files from the folder
std::vector<FormatCheck> check_formats(const std::filesystem::path& folder);

/// Names and versions of the libraries that read images.
std::string image_library_versions();

} // namespace retractor::datasets

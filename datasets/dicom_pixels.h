#pragma once
// Pixels of a series to Hounsfield units, several files at a time.

#include "datasets/dicom_geometry.h"
#include "mesh/base/job.h"

namespace retractor {

/// What became of the pixels, over all slices.
struct DicomPixelCounts {
    std::size_t padding = 0; ///< pixels of the declared padding value or range, now -1024
    std::size_t circle = 0; ///< outside the scan circle: the value of the corners, below -1024; now -1024
    int padding_darkest = 0; ///< HU that the padding would have had
    int padding_brightest = 0;
    int circle_value = 0; ///< HU, the darkest found
};

/// What is checked without decoding: an image of one 8- or 16-bit sample, and as many bytes as it needs.
/// @throws InputError naming file and tag.
void check_pixel_tags(const DicomFile& file);

/// Fills the voxels of the arrangement's grid, which the caller has sized; nothing useful when cancelled.
/// @throws InputError for pixels that cannot be decoded or do not fit 16 bits.
DicomPixelCounts read_dicom_pixels(const std::vector<DicomFile>& files, const DicomArrangement& stack,
    std::vector<std::int16_t>& voxels, const Job& job);

} // namespace retractor

#pragma once
// Stored numbers of one slice to Hounsfield units: bits, sign, padding, rescale, the scan circle, and the place of the
// slice in a stack that a tilted gantry has sheared.

#include "datasets/dicom/dicom_geometry.h"

#include <span>

namespace retractor::datasets {

/// What became of the pixels, over all slices.
struct DicomPixelCounts {
    std::size_t padding = 0; ///< pixels of the declared padding value or range, now -1024
    std::size_t circle = 0; ///< outside the scan circle: the value of the corners, below -1024; now -1024
    int padding_darkest = 0; ///< HU that the padding would have had
    int padding_brightest = 0;
    int circle_value = 0; ///< HU, the darkest found
};

/// `stored`: columns x rows words of BitsAllocated, aligned for them. Fills layer `k` of the stack's voxels.
/// @throws InputError naming file, column and row for a value that is no 16-bit Hounsfield number, and for more bits
/// than the file says it stores.
void store_dicom_slice(const void* stored, const DicomFile& file, const DicomArrangement& stack, std::size_t k,
    std::span<std::int16_t> voxels, DicomPixelCounts& counts);

} // namespace retractor::datasets

#pragma once
// Converts the stored numbers of one slice to Hounsfield units. The conversion handles bits, sign, padding, rescale,
// the scan circle, and the shift of the slice in a stack that a tilted gantry has sheared.

#include "datasets/dicom/dicom_geometry.h"

#include <span>

namespace retractor::datasets {

/// Counts of replaced pixels, over all slices.
struct DicomPixelCounts {
    std::size_t padding = 0; ///< pixels with the declared padding value or range, replaced by -1024 HU
    /// Pixels outside the scan circle, replaced by -1024 HU. These pixels have the value of the image's corners, which
    /// lies below -1024 HU.
    std::size_t circle = 0;
    int padding_darkest = 0; ///< lowest HU of the replaced padding
    int padding_brightest = 0; ///< highest HU of the replaced padding
    int circle_value = 0; ///< lowest HU found outside the scan circle
};

/// Fills layer `k` of the stack's voxels (HU) and adds to `counts`.
/// @param stored columns x rows words of BitsAllocated, aligned for their type
/// @throws InputError, naming file, column and row, for a value that is no 16-bit Hounsfield number, and for a value
/// with more bits than the file declares.
void store_dicom_slice(const void* stored, const DicomFile& file, const DicomArrangement& stack, std::size_t k,
    std::span<std::int16_t> voxels, DicomPixelCounts& counts);

} // namespace retractor::datasets

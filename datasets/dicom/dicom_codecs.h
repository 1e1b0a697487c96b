#pragma once
// Compressed pixels, decoded from their bytes alone. The codec library trusts the tags and stops the program when the
// code stream contradicts them, so it is never shown a file, and the stream's own header is compared first.

#include "datasets/dicom/dicom_tags.h"

namespace retractor::datasets {

/// The bytes of each image of a compressed file, in order.
/// @throws InputError when the chain of fragments is cut or damaged, or does not tell where an image begins.
std::vector<std::vector<char>> compressed_images(const DicomFile& file);

/// Compressed by a codec that decode_image() knows: RLE, JPEG, JPEG-LS, JPEG 2000.
bool is_compressed(const DicomFile& file);

/// One image as 8- or 16-bit words (BitsAllocated), columns x rows.
/// @throws InputError for a stream that is cut, damaged or of another size than the tags say.
std::vector<char> decode_image(const DicomFile& file, const std::vector<char>& compressed);

} // namespace retractor::datasets

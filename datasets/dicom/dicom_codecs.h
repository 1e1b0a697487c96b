#pragma once
// Decodes compressed pixels from their bytes alone. The codec library trusts the tags of a file and stops the program
// when the code stream contradicts the tags. For this reason the library never sees a file, and the header of the code
// stream is compared with the tags before the stream is decoded.

#include "datasets/dicom/dicom_tags.h"

namespace retractor::datasets {

/// Returns the bytes of each image of a compressed file, in order.
/// @throws InputError when the chain of fragments is cut or damaged, or when the beginning of an image cannot be found.
std::vector<std::vector<char>> compressed_images(const DicomFile& file);

/// True when the file is compressed by a codec that decode_image() knows: RLE, JPEG, JPEG-LS, JPEG 2000.
bool is_compressed(const DicomFile& file);

/// Decodes one image into columns x rows words of 8 or 16 bits (BitsAllocated).
/// @throws InputError when the stream is cut, damaged, or of another size than the tags say.
std::vector<char> decode_image(const DicomFile& file, const std::vector<char>& compressed);

} // namespace retractor::datasets

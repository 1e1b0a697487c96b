#pragma once
// Bytes of a file, decoded on the way: what image_reader.h takes voxels from.

#include "datasets/io/image_header.h"

#include <memory>

namespace retractor::datasets {

/// A stream of decoded bytes.
class ByteSource {
public:
    ByteSource() = default;
    ByteSource(const ByteSource&) = delete;
    ByteSource& operator=(const ByteSource&) = delete;
    virtual ~ByteSource() = default;
    /// Fills `out` as far as there are bytes; fewer than `count` only at the end, where checksums are compared.
    /// @throws InputError for damaged data.
    virtual std::size_t read(char* out, std::size_t count) = 0;
    /// Bytes that follow the end of compressed data and were left alone.
    virtual bool has_leftover() const { return false; }
};

/// A stretch of a file and how it is encoded.
struct EncodedBytes {
    std::filesystem::path file;
    std::uint64_t start = 0;
    std::uint64_t length = kWholeFile; ///< encoded bytes from `start`
    Encoding encoding = Encoding::raw;
    bool base64 = false; ///< around the encoding
    std::uint64_t streams = 0; ///< deflate: zlib streams one after the other; 0: one, or the members of a gzip file
    VoxelType type = VoxelType::uint8; ///< of numbers in text
};

/// Its bytes decoded. Text becomes numbers in the machine's byte order. @throws IoError when it cannot be opened.
std::unique_ptr<ByteSource> open_source(const EncodedBytes& bytes);

/// Reads and drops up to `count` bytes; returns how many there were.
std::uint64_t skip(ByteSource& source, std::uint64_t count);

} // namespace retractor::datasets

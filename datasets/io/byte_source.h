#pragma once
// Streams of decoded bytes from files. image_reader.h reads voxels from these streams.

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
    /// Fills `out` and returns the number of bytes. Fewer than `count` bytes mean the end of the stream, where
    /// checksums are compared.
    /// @throws InputError for damaged data.
    virtual std::size_t read(char* out, std::size_t count) = 0;
    /// True when unread bytes follow the end of compressed data.
    virtual bool has_leftover() const { return false; }
};

/// A part of a file, and the encoding of its bytes.
struct EncodedBytes {
    std::filesystem::path file;
    std::uint64_t start = 0; ///< offset in the file, bytes
    std::uint64_t length = kWholeFile; ///< encoded bytes from `start`
    Encoding encoding = Encoding::raw;
    bool base64 = false; ///< base64 text around the encoding
    /// Number of consecutive zlib streams (deflate only); 0: one stream, or all members of a gzip file.
    std::uint64_t streams = 0;
    VoxelType type = VoxelType::uint8; ///< type of the numbers in a text
};

/// Opens a stream of the decoded bytes. Numbers in a text become binary numbers in the machine's byte order.
/// @throws IoError when the file cannot be opened.
std::unique_ptr<ByteSource> open_source(const EncodedBytes& bytes);

/// Reads and drops up to `count` bytes. Returns the number of dropped bytes.
std::uint64_t skip(ByteSource& source, std::uint64_t count);

} // namespace retractor::datasets

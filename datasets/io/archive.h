#pragma once
// Unpacks ZIP archives, as hospitals send studies. An archive is a stranger's file: nothing in it may write outside the
// folder, and a small file must not fill the disk.

#include "mesh/base/job.h"

#include <cstdint>
#include <filesystem>

namespace retractor::datasets {

/// Whether the file begins as a ZIP archive does. @throws IoError when it cannot be read
bool is_zip_archive(const std::filesystem::path& file);

struct UnpackLimits {
    std::uint64_t bytes = std::uint64_t { 32 } << 30U; ///< of all files together
    /// Unpacked bytes for each byte of the archive. DICOM images compress by a factor of 2 to 4, empty ones by 100.
    std::uint64_t expansion = 400;
    std::size_t files = 200000;
};

/// Unpacks the regular files of an archive into an empty or new folder. A cancelled job leaves the folder as it is
/// then.
/// @throws InputError naming the entry, before anything of it is written, when its name leads out of the folder, when
/// it is encrypted, a link or a device, or when a limit is passed; InputError when the archive is damaged; IoError when
/// reading or writing fails
void unpack_zip(const std::filesystem::path& archive, const std::filesystem::path& folder, const Job& job = {},
    const UnpackLimits& limits = {});

/// The content of an archive in a temporary folder, which goes with this object.
class UnpackedArchive {
public:
    /// @throws as unpack_zip() does
    explicit UnpackedArchive(const std::filesystem::path& archive, const Job& job = {});
    ~UnpackedArchive();
    UnpackedArchive(const UnpackedArchive&) = delete;
    UnpackedArchive& operator=(const UnpackedArchive&) = delete;

    const std::filesystem::path& folder() const { return folder_; }

private:
    std::filesystem::path folder_;
};

} // namespace retractor::datasets

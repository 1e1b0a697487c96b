#pragma once
// A phantom on disk, as a scanner would deliver it.

#include "datasets/dicom/dicom.h"
#include "datasets/phantoms/phantom.h"
#include "datasets/io/volume_io.h"

#include <filesystem>

namespace retractor::cli {

struct PhantomFiles {
    std::filesystem::path ct; ///< folder of a DICOM series, or ct.nrrd
    std::filesystem::path labels; ///< labels.nrrd, with its table beside it
};

PhantomFiles write_phantom(const std::filesystem::path& folder, const Phantom& phantom, bool as_nrrd, const Job& job);

} // namespace retractor::cli

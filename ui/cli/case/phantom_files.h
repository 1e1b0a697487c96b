#pragma once
// Writes a phantom to disk in the form that a scanner delivers.

#include "datasets/dicom/dicom.h"
#include "datasets/io/volume_io.h"
#include "datasets/phantoms/phantom.h"

#include <filesystem>

namespace retractor::ui::cli {

struct PhantomFiles {
    std::filesystem::path ct; ///< folder of a DICOM series, or ct.nrrd
    std::filesystem::path labels; ///< labels.nrrd, with its table beside it
};

PhantomFiles write_phantom(
    const std::filesystem::path& folder, const datasets::Phantom& phantom, bool as_nrrd, const Job& job);

} // namespace retractor::ui::cli

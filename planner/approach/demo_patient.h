#pragma once
// The demo's patient: a phantom of a chest with an aneurysm of the aortic arch, imported as a hospital's study is, with
// the three standard approaches to the aneurysm.

#include "mesh/base/job.h"
#include "planner/case/case.h"

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace retractor::planner {

struct DemoPatient {
    Case planned_case;
    std::vector<std::pair<std::string, double>> seconds; ///< duration of each step
};

/// Writes the patient's DICOM series, labels and case.json into a folder.
/// @returns nothing when the job is cancelled; the folder then holds a part of the patient
/// @throws IoError when writing fails; InputError when the folder's ct holds other files
std::optional<DemoPatient> write_demo_patient(const std::filesystem::path& folder, const Job& job = {});

} // namespace retractor::planner

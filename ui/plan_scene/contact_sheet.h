#pragma once
// One picture for checking a CT and its labels before planning: slices of three planes with outlined labels, the
// skeleton and the body in space, the findings and the warnings. Units mm; frame patient LPS.

#include "mesh/base/job.h"
#include "ui/scene/scene.h"

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace retractor::ui {

struct ContactSheetOptions {
    std::string title = "Contact sheet";
    std::vector<std::string> notes {}; ///< decisions of the import, one line each
    std::vector<std::string> warnings {}; ///< findings that the reader must check; printed first
    std::set<std::string> rough {}; ///< labels that are estimated regions; marked in the legend
    std::optional<Vec3> focus = std::nullopt; ///< point on all slices; not set: heart or aorta, if labelled
    int columns = 5; ///< slices per plane, 1 to 12
    int width = 2400; ///< pixels; the height follows
    double window_hu = 500.0, level_hu = 40.0;
    bool surfaces = true; ///< add a row of four views in space: bones, vessels and the other labels, in the body
};

/// @param ct may be null (labels on black)
/// @param labels may be null, but not together with ct; the two grids may differ
/// @throws InputError when both are null, on bad grids, or on options out of range
Picture contact_sheet(std::shared_ptr<const mesh::Volume> ct, std::shared_ptr<const mesh::LabelVolume> labels,
    const ContactSheetOptions& options = {}, const Job& job = {});

} // namespace retractor::ui

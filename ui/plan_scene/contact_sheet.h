#pragma once
// One picture by which a reader judges a CT and its labels before anything is planned on them: slices of three planes
// with labels outlined, the skeleton and the body in space, what was found, and what to look at. Units mm; frame
// patient LPS.

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
    std::vector<std::string> notes {}; ///< what was decided while reading, one line each
    std::vector<std::string> warnings {}; ///< what the reader must look at; printed first
    std::set<std::string> rough {}; ///< labels that are estimated regions: the legend marks them
    std::optional<Vec3> focus = std::nullopt; ///< slices pass through it; none: through heart or aorta if labelled
    int columns = 5; ///< slices per plane, 1 to 12
    int width = 2400; ///< pixels; the height follows
    double window_hu = 500.0, level_hu = 40.0;
    bool surfaces = true; ///< a row of four views in space: bones, vessels and what else is labelled, in the body
};

/// @param ct may be null (labels on black), `labels` too, but not both; their grids may differ.
/// @throws InputError when both are null, on bad grids, or options out of range.
Picture contact_sheet(std::shared_ptr<const mesh::Volume> ct, std::shared_ptr<const mesh::LabelVolume> labels,
    const ContactSheetOptions& options = {}, const Job& job = {});

} // namespace retractor::ui

#pragma once
// Finds how much of the wall a plan must mesh: as far as the tissue moves. A wound's ribs turn from spine to
// sternum, and carry skin and muscle far from the incision with them. Where the model ends nothing holds its tissue, so
// a model that ends too early bears less than the body. A draft of the whole wall, with long edges and linear four-node
// elements, shows where tissue moves; a second draft shows what the wall beyond does to the force. Units mm, N; forces
// as fractions.

#include "planner/measures/field_metrics.h"
#include "planner/measures/region_text.h"

#include <functional>
#include <optional>
#include <string>

namespace retractor::planner {

/// What a draft of a plan says about its region.
struct RegionDraft {
    enum class Status { done, memory, failure, cancelled };
    Status status = Status::done;
    std::string message {}; ///< of a failure
    double moving_mm = 0.0; ///< distance from the incision within which all tissue lies that moves beyond kStillRimMm
    double farthest_mm = 0.0; ///< distance from the incision of the farthest vertex of the mesh
    double rim_motion_mm = 0.0; ///< largest motion where the region ends inside the image
    double force_N = 0.0; ///< of the larger side
};

/// Makes a draft of the plan with this region, mm.
using DraftOfRegion = std::function<RegionDraft(double region_mm)>;

/// The found region. @c measures has ended_by, message, drafts and force_change.
struct FoundRegion {
    double region_mm = kFirstRegionMm;
    bool cancelled = false;
    RegionMetrics measures {};
};

/// A region grows by this factor while its rim moves too far, and shrinks by it where it does not fit the memory.
inline constexpr double kRegionGrowth = 1.5;

/// A wall that lies within this distance of the incision is meshed whole where the plan's edges are as long as a
/// draft's: the drafts would take longer than what they save. The wall of most chests lies within it.
inline constexpr double kWholeWallMm = 450.0;

/// Finds the smallest region whose rim moves less than kStillRimMm, by two to four drafts.
/// @param whole_mm a region that holds the whole wall
/// @pre whole_mm > 0
FoundRegion find_region(double whole_mm, const DraftOfRegion& draft);

/// The region of a plan that does not fit the memory, made smaller: by kRegionGrowth, but not below kFirstRegionMm.
/// @returns false when the region is as small already
bool shrink_region(FoundRegion& found);

} // namespace retractor::planner

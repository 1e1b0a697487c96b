#pragma once
// One stroke of a blade through the store of a cutting session: what CutSession::cut does. Units mm.

#include "mesh/cut_store.h"

namespace retractor {

/// Which part of a growing blade a step is about.
struct StrokeStep {
    double from_along = 0.0; ///< what lies before (mm along the line) is done
    bool resolve_end = true; ///< cut up to the blade's end exactly; else leave elements it does not cross completely
    bool goes_on = false; ///< former steps may have cut under the same number
};

/// Cuts between store.begin() and store.finish(), both called by the caller, who also rolls back when the status is
/// not `done` or something is thrown. Fills status, message and the counts of the report, not the delta.
/// @param resume_along set to where the next step of a growing blade has to go on, when not null.
CutResult cut_stroke(CutStore& store, const SweptBlade& blade, const CutOptions& options, int cut_number,
    const Job& job, const StrokeStep& step = {}, double* resume_along = nullptr);

} // namespace retractor

#pragma once
// Makes one stroke of a blade through the store of a cutting session, for CutSession::cut(). Units mm.

#include "mesh/base/job.h"
#include "mesh/cutting/store/blade.h"
#include "mesh/cutting/store/cut_store.h"
#include "mesh/cutting/store/cut_types.h"
#include "mesh/cutting/stroke/cut_retry.h"

#include <map>

namespace retractor::mesh {

/// Distance (mm) by which the moves of each vertex have carried its surfaces away.
using SurfaceDrift = std::map<VertexId, double>;

/// The part of a growing blade that a step cuts.
struct StrokeStep {
    double from_along = 0.0; ///< start of the step (mm along the line); former steps cut the part before
    /// True: cut exactly up to the blade's end. False: leave out elements that the blade does not cross completely.
    bool resolve_end = true;
    bool goes_on = false; ///< former steps may have cut under the same number
    const SurfaceDrift* drift = nullptr; ///< drift of former steps; may be null
    StrokeSettings settings {};
};

/// The state that a step passes to the next step.
struct StrokeRest {
    double resume_along = 0.0; ///< start of the next step (mm along the line)
    SurfaceDrift drift;
};

/// Makes one stroke. Fills status, message and the counts of the report, not the delta.
/// @param rest when not null, receives the state for the next step of a growing blade
/// @pre the caller has called store.begin(); the caller calls store.finish(), or store.rollback() after a status other
/// than `done` or an exception
/// @throws CutQualityError (cut_retry.h) when the stroke may succeed with other settings
CutResult cut_stroke(CutStore& store, const SweptBlade& blade, const CutOptions& options, int cut_number,
    const Job& job, const StrokeStep& step = {}, StrokeRest* rest = nullptr);

} // namespace retractor::mesh

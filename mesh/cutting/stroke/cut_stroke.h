#pragma once
// One stroke of a blade through the store of a cutting session: what CutSession::cut does. Units mm.

#include "mesh/base/job.h"
#include "mesh/cutting/store/blade.h"
#include "mesh/cutting/store/cut_store.h"
#include "mesh/cutting/store/cut_types.h"
#include "mesh/cutting/stroke/cut_retry.h"

#include <map>

namespace retractor::mesh {

/// How far (mm) the moves of a vertex carried its surfaces away so far.
using SurfaceDrift = std::map<VertexId, double>;

/// Which part of a growing blade a step is about.
struct StrokeStep {
    double from_along = 0.0; ///< what lies before (mm along the line) is done
    bool resolve_end = true; ///< cut up to the blade's end exactly; else leave elements it does not cross completely
    bool goes_on = false; ///< former steps may have cut under the same number
    const SurfaceDrift* drift = nullptr; ///< of former steps; null for none
    StrokeSettings care {};
};

/// What a step leaves to the next one.
struct StrokeRest {
    double resume_along = 0.0; ///< where it has to go on, mm along the line
    SurfaceDrift drift;
};

/// Cuts between store.begin() and store.finish(), both called by the caller, who also rolls back when the status is
/// not `done` or something is thrown: CutQualityError (cut_retry.h) when it may be made with more care. Fills status,
/// message and the counts of the report, not the delta.
/// @param rest set to what the next step of a growing blade has to know, when not null.
CutResult cut_stroke(CutStore& store, const SweptBlade& blade, const CutOptions& options, int cut_number,
    const Job& job, const StrokeStep& step = {}, StrokeRest* rest = nullptr);

} // namespace retractor::mesh

#pragma once
// One stroke of a blade through the store of a cutting session: what CutSession::cut does. Units mm.

#include "mesh/cut_store.h"

namespace retractor {

/// Cuts between store.begin() and store.finish(), both called by the caller, who also rolls back when the status is
/// not `done` or something is thrown. Fills status, message and report, not the delta.
/// @throws SolverError when an element would come out without volume.
CutResult cut_stroke(
    CutStore& store, const SweptBlade& blade, const CutOptions& options, int cut_number, const Job& job);

} // namespace retractor

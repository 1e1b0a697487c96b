#pragma once
// Removing elements from the store of a cutting session: what CutSession::ablate does. Units mm.

#include "mesh/base/job.h"
#include "mesh/cutting/store/cut_store.h"
#include "mesh/cutting/store/cut_types.h"

#include <span>
#include <vector>

namespace retractor::mesh {

/// The elements by id, each once. @throws InputError when there is none, all are named, or one is not there.
std::vector<TetId> checked_marks(const CutStore& store, std::span<const TetId> tets);

/// Between store.begin() and store.finish(), both called by the caller, who also rolls back when the status is not
/// `done` or something is thrown. Fills status, message and the counts of the report, not the delta.
/// @param marked from checked_marks().
CutResult ablate_elements(CutStore& store, std::span<const TetId> marked, int cut_number, const Job& job);

} // namespace retractor::mesh

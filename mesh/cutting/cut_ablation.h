#pragma once
// Removes elements from the store of a cutting session, for CutSession::ablate(). Units mm.

#include "mesh/base/job.h"
#include "mesh/cutting/store/cut_store.h"
#include "mesh/cutting/store/cut_types.h"

#include <span>
#include <vector>

namespace retractor::mesh {

/// The elements in ascending order without duplicates.
/// @throws InputError when `tets` names no element, every element, or a missing element
std::vector<TetId> checked_marks(const CutStore& store, std::span<const TetId> tets);

/// Removes elements and separates remaining elements that are connected in a point or along an edge only. Fills status,
/// message and the counts of the report, not the delta.
/// @param marked from checked_marks()
/// @pre the caller has called store.begin(); the caller calls store.finish(), or store.rollback() after a status other
/// than `done` or an exception
CutResult ablate_elements(CutStore& store, std::span<const TetId> marked, int cut_number, const Job& job);

} // namespace retractor::mesh

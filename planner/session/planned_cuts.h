#pragma once
// Recognises the planned cuts among those that a session restores, because the journal of cuts does not say who made
// them: the same cut of the same wall gives the same elements, bit for bit.

#include "planner/case/approach.h"
#include "planner/session/cut_history.h"
#include "planner/wall/divided_tissue.h"

#include <span>
#include <vector>

namespace retractor::planner {

/// The entry of a finished cut from the skin.
CutEntry entry_of(const mesh::Blade& blade, const mesh::CutReport& report);
/// The entry of a stroke beyond the skin.
CutEntry entry_of(const DivisionStroke& stroke, const DividedTissue& divided);

/// The planned incision, and what the approach divides beyond it.
/// @param wall before any cut
/// @param cuts one delta per cut, in order, as CutSession::redo() gives them
/// @return the entries of the first cuts, as if they were made now; empty: the first cut is not the planned incision
std::vector<CutEntry> recognise_planned_cuts(const mesh::TetMesh& wall, const Approach& approach,
    const mesh::LabelTable& labels, std::span<const mesh::MeshDelta> cuts, const Job& job = {});

} // namespace retractor::planner

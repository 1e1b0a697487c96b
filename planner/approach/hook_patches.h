#pragma once
// Where the hooks of an approach take hold of its cut wall. Units mm; frame patient LPS (rest configuration).

#include "fem/statics/boundary_conditions.h"
#include "fem/statics/hook_drive.h"
#include "mesh/cutting/store/cut_types.h"
#include "planner/case/approach.h"

#include <span>
#include <vector>

namespace retractor::planner {

/// One patch per hook of the approach: nodes of its lip, and of the bone it bears on.
/// @param lips faces of `wall` on the incision's two sides.
/// @throws InputError naming the hook, when fewer than three free nodes lie under it.
std::vector<fem::HookPatch> hook_patches(const mesh::TetMesh& wall, std::span<const mesh::LipFace> lips,
    const Approach& approach, const mesh::LabelTable& table, const fem::Supports& supports);

/// What the hook does to the tissue under it.
fem::HookDrive drive_of(const HookSpec& spec);

} // namespace retractor::planner

#pragma once
// Where the hooks of an approach take hold of its cut wall. Units mm; frame patient LPS (rest configuration).

#include "fem/statics/boundary_conditions.h"
#include "fem/statics/hook_drive.h"
#include "mesh/cutting/store/cut_types.h"
#include "planner/case/approach.h"

#include <span>
#include <vector>

namespace retractor {

/// One patch per hook of the approach: nodes of its lip, and of the bone it bears on.
/// @param lips faces of `wall` on the incision's two sides.
/// @throws InputError naming the hook, when fewer than three free nodes lie under it.
std::vector<HookPatch> hook_patches(const TetMesh& wall, std::span<const LipFace> lips, const Approach& approach,
    const LabelTable& table, const Supports& supports);

/// What the hook does to the tissue under it.
HookDrive drive_of(const HookSpec& spec);

} // namespace retractor

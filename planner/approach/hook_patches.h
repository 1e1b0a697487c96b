#pragma once
// Finds the nodes of the cut wall that each hook of an approach holds. Units mm; frame patient LPS (rest
// configuration).

#include "fem/statics/boundary_conditions.h"
#include "fem/statics/hook_drive.h"
#include "mesh/cutting/store/cut_types.h"
#include "planner/case/approach.h"

#include <span>
#include <string>
#include <vector>

namespace retractor::planner {

/// One patch per hook of the approach: nodes of the hook's lip, and the nodes nearest to the points of bone on which
/// the hook bears (HookSpec::bearing), as far as they lie behind that lip.
/// @param lips faces of `wall` on the incision's two sides
/// @throws InputError naming the hook, when fewer than three free nodes lie under it
std::vector<fem::HookPatch> hook_patches(const mesh::TetMesh& wall, std::span<const mesh::LipFace> lips,
    const Approach& approach, const mesh::LabelTable& table, const fem::Supports& supports);

/// "left_blade", "right_blade", "back_blade", "front_blade", "upper_blade" or "lower_blade": by the largest component
/// of its pull, patient LPS.
std::string blade_name(const Vec3& pull);

/// The drive of a hook: its motion, force, limit and grip, as the solver takes them.
fem::HookDrive drive_of(const HookSpec& spec);

} // namespace retractor::planner

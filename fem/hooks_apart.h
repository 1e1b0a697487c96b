#pragma once
// Hooks on facing lips must not be drawn through each other: lips cannot pass. Units mm; frame patient LPS.

#include "fem/opening.h"

#include <span>

namespace retractor {

/// Looks at the patches as planes that move as a whole; what the tissue between hooks does is contact.h's.
/// @pre the hooks' nodes are in the mesh.
/// @throws InputError naming two hooks of opposite sides that would pass through each other, and by how far.
void check_hooks_apart(const TetMesh& mesh, std::span<const HookPatch> hooks);

} // namespace retractor

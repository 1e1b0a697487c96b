#pragma once
// Pits in the skin of the meshed wall. Where the mesh passes from its layer of skin to the coarse model without one, a
// vertex of the boundary may lie at the bottom of the skin, and a picture shows a slit in whole skin. Units mm; frame
// patient LPS.

#include "mesh/base/geometry.h"

#include <vector>

namespace retractor::planner {

/// Moves the vertices of the boundary that lie in pits to the surface of the body. Pictures only: the mesh keeps them.
/// @param boundary displaced or not, with the labels of drawn_labels(); @param at_rest the same triangles at rest
/// @param body surface of the body at rest; @param incision line of the cut in the skin: vertices near it belong to the
/// lips, and stay
/// @param skin label of the skin
void lift_pits(
    TriMesh& boundary, const TriMesh& at_rest, const TriMesh& body, const std::vector<Vec3>& incision, Label skin);

} // namespace retractor::planner

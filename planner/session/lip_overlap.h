#pragma once
// Measures whether the shown lips of a wound pass through each other, because the interactive solution has no contact
// between lips (fem/model/contact.h has contact). At each vertex that a cut has separated, the overlap is the motion of
// the two halves into each other's lip along the normal at rest. The measure is valid for lips that have not turned
// far. Units mm; frame patient LPS.

#include "planner/session/hook_placement.h"

#include <Eigen/Core>

#include <span>
#include <vector>

namespace retractor::planner {

/// The two halves of a separated vertex, on facing lips.
struct LipPair {
    VertexId a = 0, b = 0;
    Vec3 normal = Vec3::UnitX(); ///< unit vector from a's lip to b's lip
};

/// @param lips lip_triangles() of the session
std::vector<LipPair> lip_pairs(const mesh::CutSession& session, std::span<const LipTriangle> lips);

/// The deepest overlap, mm; 0 without overlap. @param displacement three numbers per vertex id of the session, mm
double lip_overlap_mm(std::span<const LipPair> pairs, const Eigen::VectorXd& displacement);

} // namespace retractor::planner
